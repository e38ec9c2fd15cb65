//! Photons of some kinds of paths, gathered with radii of their own.

use super::gather::Receivers;
use super::gather_by_pixel::gather_by_pixel;
use super::keeper::Keeper;
use super::pixel_lists::PixelLists;
use super::radius_floor::RadiusFloor;
use super::statistic::Statistics;
use super::statistics::{CollectorStatistics, RadiusRange};
use super::{GatherState, HitPoint, Photons, Settings, gather};
use crate::bvh::SphereBvh;
use crate::effects::PathClasses;

/// The statistics of some kinds of paths, and the tree over the spheres that they gather from.
#[derive(Clone, Debug)]
pub(super) struct Collector {
    pub classes: PathClasses,
    pub tree: SphereBvh,
    pub states: Statistics,
    pub keeper: Keeper,
    radius_floor: RadiusFloor,
}

/// What the eye sees in a pass.
#[derive(Clone, Copy)]
pub(super) struct View<'a> {
    pub hit_points: &'a [HitPoint],
    pub receivers: Receivers<'a>,
    /// The hit points of each pixel, where pixels keep the statistics.
    pub lists: Option<&'a PixelLists>,
}

impl Collector {
    /// With discs of one radius, none below its floor, kept by so many hit points or pixels.
    pub fn new(
        classes: PathClasses,
        tree: SphereBvh,
        hit_points: &[HitPoint],
        (keeper, count): (Keeper, usize),
        radius: f64,
        settings: &Settings,
    ) -> Collector {
        let states = Statistics::new(count, radius, settings.policy, settings.precision);
        let radius_floor = RadiusFloor::of(hit_points);
        let mut collector = Collector { classes, tree, states, keeper, radius_floor };
        collector.raise(hit_points);
        collector
    }

    /// Goes on with other hit points, which share the radii of their pixels.
    pub fn look_at(&mut self, tree: SphereBvh, hit_points: &[HitPoint]) {
        self.tree = tree;
        self.radius_floor = RadiusFloor::of(hit_points);
        self.follow(hit_points);
    }

    /// Empties the statistics, and gives all of them one radius; the tree is to [follow](Collector::follow) them, or to be another.
    pub fn forget(&mut self, radius: f64, settings: &Settings) {
        self.states = Statistics::new(self.states.len(), radius, settings.policy, settings.precision);
    }

    /// Gives every sphere the radius of its statistics, none below its floor.
    pub fn follow(&mut self, hit_points: &[HitPoint]) {
        self.refit(hit_points);
        self.raise(hit_points);
    }

    /// Adds the photons of pass number `pass`, from 1, shrinks the radii, none below its floor, and lets the tree follow.
    pub fn gather(
        &mut self,
        view: View,
        photons: &Photons,
        settings: &Settings,
        pass: u32,
    ) -> CollectorStatistics {
        let own_alpha = settings.policy.own_alpha(settings.alpha);
        let Collector { tree, states, .. } = self;
        let found = match view.lists {
            None => gather::gather(tree, view.receivers, photons, own_alpha, states),
            Some(lists) => gather_by_pixel(tree, view.receivers, photons, own_alpha, lists, states),
        };
        let ratio = settings.policy.common_ratio(settings.alpha, pass);
        if let Some(ratio) = ratio {
            self.states.shrink(ratio);
        }
        if ratio.is_some() || view.lists.is_some() {
            self.refit(view.hit_points);
        }
        CollectorStatistics {
            kinds: self.classes,
            gathered: found.accepted,
            rejected_by_side: found.rejected,
            radius: self.raise(view.hit_points),
        }
    }

    /// Gives every sphere the radius of its statistics.
    fn refit(&mut self, hit_points: &[HitPoint]) {
        let Collector { tree, states, keeper, .. } = self;
        tree.refit(|position| states.get(keeper.index(hit_points, position)).radius() as f32);
    }

    /// Raises radii to their floor.
    fn raise(&mut self, hit_points: &[HitPoint]) -> RadiusRange {
        self.radius_floor.apply(hit_points, self.keeper, &mut self.states, &mut self.tree)
    }

    /// Of a hit point, or a pixel.
    pub fn state(&self, index: usize) -> GatherState {
        self.states.get(index)
    }

    pub fn memory_bytes(&self) -> usize {
        self.tree.memory_bytes() + self.states.memory_bytes()
    }
}
