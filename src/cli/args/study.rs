use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{ArgGroup, Args};

use super::AccessArgs;
use super::values::{number, size, threads};
use crate::study::Axis;

#[derive(Args, Debug)]
#[command(group(ArgGroup::new("standard").required(true).args(["reference", "make_reference", "list"])), after_help = "\
Examples:
  caustica study data/course_water.toml --make-reference
  caustica study data/course_diffuse.toml --make-reference --axes alpha,radius --quick -o out/study_diffuse
  caustica study data/cornell_a.toml --reference out/cornell_a_reference.exr --budget 1800

It writes study.html, study.json and study.csv, and notes every finished run in measurements.jsonl: the same command
goes on where an interrupted one was, and repeats nothing. Ctrl-C reports what is there.")]
pub struct StudyArgs {
    /// The scene (TOML, or XML of Mitsuba 3)
    pub scene: PathBuf,
    #[command(flatten)]
    pub access: AccessArgs,
    /// Hold the pictures against this one (EXR), which also gives their size
    #[arg(long, value_name = "FILE.exr")]
    pub reference: Option<PathBuf>,
    /// The standard error of its pixels (EXR), as `caustica reference` writes it: it is no bias of the pictures
    #[arg(long, value_name = "FILE.exr", conflicts_with = "make_reference")]
    pub reference_stderr: Option<PathBuf>,
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

fn axis() -> impl TypedValueParser<Value = Axis> {
    PossibleValuesParser::new(Axis::ALL.map(Axis::name)).try_map(|name| Axis::named(&name).ok_or("no axis"))
}
