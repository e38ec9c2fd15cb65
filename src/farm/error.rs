use std::io;
use std::path::PathBuf;

use crate::batch::BatchError;
use crate::output::OutputError;
use crate::shard::ShardError;

/// Why work cannot be spread.
#[derive(Debug, thiserror::Error)]
pub enum FarmError {
    /// A file of the folder cannot be read.
    #[error("cannot read {path}: {source}; name a folder that `caustica submit` wrote", path = path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A file of the folder holds something else.
    #[error("{path}: {reason}; name a folder that `caustica submit` wrote", path = path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// The folder belongs to other work.
    #[error("{path} is the folder of another submission, whose {what} differs; name another with --folder, or remove it", path = path.display())]
    OtherSubmission {
        /// The folder.
        path: PathBuf,
        /// The first difference.
        what: &'static str,
    },
    /// A path that cannot stand in a script.
    #[error("{path} is no UTF-8 or holds a line break, and cannot stand in a script; rename it", path = path.display())]
    Path {
        /// The path.
        path: PathBuf,
    },
    /// A file cannot be written.
    #[error(transparent)]
    Write(#[from] OutputError),
    /// A shard is damaged, or none.
    #[error(transparent)]
    Shard(#[from] ShardError),
    /// The ledger of a job cannot be read.
    #[error(transparent)]
    Batch(#[from] BatchError),
    /// A program of Slurm does not run.
    #[error(
        "cannot run {program}: {source}; Slurm's programs are to be in PATH, or give --dry-run to write the scripts alone"
    )]
    NoSlurm {
        /// Its name.
        program: &'static str,
        /// What the system said.
        source: io::Error,
    },
    /// Slurm refuses.
    #[error("{program} refuses: {message}")]
    Refused {
        /// The program.
        program: &'static str,
        /// What it said.
        message: String,
    },
}
