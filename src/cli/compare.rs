use std::path::Path;

use super::args::CompareArgs;
use super::compare_folders;
use super::console::print;
use super::error::{CliError, Outcome};
use crate::compare::{
    BlockCriterion, Bound, CompareError, Comparison, Estimate, Inputs, Region, false_colour,
    signed_difference,
};
use crate::film::Image;
use crate::output::{
    Metadata, Value, check_writable, read_exr_named, read_png, write_exr, write_png_samples,
};

/// How many standard errors the means of blocks may differ by.
const BLOCK_SIGMAS: f64 = 3.0;

/// Prints how two pictures differ, or those of two folders; the bounds decide the exit code.
pub fn run(args: &CompareArgs) -> Result<Outcome, CliError> {
    if args.batch { compare_folders::run(args) } else { compare_two(args) }
}

fn compare_two(args: &CompareArgs) -> Result<Outcome, CliError> {
    check_outputs(args)?;
    let pictures = Pictures::read(args)?;
    let region = region(args, &pictures.reference)?;
    let comparison = Comparison::of(&pictures.inputs(args, &region))?;
    let broken = broken_bounds(args, &comparison)?;
    write_error_pictures(args, &pictures, &region)?;
    if args.json {
        print(format_args!("{}\n", serde_json::json!(comparison)))?;
    } else {
        print(format_args!("{comparison}\n"))?;
    }
    for bound in &broken {
        note!("beyond the bound: {bound}");
    }
    Ok(if broken.is_empty() { Outcome::Done } else { Outcome::BoundExceeded })
}

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

/// Finds out, before any work is done, whether the error pictures can be written.
fn check_outputs(args: &CompareArgs) -> Result<(), CliError> {
    for (path, kind) in [(&args.error_exr, "exr"), (&args.error_png, "png")] {
        let Some(path) = path else { continue };
        check_writable(path).map_err(CliError::BadOutput)?;
        if path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case(kind)) {
            return Err(CliError::ErrorPictureName { path: path.into(), kind });
        }
    }
    Ok(())
}

fn write_error_pictures(args: &CompareArgs, pictures: &Pictures, region: &Region) -> Result<(), CliError> {
    let (image, reference) = (&pictures.image, &pictures.reference);
    if let Some(path) = &args.error_exr {
        let name = |path: &Path| Value::Text(path.display().to_string());
        let metadata = Metadata::new()
            .with("caustica:image", name(&args.image))
            .with("caustica:reference", name(&args.reference));
        write_exr(path, &signed_difference(image, reference, region)?, &metadata)?;
    }
    if let Some(path) = &args.error_png {
        let colours = false_colour(image, reference, region, args.error_scale)?;
        write_png_samples(path, region.crop().width, region.crop().height, &colours)?;
        let scale = args.error_scale;
        note!("{}: relative error, violet 0 to yellow {scale} and above", path.display());
    }
    Ok(())
}
