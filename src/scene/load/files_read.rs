//! Which files a scene was read from, and what was in them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// The files that a loader looked for, in the order of their names. Copies share one list.
///
/// A hash is that of the very bytes that were read, whatever becomes of the file later.
#[derive(Clone, Debug, Default)]
pub struct FilesRead(Arc<Mutex<BTreeMap<PathBuf, Option<blake3::Hash>>>>);

impl FilesRead {
    /// Names with the hash (BLAKE3) of their bytes; `None` for what was looked for, but could not be read.
    pub fn list(&self) -> Vec<(PathBuf, Option<blake3::Hash>)> {
        let files = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        files.iter().map(|(path, hash)| (path.clone(), *hash)).collect()
    }

    /// What is looked for by several names of its place is noted once.
    pub(super) fn note(&self, path: &Path, bytes: Option<&[u8]>) {
        let mut files = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        files.insert(path.to_owned(), bytes.map(blake3::hash));
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{BASE, folder};
    use super::super::{Access, load_with};
    use super::*;

    const MESH: &str = "[[mesh]]\nfile = \"a.obj\"\nmaterial = \"m\"\n";
    const OBJ: &str = "mtllib none.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

    /// Names and hashes, whether the scene could be read or not.
    fn read(files: &[(&str, &str)]) -> Vec<(String, Option<blake3::Hash>)> {
        let scene = format!("{BASE}[material.m]\ndiffuse = {{ albedo = [0.5, 0.5, 0.5] }}\n{MESH}");
        let (folder, path) = folder(scene.as_bytes(), files);
        let read = FilesRead::default();
        drop(load_with(&path, &Access::any().recording(&read)));
        let name = |path: PathBuf| path.strip_prefix(folder.path()).unwrap().to_str().unwrap().to_owned();
        read.list().into_iter().map(|(path, hash)| (name(path), hash)).collect()
    }

    #[test]
    fn the_scene_and_its_meshes_are_noted_with_what_was_in_them() {
        let files = read(&[("a.obj", OBJ), ("not_used.obj", OBJ)]);
        let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
        assert!(names.starts_with(&["a.obj"]) && names.contains(&"s.toml"), "{names:?}");
        assert!(!names.contains(&"not_used.obj"));
        assert_eq!(files[0].1, Some(blake3::hash(OBJ.as_bytes())));
    }

    #[test]
    fn what_is_missing_is_noted_as_such() {
        let files = read(&[]);
        assert!(files.contains(&("a.obj".into(), None)), "{files:?}");
    }
}
