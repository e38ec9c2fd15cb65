//! Gathering at rough surfaces: every photon counts by what its facets make of it.

use std::marker::PhantomData;

use super::gather_task::{Task, close};
use super::statistic::Gathers;
use super::{Found, GlossyPoint, Photons};
use crate::bvh::{Gatherer, Leaf, Radii};
use crate::simd::{LANES, Lanes};

/// Adds photons to points of rough surfaces, one pair after the other: there are few of them.
pub(super) struct GlossyGatherer<'a, S> {
    /// In the order of the tree.
    pub points: &'a [GlossyPoint],
    pub photons: &'a Photons<'a>,
    pub alpha: f64,
    pub state: PhantomData<fn(S)>,
}

impl<S: Gathers> Gatherer for GlossyGatherer<'_, S> {
    type State = S;
    type Task = Task;
    type Tally = Found;

    fn begin(&self, points: Vec<u32>) -> Task {
        Task::of(self.photons, &points)
    }

    #[inline(always)]
    fn meet<L: Lanes>(&self, lanes: L, task: &mut Task, leaf: Leaf<S>) -> Radii {
        let balls = leaf.balls(lanes);
        let points = &self.points[leaf.first..leaf.first + leaf.states.len()];
        let (mut sums, mut touched, mut met) = ([[0.0; LANES]; 4], 0, 0);
        for (p, place) in leaf.points.iter() {
            let around = balls.around(lanes, p);
            met += u64::from(around.count_ones());
            for (lane, point) in points.iter().enumerate().filter(|(lane, _)| around & 1 << lane != 0) {
                if let Some(flux) = point.reflected(&task.photons[place]) {
                    let found = flux.as_dvec3().extend(1.0).to_array();
                    sums.iter_mut().zip(found).for_each(|(sum, found)| sum[lane] += found);
                    touched |= 1 << lane;
                }
            }
        }
        let closed = close(leaf.states, leaf.radii, touched, &sums, None, self.alpha);
        task.found.accepted += closed.accepted;
        task.found.rejected += met - closed.accepted;
        closed.radii
    }

    fn end(&self, task: Task) -> Found {
        task.found
    }
}
