use std::io;
use std::path::PathBuf;

use thiserror::Error;

use crate::shard::{PassRange, Passes};

/// Why some passes of a picture cannot be rendered, or shards not be merged.
#[derive(Debug, Error)]
pub enum PartError {
    #[error(
        "--partial renders the passes A..B of a picture; give them as --passes A..B, such as --passes 0..100"
    )]
    NoRange,
    #[error("--passes {range} are some of the passes of a picture, which make a shard; give --partial, or --passes {} for all up to there", .range.end)]
    RangeAlone { range: PassRange },
    #[error("--partial does not go with {flag}: {reason}")]
    NotInPart { flag: &'static str, reason: &'static str },
    #[error("{path}: a shard is a file that ends in .shard; name another one", path = path.display())]
    NotShardName { path: PathBuf },
    #[error(
        "{path}: there is a shard of another picture already:\n  {}\nname another file, or remove it",
        .differences.join("\n  "), path = path.display()
    )]
    OtherShard { path: PathBuf, differences: Vec<String> },
    #[error("{path}: there is a shard already with the passes {passes}, which are not the beginning of {range}; name another file, or remove it", path = path.display())]
    OtherPasses { path: PathBuf, passes: Passes, range: PassRange },
    #[error("{path}: there is no file in it that ends in .shard; name another folder, or render some", path = path.display())]
    NoShards { path: PathBuf },
    #[error("{path}: the folder cannot be read: {source}", path = path.display())]
    Folder { path: PathBuf, source: io::Error },
    #[error(
        "passes {passes} are in the shards, but not among {range}, which the picture is to have; leave those shards out, or give other --passes"
    )]
    Beyond { passes: Passes, range: PassRange },
}
