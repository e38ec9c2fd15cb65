//! The form of a scene that files can hold as it is.

use std::collections::{BTreeMap, BTreeSet};

use super::super::{CameraDesc, Mesh, SceneDesc, Textures};
use super::quads::quad_corners;
use crate::math::{Vec2, Vec3};

/// The same scene with one material a mesh, quads before other meshes, and different names for different materials.
///
/// It looks the same; meshes of several materials are split, vertices that no triangle uses are dropped, a mesh that shows one place
/// of a picture has that place's coordinates, and a pinhole is sharp where it looks at. Files that were converted once stay as they are.
#[must_use]
pub fn normal_form(desc: SceneDesc) -> SceneDesc {
    let pictured = |mesh: &Mesh| {
        mesh.materials.iter().any(|&material| desc.materials[material as usize].textures != Textures::NONE)
    };
    let meshes = desc.meshes.into_iter().flat_map(split).map(|mesh| Mesh {
        uvs: if pictured(&mesh) {
            mesh.uvs.or_else(|| Some(vec![Vec2::ZERO; mesh.vertices.len()]))
        } else {
            mesh.uvs
        },
        ..mesh
    });
    let (quads, others): (Vec<Mesh>, Vec<Mesh>) = meshes.partition(|mesh| quad_corners(mesh).is_some());
    let mut taken = BTreeSet::new();
    let mut materials = desc.materials;
    for material in &mut materials {
        material.name = unique(&material.name, &mut taken);
    }
    let camera = match desc.camera {
        CameraDesc { lens_radius: 0.0, position, look_at, fov_degrees, up, .. } => {
            CameraDesc { up, ..CameraDesc::pinhole(position, look_at, fov_degrees) }
        }
        lens => lens,
    };
    SceneDesc { meshes: [quads, others].concat(), materials, camera, ..desc }.without_places()
}

/// `name`, or the first of `name (2)`, `name (3)`, ... that is not taken; it is taken from here on.
pub(super) fn unique(name: &str, taken: &mut BTreeSet<String>) -> String {
    let numbered = (2u64..).map(|k| format!("{name} ({k})"));
    let mut names = std::iter::once(name.to_owned()).chain(numbered);
    let free = names.find(|name| !taken.contains(name)).unwrap_or_default();
    taken.insert(free.clone());
    free
}

/// One mesh for each material, in the order in which the triangles use them.
fn split(mesh: Mesh) -> Vec<Mesh> {
    let mut order = Vec::new();
    let mut triangles: BTreeMap<u32, Vec<[u32; 3]>> = BTreeMap::new();
    for (triangle, material) in mesh.triangles.iter().zip(&mesh.materials) {
        let of_material = triangles.entry(*material).or_insert_with(|| {
            order.push(*material);
            Vec::new()
        });
        of_material.push(*triangle);
    }
    let one = |material: u32| part(&mesh, triangles.remove(&material).unwrap_or_default(), material);
    order.into_iter().map(one).collect()
}

/// Some triangles of a mesh with the vertices that they use, in their order.
fn part(mesh: &Mesh, triangles: Vec<[u32; 3]>, material: u32) -> Mesh {
    const UNUSED: u32 = u32::MAX;
    let mut numbers = vec![UNUSED; mesh.vertices.len()];
    triangles.iter().flatten().for_each(|&vertex| numbers[vertex as usize] = 0);
    let used: Vec<usize> = (0..numbers.len()).filter(|&vertex| numbers[vertex] != UNUSED).collect();
    used.iter().zip(0..).for_each(|(&vertex, number)| numbers[vertex] = number);
    let of_used = |values: &Vec<Vec3>| used.iter().map(|&vertex| values[vertex]).collect();
    Mesh {
        name: mesh.name.clone(),
        vertices: of_used(&mesh.vertices),
        normals: mesh.normals.as_ref().map(of_used),
        uvs: mesh.uvs.as_ref().map(|uvs| used.iter().map(|&vertex| uvs[vertex]).collect()),
        materials: vec![material; triangles.len()],
        triangles: triangles
            .into_iter()
            .map(|triangle| triangle.map(|vertex| numbers[vertex as usize]))
            .collect(),
    }
}
