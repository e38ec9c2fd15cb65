//! Two folders of pictures held against each other: regression checks for a whole library of scenes.
//!
//! ```text
//! two folders ──Pairs──> pairs of files ──whoever compares──> [Row] ──table──> text, CSV
//!                                                                   ──page───> HTML with thumbnails
//! ```

mod page;
mod pairs;
mod row;

pub use page::page;
pub use pairs::{Pair, PairsError, pairs};
pub use row::{Row, Shown, Verdict, table};
