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
