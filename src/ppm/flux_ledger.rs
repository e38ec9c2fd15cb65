use serde::{Serialize, Serializer};

use crate::math::{DVec3, Rgb};

/// Where the flux of the photons of a pass went (W, channel by channel, not yet divided by the number emitted).
///
/// A surface absorbs what none of its lobes sends on, whatever roulette decides; what roulette sends on beyond that is its
/// gain. So `emitted + roulette + shading = absorbed + escaped + terminated + dropped` holds to the rounding of the sums,
/// and `roulette` is noise around zero, of which `roulette_variance` tells how large it may be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct FluxLedger {
    /// What left the lights.
    #[serde(serialize_with = "as_array")]
    pub emitted: DVec3,
    /// What surfaces took: of all that reached them, the share that they have no lobe for; and what media took on the way.
    #[serde(serialize_with = "as_array")]
    pub absorbed: DVec3,
    /// What left the scene.
    #[serde(serialize_with = "as_array")]
    pub escaped: DVec3,
    /// What was on its way at the longest allowed path.
    #[serde(serialize_with = "as_array")]
    pub terminated: DVec3,
    /// What photons carried before their power became no finite number.
    #[serde(serialize_with = "as_array")]
    pub dropped: DVec3,
    /// What flew on from surfaces, less the share that their lobes send on: 0 in expectation.
    #[serde(serialize_with = "as_array")]
    pub roulette: DVec3,
    /// What corrections for shading normals added; negative where they took.
    #[serde(serialize_with = "as_array")]
    pub shading: DVec3,
    /// No less than the variance of `roulette`, all channels together (W²).
    pub roulette_variance: f64,
}

fn as_array<S: Serializer>(flux: &DVec3, serializer: S) -> Result<S::Ok, S::Error> {
    flux.to_array().serialize(serializer)
}

// Numbers of f32 are summed in f64, mostly without rounding: the accounts agree however many there are.
impl FluxLedger {
    /// How far the sums may be apart, of the flux emitted.
    const TOLERANCE: f64 = 1e-12;
    /// How many standard deviations of roulette are chance.
    const CHANCE: f64 = 6.0;

    /// The sum of two ledgers.
    pub fn plus(self, other: FluxLedger) -> FluxLedger {
        FluxLedger {
            emitted: self.emitted + other.emitted,
            absorbed: self.absorbed + other.absorbed,
            escaped: self.escaped + other.escaped,
            terminated: self.terminated + other.terminated,
            dropped: self.dropped + other.dropped,
            roulette: self.roulette + other.roulette,
            shading: self.shading + other.shading,
            roulette_variance: self.roulette_variance + other.roulette_variance,
        }
    }

    /// What no account explains, of the flux emitted: the rounding of the sums, about 1e-16.
    pub fn imbalance(&self) -> f64 {
        let came = self.emitted + self.roulette + self.shading;
        let went = self.absorbed + self.escaped + self.terminated + self.dropped;
        let lost = (came - went).abs().max_element();
        if lost == 0.0 { 0.0 } else { lost / self.emitted.max_element() }
    }

    /// Whether all flux of `photons` emitted is accounted for to 1e-12, and roulette gained no more than by chance.
    ///
    /// By chance are six standard deviations, and a dozen photons beside that, as Bernstein's inequality has it where they
    /// are few.
    pub fn is_balanced(&self, photons: u64) -> bool {
        let largest_photon = self.emitted.element_sum() / photons.max(1) as f64;
        let chance = Self::CHANCE * self.roulette_variance.sqrt() + 2.0 * Self::CHANCE * largest_photon;
        self.imbalance() <= Self::TOLERANCE && self.roulette.abs().max_element() <= chance
    }

    /// Books what flies on from surfaces.
    pub(super) fn fly_on(&mut self, power: DVec3) {
        self.roulette += power;
    }

    /// Books what reached surfaces, and the share of it that their lobes send on.
    pub(super) fn land(&mut self, power: DVec3, sent_on: DVec3) {
        self.absorbed += power - sent_on;
        self.roulette -= sent_on;
    }

    /// Books what a medium takes of a photon on its way.
    pub(super) fn absorb(&mut self, power: DVec3) {
        self.absorbed += power;
    }

    /// Books a photon that goes straight on and counts as landed on a surface of this diffuse share: nothing is absorbed, and what flies
    /// on is no gain of roulette.
    pub(super) fn pass(&mut self, power: Rgb, albedo: Rgb) {
        self.land(DVec3::ZERO, power.as_dvec3() - (power * albedo).as_dvec3());
    }

