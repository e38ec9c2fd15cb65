//! What a render tells about itself, for people and for machines.

use std::time::Instant;

use rayon::prelude::*;
use serde::Serialize;

use super::{AimPlan, GuidePlan, Ledger, Render};
use crate::effects::PathClasses;

/// What the set-up of a render found and took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
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
    /// Seconds of deriving the plan.
    pub plan_seconds: f64,
    /// Seconds of the eye pass.
    pub eye_seconds: f64,
    /// Seconds of building the tree.
    pub tree_seconds: f64,
    /// Seconds of the first direct light.
    pub direct_seconds: f64,
    /// How many photons are aimed at casters of caustics, where there is anything to aim at.
    pub aim: Option<AimPlan>,
    /// Whether photons are guided to what is seen, where that was tried.
    pub guide: Option<GuidePlan>,
    /// Seconds of deciding both.
    pub aim_seconds: f64,
}

/// Seconds of each phase of a pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct PhaseSeconds {
    /// Tracing eye paths anew, and building the tree over their hit points.
    pub eye: f64,
    /// Sampling the lights at the hit points.
    pub direct: f64,
    /// Tracing photons.
    pub trace: f64,
    /// Adding them to hit points, radius reduction and refitting the tree: one walk.
    pub gather: f64,
    /// Keeping the statistics that the error is estimated from.
    pub errors: f64,
}

impl PhaseSeconds {
    /// The whole pass.
    pub fn total(&self) -> f64 {
        self.eye + self.direct + self.trace + self.gather + self.errors
    }
}

/// The radii of all hit points, in scene units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct RadiusRange {
    /// The smallest.
    pub min: f64,
    /// Their mean.
    pub mean: f64,
    /// The largest.
    pub max: f64,
    /// How many are as small as the coordinates of their hit points allow, and shrink no more.
    pub floored: u64,
}

/// What a pass brought by kinds of paths that are kept together.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct CollectorStatistics {
    /// The kinds of paths.
    pub kinds: PathClasses,
    /// Photons added to hit points, counted once for each hit point.
    pub gathered: u64,
    /// Photons within a radius, but on another side than the one that is seen.
    pub rejected_by_side: u64,
    /// Radii after the pass.
    pub radius: RadiusRange,
}

/// What a pass did.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct PassStatistics {
    /// Number of the pass, from 1.
    pub pass: u32,
    /// Seconds of the whole pass.
    pub seconds: f64,
    /// Seconds of its phases.
    pub phases: PhaseSeconds,
    /// Photon rays, shadow rays, and rays of eye paths that are retraced.
    pub rays: u64,
    /// Where the photons went that left the lights naturally.
    pub photons: Ledger,
    /// Where the aimed ones went; they end at their first diffuse event.
    pub aimed_photons: Ledger,
    /// Photons added to hit points, counted once for each hit point.
    pub gathered: u64,
    /// Photons within a radius, but on another side than the one that is seen.
    pub rejected_by_side: u64,
    /// Photons that left the lights naturally so far.
    pub emitted_in_all: u64,
    /// Radii after the pass, of all kinds of paths.
    pub radius: RadiusRange,
    /// Of the kinds of paths that photons bring light by, apart or together.
    pub collectors: Vec<CollectorStatistics>,
    /// Of caustics on rough surfaces, where they are collected.
    pub glints: Option<CollectorStatistics>,
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

/// Radii that one task sums; fixed, so that the order of the sum is.
const CHUNK: usize = 1 << 14;

impl RadiusRange {
    pub(super) fn of(radii: &[f32]) -> RadiusRange {
        if radii.is_empty() {
            return RadiusRange::default();
        }
        let chunks: Vec<RadiusRange> = radii.par_chunks(CHUNK).map(range_and_sum).collect();
        let all = chunks.iter().copied().reduce(combine).unwrap_or_default();
        RadiusRange { mean: all.mean / radii.len() as f64, ..all }
    }

    /// Of collectors that have as many radii.
    fn of_all(collectors: &[CollectorStatistics]) -> RadiusRange {
        let all = collectors.iter().map(|c| c.radius).reduce(combine).unwrap_or_default();
        RadiusRange { mean: all.mean / collectors.len().max(1) as f64, ..all }
    }
}

/// Of one chunk, with the sum in place of the mean.
fn range_and_sum(radii: &[f32]) -> RadiusRange {
    let min = radii.iter().copied().fold(f32::INFINITY, f32::min);
    let max = radii.iter().copied().fold(0.0, f32::max);
    let sum = radii.iter().map(|&r| f64::from(r)).sum();
    RadiusRange { min: min.into(), mean: sum, max: max.into(), floored: 0 }
}

fn combine(a: RadiusRange, b: RadiusRange) -> RadiusRange {
    RadiusRange {
        min: a.min.min(b.min),
        mean: a.mean + b.mean,
        max: a.max.max(b.max),
        floored: a.floored + b.floored,
    }
}

impl Render<'_> {
    pub(super) fn statistics(
        &self,
        phases: PhaseSeconds,
        [photons, aimed_photons]: [Ledger; 2],
        collectors: Vec<CollectorStatistics>,
        glints: Option<CollectorStatistics>,
        shadow_rays: u64,
    ) -> PassStatistics {
        PassStatistics {
            pass: self.passes,
            seconds: phases.total(),
            phases,
            rays: photons.rays + aimed_photons.rays + shadow_rays,
            photons,
            aimed_photons,
            gathered: collectors.iter().chain(&glints).map(|c| c.gathered).sum(),
            rejected_by_side: collectors.iter().chain(&glints).map(|c| c.rejected_by_side).sum(),
            emitted_in_all: self.emitted_photons,
            radius: RadiusRange::of_all(&collectors),
            collectors,
            glints,
            memory_bytes: self.memory_bytes() as u64,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// More than a task takes, the least and the largest in the middle.
    #[test]
    fn radii_of_many_tasks_are_one_range() {
        const COUNT: usize = 2 * CHUNK + 500;
        let radii: Vec<f32> = (0..COUNT).map(|k| ((k + COUNT / 2) % COUNT + 1) as f32).collect();
        let range = RadiusRange::of(&radii);
        let expected =
            RadiusRange { min: 1.0, mean: 0.5 * (COUNT + 1) as f64, max: COUNT as f64, floored: 0 };
        assert_eq!(range, expected);
        assert_eq!(
            combine(RadiusRange { floored: 3, ..range }, RadiusRange { floored: 4, ..range }).floored,
            7
        );
    }
}
