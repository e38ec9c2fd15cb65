use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

/// When to stop, whichever comes first.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    /// Passes or samples; `None` for no limit.
    pub steps: Option<u32>,
    /// Seconds; `None` for no limit.
    pub seconds: Option<f64>,
}

/// Watches the budget of a render and shows how far it is: on a terminal only, silent in a pipe.
pub struct Progress {
    budget: Budget,
    started: Instant,
    /// What the render took in processes before this one.
    seconds_before: f64,
    bar: ProgressBar,
}

const KNOWN_END: &str = "{prefix} {pos}/{len} [{wide_bar}] {msg}, {eta} left";
const OPEN_END: &str = "{prefix} {pos} {spinner} {msg}, {elapsed} so far";

/// A bar that fills with `steps`; where their number is unknown, a spinner.
pub fn bar(what: &'static str, steps: Option<u64>) -> ProgressBar {
    let bar = match steps {
        Some(steps) => styled(ProgressBar::new(steps), KNOWN_END),
        None => styled(ProgressBar::new_spinner(), OPEN_END),
    };
    bar.set_prefix(what);
    bar.enable_steady_tick(Duration::from_millis(500));
    bar
}

/// A bar with the texts around it.
pub fn styled(bar: ProgressBar, template: &str) -> ProgressBar {
    match ProgressStyle::with_template(template) {
        Ok(style) => bar.with_style(style.progress_chars("=> ")),
        Err(_) => bar,
    }
}

impl Progress {
    pub fn start(what: &'static str, budget: Budget) -> Progress {
        let bar = bar(what, budget.steps.map(u64::from));
        Progress { budget, started: Instant::now(), seconds_before: 0.0, bar }
    }

    /// Counts on from what a process before this one did.
    pub fn resume(&mut self, steps: u32, seconds: f64) {
        self.seconds_before = seconds;
        self.resume_at(steps);
    }

    /// The same where nobody asks for seconds.
    pub fn resume_at(&self, steps: u32) {
        self.bar.set_position(u64::from(steps));
        self.bar.reset_eta();
    }

    /// Whether the budget is spent after `steps`.
    pub fn is_over(&self, steps: u32) -> bool {
        self.budget.steps.is_some_and(|limit| steps >= limit)
            || self.budget.seconds.is_some_and(|limit| self.seconds() >= limit)
    }

    pub fn step(&self, message: String) {
        self.bar.set_message(message);
        self.bar.inc(1);
    }

    /// Seconds of the render so far.
    pub fn seconds(&self) -> f64 {
        self.seconds_before + self.started.elapsed().as_secs_f64()
    }

    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}
