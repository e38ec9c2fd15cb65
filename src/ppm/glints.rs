//! Caustics on rough surfaces.
//!
//! Light without extent that was mirrored or refracted, `L S+`, is found by no facet and by no shadow ray. Where an eye path meets
//! a rough surface, photons of such pasts are gathered, and count by what the facets make of them: `L S+ G (S | G)* E`.

use std::borrow::Cow;

use rayon::prelude::*;

use super::collector::{Collector, View};
use super::gather::Receivers;
use super::keeper::Keeper;
use super::pixel_lists::PixelLists;
use super::statistic::Statistics;
use super::statistics::CollectorStatistics;
use super::{GlossyPoint, HitPoint, PhotonBatch, RadiusPolicy, Settings};
use crate::bvh::{Sphere, SphereBvh};
use crate::effects::{PathClass, PathClasses};
use crate::math::DVec3;

/// The points of rough surfaces that eye paths met, and what their pixels gathered so far.
pub(super) struct Glints {
    collector: Collector,
    points: Vec<GlossyPoint>,
    /// Those of the points, in their order.
    hit_points: Vec<HitPoint>,
    lists: PixelLists,
}

impl Glints {
    /// With discs of one radius, for a picture of so many pixels.
    pub fn new(points: Vec<GlossyPoint>, pixels: usize, radius: f64, settings: &Settings) -> Glints {
        let (tree, points) = build_tree(points, |_| radius as f32);
        let hit_points: Vec<HitPoint> = points.par_iter().map(|point| point.hit_point).collect();
        let kept = (Keeper::Pixels, pixels);
        let collector = Collector::new(classes(), tree, &hit_points, kept, radius, &policy_of(settings));
        let lists = PixelLists::new(&hit_points, pixels, |h| h.reflectance);
        Glints { collector, points, hit_points, lists }
    }

    /// Goes on with what other eye paths met.
    pub fn look_at(&mut self, points: Vec<GlossyPoint>) {
        let radius = |h: &HitPoint| self.collector.state(h.pixel as usize).radius() as f32;
        let (tree, points) = build_tree(points, radius);
        self.hit_points = points.par_iter().map(|point| point.hit_point).collect();
        self.points = points;
        self.lists = PixelLists::new(&self.hit_points, self.collector.states.len(), |h| h.reflectance);
        self.collector.look_at(tree, &self.hit_points);
    }

    /// Empties the statistics, as [`Collector::forget`] does.
    pub fn forget(&mut self, radius: f64, settings: &Settings) {
        self.collector.forget(radius, &policy_of(settings));
    }

    /// See [`Collector::follow`].
    pub fn follow(&mut self) {
        self.collector.follow(&self.hit_points);
    }

    /// Adds the photons of pass number `pass`, from 1.
    pub fn gather(&mut self, batch: &PhotonBatch, settings: &Settings, pass: u32) -> CollectorStatistics {
        let Glints { collector, points, hit_points, lists } = self;
        let view = View { hit_points, receivers: Receivers::Glossy(points), lists: Some(lists) };
        collector.gather(view, &batch.glints(), &policy_of(settings), pass)
    }

    /// The radiance that they bring a pixel, of so many photons.
    pub fn radiance(&self, pixel: usize, emitted: u64) -> DVec3 {
        self.collector.state(pixel).irradiance(emitted)
    }

    pub fn state(&self) -> Cow<'_, Statistics> {
        Cow::Borrowed(&self.collector.states)
    }

    /// Goes on from `state`, which is [like](Statistics::is_like) its own.
    pub fn restore(&mut self, state: Statistics) {
        self.collector.states = state;
        let points = std::mem::take(&mut self.points);
        self.look_at(points);
    }

    pub fn memory_bytes(&self) -> usize {
        let points = size_of_val(&*self.points) + size_of_val(&*self.hit_points);
        points + self.collector.memory_bytes() + self.lists.memory_bytes()
    }
}

fn classes() -> PathClasses {
    [PathClass::Caustic].into_iter().collect()
}

/// Photons count by their direction here, so that how evenly they lie in a disc tells nothing.
fn policy_of(settings: &Settings) -> Settings {
    match settings.policy {
        RadiusPolicy::Tested => Settings { policy: RadiusPolicy::HitPoint, ..*settings },
        _ => *settings,
    }
}

/// The tree over the points' spheres, and the points in its order.
fn build_tree(
    points: Vec<GlossyPoint>,
    radius: impl Fn(&HitPoint) -> f32 + Sync,
) -> (SphereBvh, Vec<GlossyPoint>) {
    let sphere =
        |point: &GlossyPoint| Sphere { center: point.hit_point.receiver.p, radius: radius(&point.hit_point) };
    let (tree, order) = SphereBvh::build(&points.par_iter().map(sphere).collect::<Vec<_>>());
    let ordered = order.par_iter().map(|&k| points[k as usize]).collect();
    (tree, ordered)
}
