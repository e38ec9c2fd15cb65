//! Checkpoints: renders that survive what ends the process.
//!
//! ```text
//! ppm::RenderState ┐
//! RunState         ├─> Checkpoint ──format──> bytes ──CheckpointFile──> FILE, and the one before as FILE.previous
//! Facts            ┘                                        │
//!   └── differences name what another render has <── load ──┘
//! ```
//!
//! What scene and settings give again is not kept. A file is versioned and ends in its own hash; bytes that are not what was
//! written are found out, whatever they are.

mod error;
mod facts;
mod file;
mod format;
mod run_state;

pub use crate::sealed::FormatError;
pub use error::CheckpointError;
pub use facts::Facts;
pub use file::{CheckpointFile, Loaded, Origin};
pub use format::{parse, write};
pub use run_state::{ErrorHistory, RunState};

use serde::{Deserialize, Serialize};

use crate::ppm::RenderState;

/// All that a render needs to go on in another process.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Checkpoint<'a> {
    /// Whose it is.
    pub facts: Facts,
    /// How the run stood.
    pub run: RunState,
    /// What the passes brought.
    pub render: RenderState<'a>,
}
