//! The bias of density estimation: a disc blurs.

use super::super::Render;
use super::super::develop::photon_radiance;
use super::batch_means::BatchMeans;
use crate::math::{DVec3, Vec3, mean};

/// The largest step between pixels that are compared, in pixels.
const MAX_STEP: usize = 64;
/// Cosine below which two normals do not belong to the same smooth surface.
const MIN_NORMAL_COSINE: f32 = 0.9;
/// The largest distance from the tangent plane, in distances along it.
const MAX_SLOPE: f32 = 0.3;
/// The largest distance between compared pixels' points, in widths that they should have: beyond it something lies between.
const MAX_STRETCH: f32 = 8.0;

/// What the disc of the estimate does to a pixel, and how uncertain that itself is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Blur {
    /// `B = R²/8 · ∇²L` of the light from photons, with `R²` its mean over the passes: the mean over a disc minus the value at its centre.
    pub(super) bias: DVec3,
    /// The variance of that estimate.
    pub(super) variance: DVec3,
}

/// The point that a pixel mostly shows.
struct Guide {
    p: Vec3,
    ng: Vec3,
    footprint: f32,
    radius2: f64,
}

/// Estimates the blur from the picture itself: its second differences across a disc, along the surface that is seen.
///
/// Neighbours on another surface are left out, and with them what the disc loses over an edge.
///
/// # Source
/// Hachisuka, Jarosz and Jensen, "A Progressive Error Estimation Framework for Photon Density Estimation", SIGGRAPH
/// Asia 2010, equation 10 (`½ R² k₂ ∇²L`, and `k₂ = 1/4` for the flat disc); they find the Laplacian by kernels' derivatives.
pub(super) struct BlurEstimator<'a> {
    pub(super) render: &'a Render<'a>,
    pub(super) batches: &'a BatchMeans,
    pub(super) width: usize,
    /// The mean of `R²` over the passes, in units of the last one.
    pub(super) mean_radius2: f64,
}

impl BlurEstimator<'_> {
    pub(super) fn at(&self, pixel: usize) -> Blur {
        let Some(guide) = self.guide(pixel) else { return Blur::default() };
        let radius2 = (self.mean_radius2 * guide.radius2).min(self.first_radius2());
        let step = (radius2.sqrt() / f64::from(guide.footprint)).round().clamp(1.0, MAX_STEP as f64) as usize;
        let (mut blur, mut factors) = (Blur::default(), 0.0);
        for neighbours in self.neighbours(pixel, step).into_iter().flatten() {
            if let Some(distance2) = self.distance2(&guide, neighbours, step) {
                let factor = radius2 / (8.0 * distance2);
                self.add_neighbours(&mut blur, neighbours, factor);
                factors += factor;
            }
        }
        blur.bias -= 2.0 * factors * photon_radiance(self.render, pixel);
        blur.variance += 4.0 * factors * factors * self.batches.variance(pixel);
        blur
    }

    fn first_radius2(&self) -> f64 {
        self.render.setup().radius.powi(2)
    }

    /// The heaviest hit point of a pixel; `None` where it has none.
    fn guide(&self, pixel: usize) -> Option<Guide> {
        let seen = self.render.pixel_lists.of(pixel).iter();
        let heaviest = seen.max_by(|a, b| mean(a.factor).total_cmp(&mean(b.factor)))?.position as usize;
        let hit_point = &self.render.hit_points[heaviest];
        Some(Guide {
            p: hit_point.receiver.p,
            ng: hit_point.receiver.ng,
            footprint: hit_point.footprint,
            radius2: self.render.states.get(heaviest).radius2,
        })
    }

    /// The pixels left and right, above and below, where there are both.
    fn neighbours(&self, pixel: usize, step: usize) -> [Option<[usize; 2]>; 2] {
        let (x, height) = (pixel % self.width, self.batches.len() / self.width);
        let y = pixel / self.width;
        let across = (x >= step && x + step < self.width).then(|| [pixel - step, pixel + step]);
        let (row, inside) = (step * self.width, y >= step && y + step < height);
        [across, inside.then(|| [pixel - row, pixel + row])]
    }

    /// The mean squared distance to two neighbours, if all three lie on one smooth surface.
    fn distance2(&self, guide: &Guide, neighbours: [usize; 2], step: usize) -> Option<f64> {
        let reach = MAX_STRETCH * step as f32 * guide.footprint;
        let mut sum = 0.0;
        for neighbour in neighbours {
            let other = self.guide(neighbour)?;
            let offset = other.p - guide.p;
            let distance = offset.length();
            let alike = guide.ng.dot(other.ng) >= MIN_NORMAL_COSINE;
            let level = guide.ng.dot(offset).abs() <= MAX_SLOPE * distance;
            if !(alike && level && distance > 0.0 && distance <= reach) {
                return None;
            }
            sum += f64::from(distance * distance);
        }
        Some(0.5 * sum)
    }

    fn add_neighbours(&self, blur: &mut Blur, neighbours: [usize; 2], factor: f64) {
        for neighbour in neighbours {
            blur.bias += factor * photon_radiance(self.render, neighbour);
            blur.variance += factor * factor * self.batches.variance(neighbour);
        }
    }
}
