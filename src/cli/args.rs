mod doctor;
mod explain;

use std::ops::RangeBounds;
use std::path::PathBuf;
use std::str::FromStr;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{ArgGroup, Args, Parser, Subcommand, ValueEnum};

pub use doctor::DoctorArgs;
pub use explain::ExplainArgs;

use crate::bsdf::DiffuseSampling;
use crate::compare::{Bound, Crop};
use crate::effects::{self, PathClass};
use crate::ppm;
use crate::reference;
use crate::scene::{self, Access};
use crate::study::Axis;

/// Progressive photon mapping on Embree 4: caustics from small lights, in mirrors, through glass, under water.
#[derive(Debug, Parser)]
#[command(name = "caustica", version, max_term_width = 100, after_help = EXAMPLES)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Command,
}

const EXAMPLES: &str = "\
Examples:
  caustica surface data/surface.obj
  caustica render data/course_water.toml -o out/water.exr --passes 64
  caustica render data/cornell_b.toml --time 60 --json out/passes.jsonl
  caustica reference data/course_diffuse.toml --spp 256 -o out/reference.exr
  caustica compare out/course_diffuse.exr out/reference.exr --fail-above relmse=0.01
  caustica study data/course_water.toml --make-reference

Exit codes: 0 done; 1 a comparison exceeded its bound, the doctor found faults, or a file could not be
written; 2 wrong input or arguments, nothing was written; 130 interrupted, the picture so far was written;
141 standard output was closed.";

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a scene by progressive photon mapping
    Render(RenderArgs),
    /// Render a scene by path or light tracing: the unbiased picture that photon mapping is checked against
    Reference(ReferenceArgs),
    /// Compare two pictures in HDR
    Compare(CompareArgs),
    /// Say what a scene holds and how it would be rendered
    Info(InfoArgs),
    /// Examine a scene, or the program itself, and say what is odd and what a render will therefore do
    Doctor(DoctorArgs),
    /// Say which effects a scene calls for, because of which of its lines, and what they cost
    Explain(ExplainArgs),
    /// Write the water surface of the course's scene as OBJ
    Surface(SurfaceArgs),
    /// Measure the photon pass against bare ray tracing, or trees of spheres or triangles against their rivals
    Bench(BenchArgs),
    /// Measure what accuracy costs: error against seconds, for settings and methods in turn
    Study(StudyArgs),
}

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  caustica render data/course_diffuse.toml --passes 10 --every-pass out/passes
  caustica render data/course_balls.toml --sampling uniform --seed 7 -o out/uniform.exr
  caustica render data/cornell_b.toml --time 120 --photons 1e6 --json -
  caustica render data/course_water.toml --target-error 5% --confidence 90% --layers
  caustica render data/cornell_b.toml --transport caustic -o out/caustic.exr
  caustica render data/course_water.toml --passes 100000 --checkpoint out/water.checkpoint --resume

Ctrl-C finishes the pass under way and writes the picture, and the checkpoint where one is kept;
a second one stops at once. The last command may be killed and given again at any time.
docs/long-runs.md tells more.")]
pub struct RenderArgs {
    /// The scene (TOML)
    pub scene: PathBuf,
    /// The picture: EXR, and a PNG of the same name beside it [default: out/SCENE.exr]
    #[arg(short, long, value_name = "FILE.exr")]
    pub output: Option<PathBuf>,
    /// Photon passes; 0 renders direct light alone [default: the scene's; unlimited with --time or --target-error]
    #[arg(long, allow_negative_numbers = true, value_name = "N")]
    pub passes: Option<u32>,
    /// Photons a pass, such as 100000 or 1e6 [default: the scene's]
    #[arg(long, allow_negative_numbers = true, value_name = "N", value_parser = count)]
    pub photons: Option<u64>,
    /// Photons of a pass that are aimed at mirrors and glass: `auto`, by a trial, or so many; 0 for none
    #[arg(long, allow_negative_numbers = true, value_name = "auto|N", default_value = "auto", value_parser = aiming)]
    pub caustic_photons: ppm::Aiming,
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
    /// How gather radii shrink from pass to pass
    #[arg(long, value_enum, default_value_t = RadiusPolicy::HitPoint)]
    pub radius_policy: RadiusPolicy,
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
    /// Write the checkpoint after the pass in which so many seconds are over since the last [default: 60]
    #[arg(long, allow_negative_numbers = true, value_name = "SECONDS", value_parser = |s: &str| number(s, 0.0..=1e9))]
    pub checkpoint_every: Option<f64>,
    /// Go on from the checkpoint, if there is one: the same bytes as without the stop. --passes and --time count from the beginning
    #[arg(long)]
    pub resume: bool,
    #[command(flatten)]
    pub run: RunArgs,
}

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  caustica reference data/cornell_a.toml --spp 1024 -o out/cornell_a_reference.exr
  caustica reference data/cornell_b.toml --method light --spp 256 -o out/cornell_b_light.exr

