//! How far a picture is from another: error metrics, bounds on them, and statistics over blocks of pixels.

mod blocks;
mod bound;
mod metrics;
mod statistics;

use crate::film::Image;

pub use blocks::{BlockCriterion, BlockReport, WorstBlock, block_means};
pub use bound::{Bound, BoundError, MetricName};
pub use metrics::{Metrics, REL_MSE_EPSILON};
pub use statistics::{Estimate, share_within};

/// Why two pictures cannot be compared.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum CompareError {
    /// The pictures differ in width or height.
    #[error(
        "the pictures differ in size: {}x{} against {}x{}; compare pictures of the same size",
        image.0, image.1, reference.0, reference.1
    )]
    SizeMismatch {
        /// Width and height of the first picture.
        image: (usize, usize),
        /// Width and height of the second picture.
        reference: (usize, usize),
    },
    /// The pictures hold no pixels.
    #[error("the pictures are empty ({width}x{height}); compare pictures of at least one pixel")]
    Empty {
        /// Pixels in a row.
        width: usize,
        /// Number of rows.
        height: usize,
    },
    /// A mask has not one entry for each pixel.
    #[error("the mask has {mask} entries for {pixels} pixels; give one for each pixel, row by row")]
    MaskLength {
        /// Number of entries.
        mask: usize,
        /// Number of pixels.
        pixels: usize,
    },
}

fn check_sizes(image: &Image, reference: &Image) -> Result<(), CompareError> {
    let size = |image: &Image| (image.width(), image.height());
    let (width, height) = size(image);
    if size(image) != size(reference) {
        return Err(CompareError::SizeMismatch { image: size(image), reference: size(reference) });
    }
    if image.pixels().is_empty() {
        return Err(CompareError::Empty { width, height });
    }
    Ok(())
}
