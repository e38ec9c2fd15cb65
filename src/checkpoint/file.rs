//! A checkpoint's place on disk, where at any moment a whole one stands.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::{Checkpoint, CheckpointError, Facts, FormatError, parse, write};
use crate::input::read_file;
use crate::output::{OutputError, check_writable, replace_atomically};

/// The file of a checkpoint, and beside it the one before: `FILE` and `FILE.previous`.
#[derive(Debug)]
pub struct CheckpointFile {
    path: PathBuf,
    previous: PathBuf,
    /// Whether `path` is worth being kept as `previous`; a damaged one must not take the place of a good one.
    is_good: bool,
}

/// Which of the two files a checkpoint comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Origin {
    /// The file itself.
    Latest,
    /// The one before, since the file is damaged.
    PreviousOfDamaged,
    /// The one before, since the process ended between putting it aside and replacing it.
    PreviousOfMissing,
}

/// A checkpoint that goes on.
#[derive(Clone, Debug, PartialEq)]
pub struct Loaded {
    /// What it holds.
    pub checkpoint: Checkpoint<'static>,
    /// Where it was found.
    pub origin: Origin,
}

impl CheckpointFile {
    /// At `path`, or where it links to.
    ///
    /// # Errors
    /// When no file can be written there.
    pub fn at(path: &Path) -> Result<CheckpointFile, OutputError> {
        check_writable(path)?;
        // The one before must stand beside what a link points to.
        let target = if path.is_symlink() { fs::canonicalize(path).ok() } else { None };
        let path = target.unwrap_or_else(|| path.to_path_buf());
        let previous = previous_of(&path);
        check_writable(&previous)?;
        Ok(CheckpointFile { path, previous, is_good: false })
    }

    /// Removes what of the two files at `path` is there.
    pub fn remove(path: &Path) {
        for path in [path, &previous_of(path)] {
            drop(fs::remove_file(path));
        }
    }

    /// The file itself.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The one before it.
    pub fn previous(&self) -> &Path {
        &self.previous
    }

    /// What would be lost by writing, a checkpoint or anything else: that of the two files which is there.
    pub fn existing(&self) -> Option<&Path> {
        [&self.path, &self.previous].into_iter().find(|path| path.exists()).map(PathBuf::as_path)
    }

    /// Reads the latest checkpoint that is whole; `None` where there is none at all.
    ///
    /// # Errors
    /// If what is there cannot be read or is no checkpoint, or belongs to a render whose facts are not `facts`.
    pub fn load(&mut self, facts: &Facts) -> Result<Option<Loaded>, CheckpointError> {
        let Some(Loaded { checkpoint, origin }) = self.find()? else { return Ok(None) };
        let differences = checkpoint.facts.differences(facts);
        if !differences.is_empty() {
            return Err(CheckpointError::Different { path: self.path.clone(), differences });
        }
        self.is_good = origin == Origin::Latest;
        Ok(Some(Loaded { checkpoint, origin }))
    }

    fn find(&self) -> Result<Option<Loaded>, CheckpointError> {
        let from = |checkpoint, origin| Ok(Some(Loaded { checkpoint, origin }));
        match read(&self.path)? {
            Some(Ok(checkpoint)) => from(checkpoint, Origin::Latest),
            Some(Err(reason)) => match read(&self.previous)? {
                Some(Ok(checkpoint)) if !matches!(reason, FormatError::Version { .. }) => {
                    from(checkpoint, Origin::PreviousOfDamaged)
                }
                _ => Err(self.unusable(&self.path, reason)),
            },
            None => match read(&self.previous)? {
                Some(Ok(checkpoint)) => from(checkpoint, Origin::PreviousOfMissing),
                Some(Err(reason)) => Err(self.unusable(&self.previous, reason)),
                None => Ok(None),
            },
        }
    }

    fn unusable(&self, path: &Path, reason: FormatError) -> CheckpointError {
        CheckpointError::Unusable { path: path.into(), reason, previous: self.previous.clone() }
    }

    /// Puts `checkpoint` into the file's place, and what was there, if it was good, aside.
    ///
    /// # Errors
    /// If it cannot be written; the one before is still there then, under one of the two names.
    pub fn save(&mut self, checkpoint: &Checkpoint) -> Result<(), OutputError> {
        let aside = self.is_good.then_some(self.previous.as_path());
        replace_atomically(&self.path, aside, |mut out| write(checkpoint, &mut out))?;
        self.is_good = true;
        Ok(())
    }
}

fn previous_of(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".previous");
    name.into()
}

/// The bytes, and what is made of them.
const MEMORY_A_BYTE: u64 = 3;

/// What a file holds; `None` where there is no file.
fn read(path: &Path) -> Result<Option<Result<Checkpoint<'static>, FormatError>>, CheckpointError> {
    match read_file(path, MEMORY_A_BYTE) {
        Ok(bytes) => Ok(Some(parse(&bytes))),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(source) => Err(CheckpointError::Read { path: path.into(), source }),
    }
}