Path tracing misses point lights through glass and water, light tracing what is seen in mirrors or through
glass and water; elsewhere both tend to the same picture, and light tracing has far less noise in caustics.
Beside FILE.exr and FILE.png it writes FILE_stderr.exr: the standard error of every pixel and channel.")]
pub struct ReferenceArgs {
    /// The scene (TOML)
    pub scene: PathBuf,
    /// Where paths start
    #[arg(long, value_enum, default_value_t = Method::Path)]
    pub method: Method,
    /// Samples a pixel; one of light tracing is as many light paths as there are pixels
    #[arg(long, allow_negative_numbers = true, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: u32,
    /// The picture [default: out/SCENE_reference.exr, with --method light out/SCENE_reference_light.exr]
    #[arg(short, long, value_name = "FILE.exr")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub run: RunArgs,
}

/// What every method of rendering takes.
#[derive(Args, Debug)]
pub struct RunArgs {
    /// Who answers what rays hit
    #[arg(long, value_enum, default_value_t = Traversal::Embree)]
    pub traversal: Traversal,
    /// Width and height of the picture in pixels [default: the scene's]
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<(u32, u32)>,
    /// Key of all random numbers
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub seed: u64,
    /// Threads; the picture does not depend on them [default: all]
    #[arg(long, allow_negative_numbers = true, value_name = "N", value_parser = threads)]
    pub threads: Option<usize>,
    /// Stop after the pass or sample in which so many seconds are over
    #[arg(long, allow_negative_numbers = true, value_name = "SECONDS", value_parser = |s: &str| number(s, 0.0..=1e9))]
    pub time: Option<f64>,
    #[command(flatten)]
    pub display: DisplayArgs,
    /// Leave the measured seconds out of the EXR's header, so that equal pictures are equal files
    #[arg(long)]
    pub reproducible: bool,
    /// Write the picture in 16 bits a sample: larger values than 65504 become that, and are counted
    #[arg(long)]
    pub half: bool,
    #[command(flatten)]
    pub access: AccessArgs,
}

/// What a scene may read and ask for.
#[derive(Args, Clone, Copy, Debug)]
pub struct AccessArgs {
    /// Trust the scene with nothing: refuse files outside its folder, and pictures, counts and meshes beyond limits
    /// (docs/scenes.md lists them)
    #[arg(long)]
    pub sandbox: bool,
}

impl From<AccessArgs> for Access {
    fn from(args: AccessArgs) -> Access {
        if args.sandbox { Access::sandbox() } else { Access::any() }
    }
}

