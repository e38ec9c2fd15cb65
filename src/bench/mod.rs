//! Measurements of the program against what it could be: one file for each question.
//!
//! - [`pass`]: what does a photon pass cost beyond tracing its rays?
//! - [`gather`]: does the sphere tree beat Embree's point query and a hash grid?
//!
//! Each measures in interleaved rounds ([`timing`]), tells its [`machine`], and answers with a report that is
//! serialisable and turns into a [`crate::report::Page`]. Rivals must agree on every count, or the measurement fails;
//! nothing is ever judged by its time.

mod error;
pub mod gather;
mod hash_grid;
pub mod machine;
mod morton;
pub mod pass;
pub mod structures;
pub mod timing;

pub use error::BenchError;
pub use hash_grid::HashGrid;
