use super::statistics::is_within;
use super::{CompareError, Estimate, Region};
use crate::film::Image;
use serde::Serialize;
use std::fmt;

/// How many standard errors two estimates are apart: `z = (a - b) / √(se_a² + se_b²)` of every channel value.
///
/// If the standard errors tell the truth and there is no bias, 0.683, 0.954 and 0.997 of normal values lie within 1, 2
/// and 3, and the RMS is 1. Where the combined standard error is 0, there is no z: values that agree to 10⁻⁶ of the larger
/// are left out, others count as beyond every limit, but not towards the RMS. Values whose standard error is
/// infinite, of which nothing is known, are left out. All numbers but the counts are NaN if a pixel that counts is not
/// finite, if a standard error is NaN, or if no value is left.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ZScores {
    /// Root of the mean of `z²`.
    pub rms: f64,
    /// Share of the values with `|z| < 1`.
    pub below_1: f64,
    /// Share of the values with `|z| < 2`.
    pub below_2: f64,
    /// Share of the values with `|z| < 3`.
    pub below_3: f64,
    /// Number of values that have a finite z.
    pub values: usize,
    /// Number of values with a standard error of 0 that agree, left out.
    pub zero_stderr_equal: usize,
    /// Number of values with a standard error of 0 that differ, beyond every limit.
    pub zero_stderr_different: usize,
    /// Number of values with an infinite standard error, left out.
    pub infinite_stderr: usize,
    /// Number of values whose standard error, or which themselves in either picture, are NaN or else unusable.
    pub unusable: usize,
}

impl ZScores {
    /// The z-scores of `a` against `b` over the pixels of a region; standard errors that are missing are 0.
    ///
    /// # Errors
    /// When a picture differs in size from the region.
    pub fn between(a: Estimate, b: Estimate, region: &Region) -> Result<ZScores, CompareError> {
        a.check_region(region)?;
        b.check_region(region)?;
        let mut sums = Sums::default();
        let values = |image: &Image, pixel: usize| image.pixels()[pixel].as_dvec3();
        for pixel in region.pixels() {
            let (mean_a, mean_b) = (values(a.mean, pixel), values(b.mean, pixel));
            let stderr = (a.variance(pixel) + b.variance(pixel)).map(f64::sqrt);
            (0..3).for_each(|channel| sums.add(mean_a[channel], mean_b[channel], stderr[channel]));
        }
        Ok(sums.scores())
    }
}

#[derive(Default)]
struct Sums {
    squared: f64,
    below: [usize; 3],
    counts: ZScores,
}

impl Sums {
    fn add(&mut self, a: f64, b: f64, stderr: f64) {
        let counts = &mut self.counts;
        if !(a.is_finite() && b.is_finite()) || stderr.is_nan() {
            counts.unusable += 1;
        } else if stderr == f64::INFINITY {
            counts.infinite_stderr += 1;
        } else if stderr > 0.0 {
            let z = (a - b) / stderr;
            counts.values += 1;
            self.squared += z * z;
            [1.0, 2.0, 3.0].iter().zip(&mut self.below).for_each(|(k, n)| *n += usize::from(z.abs() < *k));
        } else if is_within(a, b, 0.0, 0.0) {
            counts.zero_stderr_equal += 1;
        } else {
            counts.zero_stderr_different += 1;
        }
    }

    fn scores(self) -> ZScores {
        let (finite, counts) = (self.counts.values, self.counts);
        let void = if counts.unusable > 0 { f64::NAN } else { 1.0 };
        let share = |n: usize| void * n as f64 / (finite + counts.zero_stderr_different) as f64;
        let [below_1, below_2, below_3] = self.below.map(share);
        ZScores { rms: void * (self.squared / finite as f64).sqrt(), below_1, below_2, below_3, ..counts }
    }
}

