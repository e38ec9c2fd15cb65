use std::path::PathBuf;

use clap::Args;

use super::values::{count, size, threads};
use super::{AccessArgs, Traversal};
use crate::effects::PathClass;

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  caustica explain data/cornell_b.toml
  caustica explain data/course_water.toml --measure 8
  caustica explain data/course_water.toml --ablate --passes 4 --size 256x256
  caustica explain data/cornell_b.toml --transport direct --json

A render simulates what its scene calls for, and leaves out what provably brings nothing. The table says
what is on and off, and because of what in which line of which file; docs/effects.md tells the rules.
Seconds are predicted from two small passes; they depend on the machine and on what else it does.

Exit codes: 0 explained; 2 wrong input or arguments.")]
pub struct ExplainArgs {
    /// The scene (TOML, or XML of Mitsuba 3)
    pub scene: PathBuf,
    /// Kinds of light that are asked for, separated by commas
    #[arg(long, value_name = "KINDS", value_delimiter = ',', default_value = "direct,caustic,indirect")]
    pub transport: Vec<PathClass>,
    /// Passes to predict, and of each render of --ablate [default: the scene's]
    #[arg(long, allow_negative_numbers = true, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub passes: Option<u32>,
    /// Photons a pass, such as 100000 or 1e6 [default: the scene's]
    #[arg(long, allow_negative_numbers = true, value_name = "N", value_parser = count)]
    pub photons: Option<u64>,
    /// Render so many passes, too, and say what they took beside what was predicted for them
    #[arg(long, allow_negative_numbers = true, value_name = "PASSES", conflicts_with = "passes", value_parser = clap::value_parser!(u32).range(1..))]
    pub measure: Option<u32>,
    /// Render without each effect in turn: the seconds that it takes, and how much the picture differs without it
    #[arg(long)]
    pub ablate: bool,
    /// Width and height of the picture in pixels [default: the scene's]
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<(u32, u32)>,
    /// Who answers what rays hit
    #[arg(long, value_enum, default_value_t = Traversal::Embree)]
    pub traversal: Traversal,
    /// Threads [default: all]
    #[arg(long, allow_negative_numbers = true, value_name = "N", value_parser = threads)]
    pub threads: Option<usize>,
    #[command(flatten)]
    pub access: AccessArgs,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}
