use std::io::ErrorKind;
use std::path::PathBuf;
use std::process::ExitCode;

use thiserror::Error;

use super::part_error::PartError;
use crate::batch::BatchError;
use crate::bench::BenchError;
use crate::checkpoint::CheckpointError;
use crate::compare::CompareError;
use crate::doctor::StabilityError;
use crate::embree::EmbreeError;
use crate::farm::FarmError;
use crate::output::OutputError;
use crate::ppm::DependentPasses;
use crate::regression::PairsError;
use crate::scene::{SaveError, SceneError, TraversalError};
use crate::shard::ShardError;
use crate::study::StudyError;

/// How a command ended without an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    Done,
    BoundExceeded,
    /// What was examined has faults.
    Unsound,
    /// Some jobs of a batch have no picture.
    SomeFailed,
    /// What was to be examined cannot be read.
    NotLoaded,
    /// Passes are missing.
    Incomplete,
    Interrupted,
}

impl Outcome {
    pub fn exit_code(self) -> ExitCode {
        ExitCode::from(match self {
            Outcome::Done => 0,
            Outcome::BoundExceeded | Outcome::Unsound | Outcome::SomeFailed | Outcome::Incomplete => 1,
            Outcome::NotLoaded => 2,
            Outcome::Interrupted => 130,
        })
    }
}

