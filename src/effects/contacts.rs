//! Where triangles touch boxes and one another, up to the errors of their points.

use super::faces::{Face, Triangles};
use crate::math::{Aabb, RELATIVE_POSITION_ERROR, Vec3};

/// Whether a face may have a point in a box.
pub(super) fn touches(triangles: &Triangles, face: Face, thing: &Aabb) -> bool {
    triangles.bounds(face).overlaps(thing) && plane_meets(triangles.corners(face), thing)
}

/// Whether the plane of a triangle meets a box, up to the errors of its points.
fn plane_meets(triangle: [Vec3; 3], thing: &Aabb) -> bool {
    let [a, b, c] = triangle.map(|corner| corner.as_dvec3());
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let (min, max) = (thing.min.as_dvec3(), thing.max.as_dvec3());
    let (middle, half) = (0.5 * (min + max), 0.5 * (max - min));
    normal.dot(middle - a).abs() <= normal.abs().dot(half) + tolerance(triangle)
}

/// The signed distances of `points` from the plane of a triangle; positive before it.
pub(super) fn heights(triangle: [Vec3; 3], points: [Vec3; 3]) -> [f64; 3] {
    let [a, b, c] = triangle.map(|corner| corner.as_dvec3());
    let normal = (b - a).cross(c - a).normalize_or_zero();
    points.map(|p| normal.dot(p.as_dvec3() - a))
}

fn tolerance(corners: [Vec3; 3]) -> f64 {
    let largest = corners.iter().fold(0.0, |m: f32, corner| m.max(corner.abs().max_element()));
    2.0 * f64::from(RELATIVE_POSITION_ERROR * largest)
}

/// Whether `other` leaves the front of `lamp` as it is: because it is behind it, or beyond one of its sides.
pub(super) fn is_clear_of(lamp: [Vec3; 3], other: [Vec3; 3]) -> bool {
    let error = tolerance(lamp).max(tolerance(other));
    let heights = heights(lamp, other);
    let is_behind = heights.iter().all(|h| *h <= error) && heights.iter().any(|h| *h < -error);
    is_behind || (0..3).any(|side| is_beyond(lamp, side, other, error))
}

/// Whether all of `other` is outward of the plane through one side of a triangle, upright on it.
fn is_beyond(triangle: [Vec3; 3], side: usize, other: [Vec3; 3], error: f64) -> bool {
    let [a, b, c] = [0, 1, 2].map(|k| triangle[(side + k) % 3].as_dvec3());
    let outward = (b - a).cross((b - a).cross(c - a)).normalize_or_zero();
    let outward = if outward.dot(c - a) > 0.0 { -outward } else { outward };
    other.iter().all(|p| outward.dot(p.as_dvec3() - a) >= -error)
}

/// Whether two triangles lie in one plane, up to the errors of their points, and may overlap.
pub(super) fn are_in_one_place(triangles: &Triangles, a: Face, b: Face) -> bool {
    if !triangles.bounds(a).overlaps(&triangles.bounds(b)) {
        return false;
    }
    let (a, b) = (triangles.corners(a), triangles.corners(b));
    let error = tolerance(a).max(tolerance(b));
    let lies_in = |plane, other| heights(plane, other).iter().all(|h| h.abs() <= error);
    lies_in(a, b) || lies_in(b, a)
}

#[cfg(test)]
mod tests {
    use super::super::testing::{WALL, scene_of};
    use super::*;
    use crate::scene::Mesh;

    #[test]
    fn what_is_behind_or_beside_a_lamp_takes_none_of_its_light() {
        let lamp = [Vec3::ZERO, Vec3::X, Vec3::Z];
        let moved = |by: Vec3| lamp.map(|corner| corner + by);
        let upright = |at: f32| [Vec3::new(at, 0., at), Vec3::new(at + 0.1, 0., at), Vec3::new(at, -1., at)];
        for (other, is_clear) in [
            (moved(Vec3::Y), true),
            (moved(-Vec3::Y), false),
            (moved(2.0 * Vec3::X), true),
            (moved(-0.1 * Vec3::X), false),
            (upright(0.2), false),
            (upright(0.2).map(|p| -p), true),
            (upright(0.7), true),
        ] {
            assert_eq!(is_clear_of(lamp, other), is_clear, "{other:?}");
        }
    }

    #[test]
    fn planes_meet_boxes_that_they_cut() {
        let slope = [Vec3::X, Vec3::Y, Vec3::Z];
        let cube = |at: f32| Aabb::of_sphere(Vec3::splat(at), 0.1);
        for (at, meets) in [(1.0 / 3.0, true), (0.43, true), (0.44, false), (0.24, true), (0.23, false)] {
            assert_eq!(plane_meets(slope, &cube(at)), meets, "{at}");
        }
    }

    /// A lamp away from the origin and askew: what is a step outward of a side, seen from the centroid, is beyond that side alone.
    #[test]
    fn sides_are_told_by_the_centroid() {
        let lamp = [Vec3::new(5.0, 1.0, 2.0), Vec3::new(7.0, 2.0, 1.0), Vec3::new(6.0, 4.0, 3.0)];
        let centroid = (lamp[0] + lamp[1] + lamp[2]) / 3.0;
        for side in 0..3 {
            let (a, b) = (lamp[side], lamp[(side + 1) % 3]);
            let foot = a + (centroid - a).project_onto(b - a);
            let outward = foot - centroid;
            let at = |steps: f32| [0.0, 0.1, 0.2].map(|t| foot + steps * outward + t * outward);
            assert!(is_beyond(lamp, side, at(0.1), 1e-5), "{side}");
            assert!(!is_beyond(lamp, side, at(-0.3), 1e-5), "{side}");
            assert!(!is_beyond(lamp, (side + 1) % 3, at(0.1), 1e-5), "{side}");
        }
    }

    /// Tiny triangles lie in the plane of a large one, though it does not lie in theirs.
    #[test]
    fn triangles_in_one_plane_are_in_one_place_where_they_overlap() {
        let flat = [Vec3::ZERO, Vec3::X, Vec3::Z];
        let tilted = [Vec3::ZERO, Vec3::X, Vec3::new(0.0, 1.0, 1.0)];
        let others = [
            (flat.map(|p| p + Vec3::new(0.3, 0.0, 0.2)), true),
            (flat.map(|p| p + 2.0 * Vec3::X), false),
            (flat.map(|p| p + 1e-4 * Vec3::Y), false),
            (tilted, false),
            (tilted.map(|p| Vec3::new(0.2, 0.0, 0.2) + 2e-6 * p), true),
        ];
        let mesh = |corners: [Vec3; 3]| Mesh::new("triangle", corners.to_vec(), vec![[0, 1, 2]], WALL);
        let scene = scene_of([flat].into_iter().chain(others.map(|other| other.0)).map(mesh).collect());
        let triangles = Triangles::of(&scene);
        let face = |mesh| Face { mesh, triangle: 0 };
        for (number, (other, expected)) in (1..).zip(others) {
            assert_eq!(are_in_one_place(&triangles, face(0), face(number)), expected, "{other:?}");
            assert_eq!(are_in_one_place(&triangles, face(number), face(0)), expected, "{other:?}");
        }
    }

    #[test]
    fn tolerances_go_with_the_largest_coordinate() {
        let corners = [Vec3::ZERO, Vec3::new(1.0, -8.0, 2.0), Vec3::splat(3.0)];
        assert_eq!(tolerance(corners), 16.0 * f64::from(RELATIVE_POSITION_ERROR));
    }
}
