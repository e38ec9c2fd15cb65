use std::time::Instant;

use serde::Serialize;

use crate::checkpoint::ErrorHistory;
use crate::ppm::{Forecast, Outlook, PictureError, Render, Settings};

/// The error is estimated anew when there are so many times the passes of the last time.
const GROWTH: f64 = 1.3;

/// Follows the error of a render, and tells when it is small enough.
pub struct ErrorWatch {
    target: Option<f64>,
    confidence: f64,
    forecast: Forecast,
    latest: Option<ErrorRecord>,
    /// The pass after which to look again.
    next: u32,
}

/// What was found at one look.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ErrorRecord {
    #[serde(flatten)]
    pub picture: PictureError,
    /// Confidence of the upper end.
    pub confidence: f64,
    /// `s` in `error ~ passes^-s`.
    pub exponent: Option<f64>,
    /// When the target will be reached.
    pub outlook: Option<Outlook>,
    /// What the look itself took.
    pub seconds: f64,
}

impl ErrorWatch {
    pub fn new(target: Option<f64>, confidence: f64, settings: &Settings) -> ErrorWatch {
        let forecast = Forecast::new(settings.policy, settings.alpha);
        ErrorWatch { target, confidence, forecast, latest: None, next: 2 }
    }

    /// Looks at the error, if it is time to; `seconds` is what the render took so far.
    pub fn after_pass(&mut self, render: &Render, seconds: f64) -> Option<&ErrorRecord> {
        if render.passes() < self.next {
            return None;
        }
        let started = Instant::now();
        let picture = render.accuracy(self.confidence)?.picture();
        self.forecast.add(&picture, seconds);
        let record = self.record(picture, started.elapsed().as_secs_f64());
        self.next = next_look(render.passes(), record.outlook);
        Some(self.latest.insert(record))
    }

    fn record(&self, picture: PictureError, seconds: f64) -> ErrorRecord {
        ErrorRecord {
            picture,
            confidence: self.confidence,
            exponent: self.forecast.exponent(),
            outlook: self.target.and_then(|target| self.forecast.outlook(target)),
            seconds,
        }
    }

    /// For a process that goes on with the render.
    pub fn history(&self) -> ErrorHistory {
        ErrorHistory {
            target: self.target,
            confidence: self.confidence,
            forecast: self.forecast.clone(),
            latest: self.latest.map(|latest| latest.picture),
            next: self.next,
        }
    }

    /// Goes on from what an earlier process saw; with another target or confidence it looks again after the next pass.
    pub fn resume(&mut self, history: &ErrorHistory) {
        self.forecast = history.forecast.clone();
        if (self.target, self.confidence) == (history.target, history.confidence) {
            self.next = history.next;
            self.latest = history.latest.map(|picture| self.record(picture, 0.0));
        }
    }

    /// What was found at the last look.
    pub fn latest(&self) -> Option<PictureError> {
        self.latest.map(|latest| latest.picture)
    }

    /// Whether the upper end of the error is down to the target.
    pub fn is_met(&self) -> bool {
        self.target.zip(self.latest).is_some_and(|(target, latest)| latest.picture.upper <= target)
    }

    /// For the line of the progress.
    pub fn message(&self, seconds: f64) -> String {
        let Some(latest) = self.latest else { return String::new() };
        let mut text = format!("error {}", percent(latest.picture.error));
        if let Some(exponent) = latest.exponent {
            text += &format!(" falling as N^-{exponent:.2}");
        }
        if let (Some(target), Some(outlook)) = (self.target, latest.outlook) {
            let left = (outlook.seconds - seconds).max(0.0);
            text += &format!(", {} in {left:.0} s", percent(target));
        }
        text
    }

    /// One sentence about the error at the end; `None` where nothing is known of it.
    pub fn summary(&self) -> Option<String> {
        let latest = self.latest?;
        let PictureError { passes, error, upper, noise, bias, untrusted } = latest.picture;
        let [error, upper, noise, bias] = [error, upper, noise, bias].map(percent);
        let confidence = percent(latest.confidence);
        let mut text = format!(
            "error after {passes} passes: {error} (√relMSE; noise {noise}, bias {bias}), at most {upper} with {confidence} confidence"
        );
        if untrusted > 0.0 {
            text += &format!("; {} of the pixels rest on too few photons to tell", percent(untrusted));
        }
        if let Some(target) = self.target.filter(|_| !self.is_met()) {
            text += &format!("; the target of {} is not reached", percent(target));
            if let Some(outlook) = latest.outlook {
                text += &format!(
                    ", it would be after about {:.0} passes, {:.0} s",
                    outlook.passes, outlook.seconds
                );
            }
        }
        Some(text)
    }
}

/// The pass after which to look again: when there are three tenths more, or when the target should be reached.
fn next_look(passes: u32, outlook: Option<Outlook>) -> u32 {
    let later = (f64::from(passes) * GROWTH).ceil();
    let expected = outlook.map_or(f64::INFINITY, |outlook| outlook.passes.ceil());
    later.min(expected).max(f64::from(passes) + 1.0) as u32
}

/// Three digits, as many as mean something.
pub fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    if percent == 0.0 {
        return "0 %".into();
    }
    let digits = (2 - percent.log10().floor().clamp(-3.0, 2.0) as i32).max(0) as usize;
    format!("{percent:.digits$} %")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentages_have_three_digits() {
        for (share, text) in
            [(1.0, "100 %"), (0.5, "50.0 %"), (0.0234, "2.34 %"), (0.00123, "0.123 %"), (0.0, "0 %")]
        {
            assert_eq!(percent(share), text);
        }
    }

    #[test]
    fn looks_become_rarer_but_not_past_the_target() {
        assert_eq!(next_look(2, None), 3);
        assert_eq!(next_look(100, None), 130);
        let expected = |passes| Some(Outlook { passes, seconds: 1.0 });
        assert_eq!(next_look(100, expected(110.2)), 111);
        assert_eq!(next_look(100, expected(90.0)), 101);
        assert_eq!(next_look(100, expected(1e12)), 130);
    }
}
