use std::path::PathBuf;

use clap::Args;

use super::values::{number, size};
use super::{AccessArgs, Traversal};

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  caustica doctor
  caustica doctor data/course_water.toml
  caustica doctor data/cornell_b.toml --radius 1e-4 --json
  caustica doctor data/cornell_b.toml --strict && caustica render data/cornell_b.toml

Exit codes: 0 sound, notes included; 1 faults, with --strict warnings too; 2 the scene does not load.")]
pub struct DoctorArgs {
    /// The scene to examine (TOML, or XML of Mitsuba 3); without one, built-in scenes tell whether the program is sound on this machine
    pub scene: Option<PathBuf>,
    /// Initial gather radius in scene units [default: the scene's, or two pixels wide]
    #[arg(long, requires = "scene", allow_negative_numbers = true, value_name = "R", value_parser = |s: &str| number(s, 1e-30..=1e30))]
    pub radius: Option<f64>,
    /// Width and height of the picture in pixels [default: the scene's]
    #[arg(long, requires = "scene", value_name = "WxH", value_parser = size)]
    pub size: Option<(u32, u32)>,
    /// Who answers what rays hit; without a scene, Embree and custom are both examined
    #[arg(long, value_enum, default_value_t = Traversal::Embree)]
    pub traversal: Traversal,
    #[command(flatten)]
    pub access: AccessArgs,
    /// Exit with code 1 for warnings too
    #[arg(long)]
    pub strict: bool,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}
