use thiserror::Error;

use crate::bvh::RayBvhError;
use crate::embree::EmbreeError;

/// Why a measurement says nothing.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum BenchError {
    /// Embree could not be used.
    #[error(transparent)]
    Embree(#[from] EmbreeError),
    /// The project's own tree could not be built.
    #[error(transparent)]
    Custom(#[from] RayBvhError),
    /// Structures that should do the same work do not.
    #[error(
        "{structure} finds {found} photons in sphere {sphere}, but {reference} finds {expected}: one is wrong"
    )]
    Counts {
        /// The structure that differs.
        structure: &'static str,
        /// The structure that it differs from.
        reference: &'static str,
        /// The first sphere on which they differ.
        sphere: usize,
        /// What the one found there.
        found: u32,
        /// What the other found there.
        expected: u32,
    },
}
