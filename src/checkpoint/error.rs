use std::io;
use std::path::PathBuf;

use crate::ppm::ForeignState;
use crate::sealed::FormatError;

/// Why a checkpoint is not used; every text names the file, what is wrong and what would be right.
#[derive(Debug, thiserror::Error)]
pub enum CheckpointError {
    /// The file cannot be read.
    #[error("{path}: the checkpoint cannot be read: {source}; see that it is a file that you may read")]
    Read {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// The file holds no checkpoint that can be used, nor does the one before it.
    #[error(
        "{path}: {reason}, and there is no good {previous}; name another file, or remove it to start anew"
    )]
    Unusable {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: FormatError,
        /// Where the checkpoint before it would be.
        previous: PathBuf,
    },
    /// It belongs to another render.
    #[error(
        "{path}: this checkpoint belongs to another render:\n  {}\nrender with the same scene and settings, or remove it to start anew",
        .differences.join("\n  ")
    )]
    Different {
        /// The file.
        path: PathBuf,
        /// By name, what the two differ in.
        differences: Vec<String>,
    },
    /// Everything that it names is alike, and still it does not fit.
    #[error("{path}: this checkpoint cannot go on here: {source}; remove it to start anew")]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What does not fit.
        source: ForeignState,
    },
}
