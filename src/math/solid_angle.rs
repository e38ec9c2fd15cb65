use super::Vec3;

/// The solid angle of a triangle seen from `p` (sr): positive from behind its counter-clockwise side, negative from
/// before it, 0 or ±2π in its plane. Over all triangles of a closed surface that faces outward they sum to 4π inside
/// and 0 outside.
///
/// Computed in f64; boundary case: 0 at a corner.
///
/// # Source
/// Van Oosterom and Strackee, "The Solid Angle of a Plane Triangle", IEEE Transactions on Biomedical Engineering 30(2), 1983.
pub fn solid_angle(corners: [Vec3; 3], p: Vec3) -> f64 {
    let [a, b, c] = corners.map(|corner| corner.as_dvec3() - p.as_dvec3());
    let (x, y, z) = (a.length(), b.length(), c.length());
    2.0 * a.dot(b.cross(c)).atan2(x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn an_octant_is_an_eighth_of_the_sphere_with_the_sign_of_the_side() {
        let octant = [Vec3::X, Vec3::Y, Vec3::Z];
        assert!((solid_angle(octant, Vec3::ZERO) - PI / 2.0).abs() < 1e-12);
        let [a, b, c] = octant;
        assert!((solid_angle([a, c, b], Vec3::ZERO) + PI / 2.0).abs() < 1e-12);
        assert_eq!(solid_angle(octant, Vec3::X), 0.0);
    }

    /// A crooked tetrahedron, whose corners no point sees at right angles. Catches a lost term of the denominator.
    #[test]
    fn a_closed_surface_is_the_whole_sphere_from_inside_and_nothing_from_outside() {
        let [a, b, c, d] =
            [[0.0, 0.0, 0.0], [2.0, 0.3, 0.1], [0.4, 1.7, -0.2], [0.5, 0.6, 1.3]].map(Vec3::from);
        let around = |p| -> f64 {
            [[a, c, b], [a, b, d], [b, c, d], [c, a, d]].iter().map(|face| solid_angle(*face, p)).sum()
        };
        let inside = 0.1 * a + 0.2 * b + 0.3 * c + 0.4 * d;
        assert!((around(inside) - 4.0 * PI).abs() < 1e-6, "{}", around(inside));
        for outside in [Vec3::new(3.0, 1.0, 0.5), Vec3::new(0.7, 0.5, -1.0)] {
            assert!(around(outside).abs() < 1e-6, "{}", around(outside));
        }
    }
}
