//! How wrong the picture still is, from the render itself: no reference is needed.
//!
//! ```text
//!                    ┌─> variance of every pixel ──────────────────┐
//! passes ──BatchMeans┤                                             ├─ErrorQuantile─> bound at a stated confidence
//!                    └─> two biases of every pixel ──BiasFilter──> ─┘
//! ```
//!
//! What it does not cover: eye paths that stay. Hit points are where they are then, so a pixel converges to the mean light at its
//! samples, and the error of having few of them is no part of the bounds. Where eye paths are retraced, it is.

mod batch_means;
mod bias_filter;
mod forecast;
mod layers;
mod pixel_error;
mod quantile;
mod radius_trend;
mod sampling;

pub(super) use batch_means::BatchMeans;
pub use forecast::{Forecast, Outlook};
pub use layers::Layers;
pub use pixel_error::PixelError;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::develop::radiance;
use super::{Render, Settings};
use crate::compare::REL_MSE_EPSILON;
use crate::math::DVec3;
use bias_filter::{Bias, BiasFilter};
use quantile::{ErrorQuantile, one_sided_normal};
use sampling::sampling_step;

/// Photons (reduced count `N` of all hit points of a pixel) below which a bound would claim too much.
const MIN_PHOTONS: f64 = 8.0;

/// Pixels that one task sums; fixed, so that the order of the sum is.
const CHUNK: usize = 1 << 10;

/// The error of the whole picture: that by which `compare` judges it, √relMSE = `√(mean of e² / (L² + ε))` over pixels and
/// channels, with ε = [`REL_MSE_EPSILON`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
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
        (batches.degrees_of_freedom() > 0.0).then(|| Accuracy {
            render,
            batches,
            confidence,
            newer: f64::from(batches.passes()) / f64::from(render.passes),
        })
    }

    /// The errors of every pixel, row by row from the top; `None` if the settings ask for that of the picture alone.
    pub fn pixels(&self) -> Option<Vec<PixelError>> {
        let quantile = ErrorQuantile::new(self.confidence, self.batches.degrees_of_freedom());
        let lists = self.render.pixel_lists();
        let width = self.render.scene.film().width as usize;
        let filter = BiasFilter::new(self.batches, width, |pixel| lists.place(pixel))?;
        let pixels = (0..lists.len()).into_par_iter();
        Some(pixels.map(|pixel| self.pixel(pixel, &filter, &quantile)).collect())
    }

    fn pixel(&self, pixel: usize, filter: &BiasFilter, quantile: &ErrorQuantile) -> PixelError {
        let lists = self.render.pixel_lists();
        let (variance, photons) = (self.variance(lists.place(pixel)), self.photons(pixel));
        let Bias { mean: bias, variance: doubt } = filter.at(pixel);
        let bound = if self.trusts(pixel, photons) {
            let bound = |channel: usize| quantile.bound(bias[channel], (variance + doubt)[channel].sqrt());
            DVec3::new(bound(0), bound(1), bound(2))
        } else {
            DVec3::NAN
        };
        PixelError { stderr: variance.map(f64::sqrt), bias, bound, photons }
    }

    /// The errors of every pixel as pictures; `None` if the settings ask for that of the picture alone.
    pub fn layers(&self) -> Option<Layers> {
        Some(Layers::of(self.render, &self.pixels()?))
    }

    /// The error of the picture, from some thousands of its pixels.
    pub fn picture(&self) -> PictureError {
        let pixels = self.render.pixel_lists().len();
        let places: Vec<usize> = (0..pixels).step_by(sampling_step(pixels)).collect();
        let chunks: Vec<Sums> = places.par_chunks(CHUNK).map(|chunk| self.sums(chunk)).collect();
        let sums = chunks.into_iter().fold(Sums::default(), Sums::plus);
        sums.error(self.render.passes, one_sided_normal(self.confidence))
    }

    fn sums(&self, places: &[usize]) -> Sums {
        let mut sums = Sums::default();
        for &place in places {
            let pixel = self.render.pixel_lists().pixel(place);
            let radiance = radiance(self.render, pixel);
            let share = (3.0 * (radiance * radiance + REL_MSE_EPSILON)).recip();
            let noise = share.dot(self.variance(place));
            let bias = self.batches.biases(place).map_or(0.0, |[a, b]| share.dot(a * b));
            sums.noise.add(noise);
            sums.bias.add(bias);
            sums.untrusted += u32::from(!self.trusts(pixel, self.photons(pixel)));
        }
        sums
    }

    fn sees_blur(&self) -> bool {
        let Settings { policy, alpha, .. } = self.render.settings;
        policy.asymptotic_exponent(alpha) > 0.0
    }

    fn variance(&self, place: usize) -> DVec3 {
        self.newer * self.batches.variance(place)
    }

    fn photons(&self, pixel: usize) -> f64 {
        let seen = self.render.pixel_lists().of(pixel).iter();
        let at =
            |position| self.render.collectors.iter().map(move |c| c.state(position).photons).sum::<f64>();
        seen.map(|seen| at(seen.position as usize)).sum()
    }

    /// Where radii stay as they are, blur cannot be told from light, unless discs are tested for it.
    /// A pixel without a hit point sees no photons, nor does it wait for any.
    fn trusts(&self, pixel: usize, photons: f64) -> bool {
        photons >= MIN_PHOTONS && self.sees_blur() || self.render.sees_nothing(pixel)
    }
}

