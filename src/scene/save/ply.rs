//! Meshes as binary PLY, bit by bit.

use std::path::{Path, PathBuf};

use super::super::Mesh;

/// Names of mesh files: numbered, so that no two are the same.
pub(super) fn mesh_file(folder: &str, number: usize) -> PathBuf {
    Path::new(folder).join(format!("mesh_{number:04}.ply"))
}

/// The bytes of a PLY file that holds positions, triangles, and shading normals and texture coordinates where there are some.
pub(super) fn write(mesh: &Mesh) -> Vec<u8> {
    let mut header =
        format!("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", mesh.vertices.len());
    let normals = mesh.normals.as_ref().map(|_| ["nx", "ny", "nz"]);
    for name in ["x", "y", "z"].into_iter().chain(normals.into_iter().flatten()) {
        header += &format!("property float {name}\n");
    }
    let uvs = mesh.uvs.as_ref().map(|_| "property float u\nproperty float v\n");
    header += uvs.unwrap_or_default();
    header += &format!(
        "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.triangles.len()
    );
    let mut bytes = header.into_bytes();
    for (vertex, position) in mesh.vertices.iter().enumerate() {
        let normal = mesh.normals.as_ref().map(|normals| normals[vertex].to_array());
        for value in position.to_array().into_iter().chain(normal.into_iter().flatten()) {
            bytes.extend(value.to_le_bytes());
        }
        let uv = mesh.uvs.as_ref().map(|uvs| uvs[vertex].to_array());
        uv.into_iter().flatten().for_each(|value| bytes.extend(value.to_le_bytes()));
    }
    for triangle in &mesh.triangles {
        bytes.push(3);
        triangle.iter().for_each(|index| bytes.extend(index.to_le_bytes()));
    }
    bytes
}
