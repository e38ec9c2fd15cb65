use super::{CompareError, Percentiles, Region};
use crate::film::Image;
use crate::math::DVec3;
use serde::Serialize;
use std::fmt;

/// What keeps the relative error finite where the reference is black (radiance squared).
pub const REL_MSE_EPSILON: f64 = 1e-2;
/// What keeps the symmetric relative error finite, and small, where both pictures are black (radiance).
pub const SMAPE_EPSILON: f64 = 1e-2;

/// How far a picture `a` is from a reference `b`: sums over all `n` channel values that count (three a pixel), in f64
/// and in the order of the pixels, so that equal pictures give equal digits.
///
/// If any pixel that counts is not finite in either picture, all numbers but the counts are NaN, and every bound is
/// exceeded. JSON has neither NaN nor infinity; both become `null` there, and `non_finite_pixels` tells which it was.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Metrics {
    /// Pixels in a row of what was compared.
    pub width: usize,
    /// Number of rows of what was compared.
    pub height: usize,
    /// Number of pixels that count.
    pub pixels: usize,
    /// Mean absolute error, `Σ |a - b| / n`.
    pub mae: f64,
    /// Mean squared error, `Σ (a - b)² / n`.
    pub mse: f64,
    /// Root of the mean squared error.
    pub rmse: f64,
    /// Relative mean squared error, `Σ (a - b)² / (b² + ε) / n` with ε = [`REL_MSE_EPSILON`].
    ///
    /// # Source
    /// Rousselle, Knaus and Zwicker, "Adaptive Sampling and Reconstruction using Greedy Error Minimization", ACM
    /// Transactions on Graphics 30(6), 2011; ε is this project's choice.
    pub rel_mse: f64,
    /// Symmetric mean absolute percentage error as a share, `Σ |a - b| / (|a| + |b| + ε) / n` with ε =
    /// [`SMAPE_EPSILON`]: from 0 to 1.
    ///
    /// # Source
    /// Vogels et al., "Denoising with Kernel Prediction and Asymmetric Loss Functions", ACM Transactions on Graphics
    /// 37(4), 2018.
    pub smape: f64,
    /// Peak signal-to-noise ratio for a peak of 1, `-10 log₁₀ mse` (dB): infinite for identical pictures.
    pub psnr: f64,
    /// Largest absolute error of a channel.
    pub max: f64,
    /// Column and row, in the whole picture, of the first pixel with that error, or of the first that is not finite.
    pub max_pixel: (usize, usize),
    /// Percentiles of `|a - b|`.
    pub percentiles: Percentiles,
    /// Mean of `a` over mean of `b` for each channel: 1 where both are 0, infinite where only `b` is.
    pub mean_ratio: [f64; 3],
    /// Mean over all channels of `a` over that of `b`.
    pub mean_ratio_overall: f64,
    /// Pixels that hold a NaN or an infinity in the picture, the reference or both.
    pub non_finite_pixels: usize,
}

impl Metrics {
    /// Measures `image` against `reference`.
    ///
    /// # Errors
    /// When the two differ in size or are empty.
    ///
    /// ```
    /// use caustica::{compare::Metrics, film::Image, math::Rgb};
    /// let image = Image::from_pixels(1, 1, vec![Rgb::new(0.5, 0.5, 0.8)]).unwrap();
    /// let reference = Image::from_pixels(1, 1, vec![Rgb::new(0.5, 0.5, 0.5)]).unwrap();
    /// let metrics = Metrics::between(&image, &reference)?;
    /// assert!((metrics.mse - 0.03).abs() < 1e-7); // 0.3² / 3
    /// assert!((metrics.mean_ratio[2] - 1.6).abs() < 1e-7);
    /// # Ok::<(), caustica::compare::CompareError>(())
    /// ```
    pub fn between(image: &Image, reference: &Image) -> Result<Metrics, CompareError> {
        Metrics::within(image, reference, &Region::of(reference))
    }

    /// Measures `image` against `reference` over the pixels of a region.
    ///
    /// # Errors
    /// When a picture differs in size from the region, or when the region is empty.
    pub fn within(image: &Image, reference: &Image, region: &Region) -> Result<Metrics, CompareError> {
        region.check(image)?;
        region.check(reference)?;
        let sums = Sums::over(image, reference, region);
        let percentiles = Percentiles::of(&mut absolute_errors(image, reference, region));
        let metrics = sums.metrics(region, percentiles);
        Ok(if sums.non_finite_pixels == 0 { metrics } else { metrics.voided() })
    }

    fn voided(self) -> Metrics {
        let nan = f64::NAN;
        Metrics {
            mae: nan,
            mse: nan,
            rmse: nan,
            rel_mse: nan,
            smape: nan,
            psnr: nan,
            max: nan,
            percentiles: Percentiles::of(&mut []),
            mean_ratio: [nan; 3],
            mean_ratio_overall: nan,
            ..self
        }
    }
}

