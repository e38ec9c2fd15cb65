//! What is in files, whatever their dates say.

use std::collections::BTreeMap;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use super::FileHash;

/// Hashes of files, each read once.
#[derive(Debug, Default)]
pub struct Hashes(BTreeMap<PathBuf, Option<String>>);

impl Hashes {
    /// `None` for what cannot be read.
    pub fn of(&mut self, path: &Path) -> Option<String> {
        if !self.0.contains_key(path) {
            self.0.insert(path.to_owned(), hash_file(path).ok());
        }
        self.0.get(path).cloned().flatten()
    }

    /// Whether the files, relative to a folder, hold what they held, and none is there that was not.
    pub fn hold(&mut self, folder: &Path, files: &[FileHash]) -> bool {
        files.iter().all(|file| self.of(&folder.join(&file.path)) == file.hash)
    }
}

/// BLAKE3 in hexadecimal.
///
/// # Errors
/// When the file cannot be read.
pub fn hash_file(path: &Path) -> io::Result<String> {
    let mut hasher = blake3::Hasher::new();
    let (file, _): (File, u64) = crate::input::open_file(path)?;
    hasher.update_reader(file)?;
    Ok(hasher.finalize().to_hex().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn files_are_known_by_what_is_in_them() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
        write("a", "one");
        let file = |name: &str, text: Option<&str>| FileHash {
            path: name.into(),
            hash: text.map(|text| blake3::hash(text.as_bytes()).to_hex().to_string()),
        };
        let known = [file("a", Some("one")), file("none", None)];
        let hold = || Hashes::default().hold(folder.path(), &known);
        assert!(hold());
        write("a", "one");
        assert!(hold(), "the date alone changed");
        write("none", "");
        assert!(!hold(), "one is there that was not");
        fs::remove_file(folder.path().join("none")).unwrap();
        write("a", "two");
        assert!(!hold());
        fs::remove_file(folder.path().join("a")).unwrap();
        assert!(!hold());
    }
}
