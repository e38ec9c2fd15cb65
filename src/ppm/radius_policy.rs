use std::fmt;

/// How gather radii shrink from pass to pass.
///
/// All of them keep `τ / R²`: each pass is measured by the radii that it was gathered with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RadiusPolicy {
    /// Each hit point's by its own photons: `R'² = R² (N + αM) / (N + M)`.
    ///
    /// # Source
    /// Hachisuka, Ogaki and Jensen, "Progressive Photon Mapping", SIGGRAPH Asia 2008, equation 10.
    #[default]
    HitPoint,
    /// All by one schedule, whatever they find: `R²_{i+1} = R²_i (i + α) / (i + 1)`.
    ///
    /// # Source
    /// Knaus and Zwicker, "Progressive Photon Mapping: A Probabilistic Approach", ACM Transactions on Graphics 30(3), 2011,
    /// equation 5.
    Shared,
    /// Each hit point's by `α`, whenever its photons are found to lie unevenly in its disc.
    ///
    /// # Source
    /// Lin et al., "CPPM: Chi-Squared Progressive Photon Mapping", ACM Transactions on Graphics 39(6), 2020.
    Tested,
    /// Not at all: the noise falls, the blur stays.
    Fixed,
}

impl fmt::Display for RadiusPolicy {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            RadiusPolicy::HitPoint => "hit-point",
            RadiusPolicy::Shared => "shared",
            RadiusPolicy::Tested => "tested",
            RadiusPolicy::Fixed => "fixed",
        })
    }
}

impl RadiusPolicy {
    /// The share of its new photons by which each hit point shrinks on its own, for an `α` in (0, 1].
    pub(super) fn own_alpha(self, alpha: f64) -> f64 {
        match self {
            RadiusPolicy::HitPoint | RadiusPolicy::Tested => alpha,
            RadiusPolicy::Shared | RadiusPolicy::Fixed => 1.0,
        }
    }

    /// What all `R²` are scaled by after a pass, counted from 1; `None` where there is no common schedule.
    pub(super) fn common_ratio(self, alpha: f64, pass: u32) -> Option<f64> {
        let i = f64::from(pass);
        (self == RadiusPolicy::Shared).then(|| (i + alpha) / (i + 1.0))
    }

    /// The radius that pass `pass`, counted from 0, gathers with: `R_k² = R_0² Π_{i=1..k} (i + α) / (i + 1)` by the shared
    /// schedule, `R_0` where radii do not shrink; `None` where it depends on what was found before.
    ///
    /// ```
    /// use caustica::ppm::RadiusPolicy;
    /// assert_eq!(RadiusPolicy::Shared.radius_of_pass(2.0, 0.5, 1), Some(3f64.sqrt()));
    /// assert_eq!(RadiusPolicy::Fixed.radius_of_pass(2.0, 0.5, 1), Some(2.0));
    /// assert_eq!(RadiusPolicy::HitPoint.radius_of_pass(2.0, 0.5, 1), None);
    /// ```
    pub fn radius_of_pass(self, first: f64, alpha: f64, pass: u32) -> Option<f64> {
        let ratios = (1..=pass).filter_map(|i| self.common_ratio(alpha, i));
        match self {
            RadiusPolicy::HitPoint | RadiusPolicy::Tested => None,
            RadiusPolicy::Fixed => Some(first),
            RadiusPolicy::Shared => Some(ratios.fold(first * first, |radius2, ratio| radius2 * ratio).sqrt()),
        }
    }

    /// `R_k² / R_0²` of the passes `k = 0, 1, ..` where light is even and plentiful; by [`RadiusPolicy::Shared`] and
    /// [`RadiusPolicy::Fixed`], everywhere.
    ///
    /// A hit point's own photons are `N = i M` before pass `i` there, so that `(N + αM) / (N + M) = (i + α) / (i + 1)`, with `i` from 0; discs
    /// that are tested find nothing uneven.
    ///
    /// ```
    /// use caustica::ppm::RadiusPolicy;
    /// let areas = |policy: RadiusPolicy| policy.expected_areas(0.5).take(3).collect::<Vec<_>>();
    /// assert_eq!(areas(RadiusPolicy::HitPoint), [1.0, 0.5, 0.375]);
    /// assert_eq!(areas(RadiusPolicy::Shared), [1.0, 0.75, 0.625]);
    /// assert_eq!(areas(RadiusPolicy::Fixed), [1.0; 3]);
    /// ```
    pub fn expected_areas(self, alpha: f64) -> impl Iterator<Item = f64> {
        let first = u32::from(self == RadiusPolicy::Shared);
        let is_steady = matches!(self, RadiusPolicy::Fixed | RadiusPolicy::Tested);
        let ratio = move |i: u32| if is_steady { 1.0 } else { (f64::from(i) + alpha) / (f64::from(i) + 1.0) };
        (first..u32::MAX).scan(1.0, move |area, i| {
            let now = *area;
            *area *= ratio(i);
            Some(now)
        })
    }

