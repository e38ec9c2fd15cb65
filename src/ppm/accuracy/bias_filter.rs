use std::ops::Range;

use rayon::prelude::*;

use super::batch_means::BatchMeans;
use crate::math::DVec3;

/// A window reaches so many pixels to each side.
const REACH: usize = 3;

/// How far above zero the products of a window must be on average, in units of the noise in their factors: four thirds of the
/// standard error of a mean over 49 products. More would hide blur that is there, less would see blur in noise.
const THRESHOLD: f64 = 0.4;

/// The bias of a pixel as far as it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bias {
    /// The best guess.
    pub(super) mean: DVec3,
    /// Its uncertainty.
    pub(super) variance: DVec3,
}

/// Tells biases from noise by their neighbourhood: a Wiener filter.
///
/// Two independent estimates `B_1`, `B_2` of each pixel's bias are far noisier than the picture. Over a window the mean of
/// `B_1 B_2` is that of the squared bias, `β²`, and the mean of `((B_1 - B_2) / 2)²` the variance `ν` of `(B_1 + B_2) / 2`. So the best guess is
/// `β² / (β² + ν) · (B_1 + B_2) / 2`, with the variance `β² ν / (β² + ν)`.
pub(super) struct BiasFilter {
    width: usize,
    /// For each pixel, row by row from the top; zero where nothing is known.
    pixels: Vec<Biases>,
}

/// What two biases of a pixel say.
#[derive(Clone, Copy, Debug, Default)]
struct Biases {
    /// `(B_1 + B_2) / 2`.
    mean: DVec3,
    /// `B_1 B_2`.
    product: DVec3,
    /// `((B_1 - B_2) / 2)²`.
    noise: DVec3,
}

impl BiasFilter {
    /// For pixels whose numbers in `batches` are `place(pixel)`; `None` if not all of them are looked at.
    pub(super) fn new(
        batches: &BatchMeans,
        width: usize,
        place: impl Fn(usize) -> usize + Sync,
    ) -> Option<BiasFilter> {
        let of = |pixel| Biases::of(batches.biases(place(pixel)));
        let pixels = || (0..batches.len()).into_par_iter().map(of).collect();
        (batches.step() == 1).then(|| BiasFilter { width, pixels: pixels() })
    }

    pub(super) fn at(&self, pixel: usize) -> Bias {
        let [product, noise] = self.window(pixel);
        let bias2 = (product - THRESHOLD * noise).max(DVec3::ZERO);
        let total = bias2 + noise;
        let share = DVec3::select(total.cmpgt(DVec3::ZERO), bias2 / total, DVec3::ZERO);
        Bias { mean: share * self.pixels[pixel].mean, variance: share * noise }
    }

    /// The means of product and noise.
    fn window(&self, pixel: usize) -> [DVec3; 2] {
        let (x, y, height) = (pixel % self.width, pixel / self.width, self.pixels.len() / self.width);
        let (columns, rows) = (around(x, self.width), around(y, height));
        let n = (columns.len() * rows.len()) as f64;
        let [mut product, mut noise] = [DVec3::ZERO; 2];
        for row in rows {
            for biases in &self.pixels[row * self.width..][columns.clone()] {
                product += biases.product;
                noise += biases.noise;
            }
        }
        [product / n, noise / n]
    }
}

impl Biases {
    fn of(biases: Option<[DVec3; 2]>) -> Biases {
        let Some([a, b]) = biases else { return Biases::default() };
        let half = 0.5 * (a - b);
        Biases { mean: 0.5 * (a + b), product: a * b, noise: half * half }
    }
}

