//! How wrong the picture still is, from the render itself: no reference is needed.
//!
//! ```text
//! passes ──BatchMeans──> variance of every pixel ─┐
//! picture ──BlurEstimator──> bias of every pixel ─┴─> ErrorQuantile ──> bound at a stated confidence
//! ```
//!
//! What it does not cover: the eye paths. Hit points stay where they are, so a pixel converges to the mean light at its
//! samples, and the error of having few of them is no part of the bounds.

mod batch_means;
mod blur;
mod forecast;
mod layers;
mod quantile;

pub(super) use batch_means::BatchMeans;
pub use forecast::{Forecast, Outlook};
pub use layers::Layers;

use rayon::prelude::*;
use serde::Serialize;

use super::Render;
use super::develop::radiance;
use crate::compare::REL_MSE_EPSILON;
use crate::math::DVec3;
use blur::BlurEstimator;
use quantile::{ErrorQuantile, one_sided_normal};

/// Photons (reduced count `N` of all hit points of a pixel) below which a bound would claim too much.
const MIN_PHOTONS: f64 = 8.0;

/// The summary looks at every pixel in so many columns and rows: neighbours tell nearly the same.
const STRIDE: usize = 6;

/// Pixels that one task sums; fixed, so that the order of the sum is.
const CHUNK: usize = 1 << 10;

/// What is known of the error of one pixel, channel by channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelError {
    /// The standard error of the estimate (radiance).
    pub stderr: DVec3,
    /// Its bias: the blur by the gather radius (radiance).
    pub bias: DVec3,
    /// The error stays below it with the confidence asked for; NaN where that cannot be told.
    pub bound: DVec3,
    /// Photons that the pixel rests on: the reduced counts `N` of its hit points.
    pub photons: f64,
}

/// The error of the whole picture: that by which `compare` judges it, √relMSE = `√(mean of e² / (L² + ε))` over pixels and
/// channels, with ε = [`REL_MSE_EPSILON`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PictureError {
    /// Passes that the estimate rests on.
    pub passes: u32,
    /// The estimate of √relMSE.
    pub error: f64,
    /// What the true √relMSE stays below with the confidence asked for.
    pub upper: f64,
    /// The part of `error` that is noise.
    pub noise: f64,
    /// The part of `error` that is bias; the squares of both add up.
    pub bias: f64,
    /// The share of pixels that rest on too few photons for a bound.
    pub untrusted: f64,
}

/// The errors of a render as they stand.
pub struct Accuracy<'a> {
    render: &'a Render<'a>,
    batches: &'a BatchMeans,
    blur: BlurEstimator<'a>,
    quantile: ErrorQuantile,
    confidence: f64,
    /// Passes since the last batch was closed make the picture better than the batches know: by `m / n`.
    newer: f64,
}

impl<'a> Accuracy<'a> {
    /// `None` before there are two batches of passes.
    pub(super) fn new(
        render: &'a Render<'a>,
        batches: &'a BatchMeans,
        confidence: f64,
    ) -> Option<Accuracy<'a>> {
        let degrees_of_freedom = batches.degrees_of_freedom();
        (degrees_of_freedom > 0.0).then(|| Accuracy {
            render,
            batches,
            blur: BlurEstimator {
                render,
                batches,
                width: render.scene.film().width as usize,
                mean_radius2: render.settings.policy.mean_radius2(render.settings.alpha),
            },
            quantile: ErrorQuantile::new(confidence, degrees_of_freedom),
            confidence,
            newer: f64::from(batches.passes()) / f64::from(render.passes),
        })
    }

    /// The errors of a pixel.
    pub fn pixel(&self, pixel: usize) -> PixelError {
        let stderr = self.variance(pixel).map(f64::sqrt);
        let blur = self.blur.at(pixel);
        let photons = self.photons(pixel);
        let bound = if self.trusts(pixel, photons) {
            // What of the bias is no noise of its own estimate.
            let bias = (blur.bias * blur.bias - blur.variance).max(DVec3::ZERO).map(f64::sqrt);
            let bound = |channel: usize| self.quantile.bound(bias[channel], stderr[channel]);
            DVec3::new(bound(0), bound(1), bound(2))
        } else {
            DVec3::NAN
        };
        PixelError { stderr, bias: blur.bias, bound, photons }
    }

    /// All layers, for every pixel.
    pub fn layers(&self) -> Layers {
        Layers::of(self.render, self)
    }

    /// The error of the picture, from one in 36 of its pixels.
    pub fn picture(&self) -> PictureError {
        let pixels: Vec<usize> = self.sampled_pixels().collect();
        let chunks: Vec<Sums> = pixels.par_chunks(CHUNK).map(|chunk| self.sums(chunk)).collect();
        let sums = chunks.into_iter().fold(Sums::default(), Sums::plus);
        let n = pixels.len() as f64;
        let (noise, bias) = (sums.noise / n, (sums.bias / n).max(0.0));
        let square = noise + bias;
        let spread = (sums.squares / n - square * square).max(0.0) / n;
        PictureError {
            passes: self.render.passes,
            error: square.sqrt(),
            upper: (square + one_sided_normal(self.confidence) * spread.sqrt()).sqrt(),
            noise: noise.sqrt(),
            bias: bias.sqrt(),
            untrusted: f64::from(sums.untrusted) / n,
        }
    }

    /// In each block of `STRIDE × STRIDE` pixels one, not always at the same place of it.
    fn sampled_pixels(&self) -> impl Iterator<Item = usize> {
        let (width, pixels) = (self.blur.width, self.batches.len());
        (0..pixels / width)
            .step_by(STRIDE)
            .flat_map(move |y| (y / STRIDE % STRIDE..width).step_by(STRIDE).map(move |x| y * width + x))
    }

    fn sums(&self, pixels: &[usize]) -> Sums {
        let mut sums = Sums::default();
        for &pixel in pixels {
            let radiance = radiance(self.render, pixel);
            let share = (3.0 * (radiance * radiance + REL_MSE_EPSILON)).recip();
            let blur = self.blur.at(pixel);
            let noise = share.dot(self.variance(pixel));
            let bias = share.dot(blur.bias * blur.bias - blur.variance);
            sums.noise += noise;
            sums.bias += bias;
            sums.squares += (noise + bias.max(0.0)).powi(2);
            sums.untrusted += u32::from(!self.trusts(pixel, self.photons(pixel)));
        }
        sums
    }

    fn variance(&self, pixel: usize) -> DVec3 {
        self.newer * self.batches.variance(pixel)
    }

    fn photons(&self, pixel: usize) -> f64 {
        let seen = self.render.pixel_lists.of(pixel).iter();
        seen.map(|seen| self.render.states.get(seen.position as usize).photons).sum()
    }

    /// A pixel without a hit point sees no photons, nor does it wait for any.
    fn trusts(&self, pixel: usize, photons: f64) -> bool {
        photons >= MIN_PHOTONS || self.render.pixel_lists.of(pixel).is_empty()
    }
}

/// Sums over pixels.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    noise: f64,
    bias: f64,
    squares: f64,
    untrusted: u32,
}

impl Sums {
    fn plus(self, other: Sums) -> Sums {
        Sums {
            noise: self.noise + other.noise,
            bias: self.bias + other.bias,
            squares: self.squares + other.squares,
            untrusted: self.untrusted + other.untrusted,
        }
    }
}