impl fmt::Display for ZScores {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "z-rms       {:.4} of {} values", self.rms, self.values)?;
        writeln!(f, "z1          {:.4} (normal: 0.6827)", self.below_1)?;
        writeln!(f, "z2          {:.4} (normal: 0.9545)", self.below_2)?;
        writeln!(f, "z3          {:.4} (normal: 0.9973)", self.below_3)?;
        writeln!(
            f,
            "zero-stderr {} values equal, {} different",
            self.zero_stderr_equal, self.zero_stderr_different
        )?;
        write!(f, "no-stderr   {} values infinite, {} unusable", self.infinite_stderr, self.unusable)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Rgb, Rng, Stream};

    fn row(pixels: &[[f32; 3]]) -> Image {
        Image::from_pixels(pixels.len(), 1, pixels.iter().map(|&pixel| Rgb::from(pixel)).collect()).unwrap()
    }

    fn scores(a: &Image, se_a: Option<&Image>, b: &Image, se_b: Option<&Image>) -> ZScores {
        let (a, b) = (Estimate { mean: a, stderr: se_a }, Estimate { mean: b, stderr: se_b });
        ZScores::between(a, b, &Region::of(b.mean)).unwrap()
    }

    #[test]
    fn both_standard_errors_go_in() {
        let (a, b) = (row(&[[1.5, 1.0, 3.0]]), row(&[[1.0; 3]]));
        let (se_a, se_b) = (row(&[[0.3; 3]]), row(&[[0.4; 3]]));
        let both = scores(&a, Some(&se_a), &b, Some(&se_b));
        // z is 1, 0 and 4.
        assert!((both.rms - (17.0f64 / 3.0).sqrt()).abs() < 1e-6);
        let shares = |z: &ZScores| [z.below_1, z.below_2, z.below_3].map(|share| (share * 3.0).round());
        assert_eq!(shares(&both)[1..], [2.0, 2.0]);
        // z is 1.25, 0 and 5, or 1.67, 0 and 6.67.
        assert_eq!(shares(&scores(&a, None, &b, Some(&se_b))), [1.0, 2.0, 2.0]);
        assert!((scores(&a, Some(&se_a), &b, None).rms - (425.0f64 / 27.0).sqrt()).abs() < 1e-5);
    }

    #[test]
    fn normal_errors_have_an_rms_of_one() {
        let mut rng = Rng::new(5, Stream::Test, 0, 0);
        let mut normal = move || (0..12).map(|_| rng.next_f32()).sum::<f32>() - 6.0;
        let pixels: Vec<[f32; 3]> = (0..10_000).map(|_| [0; 3].map(|_| 5.0 + 0.25 * normal())).collect();
        let (a, b) = (row(&pixels), row(&vec![[5.0; 3]; 10_000]));
        let z = scores(&a, Some(&row(&vec![[0.25; 3]; 10_000])), &b, None);
        assert!((z.rms - 1.0).abs() < 0.02 && (z.below_1 - 0.683).abs() < 0.012, "{z:?}");
        assert!((z.below_2 - 0.954).abs() < 0.006 && (z.below_3 - 0.997).abs() < 0.003, "{z:?}");
    }

    #[test]
    fn zero_and_infinite_standard_errors_are_counted() {
        let a = row(&[[2.0, 1.0, 9.0], [1.5, 1.0, 1.0]]);
        let b = row(&[[1.0; 3], [1.0; 3]]);
        let stderr = row(&[[0.0, 0.0, f32::INFINITY], [1.0, 0.5, 0.0]]);
        let z = scores(&a, Some(&stderr), &b, None);
        let counts = (z.values, z.zero_stderr_equal, z.zero_stderr_different, z.infinite_stderr, z.unusable);
        assert_eq!(counts, (2, 2, 1, 1, 0));
        assert_eq!((z.rms, z.below_1, z.below_3), (0.125f64.sqrt(), 2.0 / 3.0, 2.0 / 3.0));
    }

    #[test]
    fn what_is_not_a_number_voids_the_scores() {
        let (fine, nan) = (row(&[[1.0; 3], [2.0; 3]]), row(&[[1.0; 3], [1.0, f32::NAN, 1.0]]));
        for z in [
            scores(&fine, Some(&nan), &fine, None),
            scores(&nan, Some(&fine), &fine, None),
            scores(&nan, Some(&fine), &nan, None),
        ] {
            assert_eq!((z.unusable, z.values), (1, 5));
            assert!([z.rms, z.below_1, z.below_2, z.below_3].iter().all(|value| value.is_nan()));
        }
        let nothing = scores(&fine, None, &fine, None);
        assert!(nothing.rms.is_nan() && nothing.below_1.is_nan());
    }

    #[test]
    fn sizes_are_checked() {
        let (small, large) = (row(&[[1.0; 3]]), row(&[[1.0; 3]; 2]));
        let odd = Estimate { mean: &small, stderr: Some(&large) };
        assert!(ZScores::between(Estimate::exact(&small), odd, &Region::of(&small)).is_err());
        assert!(ZScores::between(odd, Estimate::exact(&small), &Region::of(&small)).is_err());
    }
}
