use std::mem::discriminant;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::evenness::{PartSums, TestedState};
use super::{GatherState, PassSum, RadiusPolicy};
use crate::math::DVec3;

/// How precisely the statistics of hit points are kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// In f64, 40 bytes a hit point.
    #[default]
    Double,
    /// In f32, 20 bytes a hit point: to see what that costs in accuracy. Hit points that test their light stay in f64.
    Single,
}

/// What photons are gathered into.
pub(super) trait Gathers: Copy + Send + Sync {
    /// Whether it wants to know where in the disc photons lie.
    const WANTS_PARTS: bool;

    fn new(radius: f64) -> Self;

    fn radius(&self) -> f64;

    /// Closes a pass that brought photons.
    fn after_pass(&mut self, pass: &PassSum, parts: &PartSums, alpha: f64);
}

/// What is kept of gathered photons from pass to pass.
pub(super) trait Statistic: Gathers {
    fn state(&self) -> GatherState;

    /// Scales `R²`, and what was gathered with it.
    fn shrink(&mut self, ratio: f64);
}

impl Gathers for GatherState {
    const WANTS_PARTS: bool = false;

    fn new(radius: f64) -> GatherState {
        GatherState::new(radius)
    }

    #[inline]
    fn radius(&self) -> f64 {
        GatherState::radius(self)
    }

    #[inline]
    fn after_pass(&mut self, pass: &PassSum, _: &PartSums, alpha: f64) {
        GatherState::after_pass(self, pass, alpha);
    }
}

impl Statistic for GatherState {
    fn state(&self) -> GatherState {
        *self
    }

    fn shrink(&mut self, ratio: f64) {
        GatherState::shrink(self, ratio);
    }
}

impl Gathers for TestedState {
    const WANTS_PARTS: bool = true;

    fn new(radius: f64) -> TestedState {
        TestedState::new(radius)
    }

    fn radius(&self) -> f64 {
        self.state.radius()
    }

    fn after_pass(&mut self, pass: &PassSum, parts: &PartSums, alpha: f64) {
        TestedState::after_pass(self, pass, parts, alpha);
    }
}

impl Statistic for TestedState {
    fn state(&self) -> GatherState {
        self.state
    }

    fn shrink(&mut self, ratio: f64) {
        self.state.shrink(ratio);
    }
}

/// [`GatherState`] in f32.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct SingleState {
    radius2: f32,
    photons: f32,
    flux: [f32; 3],
}

impl SingleState {
    fn update(&mut self, update: impl FnOnce(&mut GatherState)) {
        let mut state = self.state();
        update(&mut state);
        *self = SingleState {
            radius2: state.radius2 as f32,
            photons: state.photons as f32,
            flux: state.flux.as_vec3().to_array(),
        };
    }
}

impl Gathers for SingleState {
    const WANTS_PARTS: bool = false;

    fn new(radius: f64) -> SingleState {
        SingleState { radius2: (radius * radius) as f32, photons: 0.0, flux: [0.0; 3] }
    }

    #[inline]
    fn radius(&self) -> f64 {
        f64::from(self.radius2).sqrt()
    }

    #[inline]
    fn after_pass(&mut self, pass: &PassSum, _: &PartSums, alpha: f64) {
        self.update(|state| state.after_pass(pass, alpha));
    }
}

impl Statistic for SingleState {
    fn state(&self) -> GatherState {
        GatherState {
            radius2: self.radius2.into(),
            photons: self.photons.into(),
            flux: DVec3::from_array(self.flux.map(f64::from)),
        }
    }

    fn shrink(&mut self, ratio: f64) {
        self.update(|state| state.shrink(ratio));
    }
}

/// The statistics of all hit points in the order of the tree, or of all pixels.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum Statistics {
    Double(Vec<GatherState>),
    Single(Vec<SingleState>),
    Tested(Vec<TestedState>),
}