    /// Books what the specular lobes of a surface send on beside the diffuse one of a photon that landed.
    pub(super) fn send_on(&mut self, power: Rgb, share: Rgb) {
        let sent_on = (power * share).as_dvec3();
        if sent_on.is_finite() {
            self.land(DVec3::ZERO, sent_on);
            self.roulette_variance += 2.0 * power.as_dvec3().dot(sent_on);
        }
    }

    /// Books what a correction adds to a photon.
    pub(super) fn correct(&mut self, gain: Rgb) {
        let gain = gain.as_dvec3();
        if gain.is_finite() {
            self.shading += gain;
            self.roulette -= gain;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PHOTONS: u64 = 10_000;

    /// Grey photons of one watt that meet a surface of albedo .5, half of which survive with `kept` watts, fly on and leave.
    fn after_a_bounce(kept: f64) -> FluxLedger {
        let all = DVec3::splat(PHOTONS as f64);
        let mut ledger = FluxLedger { emitted: all, roulette_variance: all.x, ..FluxLedger::default() };
        ledger.land(all, 0.5 * all);
        let onward = kept * 0.5 * all;
        ledger.fly_on(onward);
        ledger.escaped += onward;
        ledger
    }

    #[test]
    fn power_that_flies_on_as_expected_is_balanced() {
        let ledger = after_a_bounce(1.0);
        assert_eq!((ledger.absorbed.x, ledger.escaped.x, ledger.roulette.x), (5000.0, 5000.0, 0.0));
        assert!(ledger.imbalance() == 0.0 && ledger.is_balanced(PHOTONS));
    }

    #[test]
    fn bounces_that_forget_or_double_power_are_found() {
        for kept in [0.5, 0.8, 1.2, 2.0] {
            let ledger = after_a_bounce(kept);
            assert!(ledger.imbalance() < 1e-15 && !ledger.is_balanced(PHOTONS), "{kept}: {ledger:?}");
        }
    }

    #[test]
    fn a_photon_that_is_lost_on_its_way_is_found() {
        for lost in [1.0, 1e-7] {
            let mut ledger = after_a_bounce(1.0);
            ledger.escaped.y -= lost;
            assert!((ledger.imbalance() * PHOTONS as f64 / lost - 1.0).abs() < 1e-4);
            assert!(!ledger.is_balanced(PHOTONS));
        }
    }

    #[test]
    fn corrections_are_no_gain_of_roulette() {
        let mut ledger = after_a_bounce(1.0);
        ledger.correct(Rgb::splat(1000.0));
        ledger.fly_on(DVec3::splat(1000.0));
        ledger.escaped += 1000.0;
        ledger.correct(Rgb::splat(f32::NAN));
        assert!(ledger.is_balanced(PHOTONS) && ledger.shading.x == 1000.0, "{ledger:?}");
    }

    #[test]
    fn nothing_emitted_is_balanced() {
        assert!(FluxLedger::default().is_balanced(0));
        let json = serde_json::to_string(&FluxLedger::default()).unwrap();
        assert!(json.starts_with(r#"{"emitted":[0.0,0.0,0.0],"#), "{json}");
    }

    #[test]
    fn accounts_of_two_are_added_one_by_one() {
        let ledger = |x: f64| FluxLedger {
            emitted: DVec3::splat(x),
            absorbed: DVec3::splat(2.0 * x),
            escaped: DVec3::splat(3.0 * x),
            terminated: DVec3::splat(4.0 * x),
            dropped: DVec3::splat(5.0 * x),
            roulette: DVec3::splat(6.0 * x),
            shading: DVec3::splat(7.0 * x),
            roulette_variance: 8.0 * x,
        };
        assert_eq!(ledger(1.0).plus(ledger(2.0)), ledger(3.0));
    }

    /// A mask that a photon passes takes nothing of it, and a medium what it takes.
    #[test]
    fn what_passes_a_mask_or_a_medium_is_balanced() {
        let power = Rgb::new(4.0, 2.0, 1.0);
        let all = power.as_dvec3();
        let mut ledger = FluxLedger { emitted: all, ..FluxLedger::default() };
        let albedo = Rgb::splat(0.25);
        ledger.land(all, (power * albedo).as_dvec3());
        ledger.pass(power, albedo);
        ledger.fly_on(all);
        ledger.absorb(0.5 * all);
        ledger.escaped += 0.5 * all;
        assert_eq!((ledger.absorbed, ledger.roulette), (0.5 * all, DVec3::ZERO));
        assert!(ledger.imbalance() < 1e-15, "{ledger:?}");
    }
}
