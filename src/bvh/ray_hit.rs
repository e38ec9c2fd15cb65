//! What a ray meets.

use super::primitive::PrimitiveId;
use crate::math::Vec3;

/// Where a ray first meets the primitives of a [`RayBvh`](super::RayBvh).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// The ray parameter: the distance in lengths of the ray's direction.
    pub t: f32,
    /// The barycentric weight of the triangle's second vertex; 0 on a sphere.
    pub u: f32,
    /// The barycentric weight of the triangle's third vertex; 0 on a sphere.
    pub v: f32,
    /// The geometric normal, not of unit length: `(v1 - v0) x (v2 - v0)` of a triangle, outward on a sphere.
    pub ng: Vec3,
    /// The geometry that was hit.
    pub geometry: u32,
    /// The number of the triangle or sphere within its geometry.
    pub primitive: u32,
}

impl RayHit {
    pub(super) fn new(t: f32, [u, v]: [f32; 2], ng: Vec3, id: PrimitiveId) -> RayHit {
        RayHit { t, u, v, ng, geometry: id.geometry, primitive: id.primitive }
    }
}
