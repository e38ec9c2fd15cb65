//! What the runs of one configuration say together.

use serde::Serialize;

use super::convergence::Convergence;
use super::curve_point::{CurvePoint, ErrorSpread};
use super::fit::{Confidence, crossing, price_of_half, tail};
use super::theory::Theory;
use super::{Configuration, Run, Subject};
use crate::bench::timing::Spread;
use crate::math::PowerLaw;
use crate::scene::SceneDesc;

/// Where an error is reached.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Conclusion {
    /// It was, in all repetitions.
    Measured(Spread),
    /// It was not; the end of the curve, drawn on, gets there after so many seconds.
    Predicted(f64),
    /// It was not, and would not be in any time worth telling.
    OutOfReach,
}

/// An error and where it is reached.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SecondsTo {
    /// The error in percent.
    pub percent: f64,
    /// Seconds to get there.
    pub seconds: Conclusion,
}

/// A prediction that is this many times beyond what was measured is none.
const FARTHEST: f64 = 300.0;

/// What the repetitions of a configuration measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Curve {
    /// The configuration.
    pub name: &'static str,
    /// What it changes.
    pub axis: String,
    /// Finished repetitions.
    pub repetitions: usize,
    /// Errors and seconds by ascending steps.
    pub points: Vec<CurvePoint>,
    /// Exponent of the error over the last part of the curve: the mean of the repetitions.
    pub exponent: Option<f64>,
    /// Half the width of its 95 % confidence interval; none for a single repetition.
    pub exponent_half_width: Option<f64>,
    /// Exponents that theory has.
    pub theory: Theory,
    /// How variance and squared bias fall; none for a single repetition.
    pub convergence: Option<Convergence>,
    /// Whether it may lack light however long it takes, so that nothing is foretold of it.
    pub may_lack_light: bool,
    /// How many times the steps half the error costs, by the exponent; none where it cannot be had.
    pub price_of_half: Option<f64>,
    /// Seconds to each error asked for.
    pub seconds_to: Vec<SecondsTo>,
    /// The command of the last point.
    pub command: String,
}

impl Curve {
    /// Sums up `runs` of `configuration`, by ascending repetition, in a scene; `None` where there are none.
    pub fn of(
        configuration: &Configuration,
        runs: &[&Run],
        scene: &SceneDesc,
        subject: &Subject,
        targets: &[f64],
    ) -> Option<Curve> {
        let seed = runs.first()?.seed;
        let command = |steps| configuration.command(subject, steps, seed);
        let points: Vec<CurvePoint> =
            runs[0].points.iter().map(|p| point(runs, p.steps, command(p.steps))).collect();
        let exponents: Vec<f64> = runs.iter().filter_map(|run| law_of(run)).map(|law| law.exponent).collect();
        let exponent = Confidence::of(&exponents);
        let mean = |p: &CurvePoint| (f64::from(p.steps), p.error_percent.mean);
        let law = PowerLaw::through(tail(&points.iter().map(mean).collect::<Vec<_>>()));
        let may_lack_light = configuration.may_lack_light(scene);
        let law = law.filter(|_| !may_lack_light);
        Some(Curve {
            name: configuration.name,
            axis: configuration.axis.to_string(),
            repetitions: runs.len(),
            exponent: exponent.map(|e| e.mean),
            exponent_half_width: exponent.and_then(|e| e.half_width),
            theory: Theory::of(configuration),
            convergence: Convergence::of(configuration, &points),
            may_lack_light,
            price_of_half: exponent.map(|e| price_of_half(e.mean)).filter(|price| *price < FARTHEST),
            seconds_to: targets.iter().map(|&percent| seconds_to(percent, runs, law, &points)).collect(),
            command: points.last().map(|p| p.command.clone()).unwrap_or_default(),
            points,
        })
    }

    /// The last point.
    pub fn end(&self) -> Option<&CurvePoint> {
        self.points.last()
    }
}

fn point(runs: &[&Run], steps: u32, command: String) -> CurvePoint {
    let at = |run: &&Run| run.points.iter().find(|p| p.steps == steps).copied();
    let there: Vec<super::Point> = runs.iter().filter_map(at).collect();
    CurvePoint {
        steps,
        repetitions: there.len(),
        seconds: Spread::of(there.iter().map(|p| p.seconds)),
        error_percent: ErrorSpread::of(there.iter().map(super::Point::percent)),
        rel_mse: there.iter().map(|p| p.rel_mse).sum::<f64>() / there.len().max(1) as f64,
        // Each run's is of all runs up to it.
        separation: there.last().and_then(|p| p.separation),
        command,
    }
}

/// Error over steps: no noise of the clock is in it.
fn law_of(run: &Run) -> Option<PowerLaw> {
    let points: Vec<(f64, f64)> = run.points.iter().map(|p| (f64::from(p.steps), p.percent())).collect();
    PowerLaw::through(tail(&points))
}

fn seconds_to(percent: f64, runs: &[&Run], law: Option<PowerLaw>, points: &[CurvePoint]) -> SecondsTo {
    let of_run = |run: &&Run| {
        let points: Vec<(f64, f64)> = run.points.iter().map(|p| (p.seconds, p.percent())).collect();
        crossing(&points, percent)
    };
    let reached: Option<Vec<f64>> = runs.iter().map(of_run).collect();
    // A step costs what the steps so far did: their clock is less noisy than that of the last few.
    let (last, steps) = points.last().map_or((0.0, 1.0), |p| (p.seconds.median, f64::from(p.steps)));
    let predicted = law.and_then(|law| law.reaches(percent)).map(|needed| last * needed / steps);
    let predicted = predicted.filter(|seconds| *seconds <= FARTHEST * last);
    let seconds = match (reached, predicted) {
        (Some(seconds), _) => Conclusion::Measured(Spread::of(seconds)),
        (None, Some(seconds)) => Conclusion::Predicted(seconds.max(last)),
        (None, None) => Conclusion::OutOfReach,
    };
    SecondsTo { percent, seconds }
}

