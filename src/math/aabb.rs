use super::Vec3;

/// An axis-aligned box, closed on all sides. The empty box has `min = +inf`, `max = -inf`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// The smallest corner.
    pub min: Vec3,
    /// The largest corner.
    pub max: Vec3,
}

impl Aabb {
    /// The box that contains nothing and leaves every union unchanged.
    pub const EMPTY: Aabb = Aabb { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The box around a sphere.
    pub fn of_sphere(center: Vec3, radius: f32) -> Aabb {
        Aabb { min: center - radius, max: center + radius }
    }

    /// The smallest box around all `points`.
    ///
    /// ```
    /// use caustica::math::{Aabb, Vec3};
    /// let b = Aabb::of_points([Vec3::ZERO, Vec3::new(1.0, -2.0, 3.0)]);
    /// assert_eq!(b.extent(), Vec3::new(1.0, 2.0, 3.0));
    /// ```
    pub fn of_points(points: impl IntoIterator<Item = Vec3>) -> Aabb {
        points.into_iter().fold(Aabb::EMPTY, Aabb::with_point)
    }

    /// The smallest box around this one and `point`.
    pub fn with_point(self, point: Vec3) -> Aabb {
        Aabb { min: self.min.min(point), max: self.max.max(point) }
    }

    /// The smallest box around both.
    pub fn union(self, other: Aabb) -> Aabb {
        Aabb { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Whether `point` is inside or on the boundary; false where a coordinate is NaN.
    pub fn contains(&self, point: Vec3) -> bool {
        point.cmpge(self.min).all() && point.cmple(self.max).all()
    }

    /// Whether `other` lies inside entirely.
    pub fn contains_box(&self, other: &Aabb) -> bool {
        other.min.cmpge(self.min).all() && other.max.cmple(self.max).all()
    }

    /// Whether the two have a point in common.
    pub fn overlaps(&self, other: &Aabb) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }

    /// Whether nothing is inside.
    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// Edge lengths; zero for the empty box.
    pub fn extent(&self) -> Vec3 {
        if self.is_empty() { Vec3::ZERO } else { self.max - self.min }
    }

    /// The middle of the box.
    pub fn center(&self) -> Vec3 {
        0.5 * self.min + 0.5 * self.max
    }

    /// The area of the six faces: the measure of lines that meet the box (Cauchy-Crofton).
    pub fn surface_area(&self) -> f32 {
        let e = self.extent();
        2.0 * (e.x * e.y + e.y * e.z + e.z * e.x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn empty_box_contains_nothing_and_has_no_area() {
        assert!(Aabb::EMPTY.is_empty());
        assert!(!Aabb::EMPTY.contains(Vec3::ZERO));
        assert_eq!(Aabb::EMPTY.surface_area(), 0.0);
    }

    #[test]
    fn boxes_that_touch_overlap() {
        let unit = Aabb::of_sphere(Vec3::ZERO, 1.0);
        for (shift, overlap) in
            [(2.0 * Vec3::X, true), (2.1 * Vec3::Y, false), (Vec3::new(1.9, -2.0, 1.0), true)]
        {
            let moved = Aabb::of_sphere(shift, 1.0);
            assert_eq!((unit.overlaps(&moved), moved.overlaps(&unit)), (overlap, overlap), "{shift}");
        }
        assert!(!unit.overlaps(&Aabb::EMPTY));
    }

    #[test]
    fn boundary_belongs_to_the_box_and_nan_does_not() {
        let b = Aabb::of_sphere(Vec3::ONE, 1.0);
        assert!(b.contains(Vec3::ZERO) && b.contains(Vec3::splat(2.0)));
        assert!(!b.contains(Vec3::new(f32::NAN, 1.0, 1.0)));
        assert_eq!(b.surface_area(), 24.0);
    }

    /// No two edges are alike, and none is 2, whose square is its double.
    #[test]
    fn area_is_that_of_three_pairs_of_faces() {
        let b = Aabb { min: Vec3::new(-1.0, 0.0, 5.0), max: Vec3::new(0.0, 3.0, 10.0) };
        assert_eq!((b.surface_area(), b.center()), (46.0, Vec3::new(-0.5, 1.5, 7.5)));
        assert!(b.contains_box(&b) && !b.contains_box(&Aabb { max: b.max + Vec3::Y, ..b }));
    }
}
