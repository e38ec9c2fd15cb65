use std::path::PathBuf;

/// Why a scene could not be read: the file, the place in it, what is wrong there and what would be right.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// A file as a whole: it is missing, a folder, empty, or not text.
    #[error("{}: {reason}", path.display())]
    File {
        /// The file, as it was asked for.
        path: PathBuf,
        /// What is wrong and what would be right.
        reason: String,
    },
    /// A line of a mesh file or of an XML file.
    #[error("{}:{line}: {reason}", path.display())]
    Line {
        /// That file.
        path: PathBuf,
        /// Counted from 1.
        line: usize,
        /// What is wrong and what would be right.
        reason: String,
    },
    /// A key or value of a scene file.
    #[error("{}:{line}:{column}: {reason}", path.display())]
    Field {
        /// The scene file.
        path: PathBuf,
        /// Counted from 1.
        line: usize,
        /// Counted from 1, in characters.
        column: usize,
        /// What is wrong and what would be right.
        reason: String,
    },
}

impl SceneError {
    /// What is wrong and what would be right, without the place.
    pub(super) fn reason(&self) -> &str {
        match self {
            SceneError::File { reason, .. }
            | SceneError::Line { reason, .. }
            | SceneError::Field { reason, .. } => reason,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_start_with_the_place() {
        let (path, reason) = (PathBuf::from("a/b.toml"), String::from("no"));
        let file = SceneError::File { path: path.clone(), reason: reason.clone() };
        let line = SceneError::Line { path: path.clone(), line: 3, reason: reason.clone() };
        let field = SceneError::Field { path, line: 3, column: 7, reason };
        let texts = [file, line, field].map(|e| e.to_string());
        assert_eq!(texts, ["a/b.toml: no", "a/b.toml:3: no", "a/b.toml:3:7: no"]);
    }
}