#[cfg(test)]
pub mod tests {
    use super::super::testing::{desc, plan, subject};
    use super::super::{Method, Point, Separation};
    use super::*;
    use crate::bsdf::Bsdf;
    use crate::math::Rgb;

    /// Error `40 % · steps^-exponent` at `seconds` a step.
    pub fn run(repetition: u32, exponent: f64, seconds: f64) -> Run {
        let point = |steps: u32| {
            let error = 0.4 * f64::from(steps).powf(-exponent);
            Point { steps, seconds: seconds * f64::from(steps), rel_mse: error * error, separation: None }
        };
        let points = [1, 2, 4, 8, 16].map(point).to_vec();
        Run { key: "k".into(), configuration: "baseline".into(), repetition, seed: 1, points }
    }

    fn curve(runs: &[Run]) -> Curve {
        let runs: Vec<&Run> = runs.iter().collect();
        Curve::of(&plan().configurations[0], &runs, &desc(), &subject(), &[30.0, 20.0, 5.0, 0.1]).unwrap()
    }

    /// One of a curve that says nothing else.
    pub fn point_with(steps: u32, separation: Option<Separation>) -> CurvePoint {
        let error_percent = ErrorSpread { mean: 1.0, min: 1.0, max: 1.0 };
        let seconds = Spread { median: f64::from(steps), min: 1.0, max: 1.0 };
        CurvePoint {
            steps,
            repetitions: 3,
            seconds,
            error_percent,
            rel_mse: 1e-4,
            separation,
            command: String::new(),
        }
    }

    /// One of these seconds and errors in percent.
    pub fn curve_of(name: &'static str, moments: &[(f64, f64)]) -> Curve {
        let point = |(steps, &(median, mean)): (u32, &(f64, f64))| CurvePoint {
            seconds: Spread { median, min: median, max: median },
            error_percent: ErrorSpread { mean, min: mean, max: mean },
            ..point_with(steps, None)
        };
        Curve { name, points: (1..).zip(moments).map(point).collect(), ..curve(&[run(0, 0.5, 1.0)]) }
    }

    #[test]
    fn repetitions_are_summed_up() {
        let curve = curve(&[run(0, 0.5, 1.0), run(1, 0.4, 3.0), run(2, 0.6, 2.0)]);
        assert!((curve.exponent.unwrap() - 0.5).abs() < 1e-9);
        assert!((curve.exponent_half_width.unwrap() - 4.303 * 0.1 / 3f64.sqrt()).abs() < 1e-3);
        let first = &curve.points[0];
        assert_eq!(first.seconds, Spread { median: 2.0, min: 1.0, max: 3.0 });
        assert!((first.error_percent.mean - 40.0).abs() < 1e-9);
        assert!((curve.price_of_half.unwrap() - 4.0).abs() < 1e-6);
        assert!(curve.command.contains("--passes 16 --seed 1"), "{}", curve.command);
    }

    #[test]
    fn what_was_reached_is_told_from_what_would_be() {
        let seconds = |runs: &[Run]| curve(runs).seconds_to.iter().map(|to| to.seconds).collect::<Vec<_>>();
        let found = seconds(&[run(0, 0.5, 1.0), run(1, 0.5, 3.0), run(2, 0.5, 2.0)]);
        let Conclusion::Measured(spread) = found[1] else { panic!("{found:?}") };
        assert!((spread.median - 8.0).abs() < 1e-9 && (spread.max - 12.0).abs() < 1e-9);
        let Conclusion::Predicted(seconds_to_5) = found[2] else { panic!("{found:?}") };
        assert!((seconds_to_5 / 128.0 - 1.0).abs() < 1e-6);
        assert_eq!(found[3], Conclusion::OutOfReach);
        let flat = seconds(&[run(0, 0.0, 1.0)]);
        assert_eq!(flat[0], Conclusion::OutOfReach, "a curve that does not fall gets nowhere");
        let split = seconds(&[run(0, 0.5, 1.0), run(1, 0.1, 1.0)]);
        assert!(matches!(split[1], Conclusion::Predicted(_)), "all repetitions must get there");
        let path_tracing = &plan().configurations[1];
        let of = |scene: &SceneDesc| {
            Curve::of(path_tracing, &[&run(0, 0.5, 1.0)], scene, &subject(), &[20.0, 5.0]).unwrap()
        };
        let mut with_mirror = desc();
        with_mirror.materials[0].bsdf = Bsdf::Mirror { reflectance: Rgb::ONE };
        let curve = of(&with_mirror);
        assert!(matches!(curve.seconds_to[0].seconds, Conclusion::Measured(_)));
        assert_eq!(curve.seconds_to[1].seconds, Conclusion::OutOfReach, "what lacks light is not drawn on");
        assert!(matches!(of(&desc()).seconds_to[1].seconds, Conclusion::Predicted(_)), "all is diffuse");
    }

    #[test]
    fn theory_has_the_slopes_of_the_papers() {
        let mut configuration = plan().configurations[0].clone();
        configuration.settings.alpha = 2.0 / 3.0;
        let theory = Theory::of(&configuration);
        assert!((theory.noise - 1.0 / 3.0).abs() < 1e-12 && (theory.bias.unwrap() - 1.0 / 3.0).abs() < 1e-12);
        configuration.method = Method::Reference(crate::reference::Method::Path);
        assert_eq!(Theory::of(&configuration), Theory { noise: 0.5, bias: None });
    }
}