fn absolute_errors(image: &Image, reference: &Image, region: &Region) -> Vec<f64> {
    let errors = |i: usize| (image.pixels()[i].as_dvec3() - reference.pixels()[i].as_dvec3()).abs();
    region.pixels().flat_map(|pixel| errors(pixel).to_array()).collect()
}

#[derive(Default)]
struct Sums {
    absolute: DVec3,
    squared: DVec3,
    relative: DVec3,
    symmetric: DVec3,
    image: DVec3,
    reference: DVec3,
    max: f64,
    max_index: usize,
    pixels: usize,
    non_finite_pixels: usize,
}

impl Sums {
    fn over(image: &Image, reference: &Image, region: &Region) -> Sums {
        let mut sums = Sums { max: -1.0, ..Sums::default() };
        for index in region.pixels() {
            sums.add(index, image.pixels()[index].as_dvec3(), reference.pixels()[index].as_dvec3());
        }
        sums
    }

    fn add(&mut self, index: usize, a: DVec3, b: DVec3) {
        let difference = (a - b).abs();
        self.absolute += difference;
        self.squared += difference * difference;
        self.relative += difference * difference / (b * b + REL_MSE_EPSILON);
        self.symmetric += difference / (a.abs() + b.abs() + SMAPE_EPSILON);
        self.image += a;
        self.reference += b;
        self.pixels += 1;
        if !(a.is_finite() && b.is_finite()) {
            self.note_max(index, f64::INFINITY);
            self.non_finite_pixels += 1;
        } else {
            self.note_max(index, difference.max_element());
        }
    }

    fn note_max(&mut self, index: usize, error: f64) {
        if error > self.max {
            (self.max, self.max_index) = (error, index);
        }
    }

    fn metrics(&self, region: &Region, percentiles: Percentiles) -> Metrics {
        let n = (3 * self.pixels) as f64;
        let mse = self.squared.element_sum() / n;
        Metrics {
            width: region.crop().width,
            height: region.crop().height,
            pixels: self.pixels,
            mae: self.absolute.element_sum() / n,
            mse,
            rmse: mse.sqrt(),
            rel_mse: self.relative.element_sum() / n,
            smape: self.symmetric.element_sum() / n,
            psnr: -10.0 * mse.log10(),
            max: self.max,
            max_pixel: region.place(self.max_index),
            percentiles,
            mean_ratio: [0, 1, 2].map(|channel| ratio(self.image[channel], self.reference[channel])),
            mean_ratio_overall: ratio(self.image.element_sum(), self.reference.element_sum()),
            non_finite_pixels: self.non_finite_pixels,
        }
    }
}

fn ratio(a: f64, b: f64) -> f64 {
    if a == b { 1.0 } else { a / b }
}

impl fmt::Display for Metrics {
    /// A table for the terminal, one metric a line, without a newline at its end.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ((x, y), [r, g, b]) = (self.max_pixel, self.mean_ratio);
        writeln!(f, "size        {} x {}, {} pixels", self.width, self.height, self.pixels)?;
        writeln!(f, "mae         {:.6e}", self.mae)?;
        writeln!(f, "mse         {:.6e}", self.mse)?;
        writeln!(f, "rmse        {:.6e}", self.rmse)?;
        writeln!(f, "relmse      {:.6e}", self.rel_mse)?;
        writeln!(f, "smape       {:.6e}", self.smape)?;
        writeln!(f, "psnr        {:.3} dB", self.psnr)?;
        writeln!(f, "max         {:.6e} at ({x}, {y})", self.max)?;
        writeln!(f, "{}", self.percentiles)?;
        writeln!(f, "mean-ratio  {:.6} (R {r:.6}, G {g:.6}, B {b:.6})", self.mean_ratio_overall)?;
        write!(f, "non-finite  {} pixels", self.non_finite_pixels)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::Crop;
    use crate::math::Rgb;

    fn image(pixels: &[[f32; 3]]) -> Image {
        let pixels: Vec<_> = pixels.iter().map(|&pixel| Rgb::from(pixel)).collect();
        Image::from_pixels(pixels.len(), 1, pixels).unwrap()
    }

    #[test]
    fn the_formulas_hold_by_hand() {
        let a = image(&[[1.0, 2.0, 0.5], [0.0, 0.0, 0.0]]);
        let b = image(&[[1.0, 1.0, 0.5], [0.0, 0.0, 0.5]]);
        let metrics = Metrics::between(&a, &b).unwrap();
        let close = |x: f64, y: f64| assert!((x - y).abs() < 1e-12, "{x} {y}");
        close(metrics.mae, 1.5 / 6.0);
        close(metrics.mse, 1.25 / 6.0);
        close(metrics.rmse, (1.25f64 / 6.0).sqrt());
        close(metrics.rel_mse, (1.0 / 1.01 + 0.25 / 0.26) / 6.0);
        close(metrics.smape, (1.0 / 3.01 + 0.5 / 0.51) / 6.0);
        close(metrics.percentiles.p50, 0.0);
        close(metrics.percentiles.p90, 1.0);
        close(metrics.psnr, 10.0 * (6.0f64 / 1.25).log10());
        assert_eq!((metrics.max, metrics.max_pixel), (1.0, (0, 0)));
        assert_eq!(metrics.mean_ratio, [1.0, 2.0, 0.5]);
        close(metrics.mean_ratio_overall, 3.5 / 3.0);
        assert_eq!(metrics.non_finite_pixels, 0);
    }

