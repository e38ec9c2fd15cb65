use super::Vec3;

/// A half-line segment `origin + t * dir` with `t` in `(0, t_max)`.
///
/// `dir` need not be unit; `t` counts in its lengths. Nothing may rest on a hit exactly at either end:
/// start points are moved off their surface by [`super::offset_origin`] instead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where the ray starts.
    pub origin: Vec3,
    /// Where it goes.
    pub dir: Vec3,
    /// Where it ends; infinity for an unbounded ray.
    pub t_max: f32,
}

impl Ray {
    /// An unbounded ray.
    pub fn new(origin: Vec3, dir: Vec3) -> Ray {
        Ray { origin, dir, t_max: f32::INFINITY }
    }

    /// The point at parameter `t`.
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + t * self.dir
    }
}
