use std::path::Path;

use serde::Serialize;

use super::{FarmError, Product, Submission, Work};
use crate::batch::{LEDGER, Ledger, State};
use crate::shard::{PassRange, passes_of};

/// How far a task is, by the files of its product alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum TaskState {
    /// There is nothing of it.
    Missing,
    /// It was stopped, or is under way.
    Begun,
    /// Its job failed: the ledger tells why.
    Failed,
    /// All of it is there.
    Whole,
}

impl TaskState {
    /// From the worst to the best.
    pub const ALL: [TaskState; 4] =
        [TaskState::Missing, TaskState::Begun, TaskState::Failed, TaskState::Whole];
}

/// How far the tasks of a folder are.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Progress {
    /// By number.
    pub tasks: Vec<TaskState>,
    /// Passes in shards, and those of the picture, where there is one.
    pub passes: Option<(u32, u32)>,
    /// Whether the picture is there, or those of all jobs.
    pub is_complete: bool,
}

impl Progress {
    /// Looks at what the tasks in `folder` made.
    ///
    /// # Errors
    /// When a shard or a ledger cannot be read, or is damaged.
    pub fn of(submission: &Submission, folder: &Path) -> Result<Progress, FarmError> {
        let tasks = submission.tasks(folder)?;
        let found: Vec<Found> = tasks.iter().map(|task| found(&task.product)).collect::<Result<_, _>>()?;
        let tasks: Vec<TaskState> = found.iter().map(|found| found.state).collect();
        let are_whole = tasks.iter().all(|&state| state == TaskState::Whole);
        let passes = found.iter().map(|found| found.passes).sum();
        Ok(match &submission.work {
            Work::Picture(picture) => {
                let is_complete = picture.output.exists();
                Progress { tasks, passes: Some((passes, picture.passes)), is_complete }
            }
            Work::Jobs(_) => Progress { tasks, passes: None, is_complete: are_whole },
        })
    }

    /// The numbers of the tasks that are not whole.
    pub fn unfinished(&self) -> Vec<u32> {
        let numbers = (0..).zip(&self.tasks);
        numbers.filter(|(_, state)| **state != TaskState::Whole).map(|(number, _)| number).collect()
    }

    /// How many tasks are in `state`.
    pub fn count(&self, state: TaskState) -> usize {
        self.tasks.iter().filter(|&&theirs| theirs == state).count()
    }
}

/// What is there of a product.
struct Found {
    state: TaskState,
    passes: u32,
}

fn found(product: &Product) -> Result<Found, FarmError> {
    match product {
        Product::Shard { path, passes } => found_shard(path, *passes),
        Product::Job { folder } => Ok(Found { state: job(folder)?, passes: 0 }),
    }
}

fn found_shard(path: &Path, passes: PassRange) -> Result<Found, FarmError> {
    if !path.exists() {
        return Ok(Found { state: TaskState::Missing, passes: 0 });
    }
    let there = passes_of(path)?.common(&passes.into()).count();
    let state = if there < passes.count() { TaskState::Begun } else { TaskState::Whole };
    Ok(Found { state, passes: there })
}

fn job(folder: &Path) -> Result<TaskState, FarmError> {
    if !folder.join(LEDGER).exists() {
        return Ok(TaskState::Missing);
    }
    let rows = Ledger::look(folder)?.rows()?;
    Ok(match rows.iter().find(|row| row.is_listed).map(|row| row.state) {
        None | Some(State::Waiting | State::Running) => TaskState::Begun,
        Some(State::Failed) => TaskState::Failed,
        Some(State::Done) => TaskState::Whole,
    })
}