    /// `s` in `noise ~ passes^-s` and in `bias ~ passes^-s` as passes go to infinity.
    ///
    /// Where `R²` falls as `i^(α - 1)`, noise falls as `i^(-α/2)` and bias as `i^(α - 1)`. Discs that are tested shrink where
    /// light has a slope until the test misses it, as `R⁴ ~ 1/i`.
    pub fn exponents(self, alpha: f64) -> [f64; 2] {
        match self {
            RadiusPolicy::Fixed => [0.5, 0.0],
            _ if alpha == 1.0 => [0.5, 0.0],
            RadiusPolicy::Tested => [0.25, 0.5],
            RadiusPolicy::HitPoint | RadiusPolicy::Shared => [0.5 * alpha, 1.0 - alpha],
        }
    }

    /// `s` in `error ~ passes^-s` as passes go to infinity, that of what falls more slowly; 0 where radii do not shrink.
    pub fn asymptotic_exponent(self, alpha: f64) -> f64 {
        let [noise, bias] = self.exponents(alpha);
        noise.min(bias)
    }
}

#[cfg(test)]
mod tests {
    use super::super::evenness::{PARTS, PartSums, TestedState};
    use super::super::{GatherState, PassSum};
    use super::*;
    use crate::math::{DVec3, PowerLaw, Rng, Stream};

    /// Photons a unit of area and pass at the hit point; at distance `r` there are `1 + CURVATURE r²` times as many.
    const DENSITY: f64 = 12.0;
    const CURVATURE: f64 = 0.8;
    const RENDERS: u32 = 1000;
    const PASSES: u32 = 4096;

    /// How many there are where `mean` are expected: arrivals until the time is over.
    fn poisson(mean: f64, rng: &mut Rng) -> u32 {
        let (mut count, mut time) = (0, 0.0);
        loop {
            time -= (1.0 - f64::from(rng.next_f32())).ln();
            if time > mean {
                return count;
            }
            count += 1;
        }
    }

    fn photons(state: &GatherState, curvature: f64, rng: &mut Rng) -> PassSum {
        let mean = std::f64::consts::PI * state.radius2 * DENSITY * (1.0 + 0.5 * curvature * state.radius2);
        let accepted = poisson(mean, rng);
        PassSum { flux: DVec3::splat(accepted.into()), accepted }
    }

    /// One hit point of a render, at passes 1, 2, 4 ...: the relative error of its irradiance.
    fn errors(policy: RadiusPolicy, alpha: f64, render: u32) -> Vec<f64> {
        let mut rng = Rng::new(11, Stream::Test, render, 0);
        let (mut state, mut errors) = (GatherState::new(1.0), Vec::new());
        for pass in 1..=PASSES {
            let sum = photons(&state, CURVATURE, &mut rng);
            state.after_pass(&sum, policy.own_alpha(alpha));
            if let Some(ratio) = policy.common_ratio(alpha, pass) {
                state.shrink(ratio);
            }
            if pass.is_power_of_two() {
                errors.push(state.irradiance(pass.into()).x / DENSITY - 1.0);
            }
        }
        errors
    }

    /// Variance and squared bias at passes 1, 2, 4 ... over many renders.
    fn convergence(policy: RadiusPolicy, alpha: f64) -> Vec<[f64; 2]> {
        let renders: Vec<Vec<f64>> = (0..RENDERS).map(|render| errors(policy, alpha, render)).collect();
        let n = f64::from(RENDERS);
        (0..renders[0].len())
            .map(|k| {
                let mean = renders.iter().map(|errors| errors[k]).sum::<f64>() / n;
                let squares = renders.iter().map(|errors| (errors[k] - mean).powi(2)).sum::<f64>();
                [squares / (n - 1.0), mean * mean]
            })
            .collect()
    }

    /// `s` in `y ~ passes^s`, from pass 64 on.
    fn slope(values: impl Iterator<Item = f64>) -> f64 {
        let points: Vec<(f64, f64)> =
            (0u8..).zip(values).skip(6).map(|(k, y)| (f64::from(k).exp2(), y)).collect();
        -PowerLaw::through(&points).unwrap().exponent
    }

    /// Variance falls as `N^-α`, squared bias as `N^(-2 (1 - α))`, and at `α = 2/3` both as `N^-2/3`.
    #[test]
    fn shared_schedule_converges_as_theory_has_it() {
        for alpha in [0.5, 2.0 / 3.0, 0.8] {
            let convergence = convergence(RadiusPolicy::Shared, alpha);
            let variance = slope(convergence.iter().map(|c| c[0]));
            let bias2 = slope(convergence.iter().map(|c| c[1]));
            let mse = slope(convergence.iter().map(|c| c[0] + c[1]));
            assert!((variance + alpha).abs() < 0.05, "alpha {alpha}: variance falls as N^{variance}");
            assert!((bias2 + 2.0 * (1.0 - alpha)).abs() < 0.05, "alpha {alpha}: bias² falls as N^{bias2}");
            if alpha == 2.0 / 3.0 {
                assert!((mse + 2.0 / 3.0).abs() < 0.05, "MSE falls as N^{mse}");
            }
        }
    }

