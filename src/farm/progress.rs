use std::path::Path;

use serde::Serialize;

use super::{FarmError, Submission, Task};
use crate::shard::{Passes, passes_of};

/// How far a task is, by its shard alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum TaskState {
    /// There is no shard.
    Missing,
    /// The shard lacks passes: it was stopped, or is under way.
    Begun,
    /// The shard has all passes.
    Whole,
}

/// How far the tasks of a folder are.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Progress {
    /// Passes in shards.
    pub passes: u32,
    /// Passes of the picture.
    pub of: u32,
    /// By number.
    pub tasks: Vec<TaskState>,
    /// Whether there is a picture.
    pub picture: bool,
}

impl Progress {
    /// Looks at the shards of `folder`.
    ///
    /// # Errors
    /// When a shard cannot be read, or is damaged.
    pub fn of(submission: &Submission, folder: &Path) -> Result<Progress, FarmError> {
        let tasks = submission.tasks(folder)?;
        let found: Vec<Passes> = tasks.iter().map(found).collect::<Result<_, _>>()?;
        let states = tasks.iter().zip(&found).map(|(task, found)| state(task, found)).collect();
        Ok(Progress {
            passes: found.iter().map(Passes::count).sum(),
            of: submission.passes,
            tasks: states,
            picture: submission.output.exists(),
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

fn found(task: &Task) -> Result<Passes, FarmError> {
    if !task.shard.exists() {
        return Ok(Passes::default());
    }
    Ok(passes_of(&task.shard)?.common(&task.passes.into()))
}

fn state(task: &Task, found: &Passes) -> TaskState {
    match found.count() {
        0 => TaskState::Missing,
        count if count < task.passes.count() => TaskState::Begun,
        _ => TaskState::Whole,
    }
}
