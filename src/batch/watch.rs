//! Who runs a batch, and who looks on.

use std::path::PathBuf;

use serde::Serialize;

use super::{Change, Layout};

/// What a batch runs with.
#[derive(Clone, Debug)]
pub struct Crew {
    /// The program that makes pictures: this one.
    pub program: PathBuf,
    /// What tells it from others, for the ledger.
    pub version: String,
    /// Where pictures go: an absolute path.
    pub folder: PathBuf,
}

/// Follows a batch, and may end it.
pub trait Watch {
    /// Whether to stop: what is being rendered finishes its pass and keeps a checkpoint.
    fn is_over(&self) -> bool;
    /// A job took a step.
    fn step(&mut self, change: &Change);
    /// How threads are shared out was found by trial.
    fn layout(&mut self, layout: Layout, measured: &str);
    /// How the whole batch stands; comes several times a second.
    fn standing(&mut self, standing: &Standing);
}

/// How a batch stands: numbers of jobs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Standing {
    /// All.
    pub jobs: usize,
    /// Done before, and still as they were.
    pub unchanged: usize,
    /// Done now.
    pub done: usize,
    /// Without a picture.
    pub failed: usize,
    /// Whose scene is being loaded, or has been.
    pub loading: usize,
    /// Being rendered.
    pub rendering: usize,
    /// Until the last is done; `None` before the first is.
    pub seconds_left: Option<f64>,
}

impl Standing {
    /// Jobs that still have to be begun, or begun again.
    pub fn waiting(&self) -> usize {
        self.jobs - self.unchanged - self.done - self.failed - self.loading - self.rendering
    }
}