/// Why a command could not do its work.
#[derive(Debug, Error)]
pub enum CliError {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Save(#[from] SaveError),
    #[error(transparent)]
    Embree(#[from] EmbreeError),
    #[error(transparent)]
    Traversal(#[from] TraversalError),
    #[error(transparent)]
    Compare(#[from] CompareError),
    #[error(transparent)]
    Pairs(#[from] PairsError),
    #[error("{path}: with --batch this is the same file for all pictures; name a layer that each has, such as :stderr", path = path.display())]
    NotALayer { path: PathBuf },
    /// Found before any work was done.
    #[error("{0}")]
    BadOutput(#[source] OutputError),
    #[error("{path}: a picture is written as EXR; name a file that ends in .exr", path = path.display())]
    NotExrName { path: PathBuf },
    #[error("{path}: an error picture is written as {kind}; name a file that ends in .{kind}", path = path.display())]
    ErrorPictureName { path: PathBuf, kind: &'static str },
    #[error(
        "a target of {target} is out of reach: with these settings radii do not shrink, so the error never falls below the blur of \
         the first discs, which no pass can tell from light; give --alpha below 1 and a --radius-policy that shrinks"
    )]
    TargetOutOfReach { target: String },
    #[error("{0}")]
    BadImage(#[source] OutputError),
    /// Found when the work was done.
    #[error(transparent)]
    Write(#[from] OutputError),
    #[error("cannot write the statistics {path}: {source}", path = path.display())]
    Statistics { path: PathBuf, source: std::io::Error },
    #[error("cannot write to standard output: {source}; whoever reads it must not close it before the end")]
    StandardOutput { source: std::io::Error },
    #[error("{path}:{line}: this is not the record of a pass, so the file is none of a render; name another file for the statistics", path = path.display())]
    ForeignStatistics { path: PathBuf, line: usize },
    #[error("{path}: there is a checkpoint already; give --resume to go on from it, or remove it to start anew", path = path.display())]
    CheckpointExists { path: PathBuf },
    #[error("{path}: there is another file already, where a picture of the scene is to be copied to; remove it, or give the scene another name", path = path.display())]
    OtherPicture { path: PathBuf },
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    #[error(transparent)]
    Farm(#[from] FarmError),
    #[error("the tasks would be refused for what stands behind `--`: {message}")]
    TaskFlags { message: String },
    #[error("a picture in shards has one scene; give one, or --each for a task for each job")]
    OneScene,
    #[error("`caustica batch` would refuse the lists and what stands behind `--`: {message}")]
    BatchFlags { message: String },
    #[error("there is no job `{name}` in the lists; `caustica batch` without --only tells their names")]
    NoSuchJob { name: String },
    #[error("--sbatch {flags}: a quote is not closed; write it as a shell would read it")]
    Quotes { flags: String },
    #[error("cannot find out where the program is and what paths mean: {source}")]
    Program { source: std::io::Error },
    #[error(transparent)]
    Shard(#[from] ShardError),
    #[error(transparent)]
    Dependent(#[from] DependentPasses),
    #[error(transparent)]
    Part(#[from] PartError),
    #[error(transparent)]
    Stability(#[from] StabilityError),
    #[error(transparent)]
    Bench(#[from] BenchError),
    #[error(transparent)]
    Study(#[from] StudyError),
    #[error(transparent)]
    Batch(#[from] BatchError),
    #[error(
        "cannot limit the memory to {limit}: {source}; ask for less than the limit that the process has (`ulimit -d`)"
    )]
    MemoryLimit { limit: String, source: std::io::Error },
    #[cfg(feature = "oidn")]
    #[error(transparent)]
    Denoise(#[from] crate::denoise::DenoiseError),
    #[error("{what}: {source}; ask for {remedy}")]
    Memory { what: String, source: std::io::Error, remedy: &'static str },
    #[error("cannot encode a picture of the page: {source}")]
    Thumbnail { source: std::io::Error },
    #[error("cannot start threads: {reason}; ask for fewer with --threads")]
    Threads { reason: String },
}

impl CliError {
    pub fn exit_code(&self) -> ExitCode {
        ExitCode::from(match self {
            CliError::Scene(_)
            | CliError::Save(_)
            | CliError::Embree(_)
            | CliError::Traversal(_)
            | CliError::Compare(_)
            | CliError::Pairs(_)
            | CliError::NotALayer { .. }
            | CliError::BadOutput(_)
            | CliError::NotExrName { .. }
            | CliError::ErrorPictureName { .. }
            | CliError::Stability(StabilityError::Traversal(_))
            | CliError::TargetOutOfReach { .. }
            | CliError::BadImage(_)
            | CliError::ForeignStatistics { .. }
            | CliError::CheckpointExists { .. }
            | CliError::OtherPicture { .. }
            | CliError::Checkpoint(_)
            | CliError::TaskFlags { .. }
            | CliError::OneScene
            | CliError::BatchFlags { .. }
            | CliError::NoSuchJob { .. }
            | CliError::Quotes { .. }
            | CliError::Farm(_)
            | CliError::Shard(_)
            | CliError::Dependent(_)
            | CliError::Part(_)
            | CliError::Memory { .. }
            | CliError::MemoryLimit { .. }
            | CliError::Study(
                StudyError::Compare(_) | StudyError::Line { .. } | StudyError::NotFinite { .. },
            ) => 2,
            CliError::Batch(error) => code_of_batch(error),
            CliError::Bench(error) => code_of_bench(error),
            // As if SIGPIPE had ended the process.
            CliError::StandardOutput { source } if source.kind() == ErrorKind::BrokenPipe => 141,
            #[cfg(feature = "oidn")]
            CliError::Denoise(_) => 1,
            CliError::Write(_)
            | CliError::Thumbnail { .. }
            | CliError::Program { .. }
            | CliError::StandardOutput { .. }
            | CliError::Statistics { .. }
            | CliError::Stability(StabilityError::Threads { .. })
            | CliError::Study(_)
            | CliError::Threads { .. } => 1,
        })
    }
}

fn code_of_batch(error: &BatchError) -> u8 {
    match error {
        BatchError::Ledger { .. }
        | BatchError::File { .. }
        | BatchError::Start { .. }
        | BatchError::Output(_) => 1,
        _ => 2,
    }
}

fn code_of_bench(error: &BenchError) -> u8 {
    match error {
        BenchError::TooFewHitPoints { .. }
        | BenchError::NoPhotons { .. }
        | BenchError::NoCaustic { .. }
        | BenchError::NoOverlaps { .. } => 2,
        _ => 1,
    }
}