    /// Where photons are many, hit points shrink as foretold.
    #[test]
    fn even_light_shrinks_discs_as_expected() {
        for policy in [RadiusPolicy::HitPoint, RadiusPolicy::Shared, RadiusPolicy::Fixed] {
            let mut state = GatherState::new(1.0);
            for (pass, area) in (1..60).zip(policy.expected_areas(0.7)) {
                assert!(
                    (state.radius2 / area - 1.0).abs() < 1e-3,
                    "{policy}, pass {pass}: {}",
                    state.radius2
                );
                let accepted = (1e7 * state.radius2) as u32;
                let sum = PassSum { flux: DVec3::splat(accepted.into()), accepted };
                state.after_pass(&sum, policy.own_alpha(0.7));
                if let Some(ratio) = policy.common_ratio(0.7, pass) {
                    state.shrink(ratio);
                }
            }
        }
    }

    #[test]
    fn fixed_radius_keeps_its_bias() {
        let convergence = convergence(RadiusPolicy::Fixed, 0.7);
        assert!((slope(convergence.iter().map(|c| c[0])) + 1.0).abs() < 0.05);
        let floor = (0.5 * CURVATURE).powi(2);
        let [variance, bias2] = convergence[12];
        assert!((bias2 / floor - 1.0).abs() < 0.01 && variance < 0.001 * floor, "{variance} {bias2}");
    }

    /// The variance of even light over many renders, when discs that are tested have seen 64 and 4096 passes.
    #[test]
    fn tested_discs_keep_all_photons_of_even_light() {
        let estimate = |render, passes: u32| {
            let mut rng = Rng::new(12, Stream::Test, render, 0);
            let mut tested = TestedState::new(1.0);
            for _ in 0..passes {
                let sum = photons(&tested.state, 0.0, &mut rng);
                let mut parts = PartSums { squares: sum.accepted.into(), ..PartSums::default() };
                for _ in 0..sum.accepted {
                    parts.flux[(rng.next_f32() * PARTS as f32) as usize] += 1.0;
                }
                tested.after_pass(&sum, &parts, 0.7);
            }
            tested.state.irradiance(passes.into()).x / DENSITY - 1.0
        };
        let variance = |passes| {
            let squares = (0..RENDERS).map(|render| estimate(render, passes).powi(2)).sum::<f64>();
            squares / f64::from(RENDERS)
        };
        let slope = (variance(2048) / variance(64)).ln() / 32f64.ln();
        assert!((slope + 1.0).abs() < 0.05, "variance falls as N^{slope}");
    }

    /// `R²` after pass `n` is `Π (i + α) / (i + 1)`, which falls as `n^(α - 1)`.
    #[test]
    fn shared_schedule_falls_as_it_should() {
        for alpha in [0.5, 2.0 / 3.0, 0.8] {
            let mut radius2 = vec![1.0];
            for pass in 1..=100_000 {
                let ratio = RadiusPolicy::Shared.common_ratio(alpha, pass).unwrap();
                radius2.push(radius2[pass as usize - 1] * ratio);
            }
            let exponent = (radius2[100_000] / radius2[1000]).ln() / 100f64.ln();
            assert!((exponent - (alpha - 1.0)).abs() < 1e-3, "{alpha}: {exponent}");
        }
    }

    #[test]
    fn only_shrinking_radii_let_the_error_vanish() {
        for policy in [RadiusPolicy::HitPoint, RadiusPolicy::Shared, RadiusPolicy::Tested] {
            assert!(policy.asymptotic_exponent(0.7) > 0.0);
            assert_eq!(policy.asymptotic_exponent(1.0), 0.0);
        }
        assert_eq!(RadiusPolicy::Fixed.asymptotic_exponent(0.7), 0.0);
        // The best of α: noise and bias fall alike.
        assert!((RadiusPolicy::Shared.asymptotic_exponent(2.0 / 3.0) - 1.0 / 3.0).abs() < 1e-12);
    }

    /// Noise as `i^(-α/2)`, bias as `i^(α - 1)`; discs that do not shrink have noise alone to lose.
    #[test]
    fn exponents_are_those_of_noise_and_of_bias() {
        let alpha = 0.75;
        for policy in [RadiusPolicy::HitPoint, RadiusPolicy::Shared] {
            assert_eq!(policy.exponents(alpha), [0.375, 0.25]);
        }
        assert_eq!(RadiusPolicy::Tested.exponents(alpha), [0.25, 0.5]);
        assert_eq!(
            [RadiusPolicy::Fixed.exponents(alpha), RadiusPolicy::Shared.exponents(1.0)],
            [[0.5, 0.0]; 2]
        );
    }

    /// A hit point that shrinks by a common schedule, or not at all, does not by its own photons.
    #[test]
    fn radii_shrink_by_one_rule_alone() {
        let rules = |policy: RadiusPolicy| (policy.own_alpha(0.7), policy.common_ratio(0.7, 4));
        assert_eq!(rules(RadiusPolicy::HitPoint), (0.7, None));
        assert_eq!(rules(RadiusPolicy::Tested), (0.7, None));
        assert_eq!(rules(RadiusPolicy::Shared), (1.0, Some(4.7 / 5.0)));
        assert_eq!(rules(RadiusPolicy::Fixed), (1.0, None));
    }
}
