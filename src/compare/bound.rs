use super::{MetricName, UnknownMetric};
use serde::Serialize;
use std::fmt;
use std::str::FromStr;

/// How far a metric may go, written `metric=limit`; whether up or down, [`Comparison::exceeds`] and
/// [`Comparison::falls_below`] say.
///
/// [`Comparison::exceeds`]: super::Comparison::exceeds
/// [`Comparison::falls_below`]: super::Comparison::falls_below
///
/// ```
/// use caustica::compare::{Bound, MetricName};
/// let bound: Bound = "relmse=0.01".parse()?;
/// assert_eq!(bound, Bound { metric: MetricName::RelMse, limit: 0.01 });
/// assert_eq!(bound.to_string(), "relmse=0.01");
/// # Ok::<(), caustica::compare::BoundError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bound {
    /// What is bounded.
    pub metric: MetricName,
    /// How far it may go.
    pub limit: f64,
}

/// Why a text is no bound.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum BoundError {
    /// There is no `=`.
    #[error(
        "\"{text}\" is no bound; write metric=limit, such as relmse=0.01, with one of the metrics {}",
        MetricName::list()
    )]
    NoEquals {
        /// The text as given.
        text: String,
    },
    /// No metric has this name.
    #[error(transparent)]
    UnknownMetric(#[from] UnknownMetric),
    /// The limit is no number, or one that no picture could meet or miss.
    #[error("\"{limit}\" cannot bound {metric}; give {}", allowed_limit(*.metric))]
    BadLimit {
        /// What was to be bounded.
        metric: MetricName,
        /// The limit as given.
        limit: String,
    },
}

fn allowed_limit(metric: MetricName) -> &'static str {
    match metric {
        MetricName::Psnr => "a number of decibels, such as 40, or inf to ask for identical pictures",
        MetricName::MeanRatio => "a number from 0 on, such as 0.01 for ratios from 0.99 to 1.01",
        share if share.is_share() => "a share from 0 to 1, such as 0.95",
        _ => "a number from 0 on, such as 0.01",
    }
}

impl FromStr for Bound {
    type Err = BoundError;

    fn from_str(text: &str) -> Result<Bound, BoundError> {
        let (name, limit) = text.split_once('=').ok_or_else(|| BoundError::NoEquals { text: text.into() })?;
        let metric = name.trim().parse()?;
        let allowed = |limit: &f64| match metric {
            MetricName::Psnr => !limit.is_nan() && *limit > f64::NEG_INFINITY,
            share if share.is_share() => (0.0..=1.0).contains(limit),
            _ => limit.is_finite() && *limit >= 0.0,
        };
        let parsed = limit.trim().parse().ok().filter(allowed);
        parsed
            .map(|limit| Bound { metric, limit })
            .ok_or_else(|| BoundError::BadLimit { metric, limit: limit.trim().into() })
    }
}

impl fmt::Display for Bound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={}", self.metric, self.limit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_read_back_as_written() {
        for metric in MetricName::ALL {
            let bound = Bound { metric, limit: 0.25 };
            assert_eq!(bound.to_string().parse(), Ok(bound));
        }
        assert_eq!(" psnr = -3".parse(), Ok(Bound { metric: MetricName::Psnr, limit: -3.0 }));
    }

    #[test]
    fn bad_bounds_are_told_what_is_allowed() {
        let text = |bound: &str| bound.parse::<Bound>().unwrap_err().to_string();
        let names = MetricName::list();
        assert_eq!(
            text("relmse"),
            format!(
                "\"relmse\" is no bound; write metric=limit, such as relmse=0.01, with one of the metrics {names}"
            )
        );
        assert_eq!(text("ssim=1"), format!("there is no metric \"ssim\"; the metrics are {names}"));
        for limit in ["", "x", "-1", "nan", "inf"] {
            let right = format!("\"{limit}\" cannot bound mse; give a number from 0 on, such as 0.01");
            assert_eq!(text(&format!("mse={limit}")), right);
        }
        for limit in ["-0.1", "1.1", "nan"] {
            let right = format!("\"{limit}\" cannot bound coverage; give a share from 0 to 1, such as 0.95");
            assert_eq!(text(&format!("coverage={limit}")), right);
        }
        assert!(text("psnr=nan").contains("a number of decibels"));
        assert!(text("mean-ratio=-1").contains("for ratios from 0.99 to 1.01"));
    }
}
