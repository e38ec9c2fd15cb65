use super::fresnel::{fresnel_reflectance, refract};
use crate::math::{Rgb, Vec3};

/// What lies on a diffuse base: a smooth, clear coat, or nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coat {
    /// Its index of refraction over that of what lies above it; 1 where there is none.
    ior: f32,
}

impl Coat {
    /// No coat: all light reaches the base.
    pub const NONE: Coat = Coat { ior: 1.0 };

    /// The share `1 - F` of light that passes it, with the cosine of the angle above it; on either side, since light that leaves
    /// goes the way of light that enters.
    pub fn transmittance(self, cos: f32) -> f32 {
        if self == Coat::NONE {
            return 1.0;
        }
        let wo = Vec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos.abs());
        refract(wo, self.ior)
            .map_or(0.0, |inside| 1.0 - fresnel_reflectance(wo.z, inside.wi.z.abs(), inside.eta))
    }

    /// The share of diffuse light that passes it from above: `2 ∫ (1 - F) cos θ d cos θ`, by the midpoint rule over `cos² θ`.
    fn diffuse_transmittance(self) -> f64 {
        const STEPS: u32 = 4096;
        let at =
            |k: u32| f64::from(self.transmittance(((f64::from(k) + 0.5) / f64::from(STEPS)).sqrt() as f32));
        (0..STEPS).map(at).sum::<f64>() / f64::from(STEPS)
    }
}

/// A diffuse base under a smooth, clear coat.
///
/// ```text
/// f = base / π · T(wo) T(wi) / (ior² (1 - r · R_inside))      T = 1 - F
/// ```
/// beside the mirror reflection `F` of the coat. `R_inside = 1 - T_outside / ior²` is the share of diffuse light that the coat sends
/// back down to the base; `r` is the base's colour where the loss of colour at every turn is to show (`nonlinear`), else 1.
///
/// # Source
/// Weidlich and Wilkie, "Arbitrarily Layered Micro-Facet Surfaces", GRAPHITE 2007; the form is that of Mitsuba's `plastic`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plastic {
    /// Colour of the base.
    pub base: Rgb,
    /// Index of refraction of the coat, above 1.
    pub ior: f32,
    /// Whether colour deepens as light goes to and fro under the coat.
    pub nonlinear: bool,
    /// `base / (ior² (1 - r R_inside))`.
    under_coat: Rgb,
    /// `T_outside`: of diffuse light.
    enters: f32,
}

impl Plastic {
    /// A base of this colour under a coat.
    pub fn new(base: Rgb, ior: f32, nonlinear: bool) -> Plastic {
        let enters = Coat { ior }.diffuse_transmittance();
        let bare = Plastic { base, ior, nonlinear, under_coat: Rgb::ZERO, enters: enters as f32 };
        bare.with_base(base)
    }

    /// The same coat on a base of another colour.
    #[must_use]
    pub(super) fn with_base(&self, base: Rgb) -> Plastic {
        let ior2 = self.ior * self.ior;
        let inside = 1.0 - self.enters / ior2;
        let returned = if self.nonlinear { base * inside } else { Rgb::splat(inside) };
        Plastic { base, under_coat: base / (ior2 * (Rgb::ONE - returned)), ..*self }
    }

    /// The coat.
    pub fn coat(&self) -> Coat {
        Coat { ior: self.ior }
    }

    /// `π f / T(wi)`, seen at an angle of the cosine `cos`.
    pub fn albedo(&self, cos: f32) -> Rgb {
        self.under_coat * self.coat().transmittance(cos)
    }

    /// The mean of `T(wi)` over cosine-weighted directions: what turns [`Plastic::albedo`] into a share of the incident power.
    pub fn enters(&self) -> f32 {
        self.enters
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A base that loses nothing sends all light back: in a white furnace what is mirrored and what is scattered sum to 1.
    #[test]
    fn a_white_base_loses_nothing() {
        for ior in [1.1, 1.5, 2.4] {
            let plastic = Plastic::new(Rgb::ONE, ior, false);
            for cos in [0.1, 0.5, 1.0] {
                let scattered = plastic.albedo(cos).x * plastic.enters();
                let mirrored = 1.0 - plastic.coat().transmittance(cos);
                assert!((scattered + mirrored - 1.0).abs() < 1e-4, "{ior} {cos}: {scattered} and {mirrored}");
            }
        }
    }

    /// Every turn under the coat takes the base's colour once more: the series in closed form.
    #[test]
    fn turns_under_the_coat_deepen_the_colour() {
        let base = Rgb::new(0.9, 0.5, 0.1);
        let plastic = Plastic::new(base, 1.5, true);
        let enters = Coat { ior: 1.5 }.diffuse_transmittance();
        let (leaves, inside) = (enters / 2.25, 1.0 - enters / 2.25);
        for channel in 0..3 {
            let r = f64::from(base[channel]);
            let series: f64 = (0..400).map(|n| r * (r * inside).powi(n) * leaves).sum();
            let share = f64::from(plastic.under_coat[channel] * plastic.enters());
            assert!((share - series).abs() < 1e-5, "{channel}: {share}, not {series}");
        }
    }

    #[test]
    fn without_a_coat_all_light_passes() {
        assert_eq!([0.01, 1.0].map(|cos| Coat::NONE.transmittance(cos)), [1.0; 2]);
    }

    /// The integral of Fresnel's reflectance over all directions in closed form, which colours of the base alone do not show.
    ///
    /// # Source
    /// Walsh, "The Reflection Factor of a Polished Glass Surface for Diffused Light", Department of Scientific and Industrial Research, 1926.
    #[test]
    fn diffuse_light_enters_as_its_closed_form_says() {
        for ior in [1.1f64, 1.5, 2.4] {
            let (n2, n4) = (ior * ior, ior.powi(4));
            let reflected = 0.5
                + (ior - 1.0) * (3.0 * ior + 1.0) / (6.0 * (ior + 1.0).powi(2))
                + n2 * (n2 - 1.0).powi(2) / (n2 + 1.0).powi(3) * ((ior - 1.0) / (ior + 1.0)).ln()
                - 2.0 * ior * n2 * (n2 + 2.0 * ior - 1.0) / ((n2 + 1.0) * (n4 - 1.0))
                + 8.0 * n4 * (n4 + 1.0) / ((n2 + 1.0) * (n4 - 1.0).powi(2)) * ior.ln();
            let enters = f64::from(Plastic::new(Rgb::ONE, ior as f32, true).enters());
            assert!((enters - (1.0 - reflected)).abs() < 1e-5, "{ior}: {enters}, not {}", 1.0 - reflected);
        }
    }
}