#[derive(Args, Debug)]
pub struct DisplayArgs {
    /// Exposure of PNGs in stops
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, allow_negative_numbers = true)]
    pub exposure: f32,
    /// Gamma of PNGs
    #[arg(long, value_name = "G", default_value_t = 2.2, value_parser = |s: &str| number(s, 0.01..=100.0).map(|g| g as f32))]
    pub gamma: f32,
}

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  caustica compare out/a.exr out/b.exr --fail-above relmse=0.01 --fail-above mean-ratio=0.005
  caustica compare out/a.exr out/b.exr --crop 100,80,64,64 --mask out/mask.png --json
  caustica compare out/a.exr out/b.exr --error-exr out/error.exr --error-png out/error.png
  caustica compare a.exr b.exr --stderr a.exr:stderr --reference-stderr b_stderr.exr
  caustica compare a.exr b.exr --bound a.exr:bound --fail-below coverage=0.85

METRIC: mae, mse, rmse, relmse, smape, psnr, max, p50, p90, p95, p99, p99.9, mean-ratio, flip,
block-max, block-share; with standard errors z-rms, z1, z2, z3; with bounds coverage, untrusted.
Pictures may be named FILE.exr:LAYER, which reads LAYER.R, LAYER.G and LAYER.B, or LAYER.Y.
docs/compare.md explains the metrics.")]
pub struct CompareArgs {
    /// The picture to judge
    pub image: PathBuf,
    /// The picture to judge it against
    pub reference: PathBuf,
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

#[derive(Args, Debug)]
pub struct InfoArgs {
    /// The scene (TOML)
    pub scene: PathBuf,
    #[command(flatten)]
    pub access: AccessArgs,
    /// Who answers what rays hit
    #[arg(long, value_enum, default_value_t = Traversal::Embree)]
    pub traversal: Traversal,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

#[derive(Args, Debug)]
pub struct SurfaceArgs {
    /// The mesh to write
    #[arg(value_name = "FILE.obj")]
    pub output: PathBuf,
    /// Cells along each side
    #[arg(long, allow_negative_numbers = true, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub cells: u32,
}

#[derive(Args, Debug)]
#[command(group(ArgGroup::new("question").required(true).args(["pass", "gather", "rays", "leaks", "numerics", "aim"])), after_help = "\
Examples:
  caustica bench --pass data/course_diffuse.toml --json -
  caustica bench --pass data/cornell_b.toml --radius 10 --samples 1 --photons 1e5 --html out/pass.html
  caustica bench --gather --points 1e5,1e6 --radii 0.1,1,5 --csv out/gather.csv --html out/gather.html
  caustica bench --gather --scene data/cornell_b.toml --points 1e5,1e6 --radii 0.1,1 --photons 1e5
  caustica bench --rays --triangles 36,1e6 --html out/rays.html
  caustica bench --leaks 1e7
  caustica bench --numerics
  caustica bench --aim data/glass_bead.toml --passes 20

Times depend on what else the machine does: look at the smallest and largest beside the medians.")]
pub struct BenchArgs {
    /// Measure the photon pass of this scene (TOML) against tracing its rays and nothing else
    #[arg(long, value_name = "SCENE")]
    pub pass: Option<PathBuf>,
    /// Measure the sphere tree against Embree's point query, a hash grid and a k-d tree, on the walls of a box
    #[arg(long)]
    pub gather: bool,
    /// Gather the photons of a pass through this scene (TOML) at its hit points, rather than on walls
    #[arg(long, conflicts_with_all = ["pass", "rays", "leaks", "numerics", "aim"], value_name = "SCENE")]
    pub scene: Option<PathBuf>,
    /// Measure rays of real renders: Embree in all its ways, and the program's own tree
    #[arg(long)]
    pub rays: bool,
    /// Count how many of N rays, aimed at their edges and vertices, slip out of closed meshes
    #[arg(long, value_name = "N", value_parser = count)]
    pub leaks: Option<u64>,
    /// Measure what precision buys, in renders of PASSES passes
    #[arg(long, value_name = "PASSES", num_args = 0..=1, default_missing_value = "20000", value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    pub numerics: Option<u32>,
    /// Measure what photons aimed at mirrors and glass gain in this scene (TOML)
    #[arg(long, value_name = "SCENE")]
    pub aim: Option<PathBuf>,
    /// Passes of every run with --aim
    #[arg(long, conflicts_with_all = ["pass", "gather", "rays", "leaks", "numerics"], allow_negative_numbers = true, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub passes: u32,
    /// Gather radius of the pass in scene units [default: the scene's, or two pixels wide]
    #[arg(long, conflicts_with_all = ["gather", "rays", "leaks", "numerics", "aim"], allow_negative_numbers = true, value_name = "R", value_parser = |s: &str| number(s, 1e-30..=1e30))]
    pub radius: Option<f64>,
    /// Eye samples a pixel of the pass, 1 to 4096 [default: the scene's]
    #[arg(long, conflicts_with_all = ["gather", "rays", "leaks", "numerics", "aim"], allow_negative_numbers = true, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub samples: Option<u32>,
    /// Trace the eye paths and build the tree anew in every pass
    #[arg(long, conflicts_with_all = ["gather", "rays", "leaks", "numerics", "aim"])]
    pub retrace: bool,
    /// Keep caustics and indirect light apart in the pass
    #[arg(long, conflicts_with_all = ["gather", "rays", "leaks", "numerics", "aim"])]
    pub apart: bool,
    /// Numbers of spheres to gather among [default: 1e4,1e5,1e6,4e6]
    #[arg(long, conflicts_with_all = ["pass", "rays", "leaks", "numerics", "aim"], value_name = "N,..", value_delimiter = ',', value_parser = points)]
    pub points: Vec<u64>,
    /// Their radii in percent of the longest side of box or scene [default: 0.05,0.1,0.4,1, and 5 without --scene]
    #[arg(long, conflicts_with_all = ["pass", "rays", "leaks", "numerics", "aim"], value_name = "PERCENT,..", value_delimiter = ',', value_parser = |s: &str| number(s, 1e-3..=100.0))]
    pub radii: Vec<f64>,
    /// Choose the radius for each number of spheres so that a photon lies in about so many
    #[arg(long, conflicts_with_all = ["radii", "scene", "pass", "rays", "leaks", "numerics", "aim"], value_name = "K", value_parser = |s: &str| number(s, 1e-3..=1e6))]
    pub overlaps: Option<f64>,
    /// Also measure sphere trees built in other ways: costs by volume, smaller leaves
    #[arg(long, conflicts_with_all = ["pass", "rays", "leaks", "numerics", "aim"])]
    pub variants: bool,
    /// Numbers of triangles, at least, to trace rays among [default: 36,2e4,131072,1e6]
    #[arg(long, conflicts_with_all = ["pass", "gather", "leaks", "numerics", "aim"], value_name = "N,..", value_delimiter = ',', value_parser = triangles)]
    pub triangles: Vec<u64>,
    /// Photons, and of rays about as many eye paths [default: the scene's, or 100000]
    #[arg(long, allow_negative_numbers = true, value_name = "N", value_parser = count)]
    pub photons: Option<u64>,
    /// Rounds to measure
    #[arg(long, value_name = "K", default_value_t = 7, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub repetitions: u32,
    /// Threads [default: all]
    #[arg(long, allow_negative_numbers = true, value_name = "N", value_parser = threads)]
    pub threads: Option<usize>,
    /// Write everything as JSON; - is standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write the table as CSV; - is standard output
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Write a page with plots and table, for a browser
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
}

#[derive(Args, Debug)]
#[command(group(ArgGroup::new("standard").required(true).args(["reference", "make_reference", "list"])), after_help = "\
Examples:
  caustica study data/course_water.toml --make-reference
  caustica study data/course_diffuse.toml --make-reference --axes alpha,radius --quick -o out/study_diffuse
  caustica study data/cornell_a.toml --reference out/cornell_a_reference.exr --budget 1800

It writes study.html, study.json and study.csv, and notes every finished run in measurements.jsonl: the same command
goes on where an interrupted one was, and repeats nothing. Ctrl-C reports what is there.")]
pub struct StudyArgs {
    /// The scene (TOML)
    pub scene: PathBuf,
    #[command(flatten)]
    pub access: AccessArgs,
    /// Hold the pictures against this one (EXR), which also gives their size
    #[arg(long, value_name = "FILE.exr")]
    pub reference: Option<PathBuf>,
    /// Hold them against the mean of many renders; it is kept, and made anew only if scene or settings change
    #[arg(long)]
    pub make_reference: bool,
    /// Say what would be measured, and by which commands
    #[arg(long)]
    pub list: bool,
    /// Measure along these axes alone, beside the baseline [default: all]
    #[arg(long, value_name = "AXIS,..", value_delimiter = ',', value_parser = axis())]
    pub axes: Vec<Axis>,
    /// A minute for small pictures
    #[arg(long, conflicts_with = "full")]
    pub quick: bool,
    /// An hour for pictures as large as the scene asks for
    #[arg(long)]
    pub full: bool,
    /// Seconds for the whole study, shared by the reference and all runs [default: 360; 60 quick, 3600 full]
    #[arg(long, allow_negative_numbers = true, value_name = "SECONDS", value_parser = |s: &str| number(s, 0.1..=1e7))]
    pub budget: Option<f64>,
    /// Width and height of the pictures in pixels [default: at most 192; 96 quick, the scene's full]
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<(u32, u32)>,
    /// Renders of each configuration, from other seeds
    #[arg(long, value_name = "K", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub repetitions: u32,
    /// Key of all random numbers
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub seed: u64,
    /// Threads [default: all]
    #[arg(long, allow_negative_numbers = true, value_name = "N", value_parser = threads)]
    pub threads: Option<usize>,
    /// The folder for all that it writes
    #[arg(short, long, value_name = "DIR", default_value = "out/study")]
    pub output: PathBuf,
}

/// What a study takes upon itself.
pub struct Effort {
    /// Larger pictures are made smaller.
    pub longest_side: Option<u32>,
    pub budget: f64,
    /// Renders that the reference is the mean of, at most.
    pub reference_renders: u32,
    pub reference_passes: u32,
}

impl StudyArgs {
    pub fn effort(&self) -> Effort {
        let (longest_side, budget, reference_renders, reference_passes) = match (self.quick, self.full) {
            (true, _) => (Some(96), 60.0, 8, 16),
            (_, true) => (None, 3600.0, 64, 128),
            _ => (Some(192), 360.0, 32, 32),
        };
        Effort { longest_side, budget, reference_renders, reference_passes }
    }

