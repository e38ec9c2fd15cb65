//! The sphere: its one containment test and a box that never contradicts it.

use rayon::prelude::*;

use crate::math::{Aabb, Vec3};

/// A closed ball. A negative or NaN radius is allowed: such a sphere contains nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// The centre.
    pub center: Vec3,
    /// The radius, in scene units.
    pub radius: f32,
}

impl Sphere {
    /// Whether |p - c|² ≤ r², in f32: the squares of the differences are summed in the order x, y, z.
    pub fn contains(&self, p: Vec3) -> bool {
        squared_distance(self.center, p) <= self.squared_radius()
    }

    /// r², or -1 where nothing is contained.
    pub(super) fn squared_radius(&self) -> f32 {
        if self.radius >= 0.0 { self.radius * self.radius } else { -1.0 }
    }

    /// Half the side of [`Sphere::bounds`] where the radius is not negative and its square is finite.
    fn reach(&self) -> f32 {
        const RELATIVE: f32 = 1.0 + 1.0 / (1u32 << 21) as f32;
        const ABSOLUTE: f32 = 1.0 / (1u128 << 74) as f32;
        self.radius * RELATIVE + ABSOLUTE
    }

    /// A box that contains every point for which [`Sphere::contains`] holds, however it was rounded.
    ///
    /// Three roundings widen the ball by at most 2⁻²² of its radius; a difference below 2⁻⁷⁵ squares to zero; and a
    /// radius whose square overflows reaches everywhere.
    pub fn bounds(&self) -> Aabb {
        let squared_radius = self.squared_radius();
        if squared_radius < 0.0 || self.center.is_nan() {
            Aabb::EMPTY
        } else if squared_radius == f32::INFINITY {
            Aabb { min: Vec3::NEG_INFINITY, max: Vec3::INFINITY }
        } else {
            Aabb::of_sphere(self.center, self.reach())
        }
    }
}

/// Half the side that the bounds of all spheres share; `None` where they are not cubes of one size.
pub(super) fn common_reach(spheres: &[Sphere]) -> Option<f32> {
    let first = spheres.first()?;
    let finite = (0.0..f32::INFINITY).contains(&first.squared_radius());
    let alike = |s: &Sphere| s.radius == first.radius && s.center.is_finite();
    (finite && spheres.par_iter().all(alike)).then(|| first.reach())
}

pub(super) fn squared_distance(a: Vec3, b: Vec3) -> f32 {
    let d = a - b;
    d.x * d.x + d.y * d.y + d.z * d.z
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Moves a number by some units in the last place.
    fn nudge(x: f32, ulps: i32) -> f32 {
        f32::from_bits(x.to_bits().wrapping_add_signed(ulps))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]
        #[test]
        fn no_point_is_inside_the_sphere_and_outside_its_box(
            exponent in -36f32..19.0,
            center_over_radius in -2f32..2.0,
            axis in 0usize..3,
            ulps in -6i32..7,
        ) {
            let radius = 10f32.powf(exponent);
            let center = Vec3::splat(radius * center_over_radius);
            let sphere = Sphere { center, radius };
            let mut p = center;
            p[axis] = nudge(center[axis] + radius, ulps);
            prop_assert!(!sphere.contains(p) || sphere.bounds().contains(p));
        }

        #[test]
        fn squares_that_vanish_are_inside_the_box(exponent in -40f32..-20.0, distance in -30f32..-20.0) {
            let sphere = Sphere { center: Vec3::ZERO, radius: 10f32.powf(exponent) };
            let p = Vec3::Y * 10f32.powf(distance);
            prop_assert!(!sphere.contains(p) || sphere.bounds().contains(p));
        }
    }

    #[test]
    fn the_boundary_belongs_to_the_sphere() {
        let sphere = Sphere { center: Vec3::ONE, radius: 0.5 };
        assert!(sphere.contains(Vec3::new(1.5, 1.0, 1.0)));
        assert!(!sphere.contains(Vec3::new(1.500_001, 1.0, 1.0)));
    }
}
