//! The bytes that a glTF file keeps elsewhere: in its own second part, in its text, or in files beside it.

use std::path::{Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gltf::buffer::Source;
use gltf::{Buffer, Gltf};

use super::super::super::SceneError;
use super::super::access::{Denial, Reader};
use super::super::source::file_error;

/// All buffers by their index.
pub(super) struct Buffers(Vec<Vec<u8>>);

impl Buffers {
    pub fn read(file: &Gltf, path: &Path, reader: &Reader) -> Result<Buffers, SceneError> {
        let one = |buffer: Buffer| {
            let told = |reason: String| file_error(path, format!("buffer {}: {reason}", buffer.index()));
            let bytes = match buffer.source() {
                Source::Bin => {
                    file.blob.clone().ok_or_else(|| told(String::from("the file has no binary part")))?
                }
                Source::Uri(uri) => content(uri, path, reader, "a buffer of a glTF scene").map_err(told)?,
            };
            match bytes.len() < buffer.length() {
                false => Ok(bytes),
                true => Err(told(format!(
                    "holds {} bytes; allowed: {} or more, as is said",
                    bytes.len(),
                    buffer.length()
                ))),
            }
        };
        file.buffers().map(one).collect::<Result<_, _>>().map(Buffers)
    }

    /// Part of a buffer; none beyond its end.
    pub fn part(&self, buffer: usize, start: usize, length: usize) -> Option<&[u8]> {
        self.0.get(buffer)?.get(start..start.checked_add(length)?)
    }
}

/// What stands behind `data:...;base64,`, or the file of that name.
pub(super) fn content(uri: &str, path: &Path, reader: &Reader, kind: &str) -> Result<Vec<u8>, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        let encoded = data.split_once(";base64,").map(|(_, encoded)| encoded);
        let encoded = encoded.ok_or("its data are not base64; allowed: `data:...;base64,...`")?;
        return STANDARD.decode(encoded).map_err(|e| format!("its data are no base64: {e}"));
    }
    if uri.contains("://") {
        return Err(String::from("lies in a network; allowed: files, and `data:...;base64,...`"));
    }
    let file = file(uri, path).ok_or("its name is no text in percent encoding")?;
    let denied = |denial: Denial| format!("`{}` {}", file.display(), denial.reason());
    reader.read(&file, kind).map_err(denied)
}

/// The file of that name beside the scene; none where the data stand in the name.
pub(super) fn file(uri: &str, path: &Path) -> Option<PathBuf> {
    let is_data = uri.starts_with("data:");
    decoded(uri).filter(|_| !is_data).map(|name| path.parent().unwrap_or(Path::new("")).join(name))
}

/// `%41` stands for `A`.
fn decoded(uri: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.bytes();
    while let Some(byte) = rest.next() {
        if byte != b'%' {
            bytes.push(byte);
            continue;
        }
        let digits = [rest.next()?, rest.next()?];
        bytes.push(u8::from_str_radix(std::str::from_utf8(&digits).ok()?, 16).ok()?);
    }
    String::from_utf8(bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::decoded;

    #[test]
    fn names_are_decoded() {
        assert_eq!(decoded("a%20b%C3%A4.bin").as_deref(), Some("a bä.bin"));
        assert_eq!([decoded("%4"), decoded("%zz"), decoded("%ff")], [None, None, None]);
    }
}
