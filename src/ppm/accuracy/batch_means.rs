use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::super::ErrorEstimates;
use super::radius_trend::{RadiusTrend, TrendSums};
use super::sampling::sampling_step;
use crate::math::{DVec3, Vec3};

/// Every batch but the first few holds about one in so many of the passes before it: longer and longer, so that few are enough.
const PARTS: u32 = 3;

/// The variance of pixels' means over passes, from the sums of batches of passes.
/// Pixels have numbers in whatever order the caller comes to them.
///
/// The estimate after `n` passes is `L_n = (1/n) Σ x_i`, with `x_i` what pass `i` alone says: shrinking a radius keeps
/// `τ / R²`, so `τ / (π R² N_emitted)` is the mean of `Φ_i / (π R_i² N_pass)`. Given the radii, passes are
/// independent. Let batch `b` have `n_b` passes and the sum `D_b = Σ x_i`; then
/// `Var(L_n) ≈ Σ_b (D_b - n_b L_n)² / (n² - Σ_b n_b²)`. The sum is kept about the mean that makes it least,
/// `m = Σ n_b D_b / Σ n_b²`, so that means may be f32: it is `Σ (D_b - n_b m)² + (m - L_n)² Σ n_b²`.
///
/// # Source
/// Hachisuka, Jarosz and Jensen, "A Progressive Error Estimation Framework for Photon Density Estimation", SIGGRAPH
/// Asia 2010, for the variance from passes; Knaus and Zwicker, "Progressive Photon Mapping: A Probabilistic
/// Approach", ACM Transactions on Graphics 30(3), 2011, for their independence.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct BatchMeans {
    /// Of every pixel whose number is a multiple of `step`.
    pixels: Vec<Moments>,
    step: usize,
    /// Passes in all batches: `n`.
    passes: u32,
    /// `Σ n_b²`.
    squares: f64,
    batches: u32,
    /// The mean `R²` of all hit points in the pass under way, in units of the first.
    radius2: f64,
    /// Its sum over the passes of the open batch.
    open_radius2: f64,
    /// Of batches 0, 2, 4 ... and 1, 3, 5 ...: two estimates of the bias that share no photon.
    trends: [RadiusTrend; 2],
}

/// What is kept of one pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Moments {
    /// `L_n` when the last batch was closed.
    mean: Vec3,
    /// `Σ n_b D_b / Σ n_b²`, the mean of `D_b / n_b` by the weights `n_b²`.
    weighted: Vec3,
    /// `Σ (D_b - n_b weighted)²`.
    deviations: DVec3,
    /// For each of the trends.
    trends: [TrendSums; 2],
}

impl BatchMeans {
    /// For a picture of so many pixels.
    pub(crate) fn asked_for(estimates: ErrorEstimates, pixels: usize) -> Option<BatchMeans> {
        match estimates {
            ErrorEstimates::None => None,
            ErrorEstimates::Picture => Some(BatchMeans::new(pixels, sampling_step(pixels))),
            ErrorEstimates::Pixels => Some(BatchMeans::new(pixels, 1)),
        }
    }

    /// For every `step`-th of so many pixels.
    pub(crate) fn new(pixels: usize, step: usize) -> BatchMeans {
        let pixels = vec![Moments::default(); pixels.div_ceil(step)];
        let trends = Default::default();
        BatchMeans {
            pixels,
            step,
            passes: 0,
            squares: 0.0,
            batches: 0,
            radius2: 1.0,
            open_radius2: 0.0,
            trends,
        }
    }

    /// Notes the mean `R²` of all hit points after a pass, in units of the first.
    pub(crate) fn shrink(&mut self, radius2: f64) {
        self.open_radius2 += self.radius2;
        self.radius2 = radius2;
    }

    /// Whether a batch that ends after `passes` passes is long enough.
    pub(crate) fn is_due(&self, passes: u32) -> bool {
        passes - self.passes > self.passes / PARTS
    }