fn around(at: usize, end: usize) -> Range<usize> {
    at.saturating_sub(REACH)..(at + REACH + 1).min(end)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Rng, Stream};

    const WIDTH: usize = 40;

    /// A picture whose left half a disc blurs by `blur R²`, seen through noise of standard deviation 1 / R a pass.
    fn batches(blur: f64) -> BatchMeans {
        let (mut batches, mut sums) = (BatchMeans::new(WIDTH * WIDTH, 1), vec![0.0; WIDTH * WIDTH]);
        let mut rng = Rng::new(5, Stream::Test, 0, 0);
        for pass in 1..=40u32 {
            let radius2 = f64::from(pass).powf(-0.3);
            for (pixel, sum) in sums.iter_mut().enumerate() {
                let noise = 12f64.sqrt() * (f64::from(rng.next_f32()) - 0.5) / radius2.sqrt();
                let blur = if pixel % WIDTH < WIDTH / 2 { blur } else { 0.0 };
                *sum += 10.0 + blur * radius2 + noise;
            }
            batches.shrink(f64::from(pass + 1).powf(-0.3));
            if batches.is_due(pass) {
                batches.close(pass, |pixel| DVec3::splat(sums[pixel] / f64::from(pass)));
            }
        }
        batches
    }

    /// The mean bias of the left half and of the right one, away from the edge between them.
    fn found(batches: &BatchMeans) -> [f64; 2] {
        let filter = BiasFilter::new(batches, WIDTH, |pixel| pixel).unwrap();
        [0..WIDTH / 2 - 4, WIDTH / 2 + 4..WIDTH].map(|columns| {
            let pixels = (0..WIDTH).flat_map(|y| columns.clone().map(move |x| y * WIDTH + x));
            let biases: Vec<f64> = pixels.map(|pixel| filter.at(pixel).mean.x).collect();
            biases.iter().sum::<f64>() / biases.len() as f64
        })
    }

    #[test]
    fn blur_is_found_where_it_is() {
        let batches = batches(5.0);
        // The mean of R² over the batches that are closed.
        let expected = 5.0 * (1..=37).map(|pass| f64::from(pass).powf(-0.3)).sum::<f64>() / 37.0;
        let [left, right] = found(&batches);
        assert!((left / expected - 1.0).abs() < 0.15, "{left} for {expected}");
        assert!(right.abs() < 0.05 * expected, "{right}");
    }

    /// Noise that is far larger than what it hides in a single pixel.
    #[test]
    fn noise_alone_is_no_bias() {
        let batches = batches(0.0);
        let filter = BiasFilter::new(&batches, WIDTH, |pixel| pixel).unwrap();
        let pixels = 0..WIDTH * WIDTH;
        let claimed = pixels.clone().filter(|&pixel| filter.at(pixel).mean.x != 0.0).count();
        assert!(claimed * 4 < pixels.len(), "{claimed} of {} pixels", pixels.len());
        let doubt: f64 = pixels.clone().map(|pixel| filter.at(pixel).variance.x).sum();
        let variance: f64 = pixels.map(|pixel| batches.variance(pixel).x).sum();
        assert!(doubt < 0.3 * variance, "{doubt} beside {variance}");
    }

    #[test]
    fn filter_needs_all_pixels() {
        assert!(BiasFilter::new(&BatchMeans::new(100, 3), 10, |pixel| pixel).is_none());
    }

    /// Two biases of each pixel in a picture of 9 × 8 pixels, that are polynomials of the place.
    fn pair(x: usize, y: usize) -> [f64; 2] {
        let (x, y) = (x as f64, y as f64);
        [3.0 + 0.5 * x + 0.1 * y * y, 2.0 + 0.2 * x * y]
    }

    /// Windows in the middle, at an edge and in a corner, against sums over all pixels by their distance.
    #[test]
    fn a_window_weighs_all_pixels_within_its_reach_alike() {
        let places = || (0..8).flat_map(|y| (0..9).map(move |x| (x, y)));
        let pixels = places().map(|(x, y)| Biases::of(Some(pair(x, y).map(DVec3::splat)))).collect();
        let filter = BiasFilter { width: 9, pixels };
        for (x, y) in [(4, 4), (0, 3), (8, 0), (1, 7)] {
            let near = || {
                places()
                    .filter(|at| at.0.abs_diff(x) <= 3 && at.1.abs_diff(y) <= 3)
                    .map(|at| pair(at.0, at.1))
            };
            let n = near().count() as f64;
            let product = near().map(|[a, b]| a * b).sum::<f64>() / n;
            let noise = near().map(|[a, b]| (a - b).powi(2) / 4.0).sum::<f64>() / n;
            let share = (product - 0.4 * noise) / (product + 0.6 * noise);
            let [a, b] = pair(x, y);
            let found = filter.at(y * 9 + x);
            assert!((found.mean.y - share * (a + b) / 2.0).abs() < 1e-12, "{x} {y}: {:?}", found);
            assert!((found.variance.z - share * noise).abs() < 1e-12, "{x} {y}: {:?}", found);
        }
    }

    /// Where both disagree, and where nothing is known, no bias is claimed.
    #[test]
    fn biases_that_disagree_are_noise() {
        for biases in [Some([DVec3::ONE, -DVec3::ONE]), None] {
            let filter = BiasFilter { width: 1, pixels: vec![Biases::of(biases)] };
            assert_eq!(filter.at(0), Bias { mean: DVec3::ZERO, variance: DVec3::ZERO });
        }
    }
}
