//! What gathering at surfaces of all kinds shares: its photons, its count, and the end of a pass at a leaf.

use std::ops::Add;

use super::lane_parts::PartArrays;
use super::statistic::Gathers;
use super::{PassSum, Photon, Photons};
use crate::bvh::Radii;
use crate::math::DVec3;
use crate::simd::{LANES, Mask};

/// Pairs of a hit point and a photon within its radius, of one pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Found {
    /// Those that bring flux.
    pub accepted: u64,
    /// Those that belong to another side.
    pub rejected: u64,
}

impl Add for Found {
    type Output = Found;

    fn add(self, other: Found) -> Found {
        Found { accepted: self.accepted + other.accepted, rejected: self.rejected + other.rejected }
    }
}

/// The photons of a task, close together, and what became of them.
pub(super) struct Task {
    pub photons: Vec<Photon>,
    pub found: Found,
}

impl Task {
    /// With the photons of these numbers.
    pub fn of(photons: &Photons, numbers: &[u32]) -> Task {
        Task { photons: photons.pick(numbers), found: Found::default() }
    }
}

/// What the end of a pass did to the hit points of a leaf.
pub(super) struct Closed {
    pub radii: Radii,
    /// Photons accepted by any of them.
    pub accepted: u64,
}

/// Closes the pass for the hit points of a leaf, those that accepted photons.
#[inline(always)]
pub(super) fn close<S: Gathers>(
    states: &mut [S],
    radii: &mut [f32],
    mut touched: Mask,
    [red, green, blue, count]: &[[f64; LANES]; 4],
    parts: Option<&PartArrays>,
    alpha: f64,
) -> Closed {
    let mut closed = Closed { radii: Radii::Kept, accepted: 0 };
    while touched != 0 {
        let lane = touched.trailing_zeros() as usize % LANES;
        touched &= touched - 1;
        let flux = DVec3::new(red[lane], green[lane], blue[lane]);
        let pass = PassSum { flux, accepted: count[lane] as u32 };
        let parts = parts.map(|parts| parts.lane(lane)).unwrap_or_default();
        states[lane].after_pass(&pass, &parts, alpha);
        closed.accepted += u64::from(pass.accepted);
        let shrunk = states[lane].radius() as f32;
        if shrunk != radii[lane] {
            radii[lane] = shrunk;
            closed.radii = Radii::Changed;
        }
    }
    closed
}
