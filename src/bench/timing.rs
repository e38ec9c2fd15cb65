//! Repeated measurements: interleaved, so that a slow spell of the machine hits every rival alike.

use std::time::Instant;

use serde::Serialize;

/// The middle and the ends of repeated measurements.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Spread {
    /// The median; of an even number the mean of the middle two.
    pub median: f64,
    /// The smallest.
    pub min: f64,
    /// The largest.
    pub max: f64,
}

impl Spread {
    /// The spread of `samples`; all zero where there are none.
    ///
    /// ```
    /// use caustica::bench::timing::Spread;
    /// let spread = Spread::of([4.0, 1.0, 9.0, 2.0]);
    /// assert_eq!((spread.min, spread.median, spread.max), (1.0, 3.0, 9.0));
    /// ```
    pub fn of(samples: impl IntoIterator<Item = f64>) -> Spread {
        let mut sorted: Vec<f64> = samples.into_iter().collect();
        sorted.sort_by(f64::total_cmp);
        let (Some(&min), Some(&max)) = (sorted.first(), sorted.last()) else { return Spread::default() };
        let middle = sorted.len() / 2;
        let median =
            if sorted.len() % 2 == 1 { sorted[middle] } else { 0.5 * (sorted[middle - 1] + sorted[middle]) };
        Spread { median, min, max }
    }

    /// The same in another unit; `factor` is positive.
    pub fn scaled(self, factor: f64) -> Spread {
        Spread { median: factor * self.median, min: factor * self.min, max: factor * self.max }
    }
}

/// What `work` gives, and the seconds that it took.
pub fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed().as_secs_f64())
}

/// Runs every rival once in each round; the samples of rival `k` are `result[k]`, in the order of the rounds.
///
/// # Errors
/// The first error of a run ends the measurement.
pub fn interleaved<R, S, E>(
    rounds: usize,
    rivals: &[R],
    mut run: impl FnMut(&R) -> Result<S, E>,
) -> Result<Vec<Vec<S>>, E> {
    let mut samples: Vec<Vec<S>> = rivals.iter().map(|_| Vec::with_capacity(rounds)).collect();
    for _ in 0..rounds {
        for (rival, samples) in rivals.iter().zip(&mut samples) {
            samples.push(run(rival)?);
        }
    }
    Ok(samples)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn medians_of_few() {
        assert_eq!(Spread::of([]), Spread::default());
        assert_eq!(Spread::of([7.0]), Spread { median: 7.0, min: 7.0, max: 7.0 });
        assert_eq!(Spread::of([3.0, 1.0]), Spread { median: 2.0, min: 1.0, max: 3.0 });
        assert_eq!(Spread::of([9.0, 1.0, 2.0]), Spread { median: 2.0, min: 1.0, max: 9.0 });
        assert_eq!(Spread::of([1.0, 3.0]).scaled(10.0), Spread { median: 20.0, min: 10.0, max: 30.0 });
    }

    proptest! {
        #[test]
        fn the_median_halves_the_samples(samples in prop::collection::vec(-1e6f64..1e6, 1..50)) {
            let Spread { median, min, max } = Spread::of(samples.iter().copied());
            let below = samples.iter().filter(|&&s| s < median).count();
            let above = samples.iter().filter(|&&s| s > median).count();
            prop_assert!(2 * below <= samples.len() && 2 * above <= samples.len());
            prop_assert!(samples.iter().all(|s| (min..=max).contains(s)));
            prop_assert!(samples.contains(&min) && samples.contains(&max));
        }
    }

    #[test]
    fn rivals_take_turns() {
        let mut order = Vec::new();
        let samples = interleaved(2, &['a', 'b'], |&rival| {
            order.push(rival);
            Ok::<usize, ()>(order.len())
        });
        assert_eq!(samples, Ok(vec![vec![1, 3], vec![2, 4]]));
        assert_eq!(order, ['a', 'b', 'a', 'b']);
        assert_eq!(interleaved(3, &[1], |_| Err::<(), _>("stop")), Err("stop"));
    }

    #[test]
    fn time_goes_by() {
        let pause = std::time::Duration::from_millis(3);
        let ((), seconds) = timed(|| std::thread::sleep(pause));
        assert!(seconds >= 0.003);
    }
}
