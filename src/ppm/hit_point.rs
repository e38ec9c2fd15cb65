use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use crate::math::{DVec3, Rgb};
use crate::scene::Receiver;

/// A point where light is to be known, found once by an eye path and fixed for the whole render.
#[derive(Clone, Copy, Debug)]
pub struct HitPoint {
    /// The point with its geometric and shading normal.
    pub receiver: Receiver,
    /// The factor from the irradiance here to the radiance of the pixel, `weight · albedo / π`: the weight is 1 / samples, times those
    /// along the specular chain.
    pub reflectance: Rgb,
    /// Number of the pixel, row by row from the top left.
    pub pixel: u32,
    /// The width of a pixel at the length of the eye path, in scene units.
    pub footprint: f32,
}

/// What one pass brought to a hit point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PassSum {
    /// Unnormalised flux `Φ_M` of the accepted photons (W).
    pub flux: DVec3,
    /// Accepted photons `M`.
    pub accepted: u32,
}

/// The progressive statistics of a hit point: radius `R`, photon count `N` and flux `τ`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GatherState {
    /// `R²`.
    pub radius2: f64,
    /// `N`: the photons gathered so far, as many as the shrunken radius would have found.
    pub photons: f64,
    /// `τ`: their unnormalised flux (W), BRDF not included.
    pub flux: DVec3,
}

impl GatherState {
    /// A hit point that has seen no photon.
    ///
    /// ```
    /// use caustica::ppm::GatherState;
    /// assert_eq!(GatherState::new(0.5).radius(), 0.5);
    /// ```
    pub fn new(radius: f64) -> GatherState {
        GatherState { radius2: radius * radius, photons: 0.0, flux: DVec3::ZERO }
    }

    /// `R`, in scene units.
    pub fn radius(&self) -> f64 {
        self.radius2.sqrt()
    }

    /// Closes a pass: keeps the share `alpha` of the new photons and shrinks the radius to match.
    ///
    /// `R'² = R² (N + αM) / (N + M)`, `τ' = (τ + Φ_M) R'² / R²`, `N' = N + αM`. Without a photon (`M = 0`)
    /// everything stays as it is.
    ///
    /// # Source
    /// Hachisuka, Ogaki and Jensen, "Progressive Photon Mapping", SIGGRAPH Asia 2008, equations 7 to 12.
    pub fn after_pass(&mut self, pass: &PassSum, alpha: f64) {
        let PassSum { flux, accepted } = *pass;
        if accepted == 0 {
            return;
        }
        let m = f64::from(accepted);
        let kept = self.photons + alpha * m;
        let shrink = kept / (self.photons + m);
        self.radius2 *= shrink;
        self.flux = (self.flux + flux) * shrink;
        self.photons = kept;
    }

    /// Scales `R²` by `ratio`, and with it the count and the flux: `τ / R²` stays.
    pub fn shrink(&mut self, ratio: f64) {
        self.radius2 *= ratio;
        self.flux *= ratio;
        self.photons *= ratio;
    }

    /// The irradiance estimate `τ / (π R² N_emitted)` (W/m²); zero before the first photon was emitted.
    pub fn irradiance(&self, emitted: u64) -> DVec3 {
        if emitted == 0 { DVec3::ZERO } else { self.flux / (PI * self.radius2 * emitted as f64) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// `accepted` photons of the same flux.
    fn sum(accepted: u32, flux: f64) -> PassSum {
        PassSum { flux: DVec3::splat(f64::from(accepted) * flux), accepted }
    }

    /// The radii that the assignment's scene must show when every pass brings the same count.
    #[test]
    fn radius_follows_the_closed_form() {
        let mut state = GatherState::new(0.5);
        let mut radii = Vec::new();
        for _ in 0..1000 {
            state.after_pass(&sum(2, 1.0), 0.7);
            radii.push(state.radius());
        }
        for (pass, radius) in [(1, 0.4183), (2, 0.3796), (10, 0.2831), (100, 0.1752), (1000, 0.1071)] {
            assert!((radii[pass - 1] - radius).abs() < 5e-5, "pass {pass}: {}", radii[pass - 1]);
        }
    }

    /// Catches 0/0 and a radius that shrinks for nothing.
    #[test]
    fn pass_without_an_accepted_photon_changes_nothing() {
        let mut state = GatherState::new(2.0);
        state.after_pass(&sum(1, 1.0), 0.7);
        let before = state;
        state.after_pass(&PassSum::default(), 0.7);
        assert_eq!(state, before);
    }

    /// Uniform flux density must be estimated alike at any radius: shrinking keeps `τ / R²`.
    #[test]
    fn estimate_of_uniform_light_does_not_depend_on_alpha() {
        for alpha in [0.1, 0.5, 0.7, 1.0] {
            let mut state = GatherState::new(1.0);
            for pass in 0..200u64 {
                let expected = 50.0 * state.radius2;
                state.after_pass(&sum(expected.round() as u32, expected / expected.round()), alpha);
                let density = state.irradiance(pass + 1).x * PI;
                assert!((density / 50.0 - 1.0).abs() < 1e-5, "alpha {alpha}: {density}");
                if expected < 2.0 {
                    break;
                }
            }
        }
    }

    proptest! {
        #[test]
        fn radius_never_grows_and_flux_stays_finite(counts in prop::collection::vec(0u32..50, 1..40), alpha in 0.01f64..1.0) {
            let mut state = GatherState::new(1.0);
            for m in counts {
                let before = state.radius2;
                state.after_pass(&sum(m, 0.3), alpha);
                prop_assert!(state.radius2 <= before && state.radius2 > 0.0 && state.flux.is_finite());
            }
        }
    }
}
