//! Runs of rivals whose errors are compared at equal time: noise is all that they err by.

use std::convert::Infallible;

use super::timing::interleaved;
use crate::ppm::{RadiusPolicy, Settings};

/// What to measure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EqualTimeSettings {
    /// The render; radii are held at their initial value, so that the error is noise alone.
    pub render: Settings,
    /// Passes of every run.
    pub passes: u32,
    /// Runs of every rival, each with a seed of its own.
    pub repetitions: usize,
}

impl EqualTimeSettings {
    /// The render with radii held, and with the same eye paths whatever the seed.
    pub(super) fn held(&self) -> Settings {
        Settings {
            policy: RadiusPolicy::Fixed,
            eye_seed: Some(self.render.key_of_eye_paths()),
            ..self.render
        }
    }

    /// Runs every rival once in each round, by the round's seed: rivals that do the same make the same errors.
    pub(super) fn runs<R, S>(&self, rivals: &[R], mut run: impl FnMut(&R, u64) -> S) -> Vec<Vec<S>> {
        let mut runs = 0;
        let Ok(samples) = interleaved(self.repetitions, rivals, |rival| {
            let seed = self.render.seed + 1 + runs / rivals.len() as u64;
            runs += 1;
            Ok::<S, Infallible>(run(rival, seed))
        });
        samples
    }
}
