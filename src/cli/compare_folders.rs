use std::io;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::args::CompareArgs;
use super::console::print;
use super::error::{CliError, Outcome};
use super::judgement::{Pictures, broken_bounds, region};
use crate::compare::{Comparison, MetricName, Region, false_colour, thumbnail};
use crate::film::Image;
use crate::math::Rgb;
use crate::output::{Display, check_writable, write_bytes};
use crate::regression::{Pair, Row, Shown, Verdict, page, pairs, table};

/// The widest picture of the page, in pixels.
const WIDEST: usize = 192;

/// Compares all pictures of two folders and writes one table of them; any that is not good decides the exit code.
pub fn run(args: &CompareArgs) -> Result<Outcome, CliError> {
    check_layers(args)?;
    let folder = args.output.clone().unwrap_or_else(|| "out/regression".into());
    let paths = ["csv", "json", "html"].map(|kind| folder.join("regression").with_extension(kind));
    paths.iter().try_for_each(|path| check_writable(path)).map_err(CliError::BadOutput)?;
    let rows: Vec<Row> = pairs(&args.image, &args.reference)?.par_iter().map(|p| row(args, p)).collect();
    let rows_as_json = serde_json::json!({ "folders": [args.image, args.reference], "pictures": rows });
    let texts = [table(&rows).to_csv(), format!("{rows_as_json:#}\n"), html(args, &rows)];
    for (path, text) in paths.iter().zip(&texts) {
        write_bytes(path, text)?;
    }
    print(if args.json { texts[1].clone() } else { table(&rows).to_text() })?;
    let bad = rows.iter().filter(|row| !row.verdict.is_good()).count();
    note!(
        "{} of {} pictures are good; {} shows the others",
        rows.len() - bad,
        rows.len(),
        paths[2].display()
    );
    Ok(if bad == 0 { Outcome::Done } else { Outcome::BoundExceeded })
}

/// A file of standard errors cannot be that of many pictures.
fn check_layers(args: &CompareArgs) -> Result<(), CliError> {
    let layers = [&args.stderr, &args.reference_stderr, &args.bound];
    match layers.into_iter().flatten().find(|path| layer_of(path).is_none()) {
        Some(path) => Err(CliError::NotALayer { path: path.clone() }),
        None => Ok(()),
    }
}

fn layer_of(path: &Path) -> Option<&str> {
    path.to_str()?.strip_prefix(':').filter(|layer| !layer.is_empty())
}

fn row(args: &CompareArgs, pair: &Pair) -> Row {
    let name = pair.name.clone();
    let only = |verdict| Row { name: name.clone(), verdict, comparison: None, shown: None };
    match (&pair.image, &pair.reference) {
        (None, _) => only(Verdict::NoImage),
        (_, None) => only(Verdict::NoReference),
        (Some(image), Some(reference)) => compared(args, &name, image, reference)
            .unwrap_or_else(|error| only(Verdict::Failed(error.to_string()))),
    }
}

fn compared(args: &CompareArgs, name: &str, image: &Path, reference: &Path) -> Result<Row, CliError> {
    let args = &of_pair(args, image, reference);
    let pictures = Pictures::read(args)?;
    let region = region(args, &pictures.reference)?;
    let comparison = Comparison::of(&pictures.inputs(args, &region))?;
    let verdict = Verdict::of(&comparison, broken_bounds(args, &comparison)?);
    let shown = (verdict != Verdict::Equal).then(|| shown(args, &pictures, &region)).transpose()?;
    Ok(Row { name: name.into(), verdict, comparison: Some(comparison), shown })
}

/// The arguments as if the pair alone were compared.
fn of_pair(args: &CompareArgs, image: &Path, reference: &Path) -> CompareArgs {
    let layer_in = |layer: &Option<PathBuf>, picture: &Path| {
        layer.as_deref().map(|layer| format!("{}{}", picture.display(), layer.display()).into())
    };
    CompareArgs {
        image: image.into(),
        reference: reference.into(),
        stderr: layer_in(&args.stderr, image),
        reference_stderr: layer_in(&args.reference_stderr, reference),
        bound: layer_in(&args.bound, image),
        ..args.clone()
    }
}

fn shown(args: &CompareArgs, pictures: &Pictures, region: &Region) -> Result<Shown, CliError> {
    let (image, reference) = (&pictures.image, &pictures.reference);
    let errors = false_colour(image, reference, region, args.error_scale)?;
    let pixels = errors.iter().map(|colour| Rgb::from(colour.map(f32::from)) / 255.0).collect();
    let (width, height) = (region.crop().width, region.crop().height);
    let errors = Image::from_pixels(width, height, pixels).unwrap_or_else(|| Image::new(1, 1));
    let plain = Display { gamma: 1.0, ..Display::default() };
    let address = |image: &Image, display: &Display| {
        thumbnail(image, WIDEST, display).map_err(|source: io::Error| CliError::Thumbnail { source })
    };
    Ok(Shown {
        image: address(image, &Display::default())?,
        reference: address(reference, &Display::default())?,
        errors: address(&errors, &plain)?,
    })
}

fn html(args: &CompareArgs, rows: &[Row]) -> String {
    let above = args.fail_above.iter().map(|bound| format!("{} at most {}", bound.metric, bound.limit));
    let below = args.fail_below.iter().map(|bound| format!("{} at least {}", bound.metric, bound.limit));
    let bounds: Vec<String> = above.chain(below).collect();
    let facts = vec![
        ("Pictures", args.image.display().to_string()),
        ("References", args.reference.display().to_string()),
        ("Bounds", if bounds.is_empty() { "none".into() } else { bounds.join(", ") }),
        ("Errors", format!("violet 0, yellow {} and above", args.error_scale)),
        ("Worst", worst(rows)),
    ];
    page("Pictures compared", facts, rows)
}

/// The picture that is farthest from its reference by the metric that renders aim at.
fn worst(rows: &[Row]) -> String {
    let error = |row: &Row| Some((row.comparison.as_ref()?.value(MetricName::RelMse)?, row.name.clone()));
    let worst = rows.iter().filter_map(error).max_by(|a, b| a.0.total_cmp(&b.0));
    worst.map_or_else(|| "none".into(), |(error, name)| format!("{name}, relmse {error:.4e}"))
}
