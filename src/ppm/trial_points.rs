//! Hit points that stand for all in trials before the first pass.

use std::f64::consts::PI;

use rayon::prelude::*;

use super::photons::{PhotonBatch, Photons};
use super::{HitPoint, Photon, Render, received};
use crate::bvh::{Sphere, SphereBvh};
use crate::effects::PathClass;
use crate::math::{Rgb, Vec3, mean};
use crate::scene::Receiver;

/// So many hit points stand for all in a trial, about.
const POINTS: usize = 1 << 14;

/// So many photons should be found by some hit point, else the discs of a trial are widened...
const FOUND: usize = 256;

/// ... up to so many times the radius.
const WIDEST: f32 = 8.0;

/// Some of the hit points, each for as many of its neighbours.
pub(super) struct Points {
    points: Vec<Point>,
    tree: SphereBvh,
    /// Of every point.
    pub radius: f32,
    each_for: usize,
}

#[derive(Clone, Copy)]
struct Point {
    receiver: Receiver,
    pixel: u32,
    /// From irradiance to the radiance of its pixel; once related to the picture, in parts of that.
    factor: Rgb,
}

impl Points {
    pub fn new(render: &Render) -> Points {
        let each_for = render.hit_points.len().div_ceil(POINTS);
        // As many hit points are around a photon as would be.
        let radius = render.setup.radius as f32 * (each_for as f32).sqrt();
        let point = |h: &HitPoint| Point { receiver: h.receiver, pixel: h.pixel, factor: h.reflectance };
        let points: Vec<Point> = render.hit_points.iter().step_by(each_for).map(point).collect();
        let spheres: Vec<Sphere> =
            points.iter().map(|point| Sphere { center: point.receiver.p, radius }).collect();
        let (tree, order) = SphereBvh::build(&spheres);
        let points = order.iter().map(|&k| points[k as usize]).collect();
        Points { points, tree, radius, each_for }
    }

    /// Divides all factors by the radiance of the pixel without photons and the mean one of the picture, as far as the trial
    /// knows it.
    pub fn relate(&mut self, render: &Render, batch: &PhotonBatch, emitted: u64) {
        let classes = [PathClass::Caustic, PathClass::Indirect].map(|class| batch.of(class));
        let by_photons: f64 = classes.iter().flat_map(|photons| self.each(photons, |x| x)).sum();
        let disc = PI * f64::from(self.radius).powi(2);
        let lists = render.pixel_lists();
        let pixels = (0..render.scene.film().pixels()).into_par_iter();
        let without: Vec<f32> =
            pixels.map(|pixel| mean(render.direct.radiance(lists, pixel).as_vec3())).collect();
        let direct: f64 = without.iter().map(|&radiance| f64::from(radiance)).sum();
        let all = self.each_for as f64 * by_photons / (disc * emitted as f64) + direct;
        let mean = (all / without.len() as f64) as f32;
        for point in &mut self.points {
            point.factor /= without[point.pixel as usize] + mean;
        }
    }

    /// For every photon the sum of the squares of what it brings to pixels. Discs are widened where few photons are found: by
    /// photons around them, which are about as many and as bright.
    pub fn squares(&mut self, photons: &Photons) -> Vec<f64> {
        let mut widening = 1.0;
        loop {
            let radius = widening * self.radius;
            self.tree.refit(|_| radius);
            let squares = self.each(photons, |x| x * x);
            let found = squares.iter().filter(|&&square| square > 0.0).count();
            if found >= FOUND || widening >= WIDEST {
                let disc = PI * f64::from(radius).powi(2);
                return squares.iter().map(|square| square / disc).collect();
            }
            widening *= 2.0;
        }
    }

    /// For every photon the sum over the hit points that gather it of `of` the flux that it brings.
    fn each(&self, photons: &Photons, of: impl Fn(f64) -> f64 + Sync) -> Vec<f64> {
        let positions = photons.positions().concat();
        let photons: Vec<_> = photons.iter().collect();
        let sum = |(&position, photon)| {
            let mut sum = 0.0;
            self.tree.for_each_containing(position, |place| {
                let Point { receiver, factor, .. } = &self.points[place];
                let flux = received(receiver, photon).unwrap_or(Rgb::ZERO);
                sum += of(f64::from(mean(*factor * flux)));
            });
            sum
        };
        positions.par_iter().zip(photons).map(sum).collect()
    }

    /// Whether a photon that lies at `position` is received by any point.
    pub fn receive(&self, position: Vec3, photon: &Photon) -> bool {
        let mut any = false;
        self.tree.for_each_containing(position, |place| {
            any = any || received(&self.points[place].receiver, photon).is_some();
        });
        any
    }

    /// What the points are, neighbours mostly one after the other.
    pub fn receivers(&self) -> impl Iterator<Item = Receiver> {
        self.points.iter().map(|point| point.receiver)
    }
}
