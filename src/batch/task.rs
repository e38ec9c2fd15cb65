//! A job on its way.

use std::path::PathBuf;

use super::forecast::Left;
use super::{Job, Row};

/// A job that is to be done.
#[derive(Debug)]
pub(super) struct Task {
    pub job: Job,
    pub started_in: PathBuf,
    pub deaths: u32,
    pub photons_a_pass: Option<f64>,
    pub passes: Option<u32>,
    pub passes_done: u32,
    pub is_over: bool,
}

impl Task {
    pub fn of(row: Row) -> Task {
        Task {
            job: row.job,
            started_in: row.started_in,
            deaths: 0,
            photons_a_pass: None,
            passes: None,
            passes_done: 0,
            is_over: false,
        }
    }

    pub fn left(&self) -> Left {
        let passes = self.passes.map(f64::from);
        Left {
            photons: self.photons_a_pass.zip(passes).map(|(photons, passes)| photons * passes),
            share: passes
                .filter(|passes| *passes > 0.0)
                .map_or(0.0, |passes| f64::from(self.passes_done) / passes),
        }
    }
}
