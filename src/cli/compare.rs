use std::path::Path;

use super::args::CompareArgs;
use super::compare_folders;
use super::console::{print, print_json};
use super::error::{CliError, Outcome};
use super::judgement::{Pictures, broken_bounds, region};
use crate::compare::{Comparison, Region, false_colour, signed_difference};
use crate::output::{Metadata, Value, check_writable, write_exr, write_png_samples};

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
        print_json(&comparison)?;
    } else {
        print(format_args!("{comparison}\n"))?;
    }
    for bound in &broken {
        note!("beyond the bound: {bound}");
    }
    Ok(if broken.is_empty() { Outcome::Done } else { Outcome::BoundExceeded })
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
