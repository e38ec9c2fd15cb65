use super::{
    BlockCriterion, BlockReport, Bound, CompareError, Coverage, Estimate, Flip, MetricName, Metrics, Region,
    WorstBlock, ZScores,
};
use crate::film::Image;
use serde::Serialize;
use std::fmt;

/// The pictures of a comparison and what to look at in them.
#[derive(Clone, Copy, Debug)]
pub struct Inputs<'a> {
    /// The picture to judge, with its standard error if there is one.
    pub image: Estimate<'a>,
    /// The picture to judge it against.
    pub reference: Estimate<'a>,
    /// Bounds of the error that somebody predicted, one a channel value; see [`Coverage`].
    pub bound: Option<&'a Image>,
    /// Which pixels count.
    pub region: &'a Region,
    /// When blocks agree; its mask is ignored for that of the region.
    pub blocks: BlockCriterion<'a>,
}

/// Everything that can be said of how far a picture is from a reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Sums over channel values.
    #[serde(flatten)]
    pub metrics: Metrics,
    /// How different the pictures look.
    pub flip: Flip,
    /// Means of blocks, counted from the upper left of the crop.
    pub blocks: BlockReport,
    /// Errors in standard errors; `None` without any standard error.
    pub z: Option<ZScores>,
    /// How often predicted bounds hold; `None` without such bounds.
    pub coverage: Option<Coverage>,
}

impl Comparison {
    /// Compares the pictures in every way that the inputs allow.
    ///
    /// # Errors
    /// When a picture differs in size from the region.
    pub fn of(inputs: &Inputs) -> Result<Comparison, CompareError> {
        let &Inputs { image, reference, bound, region, .. } = inputs;
        let has_stderr = image.stderr.is_some() || reference.stderr.is_some();
        Ok(Comparison {
            metrics: Metrics::within(image.mean, reference.mean, region)?,
            flip: Flip::between(image.mean, reference.mean, region)?,
            blocks: blocks(inputs)?,
            z: has_stderr.then(|| ZScores::between(image, reference, region)).transpose()?,
            coverage: bound.map(|bound| Coverage::of(bound, image.mean, reference, region)).transpose()?,
        })
    }

    /// The value of a metric, or `None` if the inputs did not allow it; NaN if a pixel that counts is not finite.
    ///
    /// For `mean-ratio` that is the largest distance of any channel's ratio from 1.
    pub fn value(&self, metric: MetricName) -> Option<f64> {
        let value = self.measured(metric)?;
        Some(if self.metrics.non_finite_pixels == 0 { value } else { f64::NAN })
    }

    fn measured(&self, metric: MetricName) -> Option<f64> {
        let (metrics, percentiles) = (&self.metrics, &self.metrics.percentiles);
        let z = self.z.as_ref();
        Some(match metric {
            MetricName::Mae => metrics.mae,
            MetricName::Mse => metrics.mse,
            MetricName::Rmse => metrics.rmse,
            MetricName::RelMse => metrics.rel_mse,
            MetricName::Smape => metrics.smape,
            MetricName::Psnr => metrics.psnr,
            MetricName::Max => metrics.max,
            MetricName::P50 => percentiles.p50,
            MetricName::P90 => percentiles.p90,
            MetricName::P95 => percentiles.p95,
            MetricName::P99 => percentiles.p99,
            MetricName::P99_9 => percentiles.p99_9,
            MetricName::MeanRatio => {
                metrics.mean_ratio.map(|ratio| (ratio - 1.0).abs()).into_iter().fold(0.0, f64::max)
            }
            MetricName::Flip => self.flip.mean,
            MetricName::BlockMax => self.blocks.worst.map_or(f64::NAN, |worst| worst.relative_difference),
            MetricName::BlockShare => self.blocks.worst.map_or(f64::NAN, |_| self.blocks.share_within()),
            MetricName::ZRms => z?.rms,
            MetricName::Z1 => z?.below_1,
            MetricName::Z2 => z?.below_2,
            MetricName::Z3 => z?.below_3,
            MetricName::Coverage => self.coverage.as_ref()?.share,
            MetricName::Untrusted => self.coverage.as_ref()?.untrusted,
        })
    }

    /// Whether a metric lies above the bound, or, for `psnr`, which is better the larger it is, below.
    ///
    /// A value equal to the limit is fine, a NaN never is.
    ///
    /// # Errors
    /// When the inputs did not allow the metric.
    pub fn exceeds(&self, bound: &Bound) -> Result<bool, CompareError> {
        match bound.metric {
            MetricName::Psnr => self.falls_below(bound),
            metric => Ok(is_beyond(self.bounded(metric)?, bound.limit)),
        }
    }

    /// Whether a metric lies below the bound. A value equal to the limit is fine, a NaN never is.
    ///
    /// # Errors
    /// When the inputs did not allow the metric.
    pub fn falls_below(&self, bound: &Bound) -> Result<bool, CompareError> {
        Ok(is_beyond(-self.bounded(bound.metric)?, -bound.limit))
    }

