//! How far a picture is from another: error metrics, bounds on them, what standard errors and predicted bounds are
//! worth, pictures of the error, and small pictures for pages.

mod blocks;
mod bound;
mod comparison;
mod coverage;
mod crop;
mod error;
mod error_picture;
mod flip;
mod metric_name;
mod metrics;
mod percentiles;
mod region;
mod statistics;
mod thumbnail;
mod z_scores;

pub use blocks::{BlockCriterion, BlockReport, WorstBlock, block_means};
pub use bound::{Bound, BoundError};
pub use comparison::{Comparison, Inputs};
pub use coverage::{Coverage, ReferenceNoise};
pub use crop::{Crop, CropError};
pub use error::CompareError;
pub use error_picture::{MASKED_COLOUR, false_colour, signed_difference};
pub use flip::{Flip, PIXELS_PER_DEGREE};
pub use metric_name::{MetricName, UnknownMetric};
pub use metrics::{Metrics, REL_MSE_EPSILON, SMAPE_EPSILON};
pub use percentiles::Percentiles;
pub use region::Region;
pub use statistics::{Estimate, share_within};
pub use thumbnail::thumbnail;
pub use z_scores::ZScores;
