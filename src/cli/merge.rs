use std::fs;
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::args::MergeArgs;
use super::console::{print, print_json};
use super::error::{CliError, Outcome};
use super::part_error::PartError;
use super::partial::EXTENSION;
use super::pictures::PicturePath;
use crate::output::{Display, ExrLayer, LayerChannels, Metadata, Value, check_writable};
use crate::shard::{Merge, PassRange, Passes, Shard};

/// Merges shards into a picture, or into a bigger shard, or tells what is missing.
pub fn run(args: &MergeArgs) -> Result<Outcome, CliError> {
    let output = Output::check(args)?;
    let mut merge = Merge::default();
    for path in paths(&args.shards)? {
        merge.add(&path)?;
    }
    let files = merge.files().to_vec();
    let Some(shard) = merge.finish() else { return Ok(Outcome::Incomplete) };
    let all = args.passes.unwrap_or(PassRange { first: 0, end: shard.passes.end() });
    let gaps = shard.passes.gaps(all);
    check_inside(&shard.passes, all)?;
    let writes = gaps.count() == 0 || args.allow_gaps || matches!(output, Output::Shard(_));
    if writes {
        output.write(&shard, args)?;
    }
    let report = Report::new(&shard, &files, &gaps, args, writes);
    report.tell(args)?;
    Ok(if writes { Outcome::Done } else { Outcome::Incomplete })
}

/// What is written, found to be possible.
enum Output {
    Picture(PicturePath),
    Shard(PathBuf),
}

impl Output {
    fn check(args: &MergeArgs) -> Result<Output, CliError> {
        if args.output.extension().is_some_and(|extension| extension == EXTENSION) {
            check_writable(&args.output).map_err(CliError::BadOutput)?;
            return Ok(Output::Shard(args.output.clone()));
        }
        Ok(Output::Picture(PicturePath::new(&args.output)?.with_half(args.half)))
    }

    fn write(&self, shard: &Shard, args: &MergeArgs) -> Result<(), CliError> {
        let path = match self {
            Output::Shard(path) => return Ok(shard.save(path)?),
            Output::Picture(path) => path,
        };
        let error = shard.standard_error();
        let layer = ExrLayer { name: "stderr", channels: LayerChannels::Rgb, image: &error };
        path.write_layers(&shard.mean(), &[layer], &header(shard), &Display::from(&args.display))
    }
}

/// The facts of the picture, of which none tells how it was split.
fn header(shard: &Shard) -> Metadata {
    let header = shard.identity.header.clone();
    header
        .with("caustica:passes", Value::Integer(shard.passes.count().into()))
        .with("caustica:pass_ranges", Value::Text(shard.passes.to_string()))
}

/// Files as they are given, and those in folders by their names.
fn paths(given: &[PathBuf]) -> Result<Vec<PathBuf>, CliError> {
    let mut paths = Vec::new();
    for path in given {
        match path.is_dir() {
            true => paths.extend(shards_in(path)?),
            false => paths.push(path.clone()),
        }
    }
    Ok(paths)
}

fn shards_in(folder: &Path) -> Result<Vec<PathBuf>, CliError> {
    let failure = |source| PartError::Folder { path: folder.into(), source };
    let mut paths = Vec::new();
    for entry in fs::read_dir(folder).map_err(failure)? {
        let path = entry.map_err(failure)?.path();
        if path.extension().is_some_and(|extension| extension == EXTENSION) && path.is_file() {
            paths.push(path);
        }
    }
    paths.sort();
    if paths.is_empty() { Err(PartError::NoShards { path: folder.into() }.into()) } else { Ok(paths) }
}

fn check_inside(passes: &Passes, range: PassRange) -> Result<(), CliError> {
    let before = passes.common(&PassRange { first: 0, end: range.first }.into());
    let after = passes.common(&PassRange { first: range.end, end: u32::MAX }.into());
    let passes = before.with(&after);
    if passes.count() == 0 { Ok(()) } else { Err(PartError::Beyond { passes, range }.into()) }
}

/// What was merged, and what is missing.
#[derive(Serialize)]
struct Report<'a> {
    written: Option<&'a Path>,
    passes: u32,
    ranges: &'a [PassRange],
    missing: u32,
    gaps: &'a [PassRange],
    #[serde(skip_serializing_if = "Option::is_none")]
    array: Option<String>,
    photons: u64,
    setup_seconds: f64,
    pass_seconds: f64,
    not_finite_pixels: usize,
    shards: Vec<File<'a>>,
}

#[derive(Serialize)]
struct File<'a> {
    file: &'a Path,
    ranges: &'a [PassRange],
}

impl<'a> Report<'a> {
    fn new(
        shard: &'a Shard,
        files: &'a [(PathBuf, Passes)],
        gaps: &'a Passes,
        args: &'a MergeArgs,
        writes: bool,
    ) -> Report<'a> {
        let file = |(file, passes): &'a (PathBuf, Passes)| File { file, ranges: passes.ranges() };
        Report {
            written: writes.then_some(&args.output),
            passes: shard.passes.count(),
            ranges: shard.passes.ranges(),
            missing: gaps.count(),
            gaps: gaps.ranges(),
            array: args.shard_passes.filter(|_| gaps.count() > 0).map(|each| gaps.shards_of(each)),
            photons: shard.work.photons,
            setup_seconds: shard.work.setup_milliseconds as f64 / 1e3,
            pass_seconds: shard.work.pass_milliseconds as f64 / 1e3,
            not_finite_pixels: shard.sums.not_finite().len(),
            shards: files.iter().map(file).collect(),
        }
    }

    /// For people on standard error, so that on standard output there is but what programs read.
    fn tell(&self, args: &MergeArgs) -> Result<(), CliError> {
        let ranges =
            |ranges: &[PassRange]| ranges.iter().map(ToString::to_string).collect::<Vec<_>>().join(",");
        let gaps = ranges(self.gaps);
        if self.not_finite_pixels > 0 {
            note!(
                "warning: {}: {} pixels were not finite in some pass, which they leave out",
                args.output.display(),
                self.not_finite_pixels
            );
        }
        match self.written {
            Some(path) => {
                let path = path.display();
                note!("{path}: passes {} of {} shards", ranges(self.ranges), self.shards.len());
            }
            None => note!("no picture is written: {} passes are missing, {gaps}", self.missing),
        }
        if args.json {
            return print_json(self);
        }
        match &self.array {
            _ if self.missing == 0 => Ok(()),
            Some(array) => print(format_args!("--array={array}\n")),
            None => print(format_args!("{gaps}\n")),
        }
    }
}
