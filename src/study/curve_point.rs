//! What the repetitions of a configuration have in common at one look.

use serde::Serialize;

use super::Separation;
use crate::bench::timing::Spread;

/// A mean and the ends.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ErrorSpread {
    /// The mean of the repetitions.
    pub mean: f64,
    /// The smallest.
    pub min: f64,
    /// The largest.
    pub max: f64,
}

impl ErrorSpread {
    pub(super) fn of(numbers: impl Iterator<Item = f64> + Clone) -> ErrorSpread {
        let mean = numbers.clone().sum::<f64>() / numbers.clone().count().max(1) as f64;
        let Spread { min, max, .. } = Spread::of(numbers);
        ErrorSpread { mean, min, max }
    }
}

/// What all repetitions have at a number of steps.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CurvePoint {
    /// Passes, or samples a pixel.
    pub steps: u32,
    /// Repetitions that came so far.
    pub repetitions: usize,
    /// Seconds of set-up and steps.
    pub seconds: Spread,
    /// Relative root-mean-square error in percent.
    pub error_percent: ErrorSpread,
    /// Mean of the relative mean square errors.
    pub rel_mse: f64,
    /// What of that is variance and what is bias; none for a single repetition.
    pub separation: Option<Separation>,
    /// The command that renders the picture of the first repetition.
    pub command: String,
}
