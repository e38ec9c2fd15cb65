use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

/// Above so many standard errors of bias, the noise on its far side does not matter.
const FAR: f64 = 8.0;
/// Entries of the table for one standard error of bias.
const STEPS: f64 = 64.0;

/// How far from zero an error stays with a given probability: the quantile of `|b + s t|`, where the bias `b` is known
/// and the noise `s t` follows Student's distribution, since `s` is itself an estimate.
#[derive(Clone, Debug)]
pub(super) struct ErrorQuantile {
    /// For biases of 0, 1/64, 2/64 ... standard errors.
    table: Vec<f64>,
    /// What is added to larger biases.
    one_sided: f64,
}

impl ErrorQuantile {
    /// For a probability in (0, 1); infinite where there is no degree of freedom.
    pub(super) fn new(confidence: f64, degrees_of_freedom: f64) -> ErrorQuantile {
        let Ok(noise) = StudentsT::new(0.0, 1.0, degrees_of_freedom) else {
            return ErrorQuantile { table: Vec::new(), one_sided: f64::INFINITY };
        };
        let entries = 0..=(FAR * STEPS) as u32 + 1;
        let table = entries.map(|k| folded(&noise, confidence, f64::from(k) / STEPS)).collect();
        ErrorQuantile { table, one_sided: noise.inverse_cdf(confidence) }
    }

    /// The bound on the error for a bias (of any sign) and a standard error, 0 where both are.
    pub(super) fn bound(&self, bias: f64, stderr: f64) -> f64 {
        if stderr == 0.0 {
            return bias.abs();
        }
        let place = bias.abs() / stderr * STEPS;
        if place + 1.0 >= self.table.len() as f64 {
            return bias.abs() + self.one_sided * stderr;
        }
        let (below, share) = (place as usize, place.fract());
        stderr * (self.table[below] * (1.0 - share) + self.table[below + 1] * share)
    }
}

/// The `x` with `P(|bias + t| <= x) = confidence`, by bisection.
fn folded(noise: &StudentsT, confidence: f64, bias: f64) -> f64 {
    let (mut low, mut high) = (0.0, bias + noise.inverse_cdf(0.5 + 0.5 * confidence));
    while high - low > 1e-6 * high {
        let middle = 0.5 * (low + high);
        let inside = noise.cdf(middle - bias) - noise.cdf(-middle - bias);
        if inside < confidence { low = middle } else { high = middle }
    }
    high
}

/// The number of standard errors that a normal variable stays below with this probability in (0, 1).
pub(super) fn one_sided_normal(confidence: f64) -> f64 {
    Normal::standard().inverse_cdf(confidence)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Rng, Stream};

    /// From tables of Student's distribution: 90 % and 50 % of both sides.
    #[test]
    fn without_bias_it_is_student_s_quantile() {
        for (confidence, freedom, expected) in
            [(0.9, 1.0, 6.314), (0.9, 10.0, 1.812), (0.5, 10.0, 0.700), (0.9, 1e6, 1.645)]
        {
            let bound = ErrorQuantile::new(confidence, freedom).bound(0.0, 2.0);
            assert!((bound / (2.0 * expected) - 1.0).abs() < 1e-3, "{confidence} {freedom}: {bound}");
        }
    }

    #[test]
    fn a_large_bias_decides_alone() {
        let quantile = ErrorQuantile::new(0.9, 1e6);
        assert_eq!(quantile.bound(-3.0, 0.0), 3.0);
        assert_eq!(quantile.bound(0.0, 0.0), 0.0);
        for bias in [7.9, 8.1, 100.0] {
            assert!((quantile.bound(bias, 1.0) - (bias + 1.2816)).abs() < 1e-3);
        }
    }

    #[test]
    fn without_knowledge_nothing_is_claimed() {
        assert_eq!(ErrorQuantile::new(0.9, 0.0).bound(0.0, 1.0), f64::INFINITY);
        assert_eq!(ErrorQuantile::new(0.9, 0.0).bound(1.0, 1.0), f64::INFINITY);
    }

    /// Draws of normal noise around a bias fall inside as often as is said.
    #[test]
    fn bound_holds_as_often_as_it_says() {
        let mut rng = Rng::new(3, Stream::Test, 0, 0);
        let normal = Normal::standard();
        for confidence in [0.5, 0.9] {
            for bias in [0.0, 0.5, 1.3, 4.0] {
                let bound = ErrorQuantile::new(confidence, 1e6).bound(bias, 1.0);
                let draws = 20_000;
                let inside = (0..draws)
                    .filter(|_| {
                        let u = f64::from(rng.next_f32()).clamp(1e-7, 1.0 - 1e-7);
                        (bias + normal.inverse_cdf(u)).abs() <= bound
                    })
                    .count();
                let share = f64::from(inside as u32) / f64::from(draws);
                assert!((share - confidence).abs() < 0.015, "{confidence}, bias {bias}: {share}");
            }
        }
    }
}
