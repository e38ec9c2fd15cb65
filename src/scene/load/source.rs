//! The text of a scene file, and errors that point into it.

use std::fs;
use std::ops::Range;
use std::path::Path;

use super::super::SceneError;

/// A scene file's path and text.
pub(super) struct Source<'a> {
    pub path: &'a Path,
    pub text: &'a str,
}

impl Source<'_> {
    /// An error at the start of `span` (in bytes).
    pub fn error(&self, span: &Range<usize>, reason: String) -> SceneError {
        let (line, column) = self.place(span.start);
        SceneError::Field { path: self.path.to_owned(), line, column, reason }
    }

    /// The line, counted from 1, in which `span` starts.
    pub fn line(&self, span: &Range<usize>) -> usize {
        self.place(span.start).0
    }

    fn place(&self, byte: usize) -> (usize, usize) {
        let before = self.text.get(..byte).unwrap_or(self.text);
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
    }
}

/// An error about a whole file.
pub(super) fn file_error(path: &Path, reason: impl Into<String>) -> SceneError {
    SceneError::File { path: path.to_owned(), reason: reason.into() }
}

/// The bytes of a file; `kind` says what is expected there.
pub(super) fn read_bytes(path: &Path, kind: &str) -> Result<Vec<u8>, SceneError> {
    if path.is_dir() {
        return Err(file_error(path, format!("is a folder; {kind} is expected")));
    }
    fs::read(path).map_err(|e| file_error(path, format!("cannot be read: {e}; {kind} is expected")))
}

/// The text of a scene file without its byte order mark, if it has one.
pub(super) fn read_scene_text(path: &Path) -> Result<String, SceneError> {
    const KIND: &str = "a scene file (TOML, UTF-8)";
    let text = String::from_utf8(read_bytes(path, KIND)?).map_err(|e| {
        let line = e.as_bytes()[..e.utf8_error().valid_up_to()].split(|&b| b == b'\n').count();
        file_error(path, format!("is not UTF-8 (line {line}); {KIND} is expected"))
    })?;
    if text.trim().is_empty() {
        return Err(file_error(path, format!("is empty; {KIND} with at least [camera] is expected")));
    }
    Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_count_lines_and_characters_from_one() {
        let source = Source { path: Path::new("s"), text: "ä\nöü = 1\n" };
        assert_eq!(source.place(0), (1, 1));
        assert_eq!(source.place(source.text.find('=').unwrap()), (2, 4));
        assert_eq!(source.place(1000), (3, 1));
    }
}