    #[test]
    fn identical_pictures_have_no_error() {
        let a = image(&[[0.0, 0.0, 3.0], [0.0, 7.0, 1.0]]);
        let metrics = Metrics::between(&a, &a).unwrap();
        assert_eq!((metrics.mse, metrics.rel_mse, metrics.max), (0.0, 0.0, 0.0));
        assert_eq!((metrics.psnr, metrics.mean_ratio), (f64::INFINITY, [1.0; 3]));
    }

    #[test]
    fn a_mean_over_black_is_infinite() {
        let metrics = Metrics::between(&image(&[[1.0, 0.0, 0.0]]), &image(&[[0.0; 3]])).unwrap();
        assert_eq!(metrics.mean_ratio, [f64::INFINITY, 1.0, 1.0]);
    }

    #[test]
    fn the_first_of_the_largest_errors_is_found_with_its_place() {
        let mut a = Image::new(5, 4);
        a.pixels_mut()[13] = Rgb::new(0.0, -3.0, 0.0);
        a.pixels_mut()[17] = Rgb::new(0.0, 0.0, 3.0);
        let metrics = Metrics::between(&a, &Image::new(5, 4)).unwrap();
        assert_eq!((metrics.max, metrics.max_pixel), (3.0, (3, 2)));
    }

    #[test]
    fn one_bad_pixel_voids_every_number() {
        let fine = image(&[[9.0; 3], [1.0; 3]]);
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let broken = image(&[[1.0; 3], [1.0, bad, 1.0]]);
            for (a, b) in [(&broken, &fine), (&fine, &broken), (&broken, &broken)] {
                let m = Metrics::between(a, b).unwrap();
                assert_eq!((m.non_finite_pixels, m.max_pixel), (1, (1, 0)));
                let all = [m.mae, m.mse, m.rmse, m.rel_mse, m.smape, m.psnr, m.max, m.mean_ratio_overall];
                assert!(m.percentiles.p50.is_nan() && m.percentiles.p99_9.is_nan());
                assert!(all.iter().chain(&m.mean_ratio).all(|value| value.is_nan()), "{m:?}");
            }
        }
    }

    #[test]
    fn pixels_outside_the_region_do_not_count() {
        let (mut a, b) = (Image::new(4, 3), Image::new(4, 3));
        a.pixels_mut().fill(Rgb::NAN);
        a.pixels_mut()[6] = Rgb::new(0.5, 0.0, 0.0);
        a.pixels_mut()[10] = Rgb::ZERO;
        let crop = Crop { x: 2, y: 1, width: 1, height: 2 };
        let region = Region::of(&b).with_crop(crop).unwrap();
        let metrics = Metrics::within(&a, &b, &region).unwrap();
        assert_eq!((metrics.width, metrics.height, metrics.pixels), (1, 2, 2));
        assert_eq!((metrics.mse, metrics.max, metrics.max_pixel), (0.25 / 6.0, 0.5, (2, 1)));
        assert_eq!((metrics.percentiles.p50, metrics.percentiles.p99), (0.0, 0.5));
        assert_eq!(metrics.non_finite_pixels, 0);
        let equal = Metrics::within(&b, &b, &region).unwrap();
        assert_eq!((equal.max, equal.max_pixel), (0.0, (2, 1)));
    }

    #[test]
    fn sizes_must_agree_and_not_be_zero() {
        let text = Metrics::between(&Image::new(2, 3), &Image::new(3, 2)).unwrap_err().to_string();
        assert_eq!(text, "the pictures differ in size: 2x3 against 3x2; compare pictures of the same size");
        let empty = Image::new(0, 2);
        assert_eq!(Metrics::between(&empty, &empty), Err(CompareError::Empty { width: 0, height: 2 }));
    }

    #[test]
    fn json_has_null_for_what_json_lacks() {
        let a = image(&[[0.0, 0.5, 1.0]]);
        let json = serde_json::to_value(Metrics::between(&a, &a).unwrap()).unwrap();
        assert_eq!((&json["mse"], &json["psnr"]), (&0.0.into(), &serde_json::Value::Null));
        assert_eq!(json["mean_ratio"], serde_json::json!([1.0, 1.0, 1.0]));
    }

    #[test]
    fn the_table_names_every_metric() {
        let table = Metrics::between(&image(&[[0.0, 0.0, 0.1]]), &image(&[[0.0; 3]])).unwrap().to_string();
        assert!(table.contains("mse         3.333333e-3\n"), "{table}");
        assert!(table.contains("psnr        24.771 dB\n"), "{table}");
        assert!(table.contains("mean-ratio  inf (R 1.000000, G 1.000000, B inf)\n"), "{table}");
        assert!(table.ends_with("non-finite  0 pixels"), "{table}");
    }
}
