use std::fs;
use std::path::{Path, PathBuf};

use super::StudyError;
use super::reference::Reference;
use super::separation::Separation;
use crate::film::Image;
use crate::output::{Metadata, read_exr, write_exr};

/// The pictures at every look of a configuration's repetitions, kept on disk until all repetitions are finished: a study that was
/// interrupted has them again.
pub struct Looks {
    folder: PathBuf,
    repetitions: u32,
}

impl Looks {
    /// Of the runs with this key, in a folder beside their last pictures.
    pub fn new(pictures: &Path, key: &str, repetitions: u32) -> Looks {
        Looks { folder: pictures.join("looks").join(key), repetitions }
    }

    fn path(&self, repetition: u32, steps: u32) -> PathBuf {
        self.folder.join(repetition.to_string()).join(format!("{steps}.exr"))
    }

    /// What this picture and those of the repetitions before tell of variance and bias; `None` for the first, and where
    /// files are missing.
    pub fn separate(
        &self,
        repetition: u32,
        steps: u32,
        picture: &Image,
        reference: &Reference,
        flat: Option<&[bool]>,
    ) -> Option<Separation> {
        let size = (picture.width(), picture.height());
        let of = |k: u32| match k == repetition {
            true => Some(picture.clone()),
            false => read_exr(&self.path(k, steps)).ok().filter(|old| (old.width(), old.height()) == size),
        };
        Separation::of(repetition + 1, of, reference, flat)
    }

    /// Keeps a picture for the repetitions to come.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn keep(&self, repetition: u32, steps: u32, picture: &Image) -> Result<(), StudyError> {
        if repetition + 1 < self.repetitions {
            write_exr(&self.path(repetition, steps), picture, &Metadata::new())?;
        }
        Ok(())
    }

    /// After the last repetition, nobody needs the pictures.
    pub fn finish(&self, repetition: u32) {
        if repetition + 1 == self.repetitions {
            // What is left over costs disk space alone; the folder of all goes with the last.
            let _ = fs::remove_dir_all(&self.folder);
            let _ = self.folder.parent().map(fs::remove_dir);
        }
    }
}
