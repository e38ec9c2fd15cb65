//! Warps of the unit square (or of a stream of numbers) to directions and points, each beside its density.
//!
//! Directions are local: z is the normal. Densities are with respect to solid angle (`pdf_w`) or area.

use std::f32::consts::{FRAC_1_PI, FRAC_PI_2, FRAC_PI_4, PI, TAU};

use super::{Rng, Vec2, Vec3};

/// A point of the unit disc, uniform in area, from a point of the unit square; neighbours stay neighbours.
///
/// # Source
/// Shirley and Chiu, "A Low Distortion Map Between Disk and Square", JGT 2(3), 1997.
pub fn square_to_disk(u: Vec2) -> Vec2 {
    let v = 2.0 * u - 1.0;
    if v.x == 0.0 && v.y == 0.0 {
        return Vec2::ZERO;
    }
    let (r, theta) = if v.x.abs() > v.y.abs() {
        (v.x, FRAC_PI_4 * (v.y / v.x))
    } else {
        (v.y, FRAC_PI_2 - FRAC_PI_4 * (v.x / v.y))
    };
    r * Vec2::from_angle(theta)
}

/// A direction of the upper hemisphere with density cos θ / π (Malley's method).
pub fn square_to_cosine_hemisphere(u: Vec2) -> Vec3 {
    let d = square_to_disk(u);
    d.extend((1.0 - d.length_squared()).max(0.0).sqrt())
}

/// The density of [`square_to_cosine_hemisphere`]: cos θ / π, and 0 below the horizon.
pub fn cosine_hemisphere_pdf_w(w: Vec3) -> f32 {
    w.z.max(0.0) * FRAC_1_PI
}

/// A direction of the sphere with density 1 / 4π.
pub fn square_to_uniform_sphere(u: Vec2) -> Vec3 {
    let z = 1.0 - 2.0 * u.x;
    let r = (1.0 - z * z).max(0.0).sqrt();
    (r * Vec2::from_angle(TAU * u.y)).extend(z)
}

/// The density of [`square_to_uniform_sphere`].
pub const UNIFORM_SPHERE_PDF_W: f32 = 0.25 * FRAC_1_PI;

/// A direction of the upper hemisphere with density 1 / 2π, by rejection: points of the cube are drawn until
/// one lies in the unit ball (and not at its centre), then it is normalised and turned up.
///
/// A draw is accepted with probability π/6, so 1.91 draws of three numbers are used on average.
pub fn uniform_hemisphere_by_rejection(rng: &mut Rng) -> Vec3 {
    loop {
        let v = 2.0 * Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32()) - 1.0;
        let length_squared = v.length_squared();
        if length_squared <= 1.0 && length_squared > 1e-6 {
            return v.with_z(v.z.abs()) / length_squared.sqrt();
        }
    }
}

/// The density of [`uniform_hemisphere_by_rejection`]: 1 / 2π, and 0 below the horizon.
pub fn uniform_hemisphere_pdf_w(w: Vec3) -> f32 {
    if w.z >= 0.0 { 1.0 / (2.0 * PI) } else { 0.0 }
}

/// Barycentric weights `(b1, b2)` of the second and third corner, uniform over a triangle's area.
pub fn square_to_triangle(u: Vec2) -> Vec2 {
    let s = u.x.sqrt();
    Vec2::new(s * (1.0 - u.y), s * u.y)
}
