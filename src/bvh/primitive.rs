//! What a ray can hit, while the tree is being built.

use super::sphere::Sphere;
use crate::math::{Aabb, Vec3};

/// A primitive's numbers; the order decides between hits at the same distance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct PrimitiveId {
    pub geometry: u32,
    pub primitive: u32,
}

impl PrimitiveId {
    pub const FIRST: PrimitiveId = PrimitiveId { geometry: 0, primitive: 0 };
    pub const NONE: PrimitiveId = PrimitiveId { geometry: u32::MAX, primitive: u32::MAX };
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Shape {
    Triangle([Vec3; 3]),
    Sphere(Sphere),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Primitive {
    pub shape: Shape,
    pub id: PrimitiveId,
}

impl Primitive {
    pub fn bounds(&self) -> Aabb {
        match self.shape {
            Shape::Triangle(corners) => Aabb::of_points(corners),
            Shape::Sphere(Sphere { center, radius }) => Aabb::of_sphere(center, radius),
        }
    }
}

/// Whether a triangle has an area, and a normal that f32 can hold.
pub(super) fn has_area(corners: [Vec3; 3]) -> bool {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    let exact = (b - a).cross(c - a);
    let rounded = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    exact.length_squared() > 0.0 && rounded != Vec3::ZERO && rounded.is_finite()
}
