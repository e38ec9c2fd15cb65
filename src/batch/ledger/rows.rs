//! Rows of the ledger.

use std::path::PathBuf;

use serde::Serialize;

use super::super::{Job, Settings, Verdict};

/// How far a job is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum State {
    /// It has its turn yet to come, again or for the first time.
    Waiting,
    /// A process is at it.
    Running,
    /// Its picture is there.
    Done,
    /// There is none; the row says why.
    Failed,
}

impl State {
    /// All of them.
    pub const ALL: [State; 4] = [State::Waiting, State::Running, State::Done, State::Failed];

    /// As the ledger has it.
    pub fn name(self) -> &'static str {
        match self {
            State::Waiting => "waiting",
            State::Running => "running",
            State::Done => "done",
            State::Failed => "failed",
        }
    }

    pub(in super::super) fn after(verdict: &Verdict) -> State {
        match verdict {
            Verdict::Done(_) => State::Done,
            Verdict::Failed { .. } | Verdict::Died { again: false, .. } => State::Failed,
            Verdict::Died { again: true, .. } | Verdict::Stopped => State::Waiting,
        }
    }

    fn named(name: &str) -> State {
        State::ALL.into_iter().find(|state| state.name() == name).unwrap_or(State::Waiting)
    }
}

/// A job as the ledger knows it.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The job.
    pub job: Job,
    /// Whether it is in the list that was last given.
    pub is_listed: bool,
    /// The folder that its batch was started in, which its scene is relative to.
    pub started_in: PathBuf,
    /// The arguments that it was last listed with, as JSON.
    pub arguments: String,
    /// How far it is.
    pub state: State,
    /// Why it failed, or waits again.
    pub reason: Option<String>,
    /// The program of the last attempt.
    pub program: Option<String>,
    /// Passes of its picture.
    pub passes: Option<u32>,
    /// Seconds of its render, without loading the scene.
    pub seconds: Option<f64>,
    /// The error reached (√relMSE).
    pub error: Option<f64>,
    /// What the error stays below, with the confidence asked for.
    pub error_bound: Option<f64>,
}

impl Row {
    pub(super) fn read(row: &rusqlite::Row) -> rusqlite::Result<Row> {
        let settings: String = row.get("settings")?;
        Ok(Row {
            job: Job {
                name: row.get("name")?,
                scene: row.get::<_, String>("scene")?.into(),
                settings: serde_json::from_str::<Settings>(&settings).unwrap_or_default(),
                priority: row.get("priority")?,
                retries: row.get("retries")?,
                memory_limit: row.get::<_, Option<i64>>("memory_limit")?.map(|bytes| bytes as u64),
            },
            is_listed: row.get::<_, Option<i64>>("place")?.is_some(),
            started_in: row.get::<_, String>("started_in")?.into(),
            arguments: row.get("arguments")?,
            state: State::named(&row.get::<_, String>("state")?),
            reason: row.get("reason")?,
            program: row.get("program")?,
            passes: row.get("passes")?,
            seconds: row.get("seconds")?,
            error: row.get("error")?,
            error_bound: row.get("error_bound")?,
        })
    }
}

/// One process that was at a job.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Attempt {
    /// Counted from 1, over all batches.
    pub number: u32,
    /// When it began, by the clock of the machine: for people alone.
    pub began: String,
    /// The id of its process.
    pub process: u32,
    /// Its threads.
    pub threads: u32,
    /// Seconds of loading and building the scene.
    pub load_seconds: Option<f64>,
    /// Seconds of the render.
    pub seconds: Option<f64>,
    /// How it ended: done, failed, died, stopped or lost; `None` while it runs.
    pub outcome: Option<String>,
    /// Why, unless it is done.
    pub reason: Option<String>,
    /// The last lines that it said on standard error.
    pub last_words: Option<String>,
    /// The most memory that it held, in bytes.
    pub peak_memory: Option<i64>,
}

impl Attempt {
    pub(super) fn read(row: &rusqlite::Row) -> rusqlite::Result<Attempt> {
        Ok(Attempt {
            number: row.get("number")?,
            began: row.get("began")?,
            process: row.get("process")?,
            threads: row.get("threads")?,
            load_seconds: row.get("load_seconds")?,
            seconds: row.get("seconds")?,
            outcome: row.get("outcome")?,
            reason: row.get("reason")?,
            last_words: row.get("last_words")?,
            peak_memory: row.get("peak_memory")?,
        })
    }
}
