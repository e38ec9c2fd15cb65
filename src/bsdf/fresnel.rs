use crate::math::{Rgb, Vec3};

/// What a smooth interface between two dielectrics does with a ray, all in the local frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refraction {
    /// Direction of the transmitted ray, unit, on the other side than `wo`.
    pub wi: Vec3,
    /// Relative index of refraction: transmitted side over incident side.
    pub eta: f32,
}

/// The mirror direction of `wo` about the local z axis.
pub(super) fn reflect(wo: Vec3) -> Vec3 {
    Vec3::new(-wo.x, -wo.y, wo.z)
}

/// Refracts by Snell's law: `sin θ_t = sin θ_i / eta`. `None` is total internal reflection.
///
/// `ior` is the index below the surface (z < 0) over that above; the side of `wo` tells which one the ray is in.
///
/// ```
/// use caustica::{bsdf::refract, math::Vec3};
/// let straight = refract(Vec3::Z, 1.5).map(|r| r.wi);
/// assert_eq!(straight, Some(Vec3::NEG_Z));
/// assert_eq!(refract(Vec3::new(0.8, 0.0, -0.6), 1.5), None);
/// ```
pub fn refract(wo: Vec3, ior: f32) -> Option<Refraction> {
    let eta = if wo.z > 0.0 { ior } else { ior.recip() };
    let z = -cos_transmitted(wo.z, eta)?.copysign(wo.z);
    let wi = Vec3::new(-wo.x / eta, -wo.y / eta, z).normalize();
    Some(Refraction { wi, eta })
}

/// The cosine of the transmitted angle by Snell's law, from that of the incident one; `None` under total internal reflection.
pub(super) fn cos_transmitted(cos: f32, eta: f32) -> Option<f32> {
    let cos2 = 1.0 - (1.0 - cos * cos).max(0.0) / (eta * eta);
    // Where eta² is too small for a number, 0/0 is total internal reflection as well.
    (cos2 > 0.0).then(|| cos2.sqrt())
}

/// The share of unpolarised light that a smooth interface reflects.
///
/// `R = ((eta cos_i - cos_t) / (eta cos_i + cos_t))² / 2 + ((cos_i - eta cos_t) / (cos_i + eta cos_t))² / 2`
///
/// `cos_i` and `cos_t` are the cosines of the incident and the transmitted angle, both in `[0, 1]`; `eta` is the
/// index on the transmitted side over that on the incident side. At a grazing `cos_i = 0` the result is 1.
///
/// # Source
/// Born and Wolf, "Principles of Optics", section 1.5.2.
pub fn fresnel_reflectance(cos_i: f32, cos_t: f32, eta: f32) -> f32 {
    let parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    let perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    (0.5 * (parallel * parallel + perpendicular * perpendicular)).min(1.0)
}

/// The share of unpolarised light that a metal reflects, channel by channel.
///
/// With `c = cos θ`, `s² = 1 - c²`, `2a² = √((η² - k² - s²)² + 4 η² k²) + η² - k² - s²` and `a² + b² = √(...)`:
///
/// ```text
/// R_s = (a² + b² - 2ac + c²) / (a² + b² + 2ac + c²)
/// R_p = R_s (c² (a² + b²) - 2acs² + s⁴) / (c² (a² + b²) + 2acs² + s⁴)
/// R   = (R_s + R_p) / 2
/// ```
/// `eta - i k` is the index of the metal over that of what lies on it. At a grazing `cos = 0` the result is 1.
///
/// # Source
/// Born and Wolf, "Principles of Optics", section 14.4.
pub(super) fn conductor_reflectance(cos: f32, eta: Rgb, k: Rgb) -> Rgb {
    let (cos2, sin2) = (cos * cos, (1.0 - cos * cos).max(0.0));
    let difference = eta * eta - k * k - sin2;
    let both = (difference * difference + 4.0 * eta * eta * k * k).map(f32::sqrt);
    let a = (0.5 * (both + difference)).max(Rgb::ZERO).map(f32::sqrt);
    let (even, odd) = (both + cos2, 2.0 * cos * a);
    let perpendicular = (even - odd) / (even + odd);
    let (even, odd) = (cos2 * both + sin2 * sin2, odd * sin2);
    let parallel = perpendicular * (even - odd) / (even + odd);
    (0.5 * (perpendicular + parallel)).clamp(Rgb::ZERO, Rgb::ONE)
}

