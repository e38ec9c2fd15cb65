//! What happens to jobs, for the ledger.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// A file and the hash of what is in it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct FileHash {
    /// Where it is.
    pub path: PathBuf,
    /// BLAKE3 in hexadecimal; `None` for a file that was looked for and is not there.
    pub hash: Option<String>,
}

/// A step of a job.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Change {
    /// A process is at it.
    Began {
        /// Its name.
        job: String,
        /// The process.
        process: u32,
        /// Its threads.
        threads: usize,
    },
    /// The scene is loaded, or found to be broken.
    Loaded {
        /// Its name.
        job: String,
        /// What that took.
        seconds: f64,
        /// The files of the scene.
        inputs: Vec<FileHash>,
    },
    /// The process is at it no more.
    Ended {
        /// Its name.
        job: String,
        /// What came of it.
        verdict: Verdict,
        /// The last lines of its standard error.
        last_words: String,
    },
    /// The process of a job that is over had warned of something.
    Warned {
        /// Its name.
        job: String,
        /// The process.
        process: u32,
        /// Its last warnings, a line each.
        warnings: String,
    },
}

/// What came of an attempt.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The picture is there.
    Done(Done),
    /// It would come to the same another time: there is no picture.
    Failed {
        /// Why.
        reason: String,
    },
    /// Its process died.
    Died {
        /// Of what.
        reason: String,
        /// Whether it is begun again.
        again: bool,
    },
    /// The batch was asked to stop.
    Stopped,
}

/// What a finished job came to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Done {
    /// Passes of the picture.
    pub passes: u32,
    /// Seconds of the render, those of processes before included.
    pub seconds: f64,
    /// √relMSE, where it is known.
    pub error: Option<f64>,
    /// What the error stays below, with the confidence asked for.
    pub error_bound: Option<f64>,
    /// The most memory that the process ever held, in bytes.
    pub peak_memory: Option<u64>,
    /// Its pictures.
    pub outputs: Vec<FileHash>,
}

impl Verdict {
    pub(super) fn name(&self) -> &'static str {
        match self {
            Verdict::Done(_) => "done",
            Verdict::Failed { .. } => "failed",
            Verdict::Died { .. } => "died",
            Verdict::Stopped => "stopped",
        }
    }

    pub(super) fn reason(&self) -> Option<&str> {
        match self {
            Verdict::Done(_) => None,
            Verdict::Failed { reason } | Verdict::Died { reason, .. } => Some(reason),
            Verdict::Stopped => Some("the batch was stopped"),
        }
    }
}
