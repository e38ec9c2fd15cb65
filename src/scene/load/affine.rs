//! Affine maps in double precision.

use glam::{DAffine3, DMat3};

use super::geometry::Motion;
use crate::math::{DVec3, Vec3};

/// An affine map `p -> M p + t` in f64.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Affine(pub DAffine3);

impl Affine {
    pub const IDENTITY: Affine = Affine(DAffine3::IDENTITY);

    pub fn map(&self, p: DVec3) -> DVec3 {
        self.0.transform_point3(p)
    }

    pub fn vector(&self, v: DVec3) -> DVec3 {
        self.0.transform_vector3(v)
    }

    /// The factor by which it scales, where that is the same in all directions.
    pub fn uniform_scale(&self) -> Option<f64> {
        const TOLERANCE: f64 = 1e-5;
        let DMat3 { x_axis: x, y_axis: y, z_axis: z } = self.0.matrix3;
        let scale = x.length();
        let even = |v: DVec3| (v.length() - scale).abs() <= TOLERANCE * scale;
        let right = |a: DVec3, b: DVec3| a.dot(b).abs() <= TOLERANCE * scale * scale;
        (scale > 0.0 && even(y) && even(z) && right(x, y) && right(y, z) && right(z, x)).then_some(scale)
    }

    /// This map, then `next`.
    pub fn then(self, next: DAffine3) -> Affine {
        Affine(next * self.0)
    }
}

impl Motion for Affine {
    fn is_identity(&self) -> bool {
        *self == Affine::IDENTITY
    }

    fn point(&self, p: Vec3) -> Vec3 {
        self.map(p.as_dvec3()).as_vec3()
    }

    fn normal(&self, n: Vec3) -> Option<Vec3> {
        let turned = self.0.matrix3.inverse().transpose() * n.as_dvec3();
        turned.try_normalize().map(|n| n.as_vec3())
    }

    fn mirrors(&self) -> bool {
        self.0.matrix3.determinant() < 0.0
    }
}
