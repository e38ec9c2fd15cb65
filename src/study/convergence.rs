//! How variance and squared bias fall with the passes, beside what theory has.

use serde::Serialize;

use super::curve_point::CurvePoint;
use super::fit::{tail, weighed_exponent};
use super::theory::Theory;
use super::{Configuration, Method, Parts, Separation};
use crate::math::PowerLaw;

/// `s` in `passes^-s`, over the last part of a curve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Rate {
    /// As measured; none where fewer than three looks tell.
    pub measured: Option<f64>,
    /// Its standard error, as if looks were independent; not known of the variance.
    pub standard_error: Option<f64>,
    /// In theory, as passes go to infinity.
    pub theory: Option<f64>,
    /// What the radii of the schedule make of it over the same looks; none where radii follow the photons.
    pub of_schedule: Option<f64>,
}

/// The rates of one configuration.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Convergence {
    /// Of the variance of all pixels.
    pub variance: Rate,
    /// Of their squared bias. In theory, it falls as slowly as the width of the discs wherever they hang over edges, and these rates are of
    /// that.
    pub bias2: Rate,
    /// Of the squared bias of pixels whose discs lie flat.
    pub flat_bias2: Rate,
}

impl Convergence {
    /// Of the points of a curve; `None` where nothing was told apart.
    pub(super) fn of(configuration: &Configuration, points: &[CurvePoint]) -> Option<Convergence> {
        let looks: Vec<(u32, Separation)> =
            points.iter().filter_map(|point| Some((point.steps, point.separation?))).collect();
        let &(last, _) = looks.last()?;
        let Theory { noise, bias } = Theory::of(configuration);
        let schedule = Schedule::of(configuration, last);
        let rate = |parts: &dyn Fn(&Separation) -> Option<Parts>, theory, law: fn(&Schedule, u32) -> f64| {
            let looks: Vec<(u32, Parts)> =
                looks.iter().filter_map(|(steps, of)| Some((*steps, parts(of)?))).collect();
            bias_rate(&looks, theory, schedule.as_ref(), law)
        };
        let all = |of: &Separation| Some(of.all);
        Some(Convergence {
            variance: variance_rate(&looks, 2.0 * noise, schedule.as_ref()),
            bias2: rate(&all, bias.map(|bias| 0.5 * bias), Schedule::edge_bias2),
            flat_bias2: rate(&|of| of.flat, bias.map(|bias| 2.0 * bias), Schedule::flat_bias2),
        })
    }
}

/// `s` in `y ~ x^-s` at the end of a curve.
fn end_exponent(points: &[(f64, f64)]) -> Option<f64> {
    let end = tail(points);
    PowerLaw::through(end).filter(|_| end.len() > 2).map(|law| law.exponent)
}

fn variance_rate(looks: &[(u32, Separation)], theory: f64, schedule: Option<&Schedule>) -> Rate {
    let curve = |of: &dyn Fn(&(u32, Separation)) -> f64| {
        let points: Vec<(f64, f64)> = looks.iter().map(|look| (f64::from(look.0), of(look))).collect();
        end_exponent(&points)
    };
    Rate {
        measured: curve(&|look| look.1.all.variance),
        standard_error: None,
        theory: Some(theory),
        of_schedule: schedule.and_then(|schedule| curve(&|look| schedule.variance(look.0))),
    }
}

/// Of the looks at which a bias is told from 0.
fn bias_rate(
    looks: &[(u32, Parts)],
    theory: Option<f64>,
    schedule: Option<&Schedule>,
    law: fn(&Schedule, u32) -> f64,
) -> Rate {
    let told: Vec<&(u32, Parts)> = looks.iter().filter(|(_, parts)| parts.has_bias()).collect();
    let curve: Vec<(f64, f64)> = told.iter().map(|(steps, parts)| (f64::from(*steps), parts.bias2)).collect();
    let end = &told[told.len() - tail(&curve).len()..];
    let point = |look: &&(u32, Parts)| (f64::from(look.0), look.1.bias2, look.1.bias2_error);
    let found = weighed_exponent(&end.iter().map(point).collect::<Vec<_>>());
    let expected = |schedule: &Schedule| {
        let point = |look: &&(u32, Parts)| {
            let bias2 = law(schedule, look.0);
            (f64::from(look.0), bias2, bias2 * look.1.bias2_error / look.1.bias2)
        };
        Some(weighed_exponent(&end.iter().map(point).collect::<Vec<_>>())?.0)
    };
    Rate {
        measured: found.map(|found| found.0),
        standard_error: found.map(|found| found.1),
        theory,
        of_schedule: schedule.and_then(expected),
    }
}

/// What radii `R_i` that are known beforehand make of the mean of `N` passes.
///
/// # Source
/// Knaus and Zwicker, "Progressive Photon Mapping: A Probabilistic Approach", ACM Transactions on Graphics 30(3), 2011,
/// equations 6 and 8.
struct Schedule {
    /// After `N` passes, the sums of `1 / R_i²`, of `R_i²` and, over all pairs of passes, of the smaller radius.
    sums: Vec<[f64; 3]>,
}

