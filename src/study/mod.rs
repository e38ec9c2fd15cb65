//! What accuracy costs in time: error against seconds for a set of configurations.
//!
//! [`configurations`] lists what is measured against what, [`mod@reference`] makes the picture that all are held against,
//! [`measure`] renders in turn and notes errors in a [`Journal`], and [`StudyReport`] sums up: as JSON, as CSV and as
//! one page for a browser.

mod configuration;
mod convergence;
mod curve_point;
mod error;
mod fingerprint;
mod fit;
mod flat;
mod journal;
mod leader;
mod looks;
mod measure;
mod page;
mod page_convergence;
mod page_words;
mod pictures;
pub mod reference;
mod report;
mod separation;
mod summary;
#[cfg(test)]
mod testing;
mod theory;
mod watch;

pub use configuration::{Axis, Configuration, Method, Subject, configurations};
pub use convergence::{Convergence, Rate};
pub use curve_point::{CurvePoint, ErrorSpread};
pub use error::StudyError;
pub use fit::{Confidence, crossing, pareto_front, price_of_half, tail};
pub use journal::{Journal, Point, Run};
pub use leader::Duel;
pub use measure::{Plan, measure, picture_path};
pub use page::{page, prices};
pub use pictures::{Gallery, Shown};
pub use report::{FrontRow, StudyReport, TARGETS};
pub use separation::{Parts, Separation};
pub use summary::{Conclusion, Curve, SecondsTo};
pub use theory::Theory;
pub use watch::Watch;