    pub fn budget(&self) -> f64 {
        self.budget.unwrap_or(self.effort().budget)
    }
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
pub enum Method {
    /// At the camera: path tracing with shadow rays
    Path,
    /// At the lights: every diffuse bounce is connected to the camera
    Light,
}

impl From<Method> for reference::Method {
    fn from(method: Method) -> reference::Method {
        match method {
            Method::Path => reference::Method::Path,
            Method::Light => reference::Method::Light,
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Traversal {
    /// Embree 4
    Embree,
    /// Embree 4 that may let a ray slip through between adjacent triangles
    EmbreeFast,
    /// The program's own tree of triangles and spheres
    Custom,
}

impl From<Traversal> for scene::Traversal {
    fn from(traversal: Traversal) -> scene::Traversal {
        match traversal {
            Traversal::Embree => scene::Traversal::Embree,
            Traversal::EmbreeFast => scene::Traversal::EmbreeFast,
            Traversal::Custom => scene::Traversal::Custom,
        }
    }
}

fn number(text: &str, range: impl RangeBounds<f64> + std::fmt::Debug) -> Result<f64, String> {
    let value = f64::from_str(text).map_err(|_| format!("`{text}` is not a number"))?;
    if range.contains(&value) { Ok(value) } else { Err(format!("{value} is outside {range:?}")) }
}

/// A share, which may be written in percent.
fn share(text: &str, range: impl RangeBounds<f64> + std::fmt::Debug) -> Result<f64, String> {
    match text.strip_suffix('%') {
        Some(percent) => {
            let value = number(percent.trim(), ..)? / 100.0;
            if range.contains(&value) { Ok(value) } else { Err(format!("{value} is outside {range:?}")) }
        }
        None => number(text, range),
    }
}

/// A positive whole number, which may be written with an exponent.
fn count(text: &str) -> Result<u64, String> {
    if let Ok(value) = text.parse::<u64>() {
        return if value > 0 { Ok(value) } else { Err("at least 1 is needed".into()) };
    }
    let value = number(text, 1.0..=1e15)?;
    if value.fract() == 0.0 { Ok(value as u64) } else { Err(format!("`{text}` is not a whole number")) }
}

/// `auto` or a count, which may be 0.
fn aiming(text: &str) -> Result<ppm::Aiming, String> {
    match text {
        "auto" => Ok(ppm::Aiming::Auto),
        "0" => Ok(ppm::Aiming::Photons(0)),
        _ => count(text).map(ppm::Aiming::Photons).map_err(|reason| format!("{reason}; or write `auto`")),
    }
}

/// So many spheres that a 32-bit number still counts the cells of a grid that each of them touches.
fn points(text: &str) -> Result<u64, String> {
    count_up_to(100_000_000, text)
}

/// So many triangles that seven trees over them fit into the memory of most machines.
fn triangles(text: &str) -> Result<u64, String> {
    count_up_to(20_000_000, text)
}

fn count_up_to(most: u64, text: &str) -> Result<u64, String> {
    match count(text)? {
        n if n <= most => Ok(n),
        n => Err(format!("{n} is more than {most}")),
    }
}

/// Two sides from 1 to 16384 pixels, such as 640x480.
fn size(text: &str) -> Result<(u32, u32), String> {
    let side = |text: &str| text.parse().ok().filter(|side| (1..=16384).contains(side));
    let sides = text.split_once('x').and_then(|(width, height)| Some((side(width)?, side(height)?)));
    sides.ok_or_else(|| "write WIDTHxHEIGHT, such as 640x480, with sides from 1 to 16384".into())
}

fn axis() -> impl TypedValueParser<Value = Axis> {
    PossibleValuesParser::new(Axis::ALL.map(Axis::name)).try_map(|name| Axis::named(&name).ok_or("no axis"))
}

fn threads(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(n @ 1..=1024) => Ok(n),
        _ => Err("allowed: 1 to 1024".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn argument_table_is_consistent() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn counts_may_have_exponents_but_no_fraction() {
        assert_eq!(count("100000"), Ok(100_000));
        assert_eq!(count("1e6"), Ok(1_000_000));
        for wrong in ["0", "-1", "1.5", "nan", "inf", "many", "1e300"] {
            assert!(count(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn photons_are_aimed_by_a_trial_or_by_number() {
        assert_eq!(aiming("auto"), Ok(ppm::Aiming::Auto));
        assert_eq!(aiming("0"), Ok(ppm::Aiming::Photons(0)));
        assert_eq!(aiming("1e3"), Ok(ppm::Aiming::Photons(1000)));
        assert_eq!(aiming("some").unwrap_err(), "`some` is not a number; or write `auto`");
    }

    #[test]
    fn shares_may_be_percentages() {
        assert_eq!(share("2%", 0.0..=1.0), Ok(0.02));
        assert_eq!(share("0.5 %", 0.0..=1.0), Ok(0.005));
        assert_eq!(share("0.02", 0.0..=1.0), Ok(0.02));
        for wrong in ["200%", "%", "two%", "nan%", "-1%", "2"] {
            assert!(share(wrong, 0.0..=1.0).is_err(), "{wrong}");
        }
    }

    #[test]
    fn numbers_outside_their_range_are_refused() {
        assert_eq!(number("0.5", 0.0..=1.0), Ok(0.5));
        for wrong in ["1.5", "nan", "x", "-inf"] {
            assert!(number(wrong, 0.0..=1.0).is_err(), "{wrong}");
        }
    }
}
