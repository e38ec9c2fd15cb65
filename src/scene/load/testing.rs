//! What the tests of this module share: a scene that loads, and ways to change it.

use std::fs;
use std::path::PathBuf;

use tempfile::TempDir;

use super::super::{Mesh, SceneDesc, SceneError};
use super::load;
use crate::math::Vec3;

/// A scene that loads; the tests of mistakes change or add lines. `[camera]` is line 1, `[material.a]` line 5.
pub const BASE: &str = "\
[camera]
position = [0, 0, 5]
look_at = [0, 0, 0]
fov = 40
[material.a]
diffuse = { albedo = [0.5, 0.5, 0.5] }
[[point_light]]
position = [0, 3, 0]
intensity = [1, 1, 1]
";

/// A folder with `s.toml` and other files.
pub fn folder(scene: &[u8], files: &[(&str, &str)]) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        fs::write(folder.path().join(name), text).unwrap();
    }
    let path = folder.path().join("s.toml");
    fs::write(&path, scene).unwrap();
    (folder, path)
}

pub fn read(scene: &str, files: &[(&str, &str)]) -> Result<SceneDesc, String> {
    let (folder, path) = folder(scene.as_bytes(), files);
    let shorten = |e: SceneError| e.to_string().replace(&format!("{}/", folder.path().display()), "");
    load(&path).map_err(shorten)
}

pub fn good(scene: &str, files: &[(&str, &str)]) -> SceneDesc {
    read(scene, files).unwrap()
}

/// The one mesh of `BASE` with `table` and an OBJ file `m.obj`.
pub fn mesh_with(table: &str, obj: &str) -> (Mesh, SceneDesc) {
    let scene = good(&format!("{BASE}[[mesh]]\nfile = \"m.obj\"\n{table}\n"), &[("m.obj", obj)]);
    (scene.meshes[0].clone(), scene)
}

pub fn fails_with(scene: &str, place: &str, words: &str) {
    let error = read(scene, &[("m.obj", TRIANGLE)]).expect_err(scene);
    assert!(error.starts_with(place), "{scene}\n{error}\nis not at {place}");
    assert!(error.contains(words), "{scene}\n{error}\nlacks {words}");
}

pub const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

pub fn close(a: Vec3, b: Vec3) -> bool {
    (a - b).length() < 1e-5
}

pub fn normal(mesh: &Mesh, triangle: usize) -> Vec3 {
    let [a, b, c] = mesh.corners(triangle);
    (b - a).cross(c - a).normalize()
}

/// `BASE` with `old` replaced by `new` fails at `place` (`s.toml:LINE:COLUMN...`) with `words`.
pub fn changed_fails_with(old: &str, new: &str, place: &str, words: &str) {
    assert!(BASE.contains(old), "{old}");
    fails_with(&BASE.replace(old, new), place, words);
}

/// `BASE` followed by `tables` (from line 10) fails in `line` with `words`.
pub fn added_fails_with(tables: &str, line: usize, words: &str) {
    fails_with(&format!("{BASE}{tables}\n"), &format!("s.toml:{line}:"), words);
}
