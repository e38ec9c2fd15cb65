use serde::{Deserialize, Serialize};

use super::PictureError;
use crate::math::PowerLaw;
use crate::ppm::RadiusPolicy;

/// The fit looks back to where there were so many times fewer passes: the exponent drifts at first.
const LOOK_BACK: f64 = 3.0;
/// Points below which no line is fitted.
const MIN_POINTS: usize = 3;
/// Passes beyond which nothing is foretold.
const MAX_PASSES: f64 = 1e12;

/// Where the error of a render has been, and from that where it is going: noise by the power law that it followed so far, bias,
/// which is hard to see, by the one that it follows in theory.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Forecast {
    history: Vec<Point>,
    /// `s` in `bias ~ passes^-s`.
    bias_exponent: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Point {
    passes: f64,
    seconds: f64,
    noise: f64,
    bias: f64,
}

/// What is expected of the passes to come.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Outlook {
    /// Passes, counted from the beginning, after which the error reaches the target.
    pub passes: f64,
    /// Seconds from the beginning until then.
    pub seconds: f64,
}

impl Forecast {
    /// Of a render whose radii shrink by this policy.
    pub fn new(policy: RadiusPolicy, alpha: f64) -> Forecast {
        let [_, bias_exponent] = policy.exponents(alpha);
        Forecast { history: Vec::new(), bias_exponent }
    }

    /// Notes the error after `seconds` of rendering; passes must grow from call to call.
    pub fn add(&mut self, error: &PictureError, seconds: f64) {
        let PictureError { passes, noise, bias, .. } = *error;
        if noise > 0.0 && noise.is_finite() && bias.is_finite() {
            self.history.push(Point { passes: f64::from(passes), seconds, noise, bias });
        }
    }

    /// `s` in `error ~ passes^-s` as it is now; `None` while there are too few passes to tell.
    pub fn exponent(&self) -> Option<f64> {
        let (last, noise) = (self.history.last()?, self.noise_exponent()?);
        let [noise2, bias2] = [last.noise.powi(2), last.bias.powi(2)];
        Some((noise2 * noise + bias2 * self.bias_exponent) / (noise2 + bias2))
    }

    /// When the error will have fallen to `target`; `None` while that cannot be told, or if it does not fall.
    ///
    /// Passes take as long as the latest ones did.
    pub fn outlook(&self, target: f64) -> Option<Outlook> {
        let noise = self.noise_exponent()?;
        let [.., before, last] = self.history.as_slice() else { return None };
        let error = |passes: f64| {
            let ratio = last.passes / passes;
            (last.noise * ratio.powf(noise)).hypot(last.bias * ratio.powf(self.bias_exponent))
        };
        let passes = first_below(target, 1.0, MAX_PASSES, error)?;
        let pass_seconds = (last.seconds - before.seconds) / (last.passes - before.passes);
        Some(Outlook { passes, seconds: last.seconds + (passes - last.passes) * pass_seconds })
    }

    /// Least squares through the logarithms of the latest passes.
    fn noise_exponent(&self) -> Option<f64> {
        let last = self.history.last()?;
        let recent = self.history.iter().filter(|point| point.passes * LOOK_BACK >= last.passes);
        let points: Vec<(f64, f64)> = recent.map(|point| (point.passes, point.noise)).collect();
        let law = PowerLaw::through(&points).filter(|_| points.len() >= MIN_POINTS)?;
        Some(law.exponent)
    }
}

/// Where a falling function comes down to `target`, by bisection of the logarithm; `None` if it is above it at the end.
fn first_below(target: f64, start: f64, end: f64, of: impl Fn(f64) -> f64) -> Option<f64> {
    let (mut low, mut high) = (start, end);
    while high / low > 1.0 + 1e-9 {
        let middle = (low * high).sqrt();
        if of(middle) > target { low = middle } else { high = middle }
    }
    (of(high) <= target).then_some(high)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(passes: u32, noise: f64, bias: f64) -> PictureError {
        let error = noise.hypot(bias);
        PictureError { passes, error, upper: error, noise, bias, untrusted: 0.0 }
    }

    /// Noise that falls from 0.5, a quarter of a second a pass.
    fn falling(exponent: f64, bias: f64, passes: impl Iterator<Item = u32>) -> Forecast {
        let mut forecast = Forecast::new(RadiusPolicy::Shared, 0.7);
        for n in passes {
            let passes = f64::from(n);
            let error = after(n, 0.5 * passes.powf(-exponent), bias * passes.powf(-0.3));
            forecast.add(&error, 3.0 + 0.25 * passes);
        }
        forecast
    }

    #[test]
    fn a_power_law_is_found_and_followed() {
        let forecast = falling(0.35, 0.0, 2..=20);
        assert!((forecast.exponent().unwrap() - 0.35).abs() < 1e-12);
        // 0.5 n^-0.35 = 0.05.
        let (passes, outlook) = (10f64.powf(1.0 / 0.35), forecast.outlook(0.05).unwrap());
        assert!((outlook.passes / passes - 1.0).abs() < 1e-6);
        assert!((outlook.seconds - (3.0 + 0.25 * passes)).abs() < 1e-3);
    }

    #[test]
    fn bias_falls_as_in_theory() {
        let forecast = falling(0.5, 0.5, 2..=20);
        let error = |n: f64| 0.5 * n.powf(-0.5).hypot(n.powf(-0.3));
        let outlook = forecast.outlook(error(300.0)).unwrap();
        assert!((outlook.passes / 300.0 - 1.0).abs() < 1e-6, "{outlook:?}");
        assert!((0.31..0.49).contains(&forecast.exponent().unwrap()));
    }

    #[test]
    fn first_passes_are_forgotten() {
        let mut forecast = falling(0.9, 0.0, 1..=4);
        let at_four = 0.5 * 4f64.powf(-0.9);
        for n in 13..=40 {
            forecast.add(&after(n, at_four * (f64::from(n) / 4.0).powf(-0.3), 0.0), 0.0);
        }
        assert!((forecast.exponent().unwrap() - 0.3).abs() < 1e-3);
    }

    #[test]
    fn nothing_is_foretold_from_too_little_or_of_an_error_that_stays() {
        assert_eq!(falling(0.5, 0.0, 2..=3).outlook(0.01), None);
        assert_eq!(falling(-0.1, 0.0, 2..=10).outlook(0.01), None);
        assert_eq!(falling(1e-3, 0.0, 2..=10).outlook(0.01), None);
        let mut unknown = Forecast::new(RadiusPolicy::Shared, 0.7);
        (2..9).for_each(|n| unknown.add(&after(n, f64::INFINITY, 0.0), 0.0));
        assert_eq!(unknown.exponent(), None);
    }
}
