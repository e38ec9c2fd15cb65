//! How long the rest will take.

/// What is known of a job that is not done.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Left {
    /// Photons of the whole job, once its scene is loaded.
    pub photons: Option<f64>,
    /// The share of it that is done.
    pub share: f64,
}

/// Seconds and photons of the jobs that are done.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Spent {
    jobs: f64,
    seconds: f64,
    photons: f64,
}

impl Spent {
    pub fn add(&mut self, seconds: f64, photons: f64) {
        self.jobs += 1.0;
        self.seconds += seconds;
        self.photons += photons;
    }

    /// Seconds until all is done, so many jobs at once; `None` before one is. A job takes seconds in proportion to its photons; one
    /// that is not loaded yet, as many as those before on average.
    pub fn seconds_left(&self, left: &[Left], at_once: usize) -> Option<f64> {
        if self.jobs == 0.0 {
            return None;
        }
        let mean = self.seconds / self.jobs;
        let of_photons = |photons: f64| match self.photons > 0.0 {
            true => self.seconds * photons / self.photons,
            false => mean,
        };
        let seconds = |job: &Left| job.photons.map_or(mean, of_photons) * (1.0 - job.share.clamp(0.0, 1.0));
        let sum: f64 = left.iter().map(seconds).sum();
        let longest = left.iter().map(seconds).fold(0.0, f64::max);
        Some((sum / at_once.max(1) as f64).max(longest))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jobs_weigh_by_their_photons() {
        let mut spent = Spent::default();
        assert_eq!(spent.seconds_left(&[Left::default()], 1), None);
        spent.add(1.0, 1e6);
        spent.add(3.0, 3e6);
        let known = |photons, share| Left { photons: Some(photons), share };
        assert_eq!(spent.seconds_left(&[], 2), Some(0.0));
        assert_eq!(spent.seconds_left(&[known(5e6, 0.0)], 1), Some(5.0));
        assert_eq!(spent.seconds_left(&[known(4e6, 0.75), Left::default()], 1), Some(3.0));
        assert_eq!(spent.seconds_left(&[Left::default(); 4], 2), Some(4.0));
        assert_eq!(
            spent.seconds_left(&[known(9e6, 0.0), Left::default()], 2),
            Some(9.0),
            "no less than the longest"
        );
    }
}
