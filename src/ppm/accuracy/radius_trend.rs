use serde::{Deserialize, Serialize};

use crate::math::{DVec3, Vec3};

/// The regression of batches on the squared radius that they were gathered with: what a disc of radius `R` adds to the light
/// is `k R²`, so batches with larger discs tell `k`, and with it the bias of the mean over all of them.
///
/// Batch `b` of `n_b` passes has the sum `D_b` and the mean squared radius `q_b`. Its variance goes with
/// `n_b / q_b`, so weighted least squares give `k = (Σ q² D - q̄ Σ q D) / (Σ n q³ - q̄ Σ n q²)` with `q̄ = Σ n q² / Σ n q`, and the bias
/// is `k Σ n q / Σ n`.
///
/// # Source
/// Hachisuka, Jarosz and Jensen, "A Progressive Error Estimation Framework for Photon Density Estimation", SIGGRAPH
/// Asia 2010, equation 10, for `B ~ R²`; they find its factor by derivatives of kernels, not from the radii of the passes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct RadiusTrend {
    /// `Σ n`, `Σ n q`, `Σ n q²`, `Σ n q³`.
    powers: [f64; 4],
}

/// Radii alike to half a percent tell nothing: the rounding of the sums, which are f32, would be a bias of `2⁻²³ / spread`.
const LEAST_SPREAD: f64 = 1e-4;

/// The sums of one pixel that the trend makes a bias of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct TrendSums {
    /// `Σ q D`.
    first: Vec3,
    /// `Σ q² D`.
    second: Vec3,
}

impl RadiusTrend {
    /// Adds a batch of so many passes.
    pub(super) fn add(&mut self, length: f64, radius2: f64) {
        let mut power = length;
        for sum in &mut self.powers {
            *sum += power;
            power *= radius2;
        }
    }

    /// What radii differed by, as a share of their mean: `Σ n q³ Σ n q / (Σ n q²)² - 1`.
    fn spread(&self) -> f64 {
        let [_, first, second, third] = self.powers;
        third * first / (second * second) - 1.0
    }

    /// The bias of the mean over passes whose mean squared radius is `mean_radius2`; `None` where all radii are alike.
    pub(super) fn bias(&self, sums: &TrendSums, mean_radius2: f64) -> Option<DVec3> {
        let [_, first, second, _] = self.powers;
        let differ = self.spread() > LEAST_SPREAD;
        let slope = (sums.second.as_dvec3() - second / first * sums.first.as_dvec3())
            / (second * second / first * self.spread());
        differ.then_some(mean_radius2 * slope)
    }

    /// The mean squared radius over all passes.
    pub(super) fn mean_radius2(&self) -> f64 {
        let [passes, first, ..] = self.powers;
        first / passes
    }
}

impl TrendSums {
    pub(super) fn add(&mut self, sum: DVec3, radius2: f64) {
        self.first += (radius2 * sum).as_vec3();
        self.second += (radius2 * radius2 * sum).as_vec3();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Batches of `light + slope R²`, without noise.
    fn batches(radii2: &[f64], light: f64, slope: f64) -> (RadiusTrend, TrendSums) {
        let (mut trend, mut sums) = (RadiusTrend::default(), TrendSums::default());
        for (length, &radius2) in (1..).map(f64::from).zip(radii2) {
            trend.add(length, radius2);
            sums.add(DVec3::splat(length * (light + slope * radius2)), radius2);
        }
        (trend, sums)
    }

    #[test]
    fn the_bias_of_a_blur_is_found_exactly() {
        let (trend, sums) = batches(&[4.0, 3.0, 2.5], 7.0, -0.5);
        // Passes of radii² 4, 3, 3, 2.5, 2.5, 2.5.
        let mean = 17.5 / 6.0;
        assert!((trend.mean_radius2() - mean).abs() < 1e-12);
        let bias = trend.bias(&sums, mean).unwrap().x;
        assert!((bias + 0.5 * mean).abs() < 1e-4, "{bias}");
    }

    #[test]
    fn radii_that_do_not_change_tell_nothing() {
        let (trend, sums) = batches(&[0.3, 0.3, 0.3], 7.0, -0.5);
        assert_eq!(trend.bias(&sums, 0.3), None);
        let (trend, sums) = batches(&[2.0], 7.0, -0.5);
        assert_eq!(trend.bias(&sums, 2.0), None);
        // Rounding alone would be a bias of a hundredth.
        let (trend, sums) = batches(&[1.0, 0.999, 0.998], 7.0, 0.0);
        assert_eq!(trend.bias(&sums, 1.0), None);
        assert_eq!(RadiusTrend::default().bias(&TrendSums::default(), 1.0), None);
    }
}
