//! Measurements of the program against what it could be: one file for each question.
//!
//! - [`aim`]: what do photons aimed at glass gain?
//! - [`guide`]: what do photons guided to what is seen gain?
//! - [`pass`]: what does a photon pass cost beyond tracing its rays?
//! - [`gather`]: does the sphere tree beat Embree's point query, a hash grid and a k-d tree?
//! - [`leaks`]: do rays slip through closed meshes?
//! - [`numerics`]: what does precision buy?
//! - [`rays`]: which of Embree's ways answers which rays fastest, and what of the project's own tree?
//!
//! Each measures in interleaved rounds ([`timing`]), tells its [`machine`], and answers with a report that is
//! serialisable and turns into a [`crate::report::Page`]. Rivals of the gather must agree on every count, or
//! the measurement fails; those of the rays tell how often they disagree. Nothing is ever judged by its time.

pub mod aim;
mod closed_meshes;
pub mod equal_time;
mod error;
pub mod gather;
mod gather_page;
pub mod gather_source;
pub mod guide;
mod hash_grid;
mod kd_tree;
pub mod leaks;
mod leaks_page;
pub mod machine;
mod morton;
pub mod numerics;
pub mod pass;
pub mod ray_engines;
pub mod ray_scenes;
pub mod rays;
mod rays_page;
pub mod structures;
pub mod timing;

pub use error::BenchError;
pub use hash_grid::HashGrid;
pub use kd_tree::KdTree;

/// The distinct among `items`, which are few.
fn in_order_of_appearance<T: PartialEq>(items: impl Iterator<Item = T>) -> Vec<T> {
    let mut distinct = Vec::new();
    for item in items {
        if !distinct.contains(&item) {
            distinct.push(item);
        }
    }
    distinct
}
