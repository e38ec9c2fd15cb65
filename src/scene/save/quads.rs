//! Which meshes are quads.

use super::super::Mesh;
use super::super::load::check_quad;
use crate::math::{Vec2, Vec3};

/// The texture coordinates of every quad.
pub(super) const QUAD_UVS: [Vec2; 4] = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];

/// The corners of a mesh that is a quad: two triangles around one corner, flat.
pub(super) fn quad_corners(mesh: &Mesh) -> Option<[Vec3; 4]> {
    let corners = <[_; 4]>::try_from(&mesh.vertices[..]).ok()?;
    let is_plain = mesh.normals.is_none() && mesh.uvs.as_deref() == Some(&QUAD_UVS);
    let is_quad = is_plain && mesh.triangles == [[0, 1, 2], [0, 2, 3]];
    (is_quad && check_quad(&corners).is_ok()).then_some(corners)
}
