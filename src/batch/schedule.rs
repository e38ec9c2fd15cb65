//! How threads are shared out among jobs: as told, or by trying.

use std::fmt;

/// So many jobs at once, of so many threads each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Jobs that render at once.
    pub jobs: usize,
    /// Threads of each.
    pub threads: usize,
}

impl fmt::Display for Layout {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{} x {}", self.jobs, self.threads)
    }
}

/// What a layout came to in its trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rate {
    /// The layout.
    pub layout: Layout,
    /// Photons a second of all jobs together; `None` where no job came to its end.
    pub photons: Option<f64>,
}

/// A layout with fewer jobs at once takes less memory, but must be so much faster to be taken: less is noise.
const GAIN: f64 = 1.05;

/// A trial is worth its while if there are so many times the jobs that it takes.
const WORTH: usize = 4;

/// Rounds of layouts that are tried in turn, and the one that is kept.
#[derive(Clone, Debug)]
pub struct Schedule {
    trials: Vec<Layout>,
    kept: Option<Layout>,
    /// The round under way; that after the trials is the last.
    round: usize,
    /// Jobs that were begun in each trial.
    begun: Vec<usize>,
    /// Photons a second of each job that was done in the round under way.
    rates: Vec<f64>,
    measured: Vec<Rate>,
}

impl Schedule {
    /// One layout for all.
    pub fn fixed(layout: Layout) -> Schedule {
        Schedule {
            trials: Vec::new(),
            kept: Some(layout),
            round: 0,
            begun: Vec::new(),
            rates: Vec::new(),
            measured: Vec::new(),
        }
    }

    /// Tries as many jobs as cores with a thread each, then half as many with two, and so on down to one job; where there are
    /// too few jobs for that, shares the cores out evenly.
    pub fn by_trial(cores: usize, jobs: usize) -> Schedule {
        let halves = std::iter::successors(Some(cores.max(1)), |jobs| (*jobs > 1).then_some(jobs / 2));
        let trials: Vec<Layout> =
            halves.map(|jobs| Layout { jobs, threads: (cores / jobs).max(1) }).collect();
        let needed: usize = trials.iter().map(|layout| layout.jobs).sum();
        if trials.len() < 2 || jobs < WORTH * needed {
            let at_once = jobs.clamp(1, cores.max(1));
            return Schedule::fixed(Layout { jobs: at_once, threads: (cores / at_once).max(1) });
        }
        Schedule {
            begun: vec![0; trials.len()],
            trials,
            kept: None,
            ..Schedule::fixed(Layout { jobs: 1, threads: 1 })
        }
    }

    /// The layout of the round under way.
    pub fn layout(&self) -> Layout {
        self.of_round(self.round).unwrap_or(Layout { jobs: 1, threads: 1 })
    }

    fn of_round(&self, round: usize) -> Option<Layout> {
        self.trials.get(round).copied().or(self.kept)
    }

    /// The round under way.
    pub fn round(&self) -> usize {
        self.round
    }

    /// Whether no layout is tried any more.
    pub fn is_settled(&self) -> bool {
        self.round >= self.trials.len()
    }

    /// The round for another job, and its threads; `None` while it is not known what comes after the trials.
    pub fn assign(&mut self) -> Option<(usize, usize)> {
        let full =
            |round: &usize| self.begun.get(*round).is_some_and(|begun| *begun >= self.trials[*round].jobs);
        let round = (self.round..=self.trials.len()).find(|round| !full(round))?;
        let layout = self.of_round(round)?;
        if let Some(begun) = self.begun.get_mut(round) {
            *begun += 1;
        }
        Some((round, layout.threads))
    }

    /// A job of the round is done: so many photons in so many seconds.
    pub fn is_done(&mut self, round: usize, photons: f64, seconds: f64) {
        if round == self.round && seconds > 0.0 {
            self.rates.push(photons / seconds);
        }
    }

