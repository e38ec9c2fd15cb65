use super::Metrics;
use serde::Serialize;
use std::fmt;
use std::str::FromStr;

/// A metric that can be bounded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum MetricName {
    /// [`Metrics::mae`]
    Mae,
    /// [`Metrics::mse`]
    Mse,
    /// [`Metrics::rmse`]
    Rmse,
    /// [`Metrics::rel_mse`]
    #[serde(rename = "relmse")]
    RelMse,
    /// [`Metrics::psnr`]
    Psnr,
    /// [`Metrics::max`]
    Max,
    /// [`Metrics::mean_ratio`]
    MeanRatio,
}

impl MetricName {
    /// Every metric.
    pub const ALL: [MetricName; 7] = [
        MetricName::Mae,
        MetricName::Mse,
        MetricName::Rmse,
        MetricName::RelMse,
        MetricName::Psnr,
        MetricName::Max,
        MetricName::MeanRatio,
    ];
}

impl fmt::Display for MetricName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            MetricName::Mae => "mae",
            MetricName::Mse => "mse",
            MetricName::Rmse => "rmse",
            MetricName::RelMse => "relmse",
            MetricName::Psnr => "psnr",
            MetricName::Max => "max",
            MetricName::MeanRatio => "mean-ratio",
        })
    }
}

impl FromStr for MetricName {
    type Err = BoundError;

    fn from_str(text: &str) -> Result<MetricName, BoundError> {
        MetricName::ALL
            .into_iter()
            .find(|name| name.to_string() == text)
            .ok_or_else(|| BoundError::UnknownMetric { name: text.into() })
    }
}

/// How far a metric may go, written `metric=limit`.
///
/// The limit is the largest value allowed; for `psnr` the smallest, in dB; for `mean-ratio` the largest distance of
/// any channel's ratio from 1.
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
        metrics()
    )]
    NoEquals {
        /// The text as given.
        text: String,
    },
    /// No metric has this name.
    #[error("there is no metric \"{name}\"; the metrics are {}", metrics())]
    UnknownMetric {
        /// The name as given.
        name: String,
    },
    /// The limit is no number, or one that no picture could meet or miss.
    #[error("\"{limit}\" cannot bound {metric}; give {}", allowed_limit(*.metric))]
    BadLimit {
        /// What was to be bounded.
        metric: MetricName,
        /// The limit as given.
        limit: String,
    },
}

fn metrics() -> String {
    MetricName::ALL.map(|name| name.to_string()).join(", ")
}

fn allowed_limit(metric: MetricName) -> &'static str {
    match metric {
        MetricName::Psnr => "a number of decibels, such as 40, or inf to ask for identical pictures",
        MetricName::MeanRatio => "a number from 0 on, such as 0.01 for ratios from 0.99 to 1.01",
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

impl Metrics {
    /// Whether the metric lies beyond the bound; a value equal to the limit does not, a NaN always does.
    pub fn exceeds(&self, bound: &Bound) -> bool {
        let limit = bound.limit;
        let within = match bound.metric {
            MetricName::Mae => self.mae <= limit,
            MetricName::Mse => self.mse <= limit,
            MetricName::Rmse => self.rmse <= limit,
            MetricName::RelMse => self.rel_mse <= limit,
            MetricName::Psnr => self.psnr >= limit,
            MetricName::Max => self.max <= limit,
            MetricName::MeanRatio => self.mean_ratio.iter().all(|ratio| (ratio - 1.0).abs() <= limit),
        };
        !within
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Image;
    use crate::math::Rgb;

    fn metrics_of(a: Rgb, b: Rgb) -> Metrics {
        let image = |pixel| Image::from_pixels(1, 1, vec![pixel]).unwrap();
        Metrics::between(&image(a), &image(b)).unwrap()
    }

    fn exceeds(metrics: &Metrics, bound: &str) -> bool {
        metrics.exceeds(&bound.parse().unwrap())
    }

    #[test]
    fn bounds_read_back_as_written() {
        for name in MetricName::ALL {
            let bound = Bound { metric: name, limit: 0.25 };
            assert_eq!(bound.to_string().parse(), Ok(bound));
            assert_eq!(serde_json::to_value(name).unwrap(), name.to_string());
        }
        assert_eq!(" psnr = -3".parse(), Ok(Bound { metric: MetricName::Psnr, limit: -3.0 }));
    }

    #[test]
    fn bad_bounds_are_told_what_is_allowed() {
        let text = |bound: &str| bound.parse::<Bound>().unwrap_err().to_string();
        let names = "mae, mse, rmse, relmse, psnr, max, mean-ratio";
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
        assert!(text("psnr=nan").contains("a number of decibels"));
        assert!(text("mean-ratio=-1").contains("for ratios from 0.99 to 1.01"));
    }

    #[test]
    fn each_metric_is_held_against_its_own_bound() {
        // One channel of three is off by 0.5: mae 1/6, mse 1/12, rmse 0.289, relmse 0.321, psnr 10.8 dB, max 0.5.
        let metrics = metrics_of(Rgb::new(0.5, 1.0, 1.0), Rgb::new(0.5, 1.0, 0.5));
        for (name, below, above) in [
            ("mae", 0.16, 0.17),
            ("mse", 0.083, 0.084),
            ("rmse", 0.288, 0.289),
            ("relmse", 0.320, 0.321),
            ("max", 0.49, 0.5),
            ("mean-ratio", 0.99, 1.0),
        ] {
            assert!(exceeds(&metrics, &format!("{name}={below}")), "{name}");
            assert!(!exceeds(&metrics, &format!("{name}={above}")), "{name}");
        }
        assert!(exceeds(&metrics, "psnr=10.8") && !exceeds(&metrics, "psnr=10.7"));
    }

    #[test]
    fn a_dark_channel_fails_the_mean_ratio_like_a_bright_one() {
        let metrics = metrics_of(Rgb::new(1.25, 0.5, 1.25), Rgb::ONE);
        assert_eq!(metrics.mean_ratio_overall, 1.0);
        assert!(exceeds(&metrics, "mean-ratio=0.49"));
        assert!(!exceeds(&metrics, "mean-ratio=0.5"));
    }

    #[test]
    fn identical_pictures_pass_and_nan_fails_every_bound() {
        let same = metrics_of(Rgb::ONE, Rgb::ONE);
        let nan = metrics_of(Rgb::NAN, Rgb::NAN);
        for metric in MetricName::ALL {
            let strictest = if metric == MetricName::Psnr { f64::INFINITY } else { 0.0 };
            assert!(!same.exceeds(&Bound { metric, limit: strictest }), "{metric}");
            let loosest = if metric == MetricName::Psnr { f64::NEG_INFINITY } else { f64::INFINITY };
            assert!(nan.exceeds(&Bound { metric, limit: loosest }), "{metric}");
        }
    }
}
