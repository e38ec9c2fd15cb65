use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::RunArgs;
use super::values::{PassesArg, aiming, count, number, passes, share};
use crate::bsdf::DiffuseSampling;
use crate::effects::{self, PathClass};
use crate::ppm;

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  caustica render data/course_diffuse.toml --passes 10 --every-pass out/passes
  caustica render data/course_balls.toml --sampling uniform --seed 7 -o out/uniform.exr
  caustica render data/cornell_b.toml --time 120 --photons 1e6 --json -
  caustica render data/course_water.toml --target-error 5% --confidence 90% --layers
  caustica render data/cornell_b.toml --transport caustic -o out/caustic.exr
  caustica render data/course_water.toml --passes 100000 --checkpoint out/water.checkpoint --resume
  caustica render data/course_water.toml --passes 100..200 --partial -o out/water.100-200.shard

Ctrl-C finishes the pass under way and writes the picture, and the checkpoint where one is kept;
a second one stops at once. So do TERM and USR1. The last two commands may be killed and given again at
any time. docs/long-runs.md and docs/shards.md tell more.

A flag --some-name may be given as the variable CAUSTICA_SOME_NAME, too. Flags win over variables, those over the
scene file; docs/configuration.md tells more.")]
pub struct RenderArgs {
    /// The scene (TOML, or XML of Mitsuba 3)
    pub scene: PathBuf,
    /// The picture: EXR, and a PNG of the same name beside it [default: out/SCENE.exr]; with --partial the shard [default:
    /// out/SCENE.A-B.shard]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Photon passes; 0 renders direct light alone [default: the scene's; unlimited with --time or --target-error]; with --partial
    /// those from A, counted from 0, to the one before B
    #[arg(long, allow_negative_numbers = true, value_name = "N|A..B", value_parser = passes)]
    pub passes: Option<PassesArg>,
    /// Render the passes A..B alone, into a shard, which `caustica merge` makes a picture of with others; given again, it goes on
    #[arg(long)]
    pub partial: bool,
    /// Photons a pass, such as 100000 or 1e6 [default: the scene's]
    #[arg(long, allow_negative_numbers = true, value_name = "N", value_parser = count)]
    pub photons: Option<u64>,
    /// Photons of a pass that are aimed at mirrors and glass: `auto`, by a trial, or so many; 0 for none
    #[arg(long, allow_negative_numbers = true, value_name = "auto|N", default_value = "auto", value_parser = aiming)]
    pub caustic_photons: ppm::Aiming,
    /// Whether photons start where light gets to what is seen, learned from photons that are followed before the first pass
    #[arg(long, value_enum, default_value_t = Guiding::Auto)]
    pub guiding: Guiding,
    /// Share of each pass's photons that is kept as radii shrink, in (0, 1] [default: the scene's]
    #[arg(long, allow_negative_numbers = true, value_name = "A", value_parser = |s: &str| number(s, f64::MIN_POSITIVE..=1.0))]
    pub alpha: Option<f64>,
    /// Initial gather radius in scene units [default: the scene's, or two pixels wide]
    #[arg(long, allow_negative_numbers = true, value_name = "R", value_parser = |s: &str| number(s, 1e-30..=1e30))]
    pub radius: Option<f64>,
    /// Eye samples a pixel, 1 to 4096 [default: the scene's]
    #[arg(long, allow_negative_numbers = true, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub samples: Option<u32>,
    /// Longest chain of mirrors and interfaces that an eye path follows, 0 to 1024 [default: the scene's]
    #[arg(long, allow_negative_numbers = true, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=1024))]
    pub depth: Option<u32>,
    /// How gather radii shrink from pass to pass [default: hit-point; shared with --partial]
    #[arg(long, value_enum)]
    pub radius_policy: Option<RadiusPolicy>,
    /// How precisely hit points keep their statistics
    #[arg(long, value_enum, default_value_t = Precision::Double)]
    pub precision: Precision,
    /// How photons bounce off diffuse surfaces
    #[arg(long, value_enum, default_value_t = Sampling::Cosine)]
    pub sampling: Sampling,
    /// Stop when the relative error (√relMSE, see `caustica compare`) is at most E, such as 2% or 0.02
    #[arg(long, allow_negative_numbers = true, value_name = "E", value_parser = |s: &str| share(s, 1e-9..=1e3), conflicts_with = "no_error_estimates")]
    pub target_error: Option<f64>,
    /// How sure to be of errors: of the target, and of the bounds of --layers
    #[arg(long, allow_negative_numbers = true, value_name = "C", default_value = "90%", value_parser = |s: &str| share(s, 0.01..=0.999))]
    pub confidence: f64,
    /// Add layers to the EXR: stderr, bias, bound, photons, radius
    #[arg(long, conflicts_with = "no_error_estimates")]
    pub layers: bool,
    /// Add layers to the EXR of what is seen first, for denoisers and compositing: albedo, N (normal), Z (depth)
    #[arg(long)]
    pub features: bool,
    /// Write a denoised picture, too: FILE_denoised.exr and its PNG, to look at and not to measure
    #[cfg(feature = "oidn")]
    #[arg(long)]
    pub denoise: bool,
    /// Kinds of light to simulate, separated by commas; direct light holds the lamps that are seen
    #[arg(long, value_name = "KINDS", value_delimiter = ',', default_value = "direct,caustic,indirect")]
    pub transport: Vec<PathClass>,
    /// Keep caustics and indirect light apart, each with radii and statistics of its own, and add direct, caustic and indirect as
    /// layers to the EXR, which add up to the picture
    #[arg(long)]
    pub apart: bool,
    /// Simulate what was asked for even where it provably brings no light: to check the plan, which `caustica explain` shows
    #[arg(long)]
    pub no_plan: bool,
    /// Key of the eye paths; renders with equal ones have the same hit points [default: --seed]
    #[arg(long, value_name = "S")]
    pub eye_seed: Option<u64>,
    /// Whether eye paths stay: fixed ones are traced once, retraced ones in every pass, as lenses and pixel filters need
    #[arg(long, value_enum, default_value_t = EyePaths::Auto)]
    pub eye_paths: EyePaths,
    /// Keep no statistics for estimates of the error
    #[arg(long)]
    pub no_error_estimates: bool,
    /// Write the picture of each pass into this folder, as EXR and PNG
    #[arg(long, value_name = "DIR")]
    pub every_pass: Option<PathBuf>,
    /// Write the picture of direct light alone, as EXR and PNG
    #[arg(long, value_name = "FILE.exr")]
    pub direct: Option<PathBuf>,
    /// Write statistics, one JSON object a pass and line; - is standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Keep a checkpoint in this file, and the one before it in FILE.previous [default with --checkpoint-every or --resume:
    /// beside the picture, as .checkpoint]
    #[arg(long, value_name = "FILE")]
    pub checkpoint: Option<PathBuf>,
    /// Write the checkpoint, or the shard, after the pass in which so many seconds are over since the last [default: 60]
    #[arg(long, allow_negative_numbers = true, value_name = "SECONDS", value_parser = |s: &str| number(s, 0.0..=1e9))]
    pub checkpoint_every: Option<f64>,
    /// Go on from the checkpoint, if there is one: the same bytes as without the stop. --passes and --time count from the beginning
    #[arg(long)]
    pub resume: bool,
    #[command(flatten)]
    pub run: RunArgs,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum RadiusPolicy {
    /// Each hit point's by its own photons
    HitPoint,
    /// All by one schedule
    Shared,
    /// Each hit point's, where its light is found to be uneven
    Tested,
    /// Not at all: noise falls, blur stays
    Fixed,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Precision {
    /// f64
    Double,
    /// f32: half the memory, to see what it costs; tested discs stay in f64
    Single,
}

impl From<Precision> for ppm::Precision {
    fn from(precision: Precision) -> ppm::Precision {
        match precision {
            Precision::Double => ppm::Precision::Double,
            Precision::Single => ppm::Precision::Single,
        }
    }
}

impl From<RadiusPolicy> for ppm::RadiusPolicy {
    fn from(policy: RadiusPolicy) -> ppm::RadiusPolicy {
        match policy {
            RadiusPolicy::HitPoint => ppm::RadiusPolicy::HitPoint,
            RadiusPolicy::Shared => ppm::RadiusPolicy::Shared,
            RadiusPolicy::Tested => ppm::RadiusPolicy::Tested,
            RadiusPolicy::Fixed => ppm::RadiusPolicy::Fixed,
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum EyePaths {
    /// Retraced where the camera has a lens or the film a filter
    Auto,
    /// Progressive photon mapping: the picture tends to what a few paths of a pixel see
    Fixed,
    /// Stochastic progressive photon mapping: pixels keep the statistics
    Retraced,
}

impl From<EyePaths> for Option<effects::EyePaths> {
    fn from(eye_paths: EyePaths) -> Option<effects::EyePaths> {
        match eye_paths {
            EyePaths::Auto => None,
            EyePaths::Fixed => Some(effects::EyePaths::Fixed),
            EyePaths::Retraced => Some(effects::EyePaths::Retraced),
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Sampling {
    /// Density cos θ / π: the cosine cancels
    Cosine,
    /// Uniform over the hemisphere, by rejection
    Uniform,
}

impl From<Sampling> for DiffuseSampling {
    fn from(sampling: Sampling) -> DiffuseSampling {
        match sampling {
            Sampling::Cosine => DiffuseSampling::Cosine,
            Sampling::Uniform => DiffuseSampling::Uniform,
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Guiding {
    /// Where light hardly reaches what is seen, by a trial
    Auto,
    /// Never: they start in proportion to the emitted flux
    Off,
    /// Always, as well as the trial can
    On,
}

impl From<Guiding> for ppm::Guiding {
    fn from(guiding: Guiding) -> ppm::Guiding {
        match guiding {
            Guiding::Auto => ppm::Guiding::Auto,
            Guiding::Off => ppm::Guiding::Off,
            Guiding::On => ppm::Guiding::On,
        }
    }
}
