use super::{Crop, MetricName};

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
    /// A mask picture has another size than the pictures.
    #[error(
        "the mask has {}x{} pixels, the pictures have {}x{}; give a mask of their size",
        mask.0, mask.1, picture.0, picture.1
    )]
    MaskSize {
        /// Width and height of the mask.
        mask: (usize, usize),
        /// Width and height of the pictures.
        picture: (usize, usize),
    },
    /// A crop reaches beyond the pictures.
    #[error(
        "the crop {crop} reaches beyond the pictures of {width}x{height} pixels; name a rectangle inside them"
    )]
    CropOutside {
        /// The crop as given.
        crop: Crop,
        /// Pixels in a row.
        width: usize,
        /// Number of rows.
        height: usize,
    },
    /// Crop and mask leave no pixel.
    #[error("no pixel is left to compare; give a mask with a value other than 0 inside the crop")]
    NothingLeft,
    /// A bound names a metric that needs another input.
    #[error("there is no {metric} to bound; it needs {}", metric.needs())]
    NotMeasured {
        /// The metric.
        metric: MetricName,
    },
}

pub(super) fn check_sizes(image: (usize, usize), reference: (usize, usize)) -> Result<(), CompareError> {
    let (width, height) = image;
    if image != reference {
        return Err(CompareError::SizeMismatch { image, reference });
    }
    if width == 0 || height == 0 {
        return Err(CompareError::Empty { width, height });
    }
    Ok(())
}
