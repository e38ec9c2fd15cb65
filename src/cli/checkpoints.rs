use std::path::PathBuf;
use std::time::Instant;

use super::args::RenderArgs;
use super::error::CliError;
use super::error_watch::ErrorWatch;
use super::pictures::default_output;
use crate::checkpoint::{Checkpoint, CheckpointError, CheckpointFile, Facts, Loaded, Origin, RunState};
use crate::output::OutputError;
use crate::ppm::{Render, Settings};
use crate::scene::SceneDesc;

/// Seconds between checkpoints unless the user says otherwise.
pub const DEFAULT_SECONDS: f64 = 60.0;

/// The checkpoints of a render under way.
pub struct Checkpoints {
    file: CheckpointFile,
    facts: Facts,
    every: f64,
    saved: Instant,
    /// Passes in the checkpoint on disk.
    saved_passes: Option<u32>,
}

impl Checkpoints {
    /// `None` where the user wants none. No file is there, unless it is to be resumed.
    pub fn open(
        args: &RenderArgs,
        desc: &SceneDesc,
        settings: &Settings,
    ) -> Result<Option<Checkpoints>, CliError> {
        if args.checkpoint.is_none() && args.checkpoint_every.is_none() && !args.resume {
            return Ok(None);
        }
        let file = CheckpointFile::at(&path(args, desc)).map_err(CliError::BadOutput)?;
        if let Some(path) = file.existing().filter(|_| !args.resume) {
            return Err(CliError::CheckpointExists { path: path.into() });
        }
        let facts = Facts::of(desc, settings, args.run.traversal.into())?;
        let every = args.checkpoint_every.unwrap_or(DEFAULT_SECONDS);
        Ok(Some(Checkpoints { file, facts, every, saved: Instant::now(), saved_passes: None }))
    }

    /// What to go on from; says so.
    pub fn load(&mut self) -> Result<Option<Checkpoint<'static>>, CliError> {
        let Some(Loaded { checkpoint, origin }) = self.file.load(&self.facts)? else {
            note!("{}: no checkpoint yet; starting anew", self.file.path().display());
            return Ok(None);
        };
        let (path, previous) = (self.file.path().display(), self.file.previous().display());
        let passes = checkpoint.render.passes();
        let from = match origin {
            Origin::Latest => path.to_string(),
            Origin::PreviousOfMissing => previous.to_string(),
            Origin::PreviousOfDamaged => {
                note!("warning: {path} is damaged; the checkpoint before it is used");
                previous.to_string()
            }
        };
        note!("going on from {from}: {passes} passes in {:.1} s", checkpoint.run.seconds);
        self.saved_passes = (origin == Origin::Latest).then_some(passes);
        Ok(Some(checkpoint))
    }

    /// A state that fits by name may still not fit: the error names the file.
    pub fn restore(&self, render: &mut Render, checkpoint: Checkpoint) -> Result<(), CliError> {
        let path = self.file.path().to_path_buf();
        Ok(render.restore(checkpoint.render).map_err(|source| CheckpointError::Foreign { path, source })?)
    }

    pub fn is_due(&self) -> bool {
        self.saved.elapsed().as_secs_f64() >= self.every
    }

    /// Writes a checkpoint, if there are passes that are in none.
    pub fn save(&mut self, render: &Render, errors: &ErrorWatch, seconds: f64) -> Result<(), OutputError> {
        self.saved = Instant::now();
        if self.saved_passes == Some(render.passes()) {
            return Ok(());
        }
        let run = RunState { seconds, errors: errors.history() };
        let facts = std::mem::take(&mut self.facts);
        let checkpoint = Checkpoint { facts, run, render: render.state() };
        let saved = self.file.save(&checkpoint);
        self.facts = checkpoint.facts;
        saved?;
        self.saved_passes = Some(render.passes());
        Ok(())
    }
}

/// Beside the picture, unless the user names another.
fn path(args: &RenderArgs, desc: &SceneDesc) -> PathBuf {
    let beside = || args.output.clone().unwrap_or_else(|| default_output(&desc.name, ""));
    args.checkpoint.clone().unwrap_or_else(|| beside().with_extension("checkpoint"))
}
