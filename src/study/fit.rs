//! Power laws through measured errors, and what follows from them.

use statrs::distribution::{ContinuousCDF, StudentsT};

/// By how much `x` grows where a power law `x^-exponent` halves, `2^(1/exponent)`; infinite where it never does.
pub fn price_of_half(exponent: f64) -> f64 {
    if exponent > 0.0 { (1.0 / exponent).exp2() } else { f64::INFINITY }
}

/// The factor in `x` at the end of a curve that a fit goes by: the slope changes on the way, and what comes next follows the
/// last part.
const END: f64 = 8.0;

/// The last of `points`, which ascend: those within a factor of eight of the last; all where these are less than three.
pub fn tail(points: &[(f64, f64)]) -> &[(f64, f64)] {
    let Some(&(last, _)) = points.last() else { return points };
    let first = points.partition_point(|&(x, _)| END * x < last);
    if points.len() - first < 3 { points } else { &points[first..] }
}

/// The power law through points `(x, y, standard error of y)`, each weighed by how well its logarithm is known, and the standard
/// error of the exponent if the points are independent. Points that grow together, as means of passes do, tell it better than that.
///
/// `None` for less than three points.
pub fn weighed_exponent(points: &[(f64, f64, f64)]) -> Option<(f64, f64)> {
    if points.len() < 3 {
        return None;
    }
    let weight = |&(_, y, error): &(f64, f64, f64)| (y / error).powi(2);
    let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
        points.iter().map(|point| weight(point) * of(point.0.ln(), point.1.ln())).sum()
    };
    let all = sum(&|_, _| 1.0);
    let (x, y) = (sum(&|x, _| x) / all, sum(&|_, y| y) / all);
    let xx = sum(&|at, _| (at - x).powi(2));
    let exponent = -sum(&|at, value| (at - x) * (value - y)) / xx;
    (exponent.is_finite() && xx > 0.0).then(|| (exponent, xx.sqrt().recip()))
}

/// A mean of independent numbers and how far it can be trusted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Confidence {
    /// The mean.
    pub mean: f64,
    /// Half the width of the interval that holds the true mean 95 times in a hundred, for normal numbers; `None` for a
    /// single one.
    pub half_width: Option<f64>,
}

impl Confidence {
    /// By Student's distribution; `None` where there are no numbers.
    pub fn of(numbers: &[f64]) -> Option<Confidence> {
        let n = numbers.len();
        if n == 0 {
            return None;
        }
        let mean = numbers.iter().sum::<f64>() / n as f64;
        let squares: f64 = numbers.iter().map(|x| (x - mean).powi(2)).sum();
        let half_width = (n > 1).then(|| student(n - 1) * (squares / (n - 1) as f64 / n as f64).sqrt());
        Some(Confidence { mean, half_width })
    }
}

/// The quantile 0.975 of Student's distribution of `freedom` degrees of freedom; infinite where there is none.
fn student(freedom: usize) -> f64 {
    StudentsT::new(0.0, 1.0, freedom as f64).map_or(f64::INFINITY, |student| student.inverse_cdf(0.975))
}

/// Where a measured curve of ascending `x` first falls to `y`, between its points along a power law.
///
/// `None` where it never does; the first `x` where it begins below.
pub fn crossing(points: &[(f64, f64)], y: f64) -> Option<f64> {
    let after = points.iter().position(|point| point.1 <= y)?;
    let (x1, y1) = points[after];
    let Some(&(x0, y0)) = after.checked_sub(1).and_then(|before| points.get(before)) else { return Some(x1) };
    if y1 <= 0.0 || x0 <= 0.0 {
        return Some(x1);
    }
    let share = (y0 / y).ln() / (y0 / y1).ln();
    Some(x0 * (x1 / x0).powf(share))
}

