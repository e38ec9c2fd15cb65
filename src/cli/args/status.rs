use std::path::PathBuf;

use clap::Args;

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  caustica status out/water.farm
  caustica status out/water.farm --json

Exit code 0 if the picture is there, or those of all jobs, 1 if not yet.")]
pub struct FarmStatusArgs {
    /// The folder that `caustica submit` wrote
    pub folder: PathBuf,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}
