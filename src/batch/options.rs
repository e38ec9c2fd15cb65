//! What holds for all jobs of a batch.

use super::{Axis, Settings};

/// What holds for all jobs that say nothing else.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Axes that every job is swept along, in the place of its own settings.
    pub sweep: Vec<Axis>,
    /// The budget (`passes`, `time`, `target-error`) of jobs that have none of their own.
    pub budget: Settings,
    /// Retries after crashes.
    pub retries: u32,
    /// Bytes that the process of a job may hold.
    pub memory_limit: Option<u64>,
}

/// The flags that are a budget.
pub const BUDGET: [&str; 3] = ["passes", "time", "target-error"];
