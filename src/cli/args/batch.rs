use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::values::{number, share, threads};
use crate::batch::{Axis, parse_bytes};

#[derive(Args, Debug)]
#[command(
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    after_help = "\
Examples:
  caustica batch data/*.toml --passes 64
  caustica batch data/pool.toml --set alpha=.5,.7 --set photons=1e5,1e6 --time 60 -o out/sweep
  caustica batch jobs.toml --jobs 4 --threads 2 --memory-limit 4G
  caustica batch status out/batch
  caustica batch resume out/batch
  caustica batch report out/batch

JOBS are job lists (TOML with [[job]], or JSON lines in a .jsonl), scenes, or patterns of scenes in quotes.
A job whose files and settings are as they were is skipped. A broken or crashing scene does not stop the others: what
became of each is in FOLDER/ledger.sqlite. Ctrl-C finishes the passes under way; the same command, or `caustica batch
resume FOLDER`, goes on. docs/batch.md tells more.

Exit codes: 0 all pictures are there; 1 some failed; 2 the list is wrong, or another batch writes into the folder;
130 interrupted."
)]
pub struct BatchArgs {
    #[command(subcommand)]
    pub command: Option<BatchCommand>,
    #[command(flatten)]
    pub run: RunBatchArgs,
}

#[derive(Debug, Subcommand)]
pub enum BatchCommand {
    /// Say how every job of a folder stands
    Status(StatusArgs),
    /// Go on with what is not done, or is done of other files than there are now
    Resume(ResumeArgs),
    /// Write FOLDER/batch.html: thumbnails, times, errors, failures
    Report(ReportArgs),
}

#[derive(Args, Debug)]
pub struct StatusArgs {
    /// The folder of the batch
    #[arg(value_name = "FOLDER", default_value = "out/batch")]
    pub folder: PathBuf,
    /// Print JSON, a line for each job
    #[arg(long)]
    pub json: bool,
}

#[derive(Args, Debug)]
pub struct ReportArgs {
    /// The folder of the batch
    #[arg(value_name = "FOLDER", default_value = "out/batch")]
    pub folder: PathBuf,
}

#[derive(Args, Debug)]
pub struct ResumeArgs {
    /// The folder of the batch
    #[arg(value_name = "FOLDER", default_value = "out/batch")]
    pub folder: PathBuf,
    #[command(flatten)]
    pub share: ShareArgs,
}

#[derive(Args, Debug)]
pub struct RunBatchArgs {
    /// Job lists, scenes, patterns of scenes
    #[arg(value_name = "JOBS", required = true)]
    pub lists: Vec<String>,
    /// The folder for pictures and ledger
    #[arg(short, long, value_name = "FOLDER", default_value = "out/batch")]
    pub output: PathBuf,
    /// Render every job once with each of these values of a flag of `caustica render`; several --set make all combinations
    #[arg(long = "set", value_name = "FLAG=VALUE,..", value_parser = Axis::parse)]
    pub sweep: Vec<Axis>,
    /// Render this job of the lists alone; may be given several times
    #[arg(long, value_name = "NAME")]
    pub only: Vec<String>,
    /// Photon passes of jobs that have no budget of their own
    #[arg(long, value_name = "N")]
    pub passes: Option<u32>,
    /// Seconds of such jobs
    #[arg(long, value_name = "SECONDS", value_parser = |s: &str| number(s, 0.0..=1e9))]
    pub time: Option<f64>,
    /// Relative error to stop at of such jobs, such as 2%
    #[arg(long, value_name = "E", value_parser = |s: &str| share(s, 1e-9..=1e3))]
    pub target_error: Option<f64>,
    /// How often a job is begun again whose process died; a broken scene is not
    #[arg(long, value_name = "R", default_value_t = 1, value_parser = clap::value_parser!(u32).range(0..=100))]
    pub retries: u32,
    /// Memory that the process of a job may hold, such as 2G
    #[arg(long, value_name = "BYTES", value_parser = parse_bytes)]
    pub memory_limit: Option<u64>,
    #[command(flatten)]
    pub share: ShareArgs,
}

/// How the machine is shared out.
#[derive(Args, Clone, Debug)]
pub struct ShareArgs {
    /// Jobs that render at once; `auto` tries what is fastest
    #[arg(long, value_name = "auto|N", default_value = "auto", value_parser = at_once)]
    pub jobs: AtOnce,
    /// Threads of each job [default: the cores shared out]
    #[arg(long, value_name = "T", value_parser = threads)]
    pub threads: Option<usize>,
    /// Print what happens as JSON, an object a line
    #[arg(long)]
    pub json: bool,
}

/// How many jobs render at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AtOnce {
    Auto,
    Number(usize),
}

fn at_once(text: &str) -> Result<AtOnce, String> {
    match text {
        "auto" => Ok(AtOnce::Auto),
        _ => threads(text).map(AtOnce::Number).map_err(|_| "allowed: auto, or 1 to 1024".to_owned()),
    }
}
