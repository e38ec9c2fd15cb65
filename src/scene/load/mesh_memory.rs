//! Mesh files that were parsed for the scene before, so that frames of an animation parse what they share once.

use std::collections::HashMap;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use super::super::SceneError;
use super::obj::{self, Keep, Obj};
use super::ply;

/// What the mesh files of a scene held, for the next scene; told apart by their bytes, whatever their names and times are.
///
/// It keeps what the last scene that was read with it used, and nothing before.
#[derive(Debug, Default)]
pub struct MeshMemory(Mutex<Held>);

#[derive(Debug, Default)]
struct Held {
    before: HashMap<Key, Arc<Obj>>,
    now: HashMap<Key, Arc<Obj>>,
}

/// The hash of a file's bytes, and how they are read.
type Key = (blake3::Hash, Kind);

/// A format, and what is kept of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Kind {
    Obj(Keep),
    Ply,
}

impl Kind {
    fn parse(self, path: &Path, bytes: Vec<u8>) -> Result<Obj, SceneError> {
        match self {
            Kind::Obj(keep) => obj::parse(path, bytes, keep),
            Kind::Ply => ply::parse(path, &bytes).map(Obj::of),
        }
    }
}

impl MeshMemory {
    /// Another scene begins: what the one before the last used is forgotten.
    pub(super) fn begin(&self) {
        let mut held = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        held.before = std::mem::take(&mut held.now);
    }

    fn find(&self, key: &Key) -> Option<Arc<Obj>> {
        let mut held = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let found = held.now.get(key).or_else(|| held.before.get(key)).map(Arc::clone)?;
        held.now.insert(*key, Arc::clone(&found));
        Some(found)
    }

    fn keep(&self, key: Key, parsed: &Obj) {
        let mut held = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        held.now.insert(key, Arc::new(parsed.clone()));
    }
}

/// What the bytes of a mesh file hold, from memory if it was there before.
///
/// # Errors
/// Those of the format; nothing is kept of such a file.
pub(super) fn parse(
    path: &Path,
    bytes: Vec<u8>,
    kind: Kind,
    memory: Option<&MeshMemory>,
) -> Result<Obj, SceneError> {
    let Some(memory) = memory else { return kind.parse(path, bytes) };
    let key = (blake3::hash(&bytes), kind);
    if let Some(found) = memory.find(&key) {
        return Ok(Obj::clone(&found));
    }
    let parsed = kind.parse(path, bytes)?;
    memory.keep(key, &parsed);
    Ok(parsed)
}

#[cfg(test)]
mod tests {
    use super::*;

    const KEEP: Keep = Keep { normals: true, uvs: false };

    fn held(memory: &MeshMemory) -> [usize; 2] {
        let held = memory.0.lock().unwrap();
        [held.before.len(), held.now.len()]
    }

    fn parsed(memory: &MeshMemory, text: &str, keep: Keep) -> Result<Obj, SceneError> {
        parse(Path::new("m.obj"), text.into(), Kind::Obj(keep), Some(memory))
    }

    /// What is found in memory is what was parsed: the parse of a planted entry would differ.
    #[test]
    fn equal_bytes_are_parsed_once() {
        const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        let memory = MeshMemory::default();
        let first = parsed(&memory, TRIANGLE, KEEP).unwrap();
        let planted = Obj { material_names: vec!["planted".into()], ..first };
        memory.keep((blake3::hash(TRIANGLE.as_bytes()), Kind::Obj(KEEP)), &planted);
        memory.begin();
        assert_eq!(parsed(&memory, TRIANGLE, KEEP).unwrap().material_names, ["planted"]);
        for other in [Keep { uvs: true, ..KEEP }, Keep { normals: false, ..KEEP }] {
            assert!(parsed(&memory, TRIANGLE, other).unwrap().material_names.is_empty());
        }
        assert!(parsed(&memory, &format!("{TRIANGLE}\n"), KEEP).unwrap().material_names.is_empty());
    }

    #[test]
    fn only_what_the_last_scene_used_is_kept() {
        let memory = MeshMemory::default();
        let triangle = |z: u32| format!("v 0 0 {z}\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        for z in 0..3 {
            memory.begin();
            parsed(&memory, &triangle(0), KEEP).unwrap();
            parsed(&memory, &triangle(z), KEEP).unwrap();
        }
        assert_eq!(held(&memory), [2, 2]);
        parsed(&memory, "f 1 2 3", KEEP).unwrap_err();
        assert_eq!(held(&memory), [2, 2]);
    }
}
