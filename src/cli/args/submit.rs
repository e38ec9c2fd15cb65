use std::path::PathBuf;

use clap::Args;

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  caustica submit --slurm data/course_water.toml --passes 1000 --shard-passes 10 -o out/water.exr
  caustica submit --slurm data/course_water.toml --passes 1000 --shard-passes 10 -o out/water.exr --cpus 16 \\
    --sbatch '--partition=render --time=1:00:00' -- --size 1024x1024 --seed 7
  caustica submit --dry-run data/course_water.toml --passes 1000 --shard-passes 10 -o out/water.exr
  parallel < out/water.farm/tasks.txt && sh out/water.farm/merge.sh
  caustica submit --slurm --each jobs.toml -o out/night --cpus 8 -- --passes 64

Given again, the same command submits what is missing alone. `caustica status FOLDER` tells how far it is;
docs/cluster.md has the whole of it, and recipes for other engines than Slurm.")]
pub struct SubmitArgs {
    /// The scene of one picture; with --each what `caustica batch` takes: job lists, scenes, patterns
    #[arg(required = true, value_name = "SCENE|JOBS")]
    pub work: Vec<String>,
    /// The picture that the merge writes; with --each the folder of all
    #[arg(short, long, value_name = "FILE.exr|FOLDER")]
    pub output: PathBuf,
    /// Submit a task for each job of the lists, in the place of shards of one picture
    #[arg(long, conflicts_with_all = ["passes", "shard_passes", "folder"])]
    pub each: bool,
    /// Photon passes of the picture
    #[arg(long, value_name = "N", required_unless_present = "each", value_parser = clap::value_parser!(u32).range(1..))]
    pub passes: Option<u32>,
    /// Passes of a shard, which is the work of a task
    #[arg(long, value_name = "K", required_unless_present = "each", value_parser = clap::value_parser!(u32).range(1..))]
    pub shard_passes: Option<u32>,
    /// Submit to Slurm: an array of tasks, and a merge that waits for it
    #[arg(long, required_unless_present = "dry_run")]
    pub slurm: bool,
    /// Write the folder with its list of commands and scripts, and submit nothing
    #[arg(long, conflicts_with = "slurm")]
    pub dry_run: bool,
    /// Where shards, scripts and logs go; every machine must see it [default: the picture's name, ending in .farm]
    #[arg(long, value_name = "FOLDER")]
    pub folder: Option<PathBuf>,
    /// Threads of a task
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub cpus: u32,
    /// Seconds before the end of a task's time at which it keeps what it has and goes back into the queue
    #[arg(long, value_name = "SECONDS", default_value_t = 60, value_parser = clap::value_parser!(u32).range(1..=65_535))]
    pub grace: u32,
    /// Further flags of sbatch, such as '--partition=render --time=1:00:00'
    #[arg(long, value_name = "FLAGS", allow_hyphen_values = true)]
    pub sbatch: Option<String>,
    /// Flags of `caustica render`, behind --; with --each those of `caustica batch`
    #[arg(last = true, value_name = "FLAGS")]
    pub flags: Vec<String>,
}
