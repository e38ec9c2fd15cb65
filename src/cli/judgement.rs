//! What a comparison reads, what of it counts, and which bounds it breaks.

use std::path::Path;

use super::args::CompareArgs;
use super::error::CliError;
use crate::compare::{BlockCriterion, Bound, CompareError, Comparison, Estimate, Inputs, Region};
use crate::film::Image;
use crate::output::{read_exr_named, read_png};

/// How many standard errors the means of blocks may differ by.
const BLOCK_SIGMAS: f64 = 3.0;

/// What a comparison reads.
pub struct Pictures {
    pub image: Image,
    pub reference: Image,
    stderr: Option<Image>,
    reference_stderr: Option<Image>,
    bound: Option<Image>,
}

impl Pictures {
    pub fn read(args: &CompareArgs) -> Result<Pictures, CliError> {
        let read = |name: &Path| read_exr_named(name).map_err(CliError::BadImage);
        let read_if_given = |name: &Option<_>| name.as_deref().map(read).transpose();
        Ok(Pictures {
            image: read(&args.image)?,
            reference: read(&args.reference)?,
            stderr: read_if_given(&args.stderr)?,
            reference_stderr: read_if_given(&args.reference_stderr)?,
            bound: read_if_given(&args.bound)?,
        })
    }

    pub fn inputs<'a>(&'a self, args: &CompareArgs, region: &'a Region) -> Inputs<'a> {
        Inputs {
            image: Estimate { mean: &self.image, stderr: self.stderr.as_ref() },
            reference: Estimate { mean: &self.reference, stderr: self.reference_stderr.as_ref() },
            bound: self.bound.as_ref(),
            region,
            blocks: BlockCriterion {
                block: args.block as usize,
                ..BlockCriterion::new(args.block_tolerance, BLOCK_SIGMAS)
            },
        }
    }
}

/// What counts of a picture.
pub fn region(args: &CompareArgs, reference: &Image) -> Result<Region, CliError> {
    let mut region = Region::of(reference);
    if let Some(crop) = args.crop {
        region = region.with_crop(crop)?;
    }
    if let Some(path) = &args.mask {
        let is_png = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png"));
        let mask = if is_png { read_png(path) } else { read_exr_named(path) };
        region = region.with_mask(&mask.map_err(CliError::BadImage)?)?;
    }
    Ok(region)
}

/// The bounds that do not hold, each as it is to be read.
pub fn broken_bounds(args: &CompareArgs, comparison: &Comparison) -> Result<Vec<String>, CompareError> {
    let found = |bound: &Bound| comparison.value(bound.metric).unwrap_or(f64::NAN);
    let mut broken = Vec::new();
    for bound in &args.fail_above {
        if comparison.exceeds(bound)? {
            broken.push(format!("{bound} with {}", found(bound)));
        }
    }
    for bound in &args.fail_below {
        if comparison.falls_below(bound)? {
            broken.push(format!("at least {bound} with {}", found(bound)));
        }
    }
    Ok(broken)
}
