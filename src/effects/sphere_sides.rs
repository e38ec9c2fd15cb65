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

#[cfg(test)]
mod tests {
    use super::*;

    const WALL: SphereDesc = SphereDesc { center: Vec3::new(3.0, -2.0, 1.0), radius: 2.0, material: 0 };

    /// Of the largest coordinate on it, which is 5.
    #[test]
    fn errors_go_with_the_coordinates() {
        assert_eq!(error_of(&WALL), 5.0 * f64::from(RELATIVE_POSITION_ERROR));
    }

    /// Apart, within, around, crossing, and nearer than the errors of both: 1.6e-5 of `WALL` and the inner ones, 3.1e-5 of the outer ones.
    #[test]
    fn spheres_are_on_the_side_where_all_of_them_is() {
        for (apart, radius, side) in [
            (5.0, 1.0, Side::Of(0)),
            (0.5, 1.0, Side::Of(1)),
            (0.5, 6.0, Side::Of(0)),
            (2.5, 1.0, Side::Either),
            (1.5, 1.0, Side::Either),
            (5.0, 3.0 - 2e-5, Side::Either),
            (5.0, 3.0 - 4e-5, Side::Of(0)),
            (0.5, 1.5 - 1.5e-5, Side::Either),
            (0.5, 1.5 - 2.5e-5, Side::Of(1)),
        ] {
            let sphere = SphereDesc { center: WALL.center + apart * Vec3::X, radius, material: 0 };
            assert_eq!(side_of_sphere(&WALL, &sphere), side, "{apart} {radius}");
        }
    }

    /// By corners, faces and the errors of the wall.
    #[test]
    fn boxes_are_on_the_side_where_all_of_them_is() {
        let from = |x: f32| (Vec3::new(x, -0.5, -0.5), Vec3::new(x + 1.0, 0.5, 0.5));
        for ((min, max), side) in [
            (from(-0.5), Side::Of(1)),
            (from(1.0), Side::Either),
            (from(2.0 + 5e-6), Side::Either),
            (from(2.0 + 2e-5), Side::Of(0)),
            (from(-3.1), Side::Of(0)),
            ((Vec3::splat(1.5), Vec3::splat(2.0)), Side::Of(0)),
            ((Vec3::splat(1.0), Vec3::splat(2.0)), Side::Either),
            ((Vec3::splat(-3.0), Vec3::splat(3.0)), Side::Either),
        ] {
            let thing = Aabb { min: WALL.center + min, max: WALL.center + max };
            assert_eq!(side_of_box(&WALL, &thing), side, "{min} {max}");
        }
    }
}