/// What is found at some pixels.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    noise: Sum,
    bias: Sum,
    untrusted: u32,
}

/// Of one number a pixel.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    count: f64,
    sum: f64,
    squares: f64,
}

impl Sums {
    fn plus(self, other: Sums) -> Sums {
        Sums {
            noise: self.noise.plus(other.noise),
            bias: self.bias.plus(other.bias),
            untrusted: self.untrusted + other.untrusted,
        }
    }

    /// Bias counts as far as it stands out of its own noise; the upper end takes it whole, and `sigmas` standard errors.
    fn error(&self, passes: u32, sigmas: f64) -> PictureError {
        let (noise, bias) = (self.noise.mean(), (self.bias.mean() - self.bias.stderr()).max(0.0));
        let doubt = sigmas * self.noise.stderr().hypot(self.bias.stderr());
        let upper = noise + self.bias.mean().max(0.0) + doubt;
        PictureError {
            passes,
            error: (noise + bias).sqrt(),
            upper: upper.sqrt(),
            noise: noise.sqrt(),
            bias: bias.sqrt(),
            untrusted: f64::from(self.untrusted) / self.noise.count,
        }
    }
}

impl Sum {
    fn add(&mut self, x: f64) {
        *self = self.plus(Sum { count: 1.0, sum: x, squares: x * x });
    }

    fn plus(self, other: Sum) -> Sum {
        Sum {
            count: self.count + other.count,
            sum: self.sum + other.sum,
            squares: self.squares + other.squares,
        }
    }

    fn mean(&self) -> f64 {
        self.sum / self.count
    }

    fn stderr(&self) -> f64 {
        ((self.squares / self.count - self.mean().powi(2)).max(0.0) / self.count).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_upper_end_holds_what_the_estimate_leaves_out() {
        let mut sums = Sums::default();
        for (noise, bias) in [(4.0, 1.0), (4.0, 5.0), (4.0, -2.0), (4.0, 4.0)] {
            sums.noise.add(noise);
            sums.bias.add(bias);
        }
        // Biases: mean 2, standard deviation √7.5, standard error √7.5 / 2.
        let (error, doubt) = (sums.error(7, 2.0), 7.5f64.sqrt() / 2.0);
        assert!((error.error.powi(2) - (6.0 - doubt)).abs() < 1e-12 && error.noise == 2.0);
        assert!((error.upper.powi(2) - (6.0 + 2.0 * doubt)).abs() < 1e-12);
    }
}
