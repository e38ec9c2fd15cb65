//! What a render tells about itself, for people and for machines.

use std::time::Instant;

use rayon::prelude::*;
use serde::Serialize;

use super::{GatherState, Ledger, Render};

/// What the set-up of a render found and took.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SetupStatistics {
    /// Hit points left by the eye pass.
    pub hit_points: u64,
    /// Rays of the eye pass.
    pub eye_rays: u64,
    /// Shadow rays of the set-up.
    pub shadow_rays: u64,
    /// The share of the picture's weight that the depth limit cut.
    pub cut_weight: f64,
    /// Initial radius, in scene units.
    pub radius: f64,
    /// Seconds of the eye pass.
    pub eye_seconds: f64,
    /// Seconds of building the tree.
    pub tree_seconds: f64,
    /// Seconds of the first direct light.
    pub direct_seconds: f64,
}

/// Seconds of each phase of a pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PhaseSeconds {
    /// Sampling the area lights at the hit points.
    pub direct: f64,
    /// Tracing photons.
    pub trace: f64,
    /// Adding them to hit points.
    pub gather: f64,
    /// Radius reduction.
    pub update: f64,
    /// Refitting the tree.
    pub refit: f64,
}

impl PhaseSeconds {
    /// The whole pass.
    pub fn total(&self) -> f64 {
        self.direct + self.trace + self.gather + self.update + self.refit
    }
}

/// The radii of all hit points, in scene units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct RadiusRange {
    /// The smallest.
    pub min: f64,
    /// Their mean.
    pub mean: f64,
    /// The largest.
    pub max: f64,
}

/// What a pass did.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PassStatistics {
    /// Number of the pass, from 1.
    pub pass: u32,
    /// Seconds of the whole pass.
    pub seconds: f64,
    /// Seconds of its phases.
    pub phases: PhaseSeconds,
    /// Photon rays and shadow rays.
    pub rays: u64,
    /// Where the photons went.
    pub photons: Ledger,
    /// Photons added to hit points, counted once for each hit point.
    pub gathered: u64,
    /// Photons within a radius, but on another side than the one that is seen.
    pub rejected_by_side: u64,
    /// Photons emitted so far.
    pub emitted_in_all: u64,
    /// Radii after the pass.
    pub radius: RadiusRange,
    /// Heap memory of hit points, statistics and tree, in bytes.
    pub memory_bytes: u64,
}

/// Seconds between its laps.
pub(super) struct Stopwatch(Instant);

impl Stopwatch {
    pub(super) fn start() -> Stopwatch {
        Stopwatch(Instant::now())
    }

    pub(super) fn lap(&mut self) -> f64 {
        let now = Instant::now();
        let seconds = (now - self.0).as_secs_f64();
        self.0 = now;
        seconds
    }
}

/// Accepted and rejected photons of the running pass, over all hit points.
pub(super) fn gathered(states: &[GatherState]) -> [u64; 2] {
    states
        .par_iter()
        .map(|s| [u64::from(s.pass.accepted), u64::from(s.pass.rejected)])
        .reduce(|| [0; 2], |a, b| [a[0] + b[0], a[1] + b[1]])
}

/// States that one task sums; fixed, so that the order of the sum is.
const CHUNK: usize = 1 << 14;

fn radius_range(states: &[GatherState]) -> RadiusRange {
    if states.is_empty() {
        return RadiusRange::default();
    }
    let chunks: Vec<RadiusRange> = states.par_chunks(CHUNK).map(radii_of).collect();
    let all = chunks.iter().copied().reduce(combine).unwrap_or_default();
    RadiusRange { mean: all.mean / states.len() as f64, ..all }
}

/// Of one chunk, with the sum in place of the mean.
fn radii_of(states: &[GatherState]) -> RadiusRange {
    let single = |state: &GatherState| {
        let r = state.radius();
        RadiusRange { min: r, mean: r, max: r }
    };
    states.iter().map(single).reduce(combine).unwrap_or_default()
}

fn combine(a: RadiusRange, b: RadiusRange) -> RadiusRange {
    RadiusRange { min: a.min.min(b.min), mean: a.mean + b.mean, max: a.max.max(b.max) }
}

impl Render<'_> {
    pub(super) fn statistics(
        &self,
        phases: PhaseSeconds,
        photons: Ledger,
        [gathered, rejected_by_side]: [u64; 2],
        shadow_rays: u64,
    ) -> PassStatistics {
        PassStatistics {
            pass: self.passes,
            seconds: phases.total(),
            phases,
            rays: photons.rays + shadow_rays,
            photons,
            gathered,
            rejected_by_side,
            emitted_in_all: self.emitted_photons,
            radius: radius_range(&self.states),
            memory_bytes: self.memory_bytes() as u64,
        }
    }
}