    /// Ends a batch after `passes` passes, more than at the last call; `mean` is `L_n` of a pixel.
    pub(crate) fn close(&mut self, passes: u32, mean: impl Fn(usize) -> DVec3 + Sync) {
        let (before, now) = (f64::from(self.passes), f64::from(passes));
        let length = now - before;
        let (step, half) = (self.step, self.batches as usize % 2);
        let radius2 = std::mem::take(&mut self.open_radius2) / length;
        let weight = length * length / (self.squares + length * length);
        let add = |moments: &mut Moments, mean: DVec3| {
            let sum = now * mean - before * moments.mean.as_dvec3();
            moments.mean = mean.as_vec3();
            moments.add(sum, length, weight);
            moments.trends[half].add(sum, radius2);
        };
        self.pixels.par_iter_mut().enumerate().for_each(|(index, moments)| add(moments, mean(index * step)));
        self.trends[half].add(length, radius2);
        self.passes = passes;
        self.squares += length * length;
        self.batches += 1;
    }

    /// Passes in all batches that are closed.
    pub(crate) fn passes(&self) -> u32 {
        self.passes
    }

    /// Pixels that are looked at.
    pub(crate) fn len(&self) -> usize {
        self.pixels.len()
    }

    /// The distance between pixels that are looked at: 1 if all are.
    pub(crate) fn step(&self) -> usize {
        self.step
    }

    /// Whether both look at the same pixels.
    pub(crate) fn is_like(&self, other: &BatchMeans) -> bool {
        (self.pixels.len(), self.step) == (other.pixels.len(), other.step)
    }

    /// The variance of a pixel's mean; infinite below two batches, where nothing is known of it, and for pixels that are
    /// not looked at.
    pub(crate) fn variance(&self, pixel: usize) -> DVec3 {
        if self.batches < 2 || !pixel.is_multiple_of(self.step) {
            return DVec3::INFINITY;
        }
        let Moments { mean, weighted, deviations, .. } = self.pixels[pixel / self.step];
        let (n, between) = (f64::from(self.passes), (weighted - mean).as_dvec3());
        (deviations + self.squares * between * between) / (n * n - self.squares)
    }

    /// Two independent estimates of the bias of a pixel's mean; `None` where radii hardly changed, or too few batches are
    /// there to tell, and for pixels that are not looked at.
    pub(crate) fn biases(&self, pixel: usize) -> Option<[DVec3; 2]> {
        let moments = pixel.is_multiple_of(self.step).then(|| &self.pixels[pixel / self.step])?;
        let [even, odd] = &self.trends;
        let mean_radius2 = 0.5 * (even.mean_radius2() + odd.mean_radius2());
        Some([even.bias(&moments.trends[0], mean_radius2)?, odd.bias(&moments.trends[1], mean_radius2)?])
    }

    /// The degrees of freedom of the variance, `n² / Σ n_b² - 1`: one less than there are batches, if all are equal.
    pub(crate) fn degrees_of_freedom(&self) -> f64 {
        let n = f64::from(self.passes);
        if self.batches == 0 { 0.0 } else { n * n / self.squares - 1.0 }
    }

    /// Heap memory, in bytes.
    pub(crate) fn memory_bytes(&self) -> usize {
        size_of_val(&*self.pixels)
    }
}

impl Moments {
    /// Adds a batch with the sum `D_b`; `weight` is its part of `Σ n_b²`.
    fn add(&mut self, sum: DVec3, length: f64, weight: f64) {
        let off = sum / length - self.weighted.as_dvec3();
        self.weighted = (self.weighted.as_dvec3() + weight * off).as_vec3();
        self.deviations += length * length * (1.0 - weight) * off * off;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Rng, Stream};

    /// One pixel that sees `noise(pass)` in each pass.
    fn batches_of(passes: u32, mut noise: impl FnMut(u32) -> f64) -> BatchMeans {
        let (mut batches, mut sum) = (BatchMeans::new(1, 1), 0.0);
        for pass in 1..=passes {
            sum += noise(pass);
            if batches.is_due(pass) {
                batches.close(pass, |_| DVec3::splat(sum / f64::from(pass)));
            }
        }
        batches
    }

    #[test]
    fn batches_are_single_passes_at_first_and_grow_with_their_number() {
        let mut batches = BatchMeans::new(0, 1);
        let ends: Vec<u32> = (1..=40)
            .filter(|&pass| {
                let due = batches.is_due(pass);
                if due {
                    batches.close(pass, |_| DVec3::ZERO);
                }
                due
            })
            .collect();
        assert_eq!(ends, [1, 2, 3, 5, 7, 10, 14, 19, 26, 35]);
    }

