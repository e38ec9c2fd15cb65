use std::io;
use std::path::PathBuf;

use super::Passes;
use crate::sealed::FormatError;

/// Why a shard is not used; every text names the file, what is wrong and what would be right.
#[derive(Debug, thiserror::Error)]
pub enum ShardError {
    /// The file cannot be read.
    #[error("{path}: the shard cannot be read: {source}; see that it is a file that you may read")]
    Read {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// The file holds no shard that can be used.
    #[error("{path}: {reason}; remove it, and render its passes again")]
    Unusable {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: FormatError,
    },
    /// It belongs to another picture.
    #[error(
        "{path}: this shard belongs to another picture than {other}:\n  {}\nshards of the same scene, settings and program add up to a picture",
        .differences.join("\n  ")
    )]
    Different {
        /// The file.
        path: PathBuf,
        /// That which it is held against.
        other: PathBuf,
        /// By name, what the two differ in.
        differences: Vec<String>,
    },
    /// Some of its passes are in another one, too.
    #[error(
        "{path}: the passes {passes} are in {other}, too; leave one of the two out, since no pass may count twice"
    )]
    Overlap {
        /// The file.
        path: PathBuf,
        /// That which has the passes, too.
        other: PathBuf,
        /// The passes.
        passes: Passes,
    },
}