    fn bounded(&self, metric: MetricName) -> Result<f64, CompareError> {
        self.value(metric).ok_or(CompareError::NotMeasured { metric })
    }
}

fn is_beyond(value: f64, limit: f64) -> bool {
    value.is_nan() || value > limit
}

/// Blocks look at the pixels inside the crop alone, while the worst block's place is one in the whole picture.
fn blocks(inputs: &Inputs) -> Result<BlockReport, CompareError> {
    let &Inputs { image, reference, region, .. } = inputs;
    image.check_region(region)?;
    reference.check_region(region)?;
    let cut = |image: Option<&Image>| image.map(|image| region.cut(image));
    let (a, b) = (region.cut(image.mean), region.cut(reference.mean));
    let (stderr_a, stderr_b) = (cut(image.stderr), cut(reference.stderr));
    let mask = region.cut_mask();
    let criterion = BlockCriterion { mask: Some(&mask), ..inputs.blocks };
    let report = BlockReport::between(
        Estimate { mean: &a, stderr: stderr_a.as_ref() },
        Estimate { mean: &b, stderr: stderr_b.as_ref() },
        &criterion,
    )?;
    let crop = region.crop();
    let shifted = |worst: WorstBlock| WorstBlock { x: worst.x + crop.x, y: worst.y + crop.y, ..worst };
    Ok(BlockReport { worst: report.worst.map(shifted), ..report })
}

