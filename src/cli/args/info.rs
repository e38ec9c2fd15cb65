use std::path::PathBuf;

use clap::Args;

use super::{AccessArgs, Traversal};

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  caustica info data/cornell_b.toml
  caustica info data/course_water.toml --json")]
pub struct InfoArgs {
    /// The scene (TOML, or XML of Mitsuba 3)
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
