//! Which method is nearer to the reference in equal time, and where the lead changes.

use serde::Serialize;

use super::Curve;
use super::fit::tail;
use crate::math::PowerLaw;

/// Seconds and error in percent.
type Moment = (f64, f64);

/// A method beside the baseline, in equal time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Duel {
    /// The method.
    pub rival: &'static str,
    /// The last time at which both were measured (s).
    pub seconds: f64,
    /// The baseline's error then, between its points along a power law (%).
    pub baseline_percent: f64,
    /// The rival's (%).
    pub rival_percent: f64,
    /// How fast both errors fall with the seconds, over the last part of their curves: the baseline's, the rival's.
    pub exponents: Option<[f64; 2]>,
    /// When the lead changed last while both were measured (s); none where one was ahead all along.
    pub changed: Option<f64>,
    /// When the one that is behind at the end would be ahead, if both go on by their exponents: seconds, and the error then in percent. A
    /// prediction; none where it would not be, or where one of them may lack light.
    pub predicted: Option<Moment>,
    /// Whether one of them may lack light for ever.
    pub may_lack_light: bool,
}

/// A lead that changes so many times later than anything was measured is not foretold.
const FARTHEST: f64 = 300.0;

impl Duel {
    /// Of two curves; `None` where no time is in both.
    pub fn between(baseline: &Curve, rival: &Curve) -> Option<Duel> {
        let curves = [baseline, rival].map(moments);
        let (from, to) = common(&curves)?;
        let [a, b] = [at(&curves[0], to)?, at(&curves[1], to)?];
        let laws = curves.each_ref().map(|curve| PowerLaw::through(tail(curve)));
        let exponents = match laws {
            [Some(a), Some(b)] => Some([a.exponent, b.exponent]),
            _ => None,
        };
        let may_lack_light = baseline.may_lack_light || rival.may_lack_light;
        Some(Duel {
            rival: rival.name,
            seconds: to,
            baseline_percent: a,
            rival_percent: b,
            exponents,
            changed: last_change(&curves, from, to),
            predicted: exponents
                .filter(|_| !may_lack_light)
                .and_then(|exponents| foretold(to, [a, b], exponents)),
            may_lack_light,
        })
    }

    /// Whether the baseline is ahead at the end.
    pub fn baseline_leads(&self) -> bool {
        self.baseline_percent <= self.rival_percent
    }
}

fn moments(curve: &Curve) -> Vec<Moment> {
    curve.points.iter().map(|point| (point.seconds.median, point.error_percent.mean)).collect()
}

/// The times in both curves.
fn common(curves: &[Vec<Moment>; 2]) -> Option<(f64, f64)> {
    let from = curves[0].first()?.0.max(curves[1].first()?.0);
    let to = curves[0].last()?.0.min(curves[1].last()?.0);
    (from <= to).then_some((from, to))
}

/// The error at a time, along the power law between two points.
fn at(curve: &[Moment], seconds: f64) -> Option<f64> {
    let after = curve.iter().position(|point| point.0 >= seconds)?;
    let (t1, e1) = curve[after];
    let Some(&(t0, e0)) = after.checked_sub(1).and_then(|before| curve.get(before)) else {
        return (t1 == seconds).then_some(e1);
    };
    let share = (seconds / t0).ln() / (t1 / t0).ln();
    Some(e0 * (e1 / e0).powf(share))
}

/// The last time at which the curves cross.
fn last_change(curves: &[Vec<Moment>; 2], from: f64, to: f64) -> Option<f64> {
    let mut times: Vec<f64> = curves.iter().flatten().map(|point| point.0).collect();
    times.extend([from, to]);
    times.retain(|time| (from..=to).contains(time));
    times.sort_by(f64::total_cmp);
    let lead = |&time: &f64| Some((time, (at(&curves[0], time)? / at(&curves[1], time)?).ln()));
    let leads: Vec<(f64, f64)> = times.iter().filter_map(lead).collect();
    let change = leads.windows(2).rfind(|pair| pair[0].1 * pair[1].1 < 0.0)?;
    let [(t0, l0), (t1, l1)] = [change[0], change[1]];
    Some(t0 * (t1 / t0).powf(l0 / (l0 - l1)))
}

/// Where curves of these exponents meet after a time at which their errors were so large.
fn foretold(seconds: f64, errors: [f64; 2], exponents: [f64; 2]) -> Option<Moment> {
    let time = seconds * (errors[1] / errors[0]).powf(1.0 / (exponents[1] - exponents[0]));
    let is_ahead = time > seconds && time < FARTHEST * seconds;
    is_ahead.then(|| (time, errors[0] * (time / seconds).powf(-exponents[0])))
}

#[cfg(test)]
mod tests {
    use super::super::summary::tests::curve_of;
    use super::*;

    /// `factor · seconds^-exponent` at so many times.
    fn curve(name: &'static str, factor: f64, exponent: f64, times: &[f64]) -> Curve {
        let law = PowerLaw { factor, exponent };
        curve_of(name, &times.iter().map(|&seconds| (seconds, law.at(seconds))).collect::<Vec<_>>())
    }

    #[test]
    fn a_lead_that_will_change_is_foretold() {
        let photons = curve("baseline", 10.0, 0.25, &[1.0, 2.0, 4.0, 8.0, 16.0]);
        let paths = curve("path tracing", 20.0, 0.5, &[0.5, 1.5, 3.0, 6.0, 12.0]);
        let duel = Duel::between(&photons, &paths).unwrap();
        assert!(duel.baseline_leads() && duel.seconds == 12.0 && duel.changed.is_none());
        assert!((duel.baseline_percent - 10.0 * 12f64.powf(-0.25)).abs() < 1e-9);
        let (seconds, percent) = duel.predicted.unwrap();
        assert!((seconds - 16.0).abs() < 1e-6 && (percent - 5.0).abs() < 1e-6, "{seconds} {percent}");
        let turned = Duel::between(&paths, &photons).unwrap();
        assert!(!turned.baseline_leads() && (turned.predicted.unwrap().0 - 16.0).abs() < 1e-6);
    }

    #[test]
    fn a_lead_that_changed_is_told() {
        let photons = curve("baseline", 10.0, 0.25, &[1.0, 5.0, 20.0, 80.0]);
        let paths = curve("path tracing", 20.0, 0.5, &[2.0, 30.0, 70.0]);
        let duel = Duel::between(&photons, &paths).unwrap();
        assert!((duel.changed.unwrap() - 16.0).abs() < 1e-6 && !duel.baseline_leads());
        assert_eq!(duel.predicted, None, "the one behind falls more slowly");
    }

    #[test]
    fn nothing_is_foretold_of_what_lacks_light() {
        let photons = curve("baseline", 10.0, 0.25, &[1.0, 2.0, 4.0, 8.0, 16.0]);
        let mut paths = curve("path tracing", 20.0, 0.5, &[1.0, 2.0, 4.0]);
        assert!(Duel::between(&photons, &paths).unwrap().predicted.is_some());
        paths.may_lack_light = true;
        assert!(Duel::between(&photons, &paths).unwrap().predicted.is_none());
        let later = curve("path tracing", 20.0, 0.5, &[17.0, 18.0]);
        assert_eq!(Duel::between(&photons, &later), None);
        let far = curve("path tracing", 200.0, 0.26, &[1.0, 2.0, 4.0]);
        assert_eq!(Duel::between(&photons, &far).unwrap().predicted, None);
    }
}