/// The indices of the points that no other one beats in one coordinate without being worse in the other, by ascending `x`.
pub fn pareto_front(points: &[(f64, f64)]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| points[a].0.total_cmp(&points[b].0).then(points[a].1.total_cmp(&points[b].1)));
    let mut best = f64::INFINITY;
    order.retain(|&index| {
        let is_better = points[index].1 < best;
        best = best.min(points[index].1);
        is_better
    });
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{PowerLaw, Rng, Stream};
    use proptest::prelude::*;

    #[test]
    fn exact_power_laws_are_found() {
        let law = PowerLaw { factor: 40.0, exponent: 1.0 / 3.0 };
        let points: Vec<(f64, f64)> = (1..9).map(|k| (f64::from(k), law.at(f64::from(k)))).collect();
        let fit = PowerLaw::through(&points).unwrap();
        assert!((fit.exponent - law.exponent).abs() < 1e-12 && (fit.factor - 40.0).abs() < 1e-9);
        assert!((fit.reaches(5.0).unwrap() - 512.0).abs() < 1e-6);
        assert!((price_of_half(fit.exponent) - 8.0).abs() < 1e-9);
    }

    #[test]
    fn what_cannot_be_fitted_is_not() {
        assert_eq!(PowerLaw::through(&[]), None);
        assert_eq!(PowerLaw::through(&[(2.0, 3.0)]), None);
        assert_eq!(PowerLaw::through(&[(2.0, 3.0), (2.0, 4.0), (3.0, 0.0)]), None);
        let growing = PowerLaw::through(&[(1.0, 1.0), (2.0, 2.0)]).unwrap();
        assert_eq!((growing.reaches(0.5), price_of_half(growing.exponent)), (None, f64::INFINITY));
    }

    #[test]
    fn a_fit_goes_by_the_end_of_a_curve() {
        let points: Vec<(f64, f64)> = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0].map(|x| (x, 1.0 / x)).to_vec();
        assert_eq!(tail(&points), &points[2..]);
        assert_eq!(tail(&points[..2]), &points[..2]);
        let sparse = [(1.0, 1.0), (2.0, 1.0), (100.0, 1.0)];
        assert_eq!((tail(&sparse), tail(&[])), (&sparse[..], &[][..]));
    }

    /// Of intervals from three to twelve noisy numbers, 95 % hold the truth.
    #[test]
    fn confidence_is_what_it_says() {
        let mut rng = Rng::new(1, Stream::Test, 0, 0);
        let mut normal = || (0..12).map(|_| f64::from(rng.next_f32())).sum::<f64>() - 6.0;
        for n in [3, 5, 12] {
            let holds = |_: &u32| {
                let numbers: Vec<f64> = (0..n).map(|_| 7.0 + normal()).collect();
                let confidence = Confidence::of(&numbers).unwrap();
                (confidence.mean - 7.0).abs() <= confidence.half_width.unwrap()
            };
            let share = f64::from((0..4000).filter(holds).count() as u32) / 4000.0;
            assert!((0.938..0.962).contains(&share), "{n} numbers: {share}");
        }
        assert_eq!(Confidence::of(&[]), None);
        assert_eq!(Confidence::of(&[2.0]), Some(Confidence { mean: 2.0, half_width: None }));
    }

    #[test]
    fn student_agrees_with_tables() {
        for (freedom, value) in [(1, 12.706), (4, 2.776), (5, 2.571), (9, 2.262), (30, 2.042)] {
            assert!((student(freedom) / value - 1.0).abs() < 0.01, "{freedom}: {}", student(freedom));
        }
    }

    #[test]
    fn crossings_lie_on_power_laws() {
        let points = [(1.0, 40.0), (4.0, 20.0), (16.0, 10.0), (20.0, 12.0)];
        assert_eq!(crossing(&points, 50.0), Some(1.0));
        assert_eq!(crossing(&points, 20.0), Some(4.0));
        assert!((crossing(&points, 800f64.sqrt()).unwrap() - 2.0).abs() < 1e-12);
        assert_eq!((crossing(&points, 9.0), crossing(&[], 9.0)), (None, None));
    }

    #[test]
    fn the_front_is_what_nothing_beats() {
        let points = [(3.0, 1.0), (1.0, 5.0), (2.0, 5.0), (2.0, 2.0), (4.0, 1.0), (1.0, 6.0)];
        assert_eq!(pareto_front(&points), [1, 3, 0]);
        assert!(pareto_front(&[]).is_empty());
    }

    /// Of intervals of two standard errors around exponents, 95 % hold the truth; the points that are known best decide.
    #[test]
    fn weighed_exponents_are_what_they_say() {
        let mut rng = Rng::new(5, Stream::Test, 0, 0);
        let mut normal = || (0..12).map(|_| f64::from(rng.next_f32())).sum::<f64>() - 6.0;
        let law = PowerLaw { factor: 3.0, exponent: 0.7 };
        let holds = |_: &u32| {
            let point = |k: i32| {
                let (x, relative) = (f64::from(k).exp2(), 0.01 * f64::from(k));
                (x, law.at(x) * (1.0 + relative * normal()), relative * law.at(x))
            };
            let points: Vec<_> = (1..8).map(point).collect();
            let (exponent, error) = weighed_exponent(&points).unwrap();
            (exponent - law.exponent).abs() < 2.0 * error
        };
        let share = f64::from((0..2000).filter(holds).count() as u32) / 2000.0;
        assert!((0.93..0.97).contains(&share), "{share}");
        let (exponent, _) = weighed_exponent(&[(1.0, 1.0, 1e-3), (2.0, 0.5, 1e-3), (4.0, 1.0, 1e3)]).unwrap();
        assert!((exponent - 1.0).abs() < 1e-3, "{exponent}");
        assert_eq!(weighed_exponent(&[(1.0, 1.0, 0.1), (2.0, 0.5, 0.1)]), None);
        assert_eq!(weighed_exponent(&[(2.0, 1.0, 0.1); 3]), None);
    }

    proptest! {
        #[test]
        fn the_front_agrees_with_its_definition(points in prop::collection::vec((0u8..9, 0u8..9), 0..30)) {
            let points: Vec<(f64, f64)> = points.into_iter().map(|(x, y)| (x.into(), y.into())).collect();
            let beats = |a: &(f64, f64), b: &(f64, f64)| a.0 <= b.0 && a.1 <= b.1 && a != b;
            let front = pareto_front(&points);
            prop_assert!(front.iter().all(|&k| !points.iter().any(|other| beats(other, &points[k]))));
            let missed = |p: &(f64, f64)| !points.iter().any(|q| beats(q, p)) && !front.iter().any(|&k| points[k] == *p);
            prop_assert!(!points.iter().any(missed));
        }
    }
}
