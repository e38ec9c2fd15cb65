use super::Vec3;

/// Error of a computed surface point, relative to the largest coordinate that went into it.
///
/// A point on a triangle is the barycentric sum of its corners and a ray test subtracts the origin from them:
/// a few roundings of 2⁻²⁴ relative to the largest |coordinate| each. 32 of them leave room for grazing rays.
pub const RELATIVE_POSITION_ERROR: f32 = 32.0 / (1u32 << 24) as f32;

/// A start point for a ray that leaves a surface at `p` in direction `dir`, moved off the surface.
///
/// The point moves along the geometric normal `ng` (unit), to the side on which `dir` points, by
/// `p_error` (the absolute error of `p`, in scene units). That is the only epsilon of the renderer; it scales
/// with the scene, because `p_error` does.
///
/// ```
/// use caustica::math::{Vec3, offset_origin};
/// assert_eq!(offset_origin(Vec3::ZERO, 0.5, Vec3::Y, Vec3::NEG_Y), Vec3::new(0.0, -0.5, 0.0));
/// ```
pub fn offset_origin(p: Vec3, p_error: f32, ng: Vec3, dir: Vec3) -> Vec3 {
    p + p_error.copysign(ng.dot(dir)) * ng
}