impl Schedule {
    fn of(configuration: &Configuration, passes: u32) -> Option<Schedule> {
        let settings = &configuration.settings;
        settings.policy.radius_of_pass(1.0, settings.alpha, 0)?;
        if configuration.method != Method::PhotonMapping {
            return None;
        }
        let plus = |sums: &mut [f64; 3], (pass, area): (u32, f64)| {
            // The radii of all passes before are larger.
            let pairs = 2.0 * f64::from(pass) + 1.0;
            *sums = [sums[0] + 1.0 / area, sums[1] + area, sums[2] + pairs * area.sqrt()];
            Some(*sums)
        };
        let areas = settings.policy.expected_areas(settings.alpha);
        Some(Schedule { sums: (0..passes).zip(areas).scan([0.0; 3], plus).collect() })
    }

    fn means(&self, passes: u32) -> [f64; 3] {
        let n = f64::from(passes);
        let [inverse, area, smaller] = self.sums[passes as usize - 1];
        [inverse / n, area / n, smaller / (n * n)]
    }

    /// Relative to the first pass: photons of a disc are as many as its area holds.
    fn variance(&self, passes: u32) -> f64 {
        self.means(passes)[0] / f64::from(passes)
    }

    /// Relative to the first pass: the bias goes with the mean area.
    fn flat_bias2(&self, passes: u32) -> f64 {
        self.means(passes)[1].powi(2)
    }

    /// Relative to the first pass: a disc is wrong within its radius of an edge, so the square of the mean over passes is there, summed
    /// along a line across the edge, the mean over pairs of the smaller radius.
    fn edge_bias2(&self, passes: u32) -> f64 {
        self.means(passes)[2]
    }
}

#[cfg(test)]
mod tests {
    use super::super::summary::tests::point_with;
    use super::super::{Axis, configurations};
    use super::*;
    use crate::ppm::Settings;
    use crate::study::testing::desc;

    fn configuration(name: &str) -> Configuration {
        let all = configurations(Settings::of_scene(&desc().render), &Axis::ALL);
        all.into_iter().find(|configuration| configuration.name == name).unwrap()
    }

    fn looks(variance: f64, bias2: f64, error: f64) -> Vec<CurvePoint> {
        let point = |steps: u32| {
            let n = f64::from(steps);
            let bias2 = 0.2 * n.powf(-bias2);
            let all = Parts { share: 1.0, variance: 0.1 * n.powf(-variance), bias2, bias2_error: error };
            let flat = Some(Parts { share: 0.3, ..all });
            point_with(steps, Some(Separation { repetitions: 3, all, flat }))
        };
        [1, 2, 3, 4, 6, 8, 12, 16, 24, 32].map(point).to_vec()
    }

    #[test]
    fn power_laws_are_found_beside_those_of_theory() {
        let found = Convergence::of(&configuration("shared, alpha 2/3"), &looks(0.7, 0.6, 1e-4)).unwrap();
        let close = |a: Option<f64>, b: f64| assert!((a.unwrap() - b).abs() < 1e-6, "{a:?} {b}");
        close(found.variance.measured, 0.7);
        close(found.variance.theory, 2.0 / 3.0);
        close(found.flat_bias2.measured, 0.6);
        close(found.flat_bias2.theory, 2.0 / 3.0);
        close(found.bias2.theory, 1.0 / 6.0);
        assert!(found.flat_bias2.standard_error.unwrap() < 0.05);
    }

    #[test]
    fn a_bias_that_is_not_told_from_0_has_no_rate() {
        let found = Convergence::of(&configuration("shared, alpha 1/2"), &looks(0.5, 1.0, 1.0)).unwrap();
        assert_eq!((found.bias2.measured, found.flat_bias2.measured), (None, None));
        assert!(found.variance.measured.is_some());
        let nothing: Vec<CurvePoint> = [1, 2, 4].map(|steps| point_with(steps, None)).to_vec();
        assert_eq!(Convergence::of(&configuration("baseline"), &nothing), None);
    }

    /// Far on, what the schedule makes of the looks is the power law of theory.
    #[test]
    fn schedules_tend_to_theory() {
        for (name, alpha) in
            [("shared, alpha 1/2", 0.5), ("shared, alpha 2/3", 2.0 / 3.0), ("shared, alpha 0.8", 0.8)]
        {
            let schedule = Schedule::of(&configuration(name), 1 << 16).unwrap();
            let exponent = |law: fn(&Schedule, u32) -> f64| {
                let at = |steps: u32| law(&schedule, steps);
                (at(1 << 15) / at(1 << 16)).log2()
            };
            assert!((exponent(Schedule::variance) - alpha).abs() < 0.01);
            assert!((exponent(Schedule::flat_bias2) - 2.0 * (1.0 - alpha)).abs() < 0.02);
            assert!((exponent(Schedule::edge_bias2) - 0.5 * (1.0 - alpha)).abs() < 0.01);
            let early = (schedule.flat_bias2(1) / schedule.flat_bias2(8)).log2() / 3.0;
            assert!(early < 1.7 * (1.0 - alpha), "the first, large discs stay in the mean: {early}");
        }
        let fixed = Schedule::of(&configuration("fixed radius"), 8).unwrap();
        assert_eq!((fixed.variance(8), fixed.flat_bias2(8), fixed.edge_bias2(8)), (0.125, 1.0, 1.0));
        for name in ["baseline", "path tracing"] {
            assert!(Schedule::of(&configuration(name), 8).is_none(), "{name}");
        }
    }
}
