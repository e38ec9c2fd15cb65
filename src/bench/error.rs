use thiserror::Error;

use crate::bvh::RayBvhError;
use crate::embree::EmbreeError;
use crate::scene::TraversalError;

/// Why a measurement says nothing.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum BenchError {
    /// Embree could not be used.
    #[error(transparent)]
    Embree(#[from] EmbreeError),
    /// The project's own tree could not be built.
    #[error(transparent)]
    Custom(#[from] RayBvhError),
    /// Neither of them would have the scene.
    #[error(transparent)]
    Traversal(#[from] TraversalError),
    /// The k-d tree could not be built.
    #[error("kiddo cannot build its tree: {reason}")]
    Kiddo {
        /// What it says.
        reason: String,
    },
    /// A picture too small, or one that shows nothing diffuse.
    #[error(
        "{scene}: {samples} eye samples a pixel leave {found} of {asked} hit points: ask for fewer, or for a larger picture"
    )]
    TooFewHitPoints {
        /// The scene.
        scene: String,
        /// As many samples a pixel as were tried.
        samples: usize,
        /// The hit points that they left.
        found: usize,
        /// The hit points asked for.
        asked: usize,
    },
    /// A scene without light, or one whose light meets nothing diffuse.
    #[error("{scene}: no photon lands on a diffuse surface: give it a light that reaches one")]
    NoPhotons {
        /// The scene.
        scene: String,
    },
    /// A picture without caustics.
    #[error("{scene}: no caustic is seen: give it mirrors or glass that cast one into the picture")]
    NoCaustic {
        /// The scene.
        scene: String,
    },
    /// The surfaces of a render have no known area.
    #[error("{scene}: radii cannot be chosen by overlaps in a render: give them in percent")]
    NoOverlaps {
        /// The scene.
        scene: String,
    },
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
