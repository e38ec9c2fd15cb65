use serde::{Deserialize, Serialize};

use super::{GatherState, PassSum};

/// The parts of a disc: four quadrants of the inner half of its area, and four of the outer.
pub(super) const PARTS: usize = 8;

/// χ² with `PARTS - 1` degrees of freedom, above which even light comes once in a hundred tests.
///
/// # Source
/// NIST/SEMATECH e-Handbook of Statistical Methods, section 1.3.6.7.4.
const CRITICAL: f64 = 18.475;

/// Photons of the first test: four a part, few enough to notice early, enough for the distribution to hold.
const FIRST_TEST: f64 = 32.0;

/// What a pass brought to the parts of a hit point's disc.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct PartSums {
    /// Flux of each part (W, mean of the channels).
    pub(super) flux: [f64; PARTS],
    /// Sum of the squares of all photons' fluxes (W²).
    pub(super) squares: f64,
}

/// A hit point that shrinks its disc only where light is found to fall unevenly on it.
///
/// Under even light, the flux `F_k` of each of the `K` parts of equal area has the variance `Σ Φ² / K`, so
/// `Σ_k (F_k - F/K)² / (Σ Φ² / K)` follows χ² with `K - 1` degrees of freedom. Tests come when the photons have doubled, so that
/// there are few of them, each sharper than the one before. One that fails shrinks `R²` by `α` and begins anew.
///
/// # Source
/// Lin, Li, Zeng, Zhang, Jia, Wang and Yan, "CPPM: Chi-Squared Progressive Photon Mapping", ACM Transactions on Graphics 39(6),
/// 2020, for the test; parts, schedule of tests and shrinking are this project's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct TestedState {
    pub(super) state: GatherState,
    parts: PartSums,
    /// Photons since the disc last shrank.
    seen: f64,
    /// The number of them at which it is tested.
    next_test: f64,
}

impl TestedState {
    pub(super) fn new(radius: f64) -> TestedState {
        let state = GatherState::new(radius);
        TestedState { state, parts: PartSums::default(), seen: 0.0, next_test: FIRST_TEST }
    }

    /// Closes a pass: adds its photons, and shrinks the radius if they lie unevenly.
    pub(super) fn after_pass(&mut self, pass: &PassSum, parts: &PartSums, alpha: f64) {
        self.state.after_pass(pass, 1.0);
        self.parts.add(parts);
        self.seen += f64::from(pass.accepted);
        if self.seen < self.next_test {
            return;
        }
        self.next_test = 2.0 * self.seen;
        if self.parts.chi_squared() > CRITICAL {
            self.state.shrink(alpha);
            *self = TestedState { state: self.state, ..TestedState::new(0.0) };
        }
    }
}

impl PartSums {
    fn add(&mut self, other: &PartSums) {
        self.add_times(1.0, other);
    }

    /// Adds photons of `factor` times as much flux.
    pub(super) fn add_times(&mut self, factor: f64, other: &PartSums) {
        for (sum, flux) in self.flux.iter_mut().zip(other.flux) {
            *sum += factor * flux;
        }
        self.squares += factor * factor * other.squares;
    }

    fn chi_squared(&self) -> f64 {
        let k = PARTS as f64;
        let mean = self.flux.iter().sum::<f64>() / k;
        self.flux.iter().map(|flux| (flux - mean).powi(2)).sum::<f64>() * k / self.squares
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{DVec3, Rng, Stream};

    /// Passes of four photons of unequal power, each in the part that `part` draws.
    fn after(photons: u32, seed: u64, alpha: f64, part: impl Fn(&mut Rng) -> usize) -> GatherState {
        let (mut rng, mut tested) = (Rng::new(seed, Stream::Test, 0, 0), TestedState::new(1.0));
        for _ in 0..photons / 4 {
            let (mut pass, mut parts) = (PassSum::default(), PartSums::default());
            for _ in 0..4 {
                let flux = 0.5 + f64::from(rng.next_f32());
                parts.flux[part(&mut rng)] += flux;
                parts.squares += flux * flux;
                pass.accepted += 1;
                pass.flux += DVec3::splat(flux);
            }
            tested.after_pass(&pass, &parts, alpha);
        }
        tested.state
    }

    fn any(rng: &mut Rng) -> usize {
        (rng.next_f32() * PARTS as f32) as usize
    }

    #[test]
    fn even_light_rarely_shrinks_a_disc() {
        let shrunk = (0..2000).filter(|&seed| after(32, seed, 0.5, any).radius2 < 1.0).count();
        assert!((5..45).contains(&shrunk), "one test in a hundred should fail: {shrunk} of 2000 did");
        let passes = (0..300).map(|seed| after(32 << 7, seed, 0.5, any).radius2).sum::<f64>() / 300.0;
        assert!(passes > 0.93, "eight tests: {passes}");
    }

    #[test]
    fn uneven_light_shrinks_every_disc() {
        for seed in 0..50 {
            let state = after(3200, seed, 0.5, |rng| any(rng).min(5));
            assert!(state.radius2 < 0.6, "{}", state.radius2);
        }
    }

    /// Shrinking scales flux and count with the area, so estimates stay.
    #[test]
    fn shrinking_keeps_the_density() {
        let state = after(32, 1, 0.25, |_| 0);
        assert_eq!(state.radius2, 0.25);
        assert_eq!(state.photons / state.radius2, 32.0);
        let unshrunk = after(32, 1, 1.0, |_| 0);
        assert!((state.flux.x / state.radius2 / unshrunk.flux.x - 1.0).abs() < 1e-12);
    }

    #[test]
    fn alpha_one_never_shrinks() {
        assert_eq!(after(3200, 1, 1.0, |_| 0).radius2, 1.0);
    }

    /// Photons of half the flux, taken thrice: fluxes go with the factor, their squares with its square.
    #[test]
    fn squares_grow_with_the_square_of_the_factor() {
        let one = PartSums { flux: [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0], squares: 10.0 };
        let mut sum = PartSums { flux: [100.0; PARTS], squares: 1000.0 };
        for _ in 0..3 {
            sum.add_times(0.5, &one);
        }
        assert_eq!(sum.flux, [101.5, 103.0, 104.5, 106.0, 107.5, 109.0, 110.5, 112.0]);
        assert_eq!(sum.squares, 1007.5);
        // So χ² knows no unit: 8 · Σ (F - 4.5)² / 10.
        let mut scaled = PartSums::default();
        scaled.add_times(7.0, &one);
        assert!((scaled.chi_squared() - 33.6).abs() < 1e-12 && (one.chi_squared() - 33.6).abs() < 1e-12);
    }
}
