use std::io;
use std::path::PathBuf;

use crate::ppm::ForeignState;

/// What is wrong with the bytes of a checkpoint.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FormatError {
    /// They do not begin as a checkpoint does.
    #[error("not a checkpoint")]
    NotACheckpoint,
    /// They are not those that were written: cut off, or changed.
    #[error("damaged: its bytes are not those that were written")]
    Damaged,
    /// They are whole, but laid out in another way.
    #[error("its layout has number {found}, and this program reads number {supported} alone")]
    Version {
        /// The number that stands in the file.
        found: u32,
        /// The one that is read.
        supported: u32,
    },
    /// They are whole, but do not follow their layout: no version of this program wrote them.
    #[error("its content follows no layout ({0})")]
    Content(String),
}

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
