use std::f32::consts::PI;
use std::fmt;

use crate::math::{Vec2, warp};

/// How the light on the film is weighed for a pixel: `L = ∫ h(x - c) L(x) dx` about its middle `c`, with `∫ h = 1`.
///
/// Filters are sampled, not weighed: a sample counts for one pixel alone, by the same share as all others there, and `h` is
/// the density of its position. So positions may lie outside the pixel, and the noise of pixels stays independent.
///
/// # Source
/// Ernst, Stamminger and Greiner, "Filter Importance Sampling", IEEE Symposium on Interactive Ray Tracing 2006.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PixelFilter {
    /// The mean over some points of the pixel, which a render may choose once and keep. Their expectation is that of
    /// [`PixelFilter::Box`].
    #[default]
    Points,
    /// The mean over the pixel; variance 1/12 along each axis.
    Box,
    /// Falls linearly to 0 at one pixel from the middle, along each axis; variance 1/6.
    Tent,
    /// A normal distribution with σ = [`GAUSSIAN_SIGMA`] that is cut off at [`GAUSSIAN_CUT`] from the middle; variance
    /// `σ² (1 - t / (eᵗ - 1))` along each axis, with `t = cut² / 2 σ²`, which is 0.24933.
    Gaussian,
}

/// Standard deviation of [`PixelFilter::Gaussian`], in pixels.
pub const GAUSSIAN_SIGMA: f32 = 0.5;

/// Where [`PixelFilter::Gaussian`] ends, in pixels from the middle: four standard deviations.
pub const GAUSSIAN_CUT: f32 = 2.0;

impl PixelFilter {
    /// All of them.
    pub const ALL: [PixelFilter; 4] =
        [PixelFilter::Points, PixelFilter::Box, PixelFilter::Tent, PixelFilter::Gaussian];

    /// Its name in scene files.
    pub fn name(self) -> &'static str {
        match self {
            PixelFilter::Points => "points",
            PixelFilter::Box => "box",
            PixelFilter::Tent => "tent",
            PixelFilter::Gaussian => "gaussian",
        }
    }

    /// A position of density `h` from a point of the unit square, in pixels from the pixel's top left corner; neighbours
    /// stay neighbours, so strata of the square are strata of the filter.
    pub fn sample(self, u: Vec2) -> Vec2 {
        match self {
            PixelFilter::Points | PixelFilter::Box => u,
            PixelFilter::Tent => MIDDLE + Vec2::new(tent(u.x), tent(u.y)),
            PixelFilter::Gaussian => MIDDLE + gaussian(warp::square_to_disk(u)),
        }
    }

    /// `h` at an offset from the middle of the pixel, per pixel of area: the density of [`PixelFilter::sample`].
    pub fn density(self, offset: Vec2) -> f32 {
        match self {
            // Half open, so that the pixels of a picture share no point.
            PixelFilter::Points | PixelFilter::Box => {
                let inside = offset.cmpge(Vec2::splat(-0.5)).all() && offset.cmplt(Vec2::splat(0.5)).all();
                f32::from(u8::from(inside))
            }
            PixelFilter::Tent => {
                let height = (Vec2::ONE - offset.abs()).max(Vec2::ZERO);
                height.x * height.y
            }
            PixelFilter::Gaussian => {
                let t = offset.length_squared() / (2.0 * GAUSSIAN_SIGMA * GAUSSIAN_SIGMA);
                let inside = if t <= CUT { (-t).exp() } else { 0.0 };
                inside / (2.0 * PI * GAUSSIAN_SIGMA * GAUSSIAN_SIGMA * (1.0 - (-CUT).exp()))
            }
        }
    }

    /// The distance from the middle of the pixel beyond which `h` is 0, along each axis.
    pub fn reach(self) -> f32 {
        match self {
            PixelFilter::Points | PixelFilter::Box => 0.5,
            PixelFilter::Tent => 1.0,
            PixelFilter::Gaussian => GAUSSIAN_CUT,
        }
    }
}

impl fmt::Display for PixelFilter {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}

const MIDDLE: Vec2 = Vec2::splat(0.5);

/// The `t` at which the normal distribution ends.
const CUT: f32 = GAUSSIAN_CUT * GAUSSIAN_CUT / (2.0 * GAUSSIAN_SIGMA * GAUSSIAN_SIGMA);

/// Of density `1 - |x|`.
fn tent(u: f32) -> f32 {
    if u < 0.5 { (2.0 * u).sqrt() - 1.0 } else { 1.0 - (2.0 * (1.0 - u)).sqrt() }
}