impl Statistics {
    pub(super) fn new(
        hit_points: usize,
        radius: f64,
        policy: RadiusPolicy,
        precision: Precision,
    ) -> Statistics {
        match (policy, precision) {
            (RadiusPolicy::Tested, _) => Statistics::Tested(all(hit_points, radius)),
            (_, Precision::Double) => Statistics::Double(all(hit_points, radius)),
            (_, Precision::Single) => Statistics::Single(all(hit_points, radius)),
        }
    }

    /// The state of the hit point at a position.
    pub(super) fn get(&self, position: usize) -> GatherState {
        match self {
            Statistics::Double(states) => states[position],
            Statistics::Single(states) => states[position].state(),
            Statistics::Tested(states) => states[position].state,
        }
    }

    pub(super) fn len(&self) -> usize {
        match self {
            Statistics::Double(states) => states.len(),
            Statistics::Single(states) => states.len(),
            Statistics::Tested(states) => states.len(),
        }
    }

    /// Whether both are of the same kind, and of as many hit points.
    pub(super) fn is_like(&self, other: &Statistics) -> bool {
        discriminant(self) == discriminant(other) && self.len() == other.len()
    }

    /// Scales `R²` of all by the same ratio.
    pub(super) fn shrink(&mut self, ratio: f64) {
        match self {
            Statistics::Double(states) => shrink_all(states, ratio),
            Statistics::Single(states) => shrink_all(states, ratio),
            Statistics::Tested(states) => shrink_all(states, ratio),
        }
    }

    /// Raises radii to `floor(position)` where they are below it. How many are as small as that.
    pub(super) fn raise(&mut self, floor: impl Fn(usize) -> f64 + Sync) -> u64 {
        match self {
            Statistics::Double(states) => raise_all(states, floor),
            Statistics::Single(states) => raise_all(states, floor),
            Statistics::Tested(states) => raise_all(states, floor),
        }
    }

    /// Heap memory, in bytes.
    pub(super) fn memory_bytes(&self) -> usize {
        match self {
            Statistics::Double(states) => size_of_val(&**states),
            Statistics::Single(states) => size_of_val(&**states),
            Statistics::Tested(states) => size_of_val(&**states),
        }
    }
}

/// Written by all cores, each page of memory by one.
fn all<S: Statistic>(hit_points: usize, radius: f64) -> Vec<S> {
    (0..hit_points).into_par_iter().map(|_| S::new(radius)).collect()
}

fn shrink_all(states: &mut [impl Statistic], ratio: f64) {
    states.par_iter_mut().for_each(|state| state.shrink(ratio));
}

/// A radius that was raised differs from its floor by no more than rounding.
const ROUNDING: f64 = 1e-6;

fn raise_all(states: &mut [impl Statistic], floor: impl Fn(usize) -> f64 + Sync) -> u64 {
    let raise = |(position, state): (usize, &mut _)| {
        let ratio = floor(position) / Gathers::radius(state);
        if ratio > 1.0 {
            Statistic::shrink(state, ratio * ratio);
        }
        u64::from(ratio > 1.0 - ROUNDING)
    };
    states.par_iter_mut().enumerate().map(raise).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of_all_kinds(hit_points: usize) -> [Statistics; 3] {
        [
            (RadiusPolicy::HitPoint, Precision::Double),
            (RadiusPolicy::Shared, Precision::Single),
            (RadiusPolicy::Tested, Precision::Double),
        ]
        .map(|(policy, precision)| Statistics::new(hit_points, 2.0, policy, precision))
    }

    #[test]
    fn every_kind_shrinks_all_of_its_radii() {
        for mut states in of_all_kinds(3) {
            states.shrink(0.25);
            assert!((0..3).all(|position| states.get(position).radius() == 1.0), "{states:?}");
        }
    }

    #[test]
    fn states_are_alike_by_kind_and_number() {
        for (k, states) in of_all_kinds(3).iter().enumerate() {
            let alike = of_all_kinds(3).map(|other| states.is_like(&other));
            assert_eq!(alike, [0, 1, 2].map(|kind| kind == k));
            assert!(of_all_kinds(4).iter().all(|other| !states.is_like(other)));
        }
    }
}
