//! The meshes of shapes that are given by formulas.

use std::f64::consts::TAU;

use super::super::geometry::Geometry;
use crate::math::{DVec3, Vec2, Vec3};

/// Corners of a circle: an inscribed polygon of so many has 2.5e-5 less area than the circle.
const CORNERS: u32 = 512;

/// From -1 to 1 in x and y; its normal is +z.
pub(super) fn rectangle() -> Geometry {
    let corner = |x: f32, y: f32| Vec3::new(x, y, 0.0);
    Geometry {
        vertices: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
        uvs: Some(vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y]),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Geometry::default()
    }
}

/// From -1 to 1, normals outward.
pub(super) fn cube() -> Geometry {
    let corner = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 2.0 - 1.0;
    let quads = [[0u32, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let halves = |q: &[u32; 4]| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]];
    Geometry {
        vertices: (0..8).map(corner).collect(),
        triangles: quads.iter().flat_map(halves).collect(),
        ..Geometry::default()
    }
}

/// Of radius 1 around the origin, in the plane of x and y; its normal is +z.
pub(super) fn disk() -> Geometry {
    let rim = (0..CORNERS).map(|k| on_circle(k).as_vec3());
    Geometry {
        vertices: std::iter::once(Vec3::ZERO).chain(rim).collect(),
        triangles: (0..CORNERS).map(|k| [0, 1 + k, 1 + (k + 1) % CORNERS]).collect(),
        ..Geometry::default()
    }
}

/// The side of a cylinder without its ends, with its smooth normals, which point outward.
pub(super) fn cylinder(p0: DVec3, p1: DVec3, radius: f64) -> Geometry {
    let along = (p1 - p0).normalize_or_zero();
    let (u, v) = along.any_orthonormal_pair();
    let outward = |k: u32| on_circle(k).x * u + on_circle(k).y * v;
    let ring = |end: DVec3| (0..CORNERS).map(move |k| (end + radius * outward(k)).as_vec3());
    let side = |k: u32| {
        let next = (k + 1) % CORNERS;
        [[k, next, CORNERS + next], [k, CORNERS + next, CORNERS + k]]
    };
    let normals = (0..2 * CORNERS).map(|k| outward(k % CORNERS).as_vec3());
    Geometry {
        vertices: ring(p0).chain(ring(p1)).collect(),
        normals: Some(normals.collect()),
        uvs: None,
        triangles: (0..CORNERS).flat_map(side).collect(),
        ignored: 0,
    }
}

fn on_circle(k: u32) -> DVec3 {
    let (sin, cos) = (TAU * f64::from(k) / f64::from(CORNERS)).sin_cos();
    DVec3::new(cos, sin, 0.0)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    /// The area and the sum of the area vectors.
    fn areas(geometry: &Geometry) -> (f64, DVec3) {
        let vectors = geometry.triangles.iter().map(|t| {
            let [a, b, c] = t.map(|i| geometry.vertices[i as usize].as_dvec3());
            0.5 * (b - a).cross(c - a)
        });
        vectors.fold((0.0, DVec3::ZERO), |(area, sum), v| (area + v.length(), sum + v))
    }

    #[test]
    fn areas_err_by_less_than_1e_4_and_normals_point_as_told() {
        let (area, sum) = areas(&rectangle());
        assert_eq!((area, sum), (4.0, DVec3::new(0.0, 0.0, 4.0)));
        let (area, sum) = areas(&disk());
        assert!((area / PI - 1.0).abs() < 1e-4 && (sum.z - area).abs() < 1e-9, "{area}");
        let (p0, p1) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(3.0, 5.0, 9.0));
        let (area, sum) = areas(&cylinder(p0, p1, 2.0));
        assert!((area / (2.0 * PI * 2.0 * 7.0) - 1.0).abs() < 1e-4 && sum.length() < 1e-4, "{area} {sum}");
        let (area, sum) = areas(&cube());
        assert_eq!((area, sum), (24.0, DVec3::ZERO));
    }

    #[test]
    fn closed_and_round_shapes_point_outward() {
        for (geometry, center) in
            [(cube(), Vec3::ZERO), (cylinder(DVec3::ZERO, DVec3::Z, 1.0), 0.5 * Vec3::Z)]
        {
            for t in &geometry.triangles {
                let [a, b, c] = t.map(|i| geometry.vertices[i as usize]);
                assert!((b - a).cross(c - a).dot((a + b + c) / 3.0 - center) > 0.0, "{t:?}");
            }
        }
        let tube = cylinder(DVec3::ZERO, DVec3::Z, 3.0);
        for (p, n) in tube.vertices.iter().zip(tube.normals.unwrap()) {
            assert!((p.with_z(0.0) / 3.0 - n).length() < 1e-6);
        }
    }
}
