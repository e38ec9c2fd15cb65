//! The header of a PLY file: which elements follow, and what values each of them has.

use std::path::Path;

use super::super::super::SceneError;
use super::super::fields::shortened;

/// How values are written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Format {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// The type of a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

const KINDS: [(&str, &str, Kind); 8] = [
    ("char", "int8", Kind::I8),
    ("uchar", "uint8", Kind::U8),
    ("short", "int16", Kind::I16),
    ("ushort", "uint16", Kind::U16),
    ("int", "int32", Kind::I32),
    ("uint", "uint32", Kind::U32),
    ("float", "float32", Kind::F32),
    ("double", "float64", Kind::F64),
];

/// A value of each item of an element, or a list of values.
#[derive(Debug)]
pub(super) struct Property {
    pub name: String,
    pub kind: Kind,
    /// The type of the number of values, where it is a list.
    pub count: Option<Kind>,
}

#[derive(Debug)]
pub(super) struct Element {
    pub name: String,
    pub count: u64,
    pub properties: Vec<Property>,
}

#[derive(Debug)]
pub(super) struct Header {
    pub format: Format,
    pub elements: Vec<Element>,
    /// Lines up to the first value.
    pub lines: usize,
}

impl Header {
    /// The header of a file and the bytes behind it.
    pub fn read<'b>(path: &Path, bytes: &'b [u8]) -> Result<(Header, &'b [u8]), SceneError> {
        let mut rest = bytes;
        let mut header = Header { format: Format::Ascii, elements: Vec::new(), lines: 0 };
        loop {
            let (line, behind) = next_line(rest);
            header.lines += 1;
            let ended = rest.is_empty();
            rest = behind;
            let text = String::from_utf8_lossy(line);
            let words: Vec<&str> = text.split_whitespace().collect();
            let done = if ended {
                Err(String::from("the file ends in its header; allowed: a line `end_header`"))
            } else {
                header.line(&words)
            };
            let told = |reason| SceneError::Line { path: path.to_owned(), line: header.lines, reason };
            if done.map_err(told)? {
                return Ok((header, rest));
            }
        }
    }

    /// Takes in one line; true at the end.
    fn line(&mut self, words: &[&str]) -> Result<bool, String> {
        match (self.lines, words) {
            (1, ["ply"]) => {}
            (1, _) => return Err(String::from("no PLY file: `ply` is expected in its first line")),
            (2, ["format", format, version]) => self.format = read_format(format, version)?,
            (2, _) => {
                return Err(String::from("`format ascii 1.0` or the like is expected in the second line"));
            }
            (_, ["end_header"]) => return Ok(true),
            (_, [] | ["comment" | "obj_info", ..]) => {}
            (_, ["element", name, count]) => {
                let wrong =
                    || format!("element `{}` of `{}`; allowed: a count", shortened(name), shortened(count));
                let count = count.parse().map_err(|_| wrong())?;
                self.elements.push(Element { name: (*name).to_owned(), count, properties: Vec::new() });
            }
            (_, ["property", kind, name]) => self.property(name, kind, None)?,
            (_, ["property", "list", count, kind, name]) => self.property(name, kind, Some(count))?,
            _ => {
                let line = words.join(" ");
                return Err(format!(
                    "header line `{}`; allowed: `comment`, `obj_info`, `element NAME COUNT`, `property TYPE NAME`, \
                     `property list TYPE TYPE NAME`, `end_header`",
                    shortened(&line)
                ));
            }
        }
        Ok(false)
    }

    fn property(&mut self, name: &str, kind: &str, count: Option<&str>) -> Result<(), String> {
        let property = Property {
            name: name.to_owned(),
            kind: read_kind(kind)?,
            count: count.map(read_kind).transpose()?,
        };
        let element = self.elements.last_mut().ok_or("property before any element; allowed: behind one")?;
        if element.properties.iter().any(|other| other.name == name) {
            return Err(format!("property `{}` is there twice; allowed: once", shortened(name)));
        }
        element.properties.push(property);
        Ok(())
    }
}

fn next_line(bytes: &[u8]) -> (&[u8], &[u8]) {
    match bytes.iter().position(|&b| b == b'\n') {
        Some(end) => (&bytes[..end], &bytes[end + 1..]),
        None => (bytes, &[]),
    }
}

fn read_format(format: &str, version: &str) -> Result<Format, String> {
    if version != "1.0" {
        return Err(format!("version `{}`; allowed: 1.0", shortened(version)));
    }
    match format {
        "ascii" => Ok(Format::Ascii),
        "binary_little_endian" => Ok(Format::LittleEndian),
        "binary_big_endian" => Ok(Format::BigEndian),
        other => Err(format!(
            "format `{}`; allowed: `ascii`, `binary_little_endian`, `binary_big_endian`",
            shortened(other)
        )),
    }
}

fn read_kind(name: &str) -> Result<Kind, String> {
    let known = KINDS.iter().find(|(short, long, _)| name == *short || name == *long);
    known.map(|(_, _, kind)| *kind).ok_or_else(|| {
        let names: Vec<&str> = KINDS.iter().map(|(short, _, _)| *short).collect();
        format!("type `{}`; allowed: `{}`", shortened(name), names.join("`, `"))
    })
}
