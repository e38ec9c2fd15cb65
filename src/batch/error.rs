use std::io;
use std::path::PathBuf;

use crate::output::OutputError;

/// Why a batch could not be run, or be told of. What befalls a job is no error of the batch: it is in the ledger.
#[derive(Debug, thiserror::Error)]
pub enum BatchError {
    /// A job list does not say what is to be done.
    #[error("{path}:{line}: {reason}", path = path.display())]
    List {
        /// The job list.
        path: PathBuf,
        /// Counted from 1.
        line: usize,
        /// What is wrong there, and what is allowed.
        reason: String,
    },
    /// What was given in the place of jobs is none.
    #[error("{given}: {reason}")]
    Jobs {
        /// As the user wrote it.
        given: String,
        /// What is wrong, and what is allowed.
        reason: String,
    },
    /// Another batch writes into the folder.
    #[error("{folder}: another batch writes there ({holder}); wait for its end, or name another folder by -o", folder = folder.display())]
    Held {
        /// The output folder.
        folder: PathBuf,
        /// Who, as far as it is known.
        holder: String,
    },
    /// There is no batch in the folder.
    #[error("{folder}: there is no ledger of a batch; `caustica batch JOBS -o {folder}` makes one", folder = folder.display())]
    NoLedger {
        /// The folder.
        folder: PathBuf,
    },
    /// The file in the ledger's place is something else.
    #[error("{path}: is no ledger of a batch ({reason}); move it elsewhere, or name another folder by -o", path = path.display())]
    NotALedger {
        /// The file.
        path: PathBuf,
        /// What it is instead.
        reason: String,
    },
    /// A later program wrote the ledger.
    #[error("{path}: the ledger has version {version}, this program knows those up to {known}; use the program that wrote it, or another folder", path = path.display())]
    NewerLedger {
        /// The ledger.
        path: PathBuf,
        /// Its version.
        version: i64,
        /// The latest that this program knows.
        known: i64,
    },
    /// An earlier program wrote the ledger, and who only reads does not change it.
    #[error("{path}: the ledger has version {version}, this program reads {known}; `caustica batch resume {folder}` brings it up to date", path = path.display(), folder = folder.display())]
    OlderLedger {
        /// The ledger.
        path: PathBuf,
        /// Its folder.
        folder: PathBuf,
        /// Its version.
        version: i64,
        /// The version that this program reads.
        known: i64,
    },
    /// The ledger cannot be read or written; what it held before, it holds still.
    #[error("{path}: {source}; what was noted before is whole, `caustica batch resume {folder}` goes on when that is mended", path = path.display(), folder = folder.display())]
    Ledger {
        /// The ledger.
        path: PathBuf,
        /// Its folder.
        folder: PathBuf,
        /// What SQLite says.
        source: rusqlite::Error,
    },
    /// A file or folder of the batch cannot be made or read.
    #[error("{path}: {source}", path = path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// No process for a job can be started.
    #[error("cannot start a process in {folder}: {source}", folder = folder.display())]
    Start {
        /// The folder that the scene is relative to.
        folder: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// The report cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
}
