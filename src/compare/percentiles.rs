use serde::Serialize;
use std::fmt;

/// Percentiles of the absolute error over all channel values, all three of a pixel singly: the smallest error that
/// at least so many percent of the values do not exceed (nearest rank, without interpolation).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Percentiles {
    /// The median.
    pub p50: f64,
    /// 90 percent.
    pub p90: f64,
    /// 95 percent.
    pub p95: f64,
    /// 99 percent.
    pub p99: f64,
    /// 99.9 percent.
    #[serde(rename = "p99.9")]
    pub p99_9: f64,
}

impl Percentiles {
    /// The percentiles of errors, which are put into another order; all NaN where there are none, or if any is NaN.
    pub fn of(errors: &mut [f64]) -> Percentiles {
        let void = errors.is_empty() || errors.iter().any(|error| error.is_nan());
        let mut per_mille = |share: usize| {
            if void {
                return f64::NAN;
            }
            let rank = (share * errors.len()).div_ceil(1000);
            *errors.select_nth_unstable_by(rank - 1, f64::total_cmp).1
        };
        Percentiles {
            p50: per_mille(500),
            p90: per_mille(900),
            p95: per_mille(950),
            p99: per_mille(990),
            p99_9: per_mille(999),
        }
    }
}

impl fmt::Display for Percentiles {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "p50         {:.6e}", self.p50)?;
        writeln!(f, "p90         {:.6e}", self.p90)?;
        writeln!(f, "p95         {:.6e}", self.p95)?;
        writeln!(f, "p99         {:.6e}", self.p99)?;
        write!(f, "p99.9       {:.6e}", self.p99_9)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn ranks_are_rounded_up() {
        let mut errors: Vec<f64> = (1..=1000).rev().map(f64::from).collect();
        let all = |p: Percentiles| [p.p50, p.p90, p.p95, p.p99, p.p99_9];
        assert_eq!(all(Percentiles::of(&mut errors)), [500.0, 900.0, 950.0, 990.0, 999.0]);
        assert_eq!(all(Percentiles::of(&mut [3.0, 1.0, 2.0])), [2.0, 3.0, 3.0, 3.0, 3.0]);
        assert_eq!(all(Percentiles::of(&mut [4.0])), [4.0; 5]);
        for mut void in [vec![], vec![1.0, f64::NAN]] {
            assert!(all(Percentiles::of(&mut void)).iter().all(|p| p.is_nan()));
        }
    }

    proptest! {
        #[test]
        fn no_smaller_error_would_do(mut errors in prop::collection::vec(0.0..9.0f64, 1..300)) {
            let p90 = Percentiles::of(&mut errors).p90;
            let share = |inside: &dyn Fn(f64) -> bool| errors.iter().filter(|&&e| inside(e)).count() * 10;
            prop_assert!(share(&|e| e <= p90) >= 9 * errors.len() && share(&|e| e < p90) < 9 * errors.len());
        }
    }
}
