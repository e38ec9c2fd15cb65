use super::{CompareError, Estimate, Region};
use crate::film::Image;
use serde::Serialize;
use std::fmt;

/// How often a predicted bound of the error holds: of all channel values, each counted singly.
///
/// Values whose bound is NaN or infinite are not trusted and left out; a negative bound never holds. If a pixel
/// that counts is not finite in either picture, all numbers but the counts are NaN; the share is NaN too where nothing is
/// trusted.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Coverage {
    /// Share of the trusted values with `|a - b| ≤ bound`.
    pub share: f64,
    /// Share of all values that are not trusted.
    pub untrusted: f64,
    /// Number of trusted values.
    pub trusted_values: usize,
    /// Number of values that are not trusted.
    pub untrusted_values: usize,
    /// What the noise of the reference does to the share; `None` without its standard error.
    pub reference_noise: Option<ReferenceNoise>,
}

/// The noise of a reference beside the bounds that it is to judge.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReferenceNoise {
    /// RMS of the reference's standard error over the trusted values.
    pub stderr_rms: f64,
    /// RMS of the bounds over the trusted values.
    pub bound_rms: f64,
    /// Share of the trusted values with `|a - b| ≤ bound + se_b`.
    pub share_with_stderr: f64,
}

impl Coverage {
    /// How often `|image - reference|` stays within `bound`, a picture of one bound a channel value.
    ///
    /// # Errors
    /// When a picture differs in size from the region.
    pub fn of(
        bound: &Image,
        image: &Image,
        reference: Estimate,
        region: &Region,
    ) -> Result<Coverage, CompareError> {
        region.check(bound)?;
        region.check(image)?;
        reference.check_region(region)?;
        let mut counts = Counts::default();
        for pixel in region.pixels() {
            let stderr = reference.stderr.map_or([0.0; 3], |stderr| stderr.pixels()[pixel].to_array());
            let (a, b) = (image.pixels()[pixel], reference.mean.pixels()[pixel]);
            counts.void |= !(a.is_finite() && b.is_finite());
            let errors = (a.as_dvec3() - b.as_dvec3()).abs();
            for channel in 0..3 {
                counts.add(errors[channel], bound.pixels()[pixel][channel].into(), stderr[channel].into());
            }
        }
        Ok(counts.coverage(reference.stderr.is_some()))
    }
}

#[derive(Default)]
struct Counts {
    void: bool,
    trusted: usize,
    untrusted: usize,
    covered: usize,
    covered_with_stderr: usize,
    squared_bound: f64,
    squared_stderr: f64,
}

impl Counts {
    fn add(&mut self, error: f64, bound: f64, stderr: f64) {
        if !bound.is_finite() {
            self.untrusted += 1;
            return;
        }
        self.trusted += 1;
        self.covered += usize::from(error <= bound);
        self.covered_with_stderr += usize::from(error <= bound + stderr);
        self.squared_bound += bound * bound;
        self.squared_stderr += stderr * stderr;
    }

    fn coverage(&self, has_stderr: bool) -> Coverage {
        let of = |sum: f64, n: usize| if self.void { f64::NAN } else { sum / n as f64 };
        let reference_noise = has_stderr.then(|| ReferenceNoise {
            stderr_rms: of(self.squared_stderr, self.trusted).sqrt(),
            bound_rms: of(self.squared_bound, self.trusted).sqrt(),
            share_with_stderr: of(self.covered_with_stderr as f64, self.trusted),
        });
        Coverage {
            share: of(self.covered as f64, self.trusted),
            untrusted: of(self.untrusted as f64, self.trusted + self.untrusted),
            trusted_values: self.trusted,
            untrusted_values: self.untrusted,
            reference_noise,
        }
    }
}

impl fmt::Display for Coverage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "coverage    {:.6} of {} trusted values", self.share, self.trusted_values)?;
        write!(f, "untrusted   {:.6} ({} values)", self.untrusted, self.untrusted_values)?;
        let Some(noise) = &self.reference_noise else { return Ok(()) };
        let share = noise.share_with_stderr;
        write!(f, "\n  {share:.6} with bounds widened by one standard error of the reference; ")?;
        write!(f, "RMS of that {:.6e}, of the bounds {:.6e}", noise.stderr_rms, noise.bound_rms)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Rgb;

    fn row(pixels: &[[f32; 3]]) -> Image {
        Image::from_pixels(pixels.len(), 1, pixels.iter().map(|&pixel| Rgb::from(pixel)).collect()).unwrap()
    }

    fn coverage(bound: &Image, image: &Image, reference: Estimate) -> Coverage {
        Coverage::of(bound, image, reference, &Region::of(image)).unwrap()
    }

    #[test]
    fn channels_are_counted_singly_and_untrusted_ones_left_out() {
        let image = row(&[[1.5, 0.5, 1.0], [1.0, 4.0, 1.0]]);
        let reference = row(&[[1.0; 3]; 2]);
        let bound = row(&[[0.5, 0.25, 0.0], [f32::NAN, f32::INFINITY, -1.0]]);
        let found = coverage(&bound, &image, Estimate::exact(&reference));
        assert_eq!((found.share, found.untrusted), (0.5, 2.0 / 6.0));
        assert_eq!((found.trusted_values, found.untrusted_values), (4, 2));
        assert_eq!(found.reference_noise, None);
        assert!(!found.to_string().contains("standard error"));
    }

    #[test]
    fn the_references_noise_stands_beside_the_share() {
        let (image, reference) = (row(&[[1.5, 0.5, 1.75]]), row(&[[1.0; 3]]));
        let (bound, stderr) = (row(&[[0.5, 0.25, 0.25]]), row(&[[0.25; 3]]));
        let found = coverage(&bound, &image, Estimate { mean: &reference, stderr: Some(&stderr) });
        let noise = found.reference_noise.clone().unwrap();
        assert_eq!((found.share, noise.share_with_stderr, noise.stderr_rms), (1.0 / 3.0, 2.0 / 3.0, 0.25));
        assert_eq!(noise.bound_rms, 0.125f64.sqrt());
        assert!(found.to_string().contains("0.666667 with bounds widened"), "{found}");
    }

    #[test]
    fn a_pixel_that_is_not_finite_voids_it() {
        let (fine, bad, bound) = (row(&[[1.0; 3]]), row(&[[1.0, 1.0, f32::NAN]]), row(&[[f32::NAN; 3]]));
        for (a, b) in [(&bad, &fine), (&fine, &bad), (&bad, &bad)] {
            let found = coverage(&bound, a, Estimate::exact(b));
            assert!(found.share.is_nan() && found.untrusted.is_nan());
        }
        let nothing_trusted = coverage(&bound, &fine, Estimate::exact(&fine));
        assert!(nothing_trusted.share.is_nan() && nothing_trusted.untrusted == 1.0);
    }

    #[test]
    fn sizes_are_checked() {
        let (one, two) = (row(&[[1.0; 3]]), row(&[[1.0; 3]; 2]));
        assert!(Coverage::of(&two, &one, Estimate::exact(&one), &Region::of(&one)).is_err());
    }
}
