//! An OBJ file as a scene of its own: its materials, and a camera that sees all of it.

use std::path::Path;

use toml::de::DeTable;

use super::super::{CameraDesc, Places, SceneDesc, SceneError};
use super::access::{Denial, Reader};
use super::fields::Fields;
use super::mesh_entry::{self, Found};
use super::source::{Source, file_error};
use crate::math::{Aabb, Vec3};

/// The angle of view in degrees.
const FOV: f32 = 40.0;

/// Reads a mesh and looks at it along -z, from where it fits into the picture.
pub(super) fn read(path: &Path, reader: &Reader) -> Result<SceneDesc, SceneError> {
    const NO_SCENE: &str = "an OBJ mesh";
    // Looked at first, so that its absence is not told as that of a file that a scene names.
    if !reader.is_file(path) {
        let denied = |denial: Denial| file_error(path, denial.reason());
        reader.read(path, NO_SCENE).map_err(denied)?;
    }
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let text = format!("[[mesh]]\nfile = {}\n", serde_json::Value::from(name.as_ref()));
    let table = DeTable::parse(&text).map_err(|e| file_error(path, e.message()))?;
    let source = Source::new(path, &text);
    let root = Fields::root(&source, &table, &["mesh"])?;
    let mut found = Found { materials: Vec::new(), warnings: Vec::new(), triangles: 0 };
    let meshes = mesh_entry::meshes(&root, reader, &[].into_iter().collect(), &mut found).map_err(
        |error| match error {
            SceneError::Field { reason, .. } => file_error(path, reason),
            about_the_mesh => about_the_mesh,
        },
    )?;
    let camera = camera(Aabb::of_points(meshes.iter().flat_map(|mesh| mesh.vertices.iter().copied())));
    found.warnings.push(format!(
        "{}: a mesh has no camera: seen from {} with a field of view of {FOV} degrees; a scene file may say otherwise",
        path.display(),
        camera.position
    ));
    Ok(SceneDesc {
        name: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        path: path.to_owned(),
        materials: found.materials,
        meshes,
        warnings: found.warnings,
        places: Places { file: path.display().to_string(), ..Places::default() },
        ..SceneDesc::new(camera)
    })
}

/// A camera along -z in front of the middle of a box, so far that its front fits into the picture with a margin.
pub(super) fn camera(bounds: Aabb) -> CameraDesc {
    const MARGIN: f32 = 1.1;
    let (middle, half) = (0.5 * (bounds.min + bounds.max), 0.5 * bounds.extent());
    let distance = MARGIN * half.x.max(half.y).max(0.1 * half.z) / (0.5 * FOV.to_radians()).tan();
    CameraDesc::pinhole(middle + (half.z + distance) * Vec3::Z, middle, FOV)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::super::super::load;

    #[test]
    fn a_mesh_is_seen_whole() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.obj");
        fs::write(&path, "mtllib m.mtl\nusemtl a\nv -2 0 0\nv 4 0 0\nv 0 1 -3\nf 1 2 3\n").unwrap();
        fs::write(folder.path().join("m.mtl"), "newmtl a\nKd 0.5\nKe 1 1 1\n").unwrap();
        let scene = load(&path).unwrap();
        let camera = scene.camera;
        assert_eq!((camera.position.x, camera.position.y, camera.look_at.z), (1.0, 0.5, -1.5));
        let widest = (camera.position.z - 0.0) * (0.5 * camera.fov_degrees.to_radians()).tan();
        assert!((widest - 3.3).abs() < 1e-5, "{widest}");
        assert_eq!((scene.materials[0].emission.x, scene.warnings.len()), (1.0, 1));
        assert!(
            scene.warnings[0].contains("m.obj: a mesh has no camera: seen from [1, 0.5,"),
            "{:?}",
            scene.warnings
        );
    }

    #[test]
    fn a_mesh_that_is_not_there_is_told() {
        let error = load("no/mesh.obj".as_ref()).unwrap_err().to_string();
        assert!(error.starts_with("no/mesh.obj: cannot be read: "), "{error}");
    }
}
