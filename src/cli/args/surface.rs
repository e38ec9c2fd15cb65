use std::path::PathBuf;

use clap::Args;

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  caustica surface data/surface.obj
  caustica surface out/coarse.obj --cells 64")]
pub struct SurfaceArgs {
    /// The mesh to write
    #[arg(value_name = "FILE.obj")]
    pub output: PathBuf,
    /// Cells along each side
    #[arg(long, allow_negative_numbers = true, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub cells: u32,
}
