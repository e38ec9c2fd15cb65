//! Warps of the unit square (or of a stream of numbers) to directions and points, each beside its density.
//!
//! Directions are local: z is the normal. Densities are with respect to solid angle (`pdf_w`) or area.

use std::f32::consts::{FRAC_1_PI, FRAC_PI_2, FRAC_PI_4, PI};

use super::{Rng, Vec2, Vec3};

/// A point of the unit disc, uniform in area, from a point of the unit square; neighbours stay neighbours.
///
/// # Source
/// Shirley and Chiu, "A Low Distortion Map Between Disk and Square", JGT 2(3), 1997.
pub fn square_to_disk(u: Vec2) -> Vec2 {
    let v = 2.0 * u - 1.0;
    let x_is_larger = v.x.abs() > v.y.abs();
    let (r, other) = swapped_unless(x_is_larger, v.x, v.y);
    if r == 0.0 {
        return Vec2::ZERO;
    }
    let (sin, cos) = sin_cos_of_octant(FRAC_PI_4 * (other / r));
    let (x, y) = swapped_unless(x_is_larger, cos, sin);
    r * Vec2::new(x, y)
}

/// `(a, b)` or `(b, a)`, without a branch: on random numbers half of them would be mispredicted.
fn swapped_unless(keep: bool, a: f32, b: f32) -> (f32, f32) {
    let differing = (a.to_bits() ^ b.to_bits()) & u32::from(keep).wrapping_sub(1);
    (f32::from_bits(a.to_bits() ^ differing), f32::from_bits(b.to_bits() ^ differing))
}

/// The point of the unit circle at `u` of a whole turn, with `u` in `[0, 1]`.
fn unit_circle(u: f32) -> Vec2 {
    let quarters = 4.0 * u;
    let nearest = (quarters + 0.5).floor();
    let (sin, cos) = sin_cos_of_octant(FRAC_PI_2 * (quarters - nearest));
    let quarter = nearest as u32;
    let (x, y) = swapped_unless(quarter & 1 == 0, cos, sin);
    let with_sign = |value: f32, negative: u32| f32::from_bits(value.to_bits() ^ (negative & 2) << 30);
    Vec2::new(with_sign(x, quarter + 1), with_sign(y, quarter))
}

/// `sin x = ((s0 z + s1) z + s2) z x + x` with `z = x²` in ±π/4; see [`COS`] for the source.
pub const SIN: [f32; 3] = [-1.951_529_6e-4, 8.332_161e-3, -1.666_665_5e-1];

/// `cos x = ((c0 z + c1) z + c2) z² - z / 2 + 1` with `z = x²` in ±π/4.
///
/// # Source
/// Moshier, Cephes Mathematical Library, release 2.2, `sinf.c`.
pub const COS: [f32; 3] = [2.443_315_7e-5, -1.388_731_6e-3, 4.166_664_6e-2];

/// Sine and cosine of an angle in ±π/4, to a unit of the last place or two; unlike those of a C library the same on every
/// machine, and a fraction of their cost.
fn sin_cos_of_octant(x: f32) -> (f32, f32) {
    let z = x * x;
    let sin = ((SIN[0] * z + SIN[1]) * z + SIN[2]) * z * x + x;
    let cos = ((COS[0] * z + COS[1]) * z + COS[2]) * z * z - 0.5 * z + 1.0;
    (sin, cos)
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
    (r * unit_circle(u.y)).extend(z)
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_4, TAU};

    const STEPS: u32 = 1 << 16;

    #[test]
    fn sines_and_cosines_are_those_of_a_library() {
        for k in 0..=STEPS {
            let x = (2.0 * f64::from(k) / f64::from(STEPS) - 1.0) as f32 * FRAC_PI_4 as f32;
            let (sin, cos) = sin_cos_of_octant(x);
            let error = |a: f32, b: f64| (f64::from(a) - b).abs();
            assert!(error(sin, f64::from(x).sin()) < 1e-7 && error(cos, f64::from(x).cos()) < 1e-7, "{x}");
        }
    }

    #[test]
    fn circle_is_walked_once_around() {
        for k in 0..=STEPS {
            let u = k as f32 / STEPS as f32;
            let (sin, cos) = (TAU * f64::from(u)).sin_cos();
            let p = unit_circle(u).as_dvec2();
            assert!((p.x - cos).abs() < 2e-7 && (p.y - sin).abs() < 2e-7, "{u}: {p}");
        }
    }

    /// The concentric map, written down as in the paper.
    #[test]
    fn disk_is_the_concentric_map() {
        for (x, y) in (0..=64).flat_map(|x| (0..=64).map(move |y| (x, y))) {
            let u = Vec2::new(x as f32, y as f32) / 64.0;
            let v = 2.0 * u.as_dvec2() - 1.0;
            let (r, angle) = if v.x.abs() > v.y.abs() {
                (v.x, FRAC_PI_4 * v.y / v.x)
            } else if v.y != 0.0 {
                (v.y, 2.0 * FRAC_PI_4 - FRAC_PI_4 * v.x / v.y)
            } else {
                (0.0, 0.0)
            };
            let expected = r * glam::DVec2::from_angle(angle);
            assert!(square_to_disk(u).as_dvec2().distance(expected) < 2e-7, "{u}");
        }
    }
}