    /// No job of the round is under way any more: goes on to the next, if all of this one were begun. Tells the layout
    /// that is kept, when it is found.
    pub fn round_is_over(&mut self) -> Option<Layout> {
        let layout = *self.trials.get(self.round)?;
        if self.begun[self.round] < layout.jobs {
            return None;
        }
        let mean = self.rates.iter().sum::<f64>() / self.rates.len() as f64;
        let photons = (!self.rates.is_empty()).then_some(mean * layout.jobs as f64);
        self.measured.push(Rate { layout, photons });
        self.rates.clear();
        self.round += 1;
        if self.round < self.trials.len() {
            return None;
        }
        self.kept = Some(best(&self.measured, self.trials[0]));
        self.kept
    }

    /// What the trials came to, in words.
    pub fn told(&self) -> String {
        let told = |rate: &Rate| match rate.photons {
            Some(photons) => format!("{}: {photons:.3e} photons/s", rate.layout),
            None => format!("{}: not measured", rate.layout),
        };
        self.measured.iter().map(told).collect::<Vec<_>>().join("; ")
    }
}

fn best(measured: &[Rate], first: Layout) -> Layout {
    let mut best = Rate { layout: first, photons: None };
    for rate in measured {
        let Some(photons) = rate.photons else { continue };
        if best.photons.is_none_or(|before| photons > GAIN * before) {
            best = *rate;
        }
    }
    best.layout
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn layout(jobs: usize, threads: usize) -> Layout {
        Layout { jobs, threads }
    }

    /// Runs all trials; `rate` tells the photons a second of one job.
    fn kept(mut schedule: Schedule, rate: impl Fn(Layout) -> Option<f64>) -> Layout {
        for _ in 0..100 {
            let layout = schedule.layout();
            for _ in 0..layout.jobs {
                let (round, threads) = schedule.assign().unwrap();
                assert_eq!((round, threads), (schedule.round(), layout.threads));
                if let Some(rate) = rate(layout) {
                    schedule.is_done(round, rate, 1.0);
                }
            }
            if let Some(kept) = schedule.round_is_over() {
                return kept;
            }
        }
        panic!("no end")
    }

    #[test]
    fn layouts_are_tried_and_the_fastest_is_kept() {
        let by_threads =
            |exponent: i32| move |layout: Layout| Some(f64::from(layout.threads as u32).powi(exponent));
        let schedule = || Schedule::by_trial(8, 1000);
        assert_eq!(kept(schedule(), by_threads(0)), layout(8, 1), "threads bring nothing");
        assert_eq!(kept(schedule(), by_threads(2)), layout(1, 8), "threads bring more than they are");
        assert_eq!(kept(schedule(), by_threads(1)), layout(8, 1), "no difference: the first");
        assert_eq!(kept(schedule(), |_| None), layout(8, 1), "all fail");
        assert_eq!(kept(schedule(), |l| (l.jobs == 2).then_some(1.0)), layout(2, 4), "only one is known");
    }

    #[test]
    fn few_jobs_share_the_cores() {
        for (cores, jobs, expected) in
            [(8, 3, layout(3, 2)), (8, 1, layout(1, 8)), (2, 11, layout(2, 1)), (1, 9, layout(1, 1))]
        {
            assert_eq!(Schedule::by_trial(cores, jobs).layout(), expected, "{cores} cores, {jobs} jobs");
            assert_eq!(Schedule::by_trial(cores, jobs).assign(), Some((0, expected.threads)));
        }
        assert_eq!(Schedule::by_trial(2, 12).trials, [layout(2, 1), layout(1, 2)]);
    }

    #[test]
    fn nobody_is_prepared_for_a_layout_that_is_not_known() {
        let mut schedule = Schedule::by_trial(2, 100);
        let next: Vec<_> = (0..4).map(|_| schedule.assign()).collect();
        assert_eq!(next, [Some((0, 1)), Some((0, 1)), Some((1, 2)), None]);
        assert_eq!(schedule.round_is_over(), None);
        assert_eq!((schedule.round(), schedule.layout()), (1, layout(1, 2)));
        assert_eq!(schedule.round_is_over(), Some(layout(2, 1)));
        assert_eq!(schedule.assign(), Some((2, 1)));
        assert_eq!(schedule.told(), "2 x 1: not measured; 1 x 2: not measured");
    }
}