    #[test]
    fn single_passes_give_the_textbook_variance_of_a_mean() {
        let values = [3.0, 5.0, 10.0];
        let batches = batches_of(3, |pass| values[pass as usize - 1]);
        // Σ (x - 6)² = 26; 26 / (3 · 2).
        assert!((batches.variance(0).x - 26.0 / 6.0).abs() < 1e-6);
        assert!((batches.degrees_of_freedom() - 2.0).abs() < 1e-12);
    }

    #[test]
    fn nothing_is_claimed_from_one_batch() {
        let mut batches = BatchMeans::new(1, 1);
        assert_eq!(batches.degrees_of_freedom(), 0.0);
        batches.close(1, |_| DVec3::ONE);
        assert_eq!(batches.variance(0), DVec3::INFINITY);
        assert_eq!(batches.degrees_of_freedom(), 0.0);
    }

    /// Over many renders, the estimate is the true variance on average; for noise that grows as radii shrink, a twentieth less,
    /// since the longest batches are the noisiest.
    #[test]
    fn variance_is_unbiased() {
        for (passes, growth, expected) in [(5, 0.0, 1.0), (85, 0.0, 1.0), (85, 0.3, 0.95)] {
            let sigma2 = |pass: u32| f64::from(pass).powf(growth);
            let truth = (1..=passes).map(sigma2).sum::<f64>() / f64::from(passes * passes);
            let mean: f64 = (0..4000)
                .map(|render| {
                    let mut rng = Rng::new(1, Stream::Test, passes, render);
                    // Uniform numbers of variance 1.
                    let unit = |rng: &mut Rng| 12f64.sqrt() * (f64::from(rng.next_f32()) - 0.5);
                    batches_of(passes, |pass| 7.0 + sigma2(pass).sqrt() * unit(&mut rng)).variance(0).x
                })
                .sum::<f64>()
                / 4000.0;
            assert!(
                (mean / truth / expected - 1.0).abs() < 0.03,
                "{passes} passes, growth {growth}: {}",
                mean / truth
            );
        }
    }

    #[test]
    fn pixels_between_the_steps_are_not_looked_at() {
        let mut batches = BatchMeans::new(8, 3);
        for pass in [1, 2] {
            batches.close(pass, |pixel| DVec3::splat(f64::from(pass) * pixel as f64));
        }
        // Passes of p and 3 p: the mean 2 p has the variance p².
        let expected = |pixel| if pixel % 3 == 0 { (pixel * pixel) as f64 } else { f64::INFINITY };
        assert!((0..8).all(|pixel| batches.variance(pixel).x == expected(pixel)));
    }

    #[test]
    fn quiet_pixels_have_no_variance_and_large_means_lose_none() {
        let rounding = batches_of(50, |_| 1e6).variance(0).x.sqrt();
        assert!(rounding < 1e-7 * 1e6, "{rounding}");
        let loud = batches_of(12, |pass| 1e6 + f64::from(pass % 3)).variance(0).x;
        assert!((0.02..0.1).contains(&loud), "{loud}");
    }

    /// Passes of `light + slope R²` without noise, in batches of several passes: the bias is `slope` times the mean `R²` of both halves.
    /// Catches a batch that is told the radius of its end, or of the next pass.
    #[test]
    fn an_open_batch_has_the_mean_radius_of_its_passes() {
        const RADII2: [f64; 10] = [1.0, 0.9, 0.7, 0.6, 0.55, 0.5, 0.45, 0.3, 0.25, 0.2];
        let (mut batches, mut sum) = (BatchMeans::new(1, 1), 0.0);
        for (pass, radius2) in (1..).zip(RADII2) {
            sum += 2.0 + 3.0 * radius2;
            batches.shrink(RADII2.get(pass as usize).copied().unwrap_or(0.1));
            if [1, 3, 4, 7, 10].contains(&pass) {
                batches.close(pass, |_| DVec3::splat(sum / f64::from(pass)));
            }
        }
        // The mean of both halves: passes 1, 4 and 8 to 10, passes 2, 3 and 5 to 7.
        let halves = [(1.0 + 0.6 + 0.3 + 0.25 + 0.2) / 5.0, (0.9 + 0.7 + 0.55 + 0.5 + 0.45) / 5.0];
        let expected = 3.0 * (halves[0] + halves[1]) / 2.0;
        for bias in batches.biases(0).unwrap() {
            assert!((bias.x - expected).abs() < 1e-4, "{bias}, not {expected}");
        }
    }
}
