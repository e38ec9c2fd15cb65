use std::io;
use std::path::PathBuf;

use crate::compare::CompareError;
use crate::output::OutputError;
use crate::scene::TraversalError;

/// Why a study could not be made.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// The scene cannot be traced.
    #[error(transparent)]
    Traversal(#[from] TraversalError),
    /// The reference does not fit the pictures.
    #[error(transparent)]
    Compare(#[from] CompareError),
    /// A picture could not be written or read.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The list of measurements cannot be read or written.
    #[error("{path}: {source}; a study needs a folder that it may write to", path = path.display())]
    Journal {
        /// The list.
        path: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// A line of the list of measurements, not the last one, is no measurement.
    #[error("{path}:{line}: not a measurement of this program ({reason}); remove the file to begin anew", path = path.display())]
    Line {
        /// The list.
        path: PathBuf,
        /// Counted from 1.
        line: usize,
        /// What the parser says.
        reason: String,
    },
    /// The error of a picture is no number.
    #[error(
        "{configuration}: the picture or the reference holds values that are not finite; no error can be told"
    )]
    NotFinite {
        /// What was rendered.
        configuration: String,
    },
}
