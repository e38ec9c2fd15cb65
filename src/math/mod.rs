//! Vectors, rays, frames, random numbers, warps and power laws: the ground floor, which imports glam alone.

mod aabb;
mod bounding_sphere;
mod frame;
mod offset;
mod power_law;
mod ray;
/// Philox, number by number.
pub mod rng;
mod solid_angle;
pub mod warp;

pub use aabb::Aabb;
pub use bounding_sphere::BoundingSphere;
pub use frame::Frame;
pub use glam::{DVec3, Vec2, Vec3, Vec4};
pub use offset::{RELATIVE_POSITION_ERROR, offset_origin};
pub use power_law::PowerLaw;
pub use ray::Ray;
pub use rng::{Rng, Stream, UNIT, unit_f32};
pub use solid_angle::solid_angle;

/// A linear RGB triple: a reflectance, a power (W), a radiance (W/m²/sr) or a dimensionless weight.
pub type Rgb = Vec3;

/// The weight of a sample whose density is `own`, where others of density `other` find the same: the balance heuristic
/// `own / (own + other)`, which is 1 for an infinite `own`.
///
/// # Source
/// Veach and Guibas, "Optimally Combining Sampling Techniques for Monte Carlo Rendering", SIGGRAPH 1995.
///
/// ```
/// use caustica::math::balance;
/// assert_eq!([balance(1.0, 3.0), balance(f32::INFINITY, 3.0), balance(1.0, f32::INFINITY)], [0.25, 1.0, 0.0]);
/// ```
pub fn balance(own: f32, other: f32) -> f32 {
    if own.is_infinite() { 1.0 } else { own / (own + other) }
}

/// The mean of the three channels: the scalar that roulette and light selection go by.
///
/// ```
/// use caustica::math::{Rgb, mean};
/// assert_eq!(mean(Rgb::new(1.0, 2.0, 6.0)), 3.0);
/// ```
pub fn mean(rgb: Rgb) -> f32 {
    rgb.element_sum() / 3.0
}
