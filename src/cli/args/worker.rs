use clap::Args;

use super::values::threads;
use crate::batch::parse_bytes;

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  caustica worker --threads 1 < orders.jsonl

Orders are lines of JSON: {\"prepare\": {\"arguments\": [\"render\", \"scene.toml\", ..]}}, \"go\", \"stop\".
The end of standard input ends the process, whatever it is at.")]
pub struct WorkerArgs {
    /// Threads of every render [default: all]
    #[arg(long, value_name = "N", value_parser = threads)]
    pub threads: Option<usize>,
    /// Bytes that the process may hold
    #[arg(long, value_name = "BYTES", value_parser = parse_bytes)]
    pub memory_limit: Option<u64>,
    /// Keep meshes and the tree of a scene for the next, which may share them
    #[arg(long)]
    pub keep_geometry: bool,
}