/// The shares that a thin, flat pane mirrors and lets through, with all that goes to and fro inside of it: `2 R / (1 + R)`.
///
/// `ior` is the index of the pane over that of what lies on both of its sides.
pub fn pane_reflectance(cos: f32, ior: f32) -> f32 {
    let wo = Vec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos.abs());
    let Some(refraction) = refract(wo, ior) else { return 1.0 };
    let once = fresnel_reflectance(wo.z, refraction.wi.z.abs(), refraction.eta);
    2.0 * once / (1.0 + once)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn normal_incidence_on_glass_reflects_four_percent() {
        assert!((fresnel_reflectance(1.0, 1.0, 1.5) - 0.04).abs() < 1e-7);
    }

    #[test]
    fn brewster_angle_lets_half_of_the_perpendicular_share_through() {
        let eta = 1.5f32;
        let cos_i = (1.0 / (1.0 + eta * eta)).sqrt();
        let cos_t = eta * cos_i;
        let perpendicular = ((eta * eta - 1.0) / (eta * eta + 1.0)).powi(2);
        assert!((fresnel_reflectance(cos_i, cos_t, eta) - 0.5 * perpendicular).abs() < 1e-6);
    }

    #[test]
    fn grazing_light_is_reflected_whole() {
        for cos_i in [0.0, 1e-30, 1e-6] {
            let wo = Vec3::new((1.0f32 - cos_i * cos_i).sqrt(), 0.0, cos_i);
            let cos_t = refract(wo, 1.5).map_or(0.0, |r| -r.wi.z);
            assert!((fresnel_reflectance(cos_i, cos_t, 1.5) - 1.0).abs() < 1e-4);
        }
    }

    proptest! {
        #[test]
        fn refraction_obeys_snell_and_can_be_reversed(x in -0.99f32..0.99, up: bool, ior in 0.4f32..3.0) {
            let z = (1.0 - x * x).sqrt();
            let wo = Vec3::new(x, 0.0, if up { z } else { -z });
            if let Some(r) = refract(wo, ior) {
                prop_assert!((r.wi.length() - 1.0).abs() < 1e-5);
                prop_assert!((wo.x + r.eta * r.wi.x).abs() < 1e-5);
                prop_assert!(r.wi.z * wo.z < 0.0);
                prop_assume!(r.wi.z.abs() > 0.05);
                let back = refract(r.wi, ior).unwrap();
                prop_assert!((back.wi - wo).length() < 1e-3);
                prop_assert!((fresnel_reflectance(z, r.wi.z.abs(), r.eta)
                    - fresnel_reflectance(r.wi.z.abs(), z, 1.0 / r.eta)).abs() < 1e-5);
            } else {
                let eta = if up { ior } else { 1.0 / ior };
                prop_assert!(x.abs() >= eta * 0.9999);
            }
        }
    }

    /// Against complex arithmetic, and a dielectric where `k` is 0. Catches a swapped polarisation or a lost square.
    #[test]
    fn a_metal_reflects_as_its_complex_index_says() {
        for cos in [0.01f64, 0.2, 0.5, 0.8, 1.0] {
            for (eta, k) in [(0.2, 3.9), (1.4, 1.6), (1.5, 0.0), (0.15, 0.01)] {
                let expected = complex_reflectance(cos, eta, k);
                let found = conductor_reflectance(cos as f32, Rgb::splat(eta as f32), Rgb::splat(k as f32)).y;
                assert!(
                    (f64::from(found) - expected).abs() < 1e-5,
                    "{cos} {eta} {k}: {found}, not {expected}"
                );
            }
        }
        assert_eq!(conductor_reflectance(0.0, Rgb::splat(0.2), Rgb::splat(3.9)), Rgb::ONE);
    }

    /// `|r_s|²` and `|r_p|²` from Fresnel's equations with `n = eta - i k`.
    fn complex_reflectance(cos: f64, eta: f64, k: f64) -> f64 {
        type Complex = (f64, f64);
        let times = |a: Complex, b: Complex| (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0);
        let ratio = |a: Complex, b: Complex| (a.0 * a.0 + a.1 * a.1) / (b.0 * b.0 + b.1 * b.1);
        let n2 = times((eta, -k), (eta, -k));
        let inside = (n2.0 - (1.0 - cos * cos), n2.1);
        let length = inside.0.hypot(inside.1).sqrt();
        let half = 0.5 * inside.1.atan2(inside.0);
        let root = (length * half.cos(), length * half.sin());
        let perpendicular = ratio((cos - root.0, -root.1), (cos + root.0, root.1));
        let (x, y) = ((n2.0 * cos, n2.1 * cos), root);
        0.5 * (perpendicular + ratio((x.0 - y.0, x.1 - y.1), (x.0 + y.0, x.1 + y.1)))
    }

    /// The geometric series of what goes to and fro: `R + T² R (1 + R² + R⁴ + ...)`.
    #[test]
    fn a_pane_mirrors_what_leaves_it_after_any_number_of_turns() {
        for cos in [0.1f32, 0.5, 1.0] {
            let inside = refract(Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos), 1.5).unwrap();
            let r = f64::from(fresnel_reflectance(cos, -inside.wi.z, 1.5));
            let turns: f64 = (0..60).map(|n| (1.0 - r).powi(2) * r.powi(2 * n + 1)).sum();
            assert!((f64::from(pane_reflectance(cos, 1.5)) - r - turns).abs() < 1e-6);
        }
    }

    /// In vectors, without a frame: `wi = -wo / eta + (cos_i / eta - cos_t) n`, with `n` on the side of `wo`.
    #[test]
    fn refraction_out_of_the_x_z_plane_follows_its_vector_form() {
        for (wo, ior) in [
            (Vec3::new(0.48, -0.36, 0.8), 1.5),
            (Vec3::new(-0.24, 0.32, -0.916_515_1), 1.5),
            (Vec3::new(0.36, 0.48, 0.8), 0.9),
        ] {
            let n = Vec3::Z * wo.z.signum();
            let eta = if wo.z > 0.0 { ior } else { 1.0 / ior };
            let cos_t = (1.0 - (1.0 - wo.z * wo.z) / (eta * eta)).sqrt();
            let expected = -wo / eta + (wo.dot(n) / eta - cos_t) * n;
            let found = refract(wo, ior).unwrap();
            assert_eq!(found.eta, eta);
            assert!((found.wi - expected).length() < 1e-6, "{wo}, {ior}: {}, not {expected}", found.wi);
        }
    }
}
