//! Shards: some passes of a picture, which add up with those of other machines to the same bytes, whatever the split.
//!
//! ```text
//! ppm::IndependentPasses ──X_k──> Sums, exact ──┐
//! Facts, passes, seconds ───────────────────────┴─> Shard ──save──> FILE.shard ──┐
//!                                                                  FILE.shard ──┼─> Merge ──> a bigger Shard: mean, stderr
//!                                                                  FILE.shard ──┘
//! ```
//!
//! Sums of floating-point numbers depend on their order, so sums here are integers wide enough for every f32
//! ([`exact`]); they are rounded once, when all passes are in.

mod error;
pub mod exact;
mod file;
mod identity;
mod merge;
mod passes;
mod sums;

pub use error::ShardError;
pub use file::passes_of;
pub use identity::Identity;
pub use merge::Merge;
pub use passes::{PassRange, Passes, array_list};
pub use sums::Sums;

use crate::film::Image;

/// The work that passes took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Work {
    /// Milliseconds of setting up, all processes together.
    pub setup_milliseconds: u64,
    /// Milliseconds of passes.
    pub pass_milliseconds: u64,
    /// Photons emitted, aimed ones included.
    pub photons: u64,
}

impl Work {
    /// Both together.
    pub fn with(self, other: Work) -> Work {
        Work {
            setup_milliseconds: self.setup_milliseconds.saturating_add(other.setup_milliseconds),
            pass_milliseconds: self.pass_milliseconds.saturating_add(other.pass_milliseconds),
            photons: self.photons.saturating_add(other.photons),
        }
    }
}

/// Some passes of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Shard {
    /// Whose they are.
    pub identity: Identity,
    /// Which.
    pub passes: Passes,
    /// What they took.
    pub work: Work,
    /// What they brought.
    pub sums: Sums,
}

impl Shard {
    /// Without passes, of so many pixels.
    pub fn new(identity: Identity, (width, height): (usize, usize)) -> Shard {
        let (passes, work) = (Passes::default(), Work::default());
        Shard { identity, passes, work, sums: Sums::new(width, height) }
    }

    /// Adds the picture of a pass that is not in it yet.
    pub fn add(&mut self, pass: u32, picture: &Image) {
        self.sums.add(picture);
        self.passes = self.passes.with(&PassRange { first: pass, end: pass + 1 }.into());
    }

    /// The mean of its passes.
    pub fn mean(&self) -> Image {
        self.sums.mean(self.passes.count())
    }

    /// The standard error of that mean, by the spread of passes; NaN where there is but one.
    pub fn standard_error(&self) -> Image {
        self.sums.standard_error(self.passes.count())
    }
}
