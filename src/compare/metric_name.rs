use serde::{Serialize, Serializer};
use std::fmt;
use std::str::FromStr;

/// A metric that can be bounded; its text is what [`Bound`](super::Bound) calls it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MetricName {
    /// `mae`: [`Metrics::mae`](super::Metrics::mae)
    Mae,
    /// `mse`: [`Metrics::mse`](super::Metrics::mse)
    Mse,
    /// `rmse`: [`Metrics::rmse`](super::Metrics::rmse)
    Rmse,
    /// `relmse`: [`Metrics::rel_mse`](super::Metrics::rel_mse)
    RelMse,
    /// `smape`: [`Metrics::smape`](super::Metrics::smape)
    Smape,
    /// `psnr`: [`Metrics::psnr`](super::Metrics::psnr)
    Psnr,
    /// `max`: [`Metrics::max`](super::Metrics::max)
    Max,
    /// `p50`: [`Percentiles::p50`](super::Percentiles::p50)
    P50,
    /// `p90`: [`Percentiles::p90`](super::Percentiles::p90)
    P90,
    /// `p95`: [`Percentiles::p95`](super::Percentiles::p95)
    P95,
    /// `p99`: [`Percentiles::p99`](super::Percentiles::p99)
    P99,
    /// `p99.9`: [`Percentiles::p99_9`](super::Percentiles::p99_9)
    P99_9,
    /// `mean-ratio`: the largest distance of any channel's [`Metrics::mean_ratio`](super::Metrics::mean_ratio) from 1
    MeanRatio,
    /// `flip`: [`Flip::mean`](super::Flip::mean)
    Flip,
    /// `block-max`: [`WorstBlock::relative_difference`](super::WorstBlock::relative_difference)
    BlockMax,
    /// `block-share`: [`BlockReport::share_within`](super::BlockReport::share_within)
    BlockShare,
    /// `z-rms`: [`ZScores::rms`](super::ZScores::rms)
    ZRms,
    /// `z1`: [`ZScores::below_1`](super::ZScores::below_1)
    Z1,
    /// `z2`: [`ZScores::below_2`](super::ZScores::below_2)
    Z2,
    /// `z3`: [`ZScores::below_3`](super::ZScores::below_3)
    Z3,
    /// `coverage`: [`Coverage::share`](super::Coverage::share)
    Coverage,
    /// `untrusted`: [`Coverage::untrusted`](super::Coverage::untrusted)
    Untrusted,
}

impl MetricName {
    /// Every metric.
    pub const ALL: [MetricName; 22] = [
        MetricName::Mae,
        MetricName::Mse,
        MetricName::Rmse,
        MetricName::RelMse,
        MetricName::Smape,
        MetricName::Psnr,
        MetricName::Max,
        MetricName::P50,
        MetricName::P90,
        MetricName::P95,
        MetricName::P99,
        MetricName::P99_9,
        MetricName::MeanRatio,
        MetricName::Flip,
        MetricName::BlockMax,
        MetricName::BlockShare,
        MetricName::ZRms,
        MetricName::Z1,
        MetricName::Z2,
        MetricName::Z3,
        MetricName::Coverage,
        MetricName::Untrusted,
    ];

    /// Whether its values lie between 0 and 1, both possible.
    pub fn is_share(self) -> bool {
        use MetricName::{BlockShare, Coverage, Untrusted, Z1, Z2, Z3};
        matches!(self, BlockShare | Z1 | Z2 | Z3 | Coverage | Untrusted)
    }

    /// What must be given, beside two pictures, for there to be such a metric.
    pub(super) fn needs(self) -> &'static str {
        match self {
            MetricName::Coverage | MetricName::Untrusted => "a picture of bounds (--bound)",
            MetricName::ZRms | MetricName::Z1 | MetricName::Z2 | MetricName::Z3 => {
                "the standard error of either picture (--stderr, --reference-stderr)"
            }
            _ => "nothing but the two pictures",
        }
    }

    /// All names, as text to choose from.
    pub(super) fn list() -> String {
        MetricName::ALL.map(|name| name.to_string()).join(", ")
    }
}

impl fmt::Display for MetricName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            MetricName::Mae => "mae",
            MetricName::Mse => "mse",
            MetricName::Rmse => "rmse",
            MetricName::RelMse => "relmse",
            MetricName::Smape => "smape",
            MetricName::Psnr => "psnr",
            MetricName::Max => "max",
            MetricName::P50 => "p50",
            MetricName::P90 => "p90",
            MetricName::P95 => "p95",
            MetricName::P99 => "p99",
            MetricName::P99_9 => "p99.9",
            MetricName::MeanRatio => "mean-ratio",
            MetricName::Flip => "flip",
            MetricName::BlockMax => "block-max",
            MetricName::BlockShare => "block-share",
            MetricName::ZRms => "z-rms",
            MetricName::Z1 => "z1",
            MetricName::Z2 => "z2",
            MetricName::Z3 => "z3",
            MetricName::Coverage => "coverage",
            MetricName::Untrusted => "untrusted",
        })
    }
}

impl Serialize for MetricName {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// No metric has this name.
#[derive(Debug, PartialEq, thiserror::Error)]
#[error("there is no metric \"{name}\"; the metrics are {}", MetricName::list())]
pub struct UnknownMetric {
    name: String,
}

impl FromStr for MetricName {
    type Err = UnknownMetric;

    fn from_str(text: &str) -> Result<MetricName, UnknownMetric> {
        let mut all = MetricName::ALL.into_iter();
        all.find(|name| name.to_string() == text).ok_or_else(|| UnknownMetric { name: text.into() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_as_written() {
        for name in MetricName::ALL {
            assert_eq!(name.to_string().parse(), Ok(name));
            assert_eq!(serde_json::to_value(name).unwrap(), name.to_string());
        }
        let text = "ssim".parse::<MetricName>().unwrap_err().to_string();
        assert!(text.starts_with("there is no metric \"ssim\"; the metrics are mae, mse, "), "{text}");
    }
}
