//! The lines of OBJ and MTL files: one statement each, a keyword and its words.

use std::borrow::Cow;
use std::path::Path;

use super::super::SceneError;
use super::source::file_error;

/// The text of a mesh file; bytes that are not UTF-8, as in old comments, become U+FFFD.
pub(super) fn decode(path: &Path, bytes: Vec<u8>) -> Result<String, SceneError> {
    if bytes.starts_with(&[0xFE, 0xFF]) || bytes.starts_with(&[0xFF, 0xFE]) {
        return Err(file_error(path, "is UTF-16; allowed: an OBJ mesh in ASCII or UTF-8"));
    }
    if let Some(nul) = bytes.iter().position(|&b| b == 0) {
        let reason = String::from(
            "holds a NUL byte, so it is binary or UTF-16; allowed: an OBJ mesh in ASCII or UTF-8",
        );
        let line = bytes[..nul].split(|&b| b == b'\n').count();
        return Err(SceneError::Line { path: path.to_owned(), line, reason });
    }
    Ok(String::from_utf8(bytes).unwrap_or_else(|e| String::from_utf8_lossy(e.as_bytes()).into_owned()))
}

/// Lines with their numbers from 1; one that ends in `\` is joined with the next under its own number.
pub(super) fn statements(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let mut lines = text.strip_prefix('\u{feff}').unwrap_or(text).lines().zip(1..);
    std::iter::from_fn(move || {
        let (line, number) = lines.next()?;
        let Some(start) = line.strip_suffix('\\') else { return Some((number, Cow::Borrowed(line))) };
        let mut joined = start.to_owned();
        for (next, _) in lines.by_ref() {
            joined.push(' ');
            joined.push_str(next.strip_suffix('\\').unwrap_or(next));
            if !next.ends_with('\\') {
                break;
            }
        }
        Some((number, Cow::Owned(joined)))
    })
}

/// A statement's first word and the rest of its line.
pub(super) fn keyword(statement: &str) -> (&str, &str) {
    let statement = statement.trim();
    let (word, rest) = statement.split_once(char::is_whitespace).unwrap_or((statement, ""));
    (word, rest.trim())
}

/// The words in front of a comment.
pub(super) fn words(rest: &str) -> Vec<&str> {
    rest.split('#').next().unwrap_or_default().split_whitespace().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_numbered_and_continued() {
        let text = "\u{feff}a\r\n\r\nb \\\r\nc\\\nd\ne\\";
        let joined: Vec<_> = statements(text).map(|(n, s)| (n, s.into_owned())).collect();
        let expected = [(1, "a"), (2, ""), (3, "b  c d"), (6, "e")];
        assert_eq!(joined, expected.map(|(n, s)| (n, s.to_owned())));
    }

    #[test]
    fn keywords_and_words_are_split_at_any_blank() {
        assert_eq!(keyword(" usemtl \t my stuff # 1 "), ("usemtl", "my stuff # 1"));
        assert_eq!(keyword("s"), ("s", ""));
        assert_eq!(words("1\t 2 3# 4"), ["1", "2", "3"]);
    }

    #[test]
    fn only_text_is_decoded() {
        let decode = |bytes: &[u8]| decode(Path::new("a.obj"), bytes.to_vec()).map_err(|e| e.to_string());
        assert_eq!(decode(b"# caf\xe9\nv").unwrap(), "# caf\u{fffd}\nv");
        assert!(decode(b"\xff\xfev\0").unwrap_err().starts_with("a.obj: is UTF-16"));
        assert!(decode(b"\xfe\xff\0v").unwrap_err().starts_with("a.obj: is UTF-16"));
        assert!(decode(b"v 1\nv\0 2").unwrap_err().starts_with("a.obj:2: holds a NUL byte"));
    }
}