/// Moves a point of the unit disc, uniform in area, along its radius: the square of a normal radius is exponential.
fn gaussian(p: Vec2) -> Vec2 {
    let r2 = p.length_squared();
    if r2 == 0.0 {
        return Vec2::ZERO;
    }
    let t = -(-r2.min(1.0) * (1.0 - (-CUT).exp())).ln_1p();
    p * (GAUSSIAN_SIGMA * (2.0 * t / r2).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Rng, Stream};
    use glam::DVec2;

    /// Closed forms of the variance along each axis.
    fn variance(filter: PixelFilter) -> f64 {
        match filter {
            PixelFilter::Points | PixelFilter::Box => 1.0 / 12.0,
            PixelFilter::Tent => 1.0 / 6.0,
            PixelFilter::Gaussian => 0.25 * (1.0 - 8.0 / (8f64.exp() - 1.0)),
        }
    }

    /// A regular grid stands for the integral over the unit square.
    #[test]
    fn samples_have_the_moments_of_their_filter() {
        const SIDE: u32 = 1000;
        for filter in PixelFilter::ALL {
            let (mut sum, mut squares, mut product) = (DVec2::ZERO, DVec2::ZERO, 0.0);
            for (x, y) in (0..SIDE).flat_map(|x| (0..SIDE).map(move |y| (x, y))) {
                let u = (Vec2::new(x as f32, y as f32) + 0.5) / SIDE as f32;
                let offset = filter.sample(u).as_dvec2() - 0.5;
                assert!(offset.abs().max_element() <= f64::from(filter.reach()) + 1e-6, "{filter}: {offset}");
                (sum, squares, product) =
                    (sum + offset, squares + offset * offset, product + offset.x * offset.y);
            }
            let n = f64::from(SIDE * SIDE);
            assert!((sum / n).abs().max_element() < 1e-5, "{filter}: mean {}", sum / n);
            let (expected, found) = (variance(filter), squares / n);
            assert!((found - expected).abs().max_element() < 1.5e-3 * expected, "{filter}: variance {found}");
            assert!((product / n).abs() < 1e-5, "{filter}: covariance {}", product / n);
        }
    }

    /// Samples counted in cells, against the density in the middles of finer ones.
    #[test]
    fn samples_lie_as_dense_as_the_density_says() {
        const CELLS: usize = 16;
        const SAMPLES: u32 = 1 << 20;
        const FINE: usize = 8;
        for filter in PixelFilter::ALL {
            let cell = 2.0 * filter.reach() / CELLS as f32;
            let mut counts = vec![0u32; CELLS * CELLS];
            for sample in 0..SAMPLES {
                let offset = filter.sample(Rng::new(3, Stream::Test, 0, sample.into()).next_vec2()) - 0.5;
                let at =
                    ((offset + filter.reach()) / cell).clamp(Vec2::ZERO, Vec2::splat(CELLS as f32 - 1.0));
                counts[at.y as usize * CELLS + at.x as usize] += 1;
            }
            let mut total = 0.0;
            for (k, &count) in counts.iter().enumerate() {
                let corner = Vec2::new((k % CELLS) as f32, (k / CELLS) as f32) * cell - filter.reach();
                let fine = |k: usize| {
                    Vec2::new((k % FINE) as f32 + 0.5, (k / FINE) as f32 + 0.5) * cell / FINE as f32
                };
                let mean = (0..FINE * FINE).map(|k| f64::from(filter.density(corner + fine(k)))).sum::<f64>()
                    / (FINE * FINE) as f64;
                let expected = mean * f64::from(cell * cell) * f64::from(SAMPLES);
                let doubt = 5.0 * expected.sqrt() + 0.02 * expected + 5.0;
                assert!(
                    (f64::from(count) - expected).abs() < doubt,
                    "{filter}, cell {k}: {count} for {expected}"
                );
                total += expected;
            }
            assert!((total / f64::from(SAMPLES) - 1.0).abs() < 2e-3, "{filter}: the density sums to {total}");
        }
    }

    #[test]
    fn strata_of_the_square_are_strata_of_the_filter() {
        for filter in PixelFilter::ALL {
            let [a, b] = [Vec2::new(0.3, 0.6), Vec2::new(0.3001, 0.6)].map(|u| filter.sample(u));
            assert!(a.distance(b) < 1e-3, "{filter}");
        }
    }
}
