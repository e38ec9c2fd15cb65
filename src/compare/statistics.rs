use super::{CompareError, Region};
use crate::film::Image;
use crate::math::DVec3;

/// The relative difference up to which values without any standard error are equal.
const EXACT_TOLERANCE: f64 = 1e-6;

/// A picture together with how well it is known.
#[derive(Clone, Copy, Debug)]
pub struct Estimate<'a> {
    /// The picture.
    pub mean: &'a Image,
    /// The standard error of every pixel and channel; `None` if the picture counts as exact.
    pub stderr: Option<&'a Image>,
}

impl<'a> Estimate<'a> {
    /// A picture without standard errors.
    pub fn exact(mean: &'a Image) -> Estimate<'a> {
        Estimate { mean, stderr: None }
    }

    pub(super) fn variance(&self, pixel: usize) -> DVec3 {
        let stderr = self.stderr.map_or(DVec3::ZERO, |image| image.pixels()[pixel].as_dvec3());
        stderr * stderr
    }

    pub(super) fn check_sizes(&self, other: &Image) -> Result<(), CompareError> {
        self.check_region(&Region::of(other))
    }

    pub(super) fn check_region(&self, region: &Region) -> Result<(), CompareError> {
        region.check(self.mean)?;
        self.stderr.map_or(Ok(()), |stderr| region.check(stderr))
    }
}

/// The share of channel values of two estimates that lie within `k` combined standard errors of each other.
///
/// A value is inside if `|a - b| ≤ k √(se_a² + se_b²)`; where both standard errors are 0, if `a` and `b` agree to
/// 10⁻⁶ of the larger. NaN is outside. For normal errors the share tends to 0.683, 0.954 and 0.997 for `k` of 1, 2, 3.
///
/// # Errors
/// When the pictures differ in size or are empty.
pub fn share_within(a: Estimate, b: Estimate, k: f64) -> Result<f64, CompareError> {
    a.check_sizes(b.mean)?;
    b.check_sizes(b.mean)?;
    let inside = |pixel: usize| {
        let (mean_a, mean_b) = (a.mean.pixels()[pixel].as_dvec3(), b.mean.pixels()[pixel].as_dvec3());
        let stderr = (a.variance(pixel) + b.variance(pixel)).map(f64::sqrt);
        (0..3).filter(|&channel| is_within(mean_a[channel], mean_b[channel], k, stderr[channel])).count()
    };
    let n_pixels = b.mean.pixels().len();
    let n_inside: usize = (0..n_pixels).map(inside).sum();
    Ok(n_inside as f64 / (3 * n_pixels) as f64)
}

pub(super) fn is_within(a: f64, b: f64, k: f64, stderr: f64) -> bool {
    let tolerance = if stderr == 0.0 { EXACT_TOLERANCE * a.abs().max(b.abs()) } else { k * stderr };
    (a - b).abs() <= tolerance
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Rgb, Rng, Stream};

    fn uniform(width: usize, height: usize, value: Rgb) -> Image {
        Image::from_pixels(width, height, vec![value; width * height]).unwrap()
    }

    /// Sums of twelve uniform numbers less 6: mean 0, variance 1, nearly normal.
    fn noise(width: usize, height: usize, mean: f32, stderr: f32, seed: u64) -> Image {
        let mut rng = Rng::new(seed, Stream::Test, 0, 0);
        let mut normal = move || (0..12).map(|_| rng.next_f32()).sum::<f32>() - 6.0;
        let mut value = || mean + stderr * normal();
        let pixels = (0..width * height).map(|_| Rgb::new(value(), value(), value())).collect();
        Image::from_pixels(width, height, pixels).unwrap()
    }

    #[test]
    fn normal_errors_lie_within_sigmas_as_often_as_they_should() {
        let (a, b) = (noise(100, 100, 5.0, 0.3, 1), noise(100, 100, 5.0, 0.4, 2));
        let (se_a, se_b) = (uniform(100, 100, Rgb::splat(0.3)), uniform(100, 100, Rgb::splat(0.4)));
        let a = Estimate { mean: &a, stderr: Some(&se_a) };
        let b = Estimate { mean: &b, stderr: Some(&se_b) };
        for (k, share) in [(1.0, 0.6827), (2.0, 0.9545), (3.0, 0.9973)] {
            let found = share_within(a, b, k).unwrap();
            // 30 000 values: four standard errors of the share itself, and .001 for noise that is only nearly normal.
            let slack = 4.0 * f64::sqrt(share * (1.0 - share) / 3e4) + 1e-3;
            assert!((found - share).abs() < slack, "{k} sigma: {found}");
        }
    }

    #[test]
    fn without_standard_errors_values_must_agree() {
        let b = uniform(2, 1, Rgb::splat(100.0));
        let mut a = b.clone();
        a.pixels_mut()[0] = Rgb::new(100.000_05, 100.01, f32::NAN);
        let share = share_within(Estimate::exact(&a), Estimate::exact(&b), 1e9).unwrap();
        assert_eq!(share, 4.0 / 6.0);
    }

    #[test]
    fn sizes_are_checked() {
        let (small, large) = (Image::new(2, 2), Image::new(3, 2));
        let odd_stderr = Estimate { mean: &small, stderr: Some(&large) };
        assert!(share_within(odd_stderr, Estimate::exact(&small), 1.0).is_err());
        assert!(share_within(Estimate::exact(&small), odd_stderr, 1.0).is_err());
    }
}
