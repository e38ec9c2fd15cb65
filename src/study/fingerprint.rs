//! What tells the scenes and settings of one measurement from those of another.

use std::fmt::{self, Write};
use std::hash::Hasher;
use std::path::PathBuf;

use fnv::FnvHasher;

use crate::scene::SceneDesc;

/// All of a scene but where it was read.
pub(super) fn described(desc: &SceneDesc) -> SceneDesc {
    let desc = desc.clone().without_places();
    SceneDesc { name: String::new(), path: PathBuf::new(), warnings: Vec::new(), ..desc }
}

/// A number that differs where the debug texts differ, for all that matters: FNV-1a of the text.
pub(super) fn fingerprint(value: &impl fmt::Debug) -> u64 {
    struct Hash(FnvHasher);
    impl Write for Hash {
        fn write_str(&mut self, text: &str) -> fmt::Result {
            self.0.write(text.as_bytes());
            Ok(())
        }
    }
    let mut hash = Hash(FnvHasher::default());
    // Hashing never fails.
    let _ = write!(hash, "{value:?}");
    hash.0.finish()
}
