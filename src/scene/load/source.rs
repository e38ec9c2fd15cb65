//! The text of a scene file, and errors that point into it.

use std::ops::Range;
use std::path::Path;

use super::super::SceneError;

/// A scene file's path and text.
pub(super) struct Source<'a> {
    pub path: &'a Path,
    pub text: &'a str,
    /// Where lines end.
    newlines: Vec<usize>,
}

impl<'a> Source<'a> {
    pub fn new(path: &'a Path, text: &'a str) -> Source<'a> {
        Source { path, text, newlines: text.match_indices('\n').map(|(at, _)| at).collect() }
    }

    /// An error at the start of `span` (in bytes).
    pub fn error(&self, span: &Range<usize>, reason: String) -> SceneError {
        let (line, column) = self.place(span.start);
        SceneError::Field { path: self.path.to_owned(), line, column, reason }
    }

    /// The line, counted from 1, in which `span` starts.
    pub fn line(&self, span: &Range<usize>) -> usize {
        self.newlines.partition_point(|&newline| newline < span.start) + 1
    }

    fn place(&self, byte: usize) -> (usize, usize) {
        let before = self.text.get(..byte).unwrap_or(self.text);
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        (self.line(&(byte..byte)), before[line_start..].chars().count() + 1)
    }
}

/// An error about a whole file.
pub(super) fn file_error(path: &Path, reason: impl Into<String>) -> SceneError {
    SceneError::File { path: path.to_owned(), reason: reason.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_count_lines_and_characters_from_one() {
        let source = Source::new(Path::new("s"), "ä\nöü = 1\n");
        assert_eq!(source.place(0), (1, 1));
        assert_eq!(source.place(source.text.find('=').unwrap()), (2, 4));
        assert_eq!(source.place(1000), (3, 1));
    }
}
