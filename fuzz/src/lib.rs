//! What the targets share: scenes in memory, and what must hold for every scene that loads.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

pub use caustica::scene::Access;
use caustica::scene::{SceneDesc, SceneError, load_with};

/// A scene whose mesh has no material but its own.
pub const SCENE: &str =
    "camera = { position = [0, 0, 5], look_at = [0, 0, 0], fov = 40 }\n[[mesh]]\nfile = \"m.obj\"\n";

/// A mesh of two materials.
pub const MESH: &str = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 3 2 1\n";

/// Materials for a mesh.
pub const MATERIALS: &str = "newmtl a\nKd 1 0 0\nnewmtl b\nKe 1 1 1\n";

/// A picture of two pixels, as PNG.
pub const PIXELS: &[u8] = include_bytes!("pixels.png");

/// A triangle, as PLY.
pub const PLY: &[u8] = include_bytes!("../seeds/ply/ascii.ply");

/// A scene of a PLY mesh with a picture on it.
pub const PLY_SCENE: &str = "camera = { position = [0, 0, 5], look_at = [0, 0, 0], fov = 40 }\n\
    material.a.diffuse.albedo = \"p.png\"\n[[mesh]]\nfile = \"m.ply\"\nmaterial = \"a\"\n";

/// Files in memory.
pub fn files(files: &[(&str, &[u8])]) -> BTreeMap<PathBuf, Vec<u8>> {
    files.iter().map(|(name, bytes)| (name.into(), bytes.to_vec())).collect()
}

/// Loads a scene from memory, by the name of its file.
pub fn load_from(name: &str, access: Access) -> Result<SceneDesc, SceneError> {
    load_with(Path::new(name), &access)
}

/// Loads a scene from memory.
pub fn load(scene: &[u8], mesh: &[u8], materials: &[u8]) -> Result<SceneDesc, SceneError> {
    load_from("s.toml", Access::given(files(&[("s.toml", scene), ("m.obj", mesh), ("m.mtl", materials)])))
}

/// The parts of an input between lines of `%%`.
pub fn parts(data: &[u8]) -> [&[u8]; 3] {
    const LINE: &[u8] = b"\n%%\n";
    let split = |data: &[u8]| data.windows(LINE.len()).position(|window| window == LINE);
    let cut = |data| split(data).map_or((data, &[][..]), |at| (&data[..=at], &data[at + LINE.len()..]));
    let (first, rest) = cut(data);
    let (second, third) = cut(rest);
    [first, second, third]
}

/// Panics where a scene that loaded is not what it promises, or where an error does not tell its place.
pub fn check(loaded: Result<SceneDesc, SceneError>) {
    match loaded {
        Ok(scene) => check_scene(&scene),
        Err(error) => {
            let text = error.to_string();
            const NAMES: [&str; 8] = ["s.toml", "m.obj", "m.mtl", "m.ply", "s.xml", "i.xml", "s.gltf", "p.png"];
            assert!(NAMES.iter().any(|file| text.contains(file)), "{text}");
            assert!(text.len() < 4096, "{text}");
        }
    }
}

fn check_scene(scene: &SceneDesc) {
    let n_materials = scene.materials.len() as u32;
    assert!(scene.spheres.iter().all(|s| s.material < n_materials && s.center.is_finite() && s.radius > 0.0));
    assert!(scene.point_lights.iter().all(|l| l.position.is_finite() && l.intensity.is_finite()));
    assert!(scene.materials.iter().all(|m| m.emission.is_finite() && m.emission.min_element() >= 0.0));
    for mesh in &scene.meshes {
        let n_vertices = mesh.vertices.len();
        assert!(!mesh.triangles.is_empty() && mesh.materials.len() == mesh.triangles.len());
        assert!(mesh.materials.iter().all(|&m| m < n_materials));
        assert!(mesh.triangles.iter().flatten().all(|&i| (i as usize) < n_vertices));
        assert!(mesh.vertices.iter().all(|v| v.is_finite() && v.abs().max_element() <= 1.8e18));
        assert!(mesh.uvs.as_ref().is_none_or(|uvs| uvs.len() == n_vertices));
        if let Some(normals) = &mesh.normals {
            assert_eq!(normals.len(), n_vertices);
            assert!(normals.iter().all(|n| n.is_normalized()));
        }
    }
}
