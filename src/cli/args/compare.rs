use std::path::PathBuf;

use clap::Args;

use super::values::number;
use crate::compare::{Bound, Crop};

#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Examples:
  caustica compare out/a.exr out/b.exr --fail-above relmse=0.01 --fail-above mean-ratio=0.005
  caustica compare out/a.exr out/b.exr --crop 100,80,64,64 --mask out/mask.png --json
  caustica compare out/a.exr out/b.exr --error-exr out/error.exr --error-png out/error.png
  caustica compare a.exr b.exr --stderr a.exr:stderr --reference-stderr b_stderr.exr
  caustica compare a.exr b.exr --bound a.exr:bound --fail-below coverage=0.85
  caustica compare --batch out/today/ out/golden/ --fail-above relmse=0.001 -o out/regression

METRIC: mae, mse, rmse, relmse, smape, psnr, max, p50, p90, p95, p99, p99.9, mean-ratio, flip,
block-max, block-share; with standard errors z-rms, z1, z2, z3; with bounds coverage, untrusted.
Pictures may be named FILE.exr:LAYER, which reads LAYER.R, LAYER.G and LAYER.B, or the channel LAYER.
With --batch, --stderr, --reference-stderr and --bound are named :LAYER, that of each picture.
docs/compare.md explains the metrics.")]
pub struct CompareArgs {
    /// The picture to judge; with --batch, the folder of them
    pub image: PathBuf,
    /// The picture to judge it against; with --batch, the folder of them
    pub reference: PathBuf,
    /// Compare all EXR files of two folders, matched by name; exit with code 1 if a bound does not hold for any, or if one is
    /// missing or cannot be compared
    #[arg(long, conflicts_with_all = ["error_exr", "error_png"])]
    pub batch: bool,
    /// Where --batch writes regression.csv, regression.json and regression.html with pictures of the errors [default: out/regression]
    #[arg(short, long, value_name = "FOLDER", requires = "batch")]
    pub output: Option<PathBuf>,
    /// Exit with code 1 if a metric is larger than this, psnr if smaller; may be given several times
    #[arg(long, value_name = "METRIC=VALUE")]
    pub fail_above: Vec<Bound>,
    /// Exit with code 1 if a metric is smaller than this; may be given several times
    #[arg(long, value_name = "METRIC=VALUE")]
    pub fail_below: Vec<Bound>,
    /// Compare this rectangle alone
    #[arg(long, value_name = "X,Y,WIDTH,HEIGHT")]
    pub crop: Option<Crop>,
    /// Leave out the pixels that are 0 in all channels of this picture, EXR or PNG
    #[arg(long, value_name = "FILE")]
    pub mask: Option<PathBuf>,
    /// The standard error of the picture
    #[arg(long, value_name = "FILE")]
    pub stderr: Option<PathBuf>,
    /// The standard error of the reference
    #[arg(long, value_name = "FILE")]
    pub reference_stderr: Option<PathBuf>,
    /// Predicted bounds of the error, to see how often they hold; NaN or infinite where they are not to be trusted
    #[arg(long, value_name = "FILE")]
    pub bound: Option<PathBuf>,
    /// Side in pixels of the blocks whose means are compared
    #[arg(long, allow_negative_numbers = true, value_name = "N", default_value_t = 32, value_parser = clap::value_parser!(u32).range(1..=65_536))]
    pub block: u32,
    /// Relative difference of a block's means that is allowed beside 3 standard errors
    #[arg(long, allow_negative_numbers = true, value_name = "D", default_value_t = 0.02, value_parser = |s: &str| number(s, 0.0..=1e9))]
    pub block_tolerance: f64,
    /// Write the signed difference of every channel
    #[arg(long, value_name = "FILE.exr")]
    pub error_exr: Option<PathBuf>,
    /// Write the relative error in false colours, violet (0) to yellow (the scale)
    #[arg(long, value_name = "FILE.png")]
    pub error_png: Option<PathBuf>,
    /// Relative error that is yellow
    #[arg(long, allow_negative_numbers = true, value_name = "E", default_value_t = 1.0, value_parser = |s: &str| number(s, 1e-9..=1e9))]
    pub error_scale: f64,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}
