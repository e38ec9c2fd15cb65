use super::{Aabb, Vec3};

/// A closed ball around things.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundingSphere {
    /// Its middle.
    pub center: Vec3,
    /// Its radius, in scene units.
    pub radius: f32,
}

impl BoundingSphere {
    /// How much wider than computed a radius is made, so that no rounding leaves a ball outside: a few units of the last
    /// place.
    const ROUNDING: f32 = 1.0 + 8.0 * f32::EPSILON;

    /// A ball around `balls`, each of a centre and a radius (0 of a point), whose middle is that of their box.
    ///
    /// Of nothing it is a point at the origin. At most `√3` times as wide as the smallest.
    ///
    /// ```
    /// use caustica::math::{BoundingSphere, Vec3};
    /// let around = BoundingSphere::around([(Vec3::ZERO, 1.0), (4.0 * Vec3::X, 0.0)]);
    /// assert_eq!(around.center, 1.5 * Vec3::X);
    /// assert!((around.radius - 2.5).abs() < 1e-5);
    /// ```
    pub fn around<B>(balls: B) -> BoundingSphere
    where
        B: IntoIterator<Item = (Vec3, f32), IntoIter: Clone>,
    {
        let balls = balls.into_iter();
        let bounds = balls
            .clone()
            .map(|(center, radius)| Aabb::of_sphere(center, radius))
            .fold(Aabb::EMPTY, Aabb::union);
        if bounds.is_empty() {
            return BoundingSphere { center: Vec3::ZERO, radius: 0.0 };
        }
        let center = bounds.center();
        let reach = |(c, radius): (Vec3, f32)| c.distance(center) + radius;
        let radius = balls.map(reach).fold(0.0, f32::max) * Self::ROUNDING;
        BoundingSphere { center, radius }
    }

    /// Whether `point` is inside or on the boundary.
    pub fn contains(&self, point: Vec3) -> bool {
        self.center.as_dvec3().distance_squared(point.as_dvec3()) <= f64::from(self.radius).powi(2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn all_points_are_inside(
            points in prop::collection::vec((-1e6f32..1e6, -1f32..1.0, 1e3f32..1e4), 1..20),
        ) {
            let points: Vec<Vec3> = points.into_iter().map(Vec3::from).collect();
            let around = BoundingSphere::around(points.iter().map(|&p| (p, 0.0)));
            prop_assert!(points.iter().all(|&p| around.contains(p)));
        }
    }

    #[test]
    fn one_ball_is_its_own_bound() {
        let around = BoundingSphere::around([(Vec3::ONE, 2.0)]);
        assert!(around.center == Vec3::ONE && (2.0..2.000_01).contains(&around.radius));
        assert_eq!(BoundingSphere::around([]).radius, 0.0);
    }
}
