/// A power law `y = factor · x^-exponent`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PowerLaw {
    /// `y` at `x = 1`.
    pub factor: f64,
    /// How fast `y` falls; negative where it grows.
    pub exponent: f64,
}

impl PowerLaw {
    /// The least-squares line through the logarithms of `points`; those that are not positive are left out.
    ///
    /// `None` unless there are two different `x`.
    pub fn through(points: &[(f64, f64)]) -> Option<PowerLaw> {
        let logs: Vec<(f64, f64)> =
            points.iter().filter(|(x, y)| *x > 0.0 && *y > 0.0).map(|(x, y)| (x.ln(), y.ln())).collect();
        let n = logs.len() as f64;
        let (mean_x, mean_y) =
            (logs.iter().map(|p| p.0).sum::<f64>() / n, logs.iter().map(|p| p.1).sum::<f64>() / n);
        let xx: f64 = logs.iter().map(|p| (p.0 - mean_x).powi(2)).sum();
        let xy: f64 = logs.iter().map(|p| (p.0 - mean_x) * (p.1 - mean_y)).sum();
        let exponent = -xy / xx;
        (xx > 1e-12).then(|| PowerLaw { factor: (mean_y + exponent * mean_x).exp(), exponent })
    }

    /// `y` at `x`.
    pub fn at(&self, x: f64) -> f64 {
        self.factor * x.powf(-self.exponent)
    }

    /// Where `y` is reached; `None` where it never falls that far: the exponent is not positive.
    pub fn reaches(&self, y: f64) -> Option<f64> {
        (self.exponent > 0.0).then(|| (self.factor / y).powf(1.0 / self.exponent))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points on a curve are that curve, also where it grows; zeros beside them say nothing.
    #[test]
    fn a_power_law_is_found_from_its_points() {
        for (factor, exponent) in [(5.0, 0.7), (0.2, -1.5), (3.0, 0.0)] {
            let law = PowerLaw { factor, exponent };
            let mut points: Vec<(f64, f64)> = [2.0, 3.0, 7.0, 40.0].map(|x| (x, law.at(x))).to_vec();
            points.extend([(0.0, 1.0), (5.0, 0.0), (-1.0, 2.0), (4.0, -3.0)]);
            let found = PowerLaw::through(&points).unwrap();
            assert!((found.factor / factor - 1.0).abs() < 1e-12, "{found:?}");
            assert!((found.exponent - exponent).abs() < 1e-12, "{found:?}");
        }
    }

    /// `ln y` of 0, 3 and 0 at `ln x` of 0, 1 and 2 is level at its mean; 5 at 4 tilts it.
    #[test]
    fn points_off_the_line_are_met_in_least_squares() {
        let points =
            [(0.0, 0.0), (1.0, 3.0), (2.0, 0.0), (4.0, 5.0)].map(|(x, y): (f64, f64)| (x.exp(), y.exp()));
        let level = PowerLaw::through(&points[..3]).unwrap();
        assert!((level.factor.ln() - 1.0).abs() < 1e-12 && level.exponent.abs() < 1e-12, "{level:?}");
        let tilted = PowerLaw::through(&points).unwrap();
        // Σ (x - x̄)(y - ȳ) = 9, Σ (x - x̄)² = 8.75, x̄ = 1.75, ȳ = 2.
        assert!((tilted.exponent + 9.0 / 8.75).abs() < 1e-12, "{tilted:?}");
        assert!((tilted.factor.ln() - 0.2).abs() < 1e-12, "{tilted:?}");
    }

    #[test]
    fn one_place_is_no_line() {
        assert_eq!(PowerLaw::through(&[(2.0, 1.0), (2.0, 3.0)]), None);
        assert_eq!(PowerLaw::through(&[(2.0, 1.0), (0.0, 3.0)]), None);
        assert_eq!(PowerLaw::through(&[]), None);
    }

    #[test]
    fn a_value_is_reached_where_the_law_takes_it() {
        let law = PowerLaw { factor: 6.0, exponent: 0.5 };
        assert_eq!(law.at(4.0), 3.0);
        assert_eq!(law.reaches(3.0), Some(4.0));
        assert_eq!(PowerLaw { factor: 6.0, exponent: 0.0 }.reaches(3.0), None);
    }
}
