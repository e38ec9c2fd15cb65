use serde::Serialize;

use super::PictureError;

/// The fit looks back to where there were so many times fewer passes: the exponent drifts at first.
const LOOK_BACK: f64 = 6.0;
/// Points below which no line is fitted.
const MIN_POINTS: usize = 3;

/// Where the error of a render has been, and from that where it is going.
#[derive(Clone, Debug, Default)]
pub struct Forecast {
    history: Vec<Point>,
}

#[derive(Clone, Copy, Debug)]
struct Point {
    passes: f64,
    seconds: f64,
    error: f64,
    upper: f64,
}

/// What is expected of the passes to come.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Outlook {
    /// `s` in `error ~ passes^-s`, fitted to the passes so far.
    pub exponent: f64,
    /// Passes, counted from the beginning, after which the upper end of the error reaches the target.
    pub passes: f64,
    /// Seconds from the beginning until then.
    pub seconds: f64,
}

impl Forecast {
    /// Notes the error after `seconds` of rendering; passes must grow from call to call.
    pub fn add(&mut self, error: &PictureError, seconds: f64) {
        let PictureError { passes, error, upper, .. } = *error;
        if error > 0.0 && error.is_finite() {
            self.history.push(Point { passes: f64::from(passes), seconds, error, upper });
        }
    }

    /// `s` in `error ~ passes^-s`: least squares through the logarithms of the last passes; `None` while they are too few.
    pub fn exponent(&self) -> Option<f64> {
        let last = self.history.last()?;
        let recent = || self.history.iter().filter(|point| point.passes * LOOK_BACK >= last.passes);
        let n = recent().count();
        if n < MIN_POINTS {
            return None;
        }
        let mean = |of: fn(&Point) -> f64| recent().map(of).sum::<f64>() / n as f64;
        let (x, y) = (mean(|p| p.passes.ln()), mean(|p| p.error.ln()));
        let covariance: f64 = recent().map(|p| (p.passes.ln() - x) * (p.error.ln() - y)).sum();
        let variance: f64 = recent().map(|p| (p.passes.ln() - x).powi(2)).sum();
        Some(-covariance / variance)
    }

    /// When the error will have fallen to `target`; `None` while that cannot be told, or if it does not fall.
    ///
    /// Passes take as long as the latest ones did.
    pub fn outlook(&self, target: f64) -> Option<Outlook> {
        let exponent = self.exponent().filter(|&exponent| exponent > 0.0)?;
        let [.., before, last] = self.history.as_slice() else { return None };
        let passes = last.passes * (last.upper / target).powf(exponent.recip());
        let pass_seconds = (last.seconds - before.seconds) / (last.passes - before.passes);
        Some(Outlook { exponent, passes, seconds: last.seconds + (passes - last.passes) * pass_seconds })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(passes: u32, error: f64) -> PictureError {
        PictureError { passes, error, upper: error, noise: error, bias: 0.0, untrusted: 0.0 }
    }

    fn falling(exponent: f64, passes: impl Iterator<Item = u32>) -> Forecast {
        let mut forecast = Forecast::default();
        for n in passes {
            forecast.add(&after(n, 0.5 * f64::from(n).powf(-exponent)), 3.0 + 0.25 * f64::from(n));
        }
        forecast
    }

    #[test]
    fn a_power_law_is_found_and_followed() {
        let outlook = falling(0.35, 2..=20).outlook(0.05).unwrap();
        assert!((outlook.exponent - 0.35).abs() < 1e-12);
        // 0.5 n^-0.35 = 0.05.
        let passes = 10f64.powf(1.0 / 0.35);
        assert!((outlook.passes / passes - 1.0).abs() < 1e-9);
        assert!((outlook.seconds - (3.0 + 0.25 * passes)).abs() < 1e-6);
    }

    #[test]
    fn first_passes_are_forgotten() {
        let mut forecast = falling(0.9, 1..=4);
        let at_four = 0.5 * 4f64.powf(-0.9);
        for n in 24..=40 {
            forecast.add(&after(n, at_four * (f64::from(n) / 4.0).powf(-0.3)), 0.0);
        }
        assert!((forecast.exponent().unwrap() - 0.3).abs() < 1e-3);
    }

    #[test]
    fn nothing_is_foretold_from_too_little_or_of_an_error_that_grows() {
        assert_eq!(falling(0.5, 2..=3).outlook(0.01), None);
        assert_eq!(falling(-0.1, 2..=10).outlook(0.01), None);
        let mut unknown = Forecast::default();
        (2..9).for_each(|n| unknown.add(&after(n, f64::INFINITY), 0.0));
        assert_eq!(unknown.exponent(), None);
    }
}