impl fmt::Display for Comparison {
    /// A table for the terminal, without a newline at its end.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.metrics)?;
        writeln!(f, "{}", self.flip)?;
        write!(f, "{}", self.blocks)?;
        self.z.iter().try_for_each(|z| write!(f, "\n{z}"))?;
        self.coverage.iter().try_for_each(|coverage| write!(f, "\n{coverage}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::Crop;
    use crate::math::Rgb;

    fn picture(pixel: Rgb) -> Image {
        Image::from_pixels(1, 1, vec![pixel]).unwrap()
    }

    /// One pixel with a standard error of 0.25 and a bound of 0.5.
    fn comparison(a: Rgb, b: Rgb) -> Comparison {
        let (stderr, bound) = (picture(Rgb::splat(0.25)), picture(Rgb::new(0.5, 0.5, f32::NAN)));
        let (a, b) = (picture(a), picture(b));
        let region = Region::of(&a);
        Comparison::of(&Inputs {
            image: Estimate { mean: &a, stderr: Some(&stderr) },
            reference: Estimate::exact(&b),
            bound: Some(&bound),
            region: &region,
            blocks: BlockCriterion::new(0.1, 0.0),
        })
        .unwrap()
    }

    fn plain(a: &Image, b: &Image, region: &Region) -> Comparison {
        let (image, reference) = (Estimate::exact(a), Estimate::exact(b));
        let blocks = BlockCriterion { block: 2, ..BlockCriterion::new(0.1, 0.0) };
        Comparison::of(&Inputs { image, reference, bound: None, region, blocks }).unwrap()
    }

    fn exceeds(comparison: &Comparison, bound: &str) -> bool {
        comparison.exceeds(&bound.parse().unwrap()).unwrap()
    }

    fn falls_below(comparison: &Comparison, bound: &str) -> bool {
        comparison.falls_below(&bound.parse().unwrap()).unwrap()
    }

    #[test]
    fn each_metric_is_held_against_its_own_bound() {
        // The blue channel is off by 0.5, two standard errors: mse 1/12, psnr 10.8 dB, z of 0, 0, 2.
        let found = comparison(Rgb::new(0.5, 1.0, 1.0), Rgb::new(0.5, 1.0, 0.5));
        for (name, below, above) in [
            ("mae", 0.16, 0.17),
            ("mse", 0.083, 0.084),
            ("rmse", 0.288, 0.289),
            ("relmse", 0.320, 0.321),
            ("smape", 0.110, 0.111),
            ("max", 0.49, 0.5),
            ("p90", 0.49, 0.5),
            ("p95", 0.49, 0.5),
            ("p99", 0.49, 0.5),
            ("p99.9", 0.49, 0.5),
            ("mean-ratio", 0.99, 1.0),
            ("flip", 0.1, 0.9),
            ("block-max", 0.99, 1.0),
            ("z-rms", 1.154, 1.155),
            ("z1", 0.66, 0.67),
            ("z2", 0.66, 0.67),
            ("z3", 0.99, 1.0),
            ("coverage", 0.99, 1.0),
            ("untrusted", 0.33, 0.34),
        ] {
            assert!(exceeds(&found, &format!("{name}={below}")), "{name}");
            assert!(!exceeds(&found, &format!("{name}={above}")), "{name}");
            assert!(!falls_below(&found, &format!("{name}={below}")), "{name}");
        }
        assert!(!exceeds(&found, "p50=0") && !exceeds(&found, "block-share=0"));
        assert!(falls_below(&found, "block-share=0.1") && !falls_below(&found, "coverage=1"));
        assert!(falls_below(&found, "z1=0.67") && !falls_below(&found, "z3=1"));
        assert!(exceeds(&found, "psnr=10.8") && !exceeds(&found, "psnr=10.7"));
        assert!(falls_below(&found, "psnr=10.8") && !falls_below(&found, "psnr=10.7"));
    }

    #[test]
    fn a_dark_channel_fails_the_mean_ratio_like_a_bright_one() {
        let found = comparison(Rgb::new(1.25, 0.5, 1.25), Rgb::ONE);
        assert_eq!(found.metrics.mean_ratio_overall, 1.0);
        assert!(exceeds(&found, "mean-ratio=0.49"));
        assert!(!exceeds(&found, "mean-ratio=0.5"));
    }

    #[test]
    fn identical_pictures_pass_and_nan_fails_every_bound() {
        let same = comparison(Rgb::ONE, Rgb::ONE);
        for bound in ["mae=0", "smape=0", "p99.9=0", "flip=0", "block-max=0", "z-rms=0", "psnr=inf"] {
            assert!(!exceeds(&same, bound), "{bound}");
        }
        for bound in ["block-share=1", "z1=1", "coverage=1"] {
            assert!(!falls_below(&same, bound), "{bound}");
        }
        for (a, b) in [(Rgb::NAN, Rgb::NAN), (Rgb::NAN, Rgb::ONE), (Rgb::INFINITY, Rgb::INFINITY)] {
            let nan = comparison(a, b);
            assert_eq!(nan.metrics.non_finite_pixels, 1);
            for metric in MetricName::ALL {
                for limit in [f64::NEG_INFINITY, 0.0, 0.5, f64::INFINITY] {
                    let bound = Bound { metric, limit };
                    assert!(nan.exceeds(&bound).unwrap() && nan.falls_below(&bound).unwrap(), "{bound}");
                }
            }
        }
    }

    #[test]
    fn a_bound_on_what_was_not_measured_is_refused() {
        let (a, region) = (picture(Rgb::ONE), Region::of(&picture(Rgb::ONE)));
        let found = plain(&a, &a, &region);
        let refusal = |bound: &str| found.exceeds(&bound.parse().unwrap()).unwrap_err().to_string();
        let text = "there is no z-rms to bound; it needs the standard error of either picture (--stderr, \
                    --reference-stderr)";
        assert_eq!(refusal("z-rms=2"), text);
        assert!(refusal("coverage=0.9").contains("a picture of bounds (--bound)"));
    }

    #[test]
    fn the_worst_block_keeps_its_place_under_a_crop() {
        let b = Image::from_pixels(8, 6, vec![Rgb::ONE; 48]).unwrap();
        let mut a = b.clone();
        a.pixels_mut()[3 * 8 + 6] = Rgb::splat(3.0);
        a.pixels_mut()[0] = Rgb::splat(99.0);
        let region = Region::of(&b).with_crop(Crop { x: 3, y: 1, width: 5, height: 5 }).unwrap();
        let found = plain(&a, &b, &region);
        let worst = found.blocks.worst.unwrap();
        assert_eq!((worst.x, worst.y, worst.relative_difference), (5, 3, 0.5));
        assert_eq!((found.blocks.n_blocks, found.blocks.n_within), (9, 8));
        assert_eq!(found.metrics.max_pixel, (6, 3));
    }

    #[test]
    fn the_table_tells_what_was_measured() {
        let table = comparison(Rgb::ONE, Rgb::ONE).to_string();
        for start in ["mse  ", "p99.9", "flip  ", "blocks", "z-rms", "coverage", "untrusted"] {
            assert!(table.lines().any(|line| line.starts_with(start)), "{start}: {table}");
        }
        let (a, region) = (picture(Rgb::ONE), Region::of(&picture(Rgb::ONE)));
        let short = plain(&a, &a, &region).to_string();
        assert!(!short.contains("coverage") && !short.contains("z-rms") && !short.ends_with('\n'), "{short}");
    }

    #[test]
    fn json_keeps_the_names_of_the_sums_on_top() {
        let json = serde_json::to_value(comparison(Rgb::ONE, Rgb::splat(0.5))).unwrap();
        assert_eq!((&json["mse"], &json["percentiles"]["p99.9"]), (&0.25.into(), &0.5.into()));
        assert_eq!((&json["coverage"]["share"], &json["z"]["values"]), (&1.0.into(), &3.into()));
        assert_eq!(json["blocks"]["worst"]["relative_difference"], 1.0);
        assert!(json["flip"]["mean"].as_f64().unwrap() > 0.0);
    }
}
