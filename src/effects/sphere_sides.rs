//! On which side of a sphere things are.

use super::region::Side;
use crate::math::{Aabb, DVec3, RELATIVE_POSITION_ERROR, Vec3};
use crate::scene::SphereDesc;

/// How far points of a sphere may be from where they should be, in scene units.
pub(super) fn error_of(sphere: &SphereDesc) -> f64 {
    f64::from(RELATIVE_POSITION_ERROR * (sphere.center.abs().max_element() + sphere.radius))
}

/// By the points of the box that are nearest to and farthest from the centre.
pub(super) fn side_of_box(wall: &SphereDesc, thing: &Aabb) -> Side {
    let from = |corner: Vec3| wall.center.as_dvec3() - corner.as_dvec3();
    let (below, above) = (from(thing.min), from(thing.max));
    let nearest = (-below).max(above).max(DVec3::ZERO).length();
    let farthest = below.abs().max(above.abs()).length();
    side_between(wall, nearest, farthest, error_of(wall))
}

/// By the points of the sphere that are nearest to and farthest from the centre.
pub(super) fn side_of_sphere(wall: &SphereDesc, sphere: &SphereDesc) -> Side {
    let (apart, radius) =
        (wall.center.as_dvec3().distance(sphere.center.as_dvec3()), f64::from(sphere.radius));
    side_between(wall, (apart - radius).abs(), apart + radius, error_of(wall) + error_of(sphere))
}

fn side_between(wall: &SphereDesc, nearest: f64, farthest: f64, error: f64) -> Side {
    let radius = f64::from(wall.radius);
    if farthest < radius - error {
        Side::Of(1)
    } else if nearest > radius + error {
        Side::Of(0)
    } else {
        Side::Either
    }
}
