use std::path::PathBuf;

use clap::Args;

use super::DisplayArgs;
use crate::shard::PassRange;

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  caustica merge out/shards -o out/water.exr --passes 0..1000
  caustica merge out/water.0-100.shard out/water.100-200.shard -o out/water.exr
  caustica merge out/shards -o out/water.exr --passes 0..1000 --shard-passes 100
  caustica merge out/rack-7 -o out/rack-7.shard

The picture has the same bytes however its passes are split, in whatever order shards are given. Where passes are
missing, none is written: they are printed, with --shard-passes as a list for batch systems such as --array=3-4,7, and the
exit code is 1. docs/shards.md tells more.")]
pub struct MergeArgs {
    /// Shards, and folders of files that end in .shard
    #[arg(required = true, value_name = "FILE|FOLDER")]
    pub shards: Vec<PathBuf>,
    /// The picture, EXR with the layer stderr, and a PNG of the same name beside it; or a bigger shard
    #[arg(short, long, value_name = "FILE.exr|FILE.shard")]
    pub output: PathBuf,
    /// The passes that the picture is to have [default: all from 0 to the last that is there]
    #[arg(long, value_name = "A..B")]
    pub passes: Option<PassRange>,
    /// Print missing passes as the numbers of shards of K passes each, of which number 0 begins with pass 0
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u32).range(1..))]
    pub shard_passes: Option<u32>,
    /// Write the picture of what is there, even if passes are missing
    #[arg(long)]
    pub allow_gaps: bool,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub display: DisplayArgs,
    /// Write the picture in 16 bits a sample: larger values than 65504 become that, and are counted
    #[arg(long)]
    pub half: bool,
}