#[cfg(test)]
mod tests {
    use super::super::format::tests::checkpoint_after;
    use super::*;
    use tempfile::TempDir;

    struct Place {
        folder: TempDir,
    }

    impl Place {
        fn new() -> Place {
            Place { folder: tempfile::tempdir().unwrap() }
        }

        fn file(&self) -> CheckpointFile {
            CheckpointFile::at(&self.folder.path().join("a.checkpoint")).unwrap()
        }

        fn put(&self, name: &str, bytes: &[u8]) {
            fs::write(self.folder.path().join(name), bytes).unwrap();
        }

        fn remove(&self, name: &str) {
            fs::remove_file(self.folder.path().join(name)).unwrap();
        }

        /// Passes of the checkpoint that is found, and where.
        fn found(&self) -> (u32, Origin) {
            let loaded = self.file().load(&Facts::default()).unwrap().unwrap();
            (loaded.checkpoint.render.passes(), loaded.origin)
        }

        fn error(&self) -> String {
            self.file().load(&Facts::default()).unwrap_err().to_string()
        }
    }

    fn after(passes: u32) -> Checkpoint<'static> {
        parse(&checkpoint_after(passes)).unwrap()
    }

    #[test]
    fn the_one_before_is_kept_and_used_when_the_latest_is_damaged() {
        let place = Place::new();
        let mut file = place.file();
        assert_eq!(file.load(&Facts::default()).unwrap(), None);
        (1..=3).for_each(|passes| file.save(&after(passes)).unwrap());
        assert_eq!(place.found(), (3, Origin::Latest));
        let latest = fs::read(file.path()).unwrap();
        for damaged in [&latest[..0], &latest[..40], &latest[..latest.len() - 1], b"something else"] {
            place.put("a.checkpoint", damaged);
            assert_eq!(place.found(), (2, Origin::PreviousOfDamaged));
        }
        place.remove("a.checkpoint");
        assert_eq!(place.found(), (2, Origin::PreviousOfMissing));
    }

    /// What is damaged must not push out what is good.
    #[test]
    fn a_damaged_file_is_not_put_aside() {
        let place = Place::new();
        place.put("a.checkpoint", b"damaged");
        place.put("a.checkpoint.previous", &checkpoint_after(2));
        let mut file = place.file();
        file.load(&Facts::default()).unwrap();
        file.save(&after(3)).unwrap();
        assert_eq!(parse(&fs::read(file.previous()).unwrap()).unwrap().render.passes(), 2);
        file.save(&after(4)).unwrap();
        assert_eq!(parse(&fs::read(file.previous()).unwrap()).unwrap().render.passes(), 3);
        assert_eq!(place.found(), (4, Origin::Latest));
    }

    #[test]
    fn without_a_good_one_the_user_is_told() {
        let place = Place::new();
        place.put("a.checkpoint", b"a picture, say");
        let error = place.error();
        assert!(
            error.contains("a.checkpoint: not a checkpoint, and there is no good")
                && error.contains("remove it"),
            "{error}"
        );
        let whole = checkpoint_after(1);
        place.put("a.checkpoint", &whole[..whole.len() - 1]);
        place.put("a.checkpoint.previous", &whole[..30]);
        assert!(place.error().contains("a.checkpoint: damaged"), "{}", place.error());
        place.remove("a.checkpoint");
        assert!(place.error().contains("a.checkpoint.previous: damaged"), "{}", place.error());
    }

    #[test]
    fn others_are_refused_by_what_differs() {
        let place = Place::new();
        place.put("a.checkpoint", &checkpoint_after(1));
        let facts: Facts = postcard::from_bytes(b"\x01\x05alpha\x030.5").unwrap();
        let error = place.file().load(&facts).unwrap_err().to_string();
        assert!(error.contains("alpha: the checkpoint has none, this render 0.5"), "{error}");
    }

    #[test]
    fn files_that_are_there_are_told() {
        for name in ["a.checkpoint", "a.checkpoint.previous"] {
            let place = Place::new();
            assert_eq!(place.file().existing(), None);
            place.put(name, b"");
            assert!(place.file().existing().unwrap().ends_with(name));
        }
    }

    #[test]
    fn behind_a_link_it_has_its_predecessor_beside_it() {
        let place = Place::new();
        let (link, there) = (place.folder.path().join("a.checkpoint"), place.folder.path().join("there"));
        place.put("there", &checkpoint_after(1));
        std::os::unix::fs::symlink(&there, &link).unwrap();
        let mut file = place.file();
        file.load(&Facts::default()).unwrap();
        file.save(&after(2)).unwrap();
        assert!(link.is_symlink() && file.previous().ends_with("there.previous"));
        assert_eq!(place.found(), (2, Origin::Latest));
    }

    #[test]
    fn a_folder_in_its_place_is_told() {
        let place = Place::new();
        fs::create_dir(place.folder.path().join("a.checkpoint.previous")).unwrap();
        let error = CheckpointFile::at(&place.folder.path().join("a.checkpoint")).unwrap_err();
        assert!(matches!(error, OutputError::IsFolder { .. }));
    }
}
