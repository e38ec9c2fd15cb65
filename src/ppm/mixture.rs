//! Natural and aimed photons in one pass.

use serde::Serialize;

use super::draws::Draws;
use super::emission::LightRay;
use crate::light::{Aim, Lights};

/// How many photons of a pass leave the lights naturally, and how many are aimed at casters of caustics.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct PhotonBudget {
    /// `N_g`: drawn in proportion to the emitted flux. All flux is normalised by their number.
    pub natural: u64,
    /// `N_a`: drawn into the cones to the casters. They bring caustics alone.
    pub aimed: u64,
}

impl PhotonBudget {
    /// `photons` in all, of which `aimed` are, but one at most is left.
    pub fn of(photons: u64, aimed: u64) -> PhotonBudget {
        let aimed = aimed.min(photons.saturating_sub(1));
        PhotonBudget { natural: photons - aimed, aimed }
    }

    /// `ρ = N_a / N_g`.
    fn rho(&self) -> f64 {
        self.aimed as f64 / self.natural.max(1) as f64
    }
}

/// Both kinds of photons, mixed by the balance heuristic: a caustic photon of either kind carries `Φ / (1 + ρ r)`, with `r` the
/// ratio of its densities. Since that depends on how the photon starts alone, all else about it stays as it is.
///
/// # Source
/// Veach and Guibas, "Optimally Combining Sampling Techniques for Monte Carlo Rendering", SIGGRAPH 1995, section 3.3.
#[derive(Clone, Debug)]
pub struct Mixture {
    /// Where aimed photons go.
    pub aim: Aim,
    /// How many there are of each kind.
    pub budget: PhotonBudget,
}

impl Mixture {
    /// `1 / (1 + ρ r)`.
    pub(super) fn weight(&self, ratio: f64) -> f32 {
        (1.0 / (1.0 + self.budget.rho() * ratio)) as f32
    }

    /// `r` of a natural photon, whose start is drawn once more: nothing has to remember it.
    pub(super) fn ratio_of(&self, lights: &Lights, emission: Draws, path: u32) -> f64 {
        let start = lights.sample_numbered_emission(&mut emission.of(path));
        start.map_or(0.0, |(light, start)| self.aim.ratio(light, start.origin, start.dir))
    }

    /// `r` of a photon that starts like this.
    pub(super) fn ratio_along(&self, start: Option<LightRay>) -> f64 {
        start.map_or(0.0, |(light, origin, dir)| self.aim.ratio(light, origin, dir))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::Light;
    use crate::math::{BoundingSphere, Rgb, Vec3};

    #[test]
    fn one_natural_photon_is_left() {
        assert_eq!(PhotonBudget::of(100, 25), PhotonBudget { natural: 75, aimed: 25 });
        assert_eq!(PhotonBudget::of(100, 1000), PhotonBudget { natural: 1, aimed: 99 });
        assert_eq!(PhotonBudget::of(0, 5), PhotonBudget { natural: 0, aimed: 0 });
        assert_eq!(PhotonBudget::of(80, 20).rho() * 3.0, 1.0);
    }

    /// A start that natural photons find with density `p` and aimed ones with `r p` is found by `N_g p (1 + ρ r)` in all: whatever
    /// brings it, the weights of all that do sum to `N_g`.
    #[test]
    fn weights_share_a_start_among_both_kinds() {
        let lamp = Light::Point { position: Vec3::ZERO, intensity: Rgb::ONE };
        let ball = BoundingSphere { center: 3.0 * Vec3::Y, radius: 1.0 };
        let aim = Aim::new(&Lights::new([lamp]), &[ball]).unwrap();
        for (photons, aimed) in [(100, 25), (100, 75), (100, 0)] {
            let budget = PhotonBudget::of(photons, aimed);
            let mixture = Mixture { aim: aim.clone(), budget };
            for ratio in [0.0, 0.5, 40.0] {
                let found = budget.natural as f64 + budget.aimed as f64 * ratio;
                let sum = found * f64::from(mixture.weight(ratio));
                assert!((sum / budget.natural as f64 - 1.0).abs() < 1e-6, "{photons} {aimed} {ratio}: {sum}");
            }
        }
    }
}
