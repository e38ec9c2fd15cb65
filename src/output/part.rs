//! Files under passing names. Their writers hold a lock on them, which ends with the process however that ends: what no lock
//! holds was left behind.

use std::fs::{self, File, OpenOptions, Permissions};
use std::io;
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::Path;

use tempfile::NamedTempFile;

const PREFIX: &str = ".caustica-";
const SUFFIX: &str = ".part";
/// How often a new file may be taken for a leftover before that is an error.
const ATTEMPTS: u32 = 16;

/// An empty, locked file in `folder` that removes itself, readable by whom the umask allows.
pub(super) fn make_part(folder: &Path) -> io::Result<NamedTempFile> {
    for _ in 0..ATTEMPTS {
        let part = tempfile::Builder::new()
            .prefix(PREFIX)
            .suffix(SUFFIX)
            .permissions(Permissions::from_mode(0o666))
            .tempfile_in(folder)?;
        // Where files cannot be locked, nobody removes them.
        if part.as_file().lock().is_err() || part.as_file().metadata()?.nlink() > 0 {
            return Ok(part);
        }
    }
    Err(io::ErrorKind::ResourceBusy.into())
}

/// Removes what writers left in `folder` that were killed; others' files and those being written stay.
pub(super) fn remove_leftovers(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let name = name.as_encoded_bytes();
        let is_part = name.starts_with(PREFIX.as_bytes()) && name.ends_with(SUFFIX.as_bytes());
        if is_part && entry.file_type().is_ok_and(|kind| kind.is_file()) {
            remove_if_left(&entry.path());
        }
    }
}

/// Whoever may not remove it leaves it to its owner.
fn remove_if_left(path: &Path) {
    let locked = OpenOptions::new().write(true).open(path).and_then(lock_at_once);
    if locked.is_ok() {
        drop(fs::remove_file(path));
    }
}

fn lock_at_once(file: File) -> io::Result<File> {
    file.try_lock()?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_dead_left_is_removed_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        for name in [".caustica-dead.part", ".caustica-note", "other.part"] {
            fs::write(path(name), "").unwrap();
        }
        fs::create_dir(path(".caustica-folder.part")).unwrap();
        let living = make_part(folder.path()).unwrap();
        remove_leftovers(folder.path());
        assert!(!path(".caustica-dead.part").exists());
        for name in [".caustica-note", "other.part", ".caustica-folder.part"] {
            assert!(path(name).exists(), "{name}");
        }
        assert!(living.path().exists());
        let left = living.into_temp_path();
        remove_leftovers(folder.path());
        assert!(!left.exists());
    }
}
