//! Photons of one kind of path, gathered at the hit points with radii of their own.

use super::radius_floor::RadiusFloor;
use super::statistic::Statistics;
use super::statistics::{ClassStatistics, RadiusRange};
use super::{Facets, Found, GatherState, HitPoint, Photons, Settings, gather};
use crate::bvh::SphereBvh;
use crate::effects::PathClass;

/// The statistics of all hit points for one kind of path, and the tree over the spheres that they gather from.
#[derive(Clone, Debug)]
pub(super) struct Collector {
    pub class: PathClass,
    pub tree: SphereBvh,
    pub states: Statistics,
    radius_floor: RadiusFloor,
}

impl Collector {
    /// With discs of one radius, none below its floor.
    pub fn new(
        class: PathClass,
        tree: SphereBvh,
        hit_points: &[HitPoint],
        radius: f64,
        settings: &Settings,
    ) -> Collector {
        let states = Statistics::new(tree.len(), radius, settings.policy, settings.precision);
        let mut collector = Collector { class, tree, states, radius_floor: RadiusFloor::of(hit_points) };
        collector.raise(hit_points);
        collector
    }

    /// Adds the photons of pass number `pass`, from 1, shrinks the radii and lets the tree follow.
    pub fn gather(&mut self, facets: &Facets, photons: &Photons, settings: &Settings, pass: u32) -> Found {
        let own_alpha = settings.policy.own_alpha(settings.alpha);
        let found = gather::gather(&mut self.tree, facets, photons, own_alpha, &mut self.states);
        if let Some(ratio) = settings.policy.common_ratio(settings.alpha, pass) {
            self.states.shrink(ratio);
            self.tree.refit(|position| self.states.get(position).radius() as f32);
        }
        found
    }

    /// Raises radii to their floor.
    pub fn raise(&mut self, hit_points: &[HitPoint]) -> RadiusRange {
        self.radius_floor.apply(hit_points, &mut self.states, &mut self.tree)
    }

    pub fn state(&self, position: usize) -> GatherState {
        self.states.get(position)
    }

    pub fn statistics(&self, found: Found, radius: RadiusRange) -> ClassStatistics {
        ClassStatistics {
            class: self.class,
            gathered: found.accepted,
            rejected_by_side: found.rejected,
            radius,
        }
    }

    pub fn memory_bytes(&self) -> usize {
        self.tree.memory_bytes() + self.states.memory_bytes()
    }
}
