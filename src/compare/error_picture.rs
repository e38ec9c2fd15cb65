use super::{CompareError, REL_MSE_EPSILON, Region};
use crate::film::Image;
use crate::math::Rgb;

/// What stands for a pixel that the mask leaves out.
pub const MASKED_COLOUR: [u8; 3] = [128, 128, 128];
/// What stands for a pixel that is not finite in either picture.
const NOT_FINITE_COLOUR: [u8; 3] = [255, 0, 255];

/// The signed difference `image - reference` inside the crop; 0 where the mask leaves pixels out.
///
/// # Errors
/// When a picture differs in size from the region.
pub fn signed_difference(image: &Image, reference: &Image, region: &Region) -> Result<Image, CompareError> {
    region.check(image)?;
    region.check(reference)?;
    let (mut picture, reference, counts) = (region.cut(image), region.cut(reference), region.cut_mask());
    for ((a, &b), counts) in picture.pixels_mut().iter_mut().zip(reference.pixels()).zip(counts) {
        *a = if counts { *a - b } else { Rgb::ZERO };
    }
    Ok(picture)
}

/// The relative error of each pixel inside the crop, `√(Σ (a - b)² / (b² + ε) / 3)` over the channels, in the colours
/// of viridis: dark violet is 0, yellow is `scale` (more than 0) and beyond, linear between.
///
/// The mean of the squares of these errors is [`Metrics::rel_mse`](super::Metrics::rel_mse). Masked pixels are grey
/// ([`MASKED_COLOUR`]), pixels that are not finite magenta.
///
/// # Errors
/// When a picture differs in size from the region.
pub fn false_colour(
    image: &Image,
    reference: &Image,
    region: &Region,
    scale: f64,
) -> Result<Vec<[u8; 3]>, CompareError> {
    region.check(image)?;
    region.check(reference)?;
    let (image, reference, counts) = (region.cut(image), region.cut(reference), region.cut_mask());
    let pairs = image.pixels().iter().zip(reference.pixels());
    let colour = |(&a, &b)| viridis(relative_error(a, b) / scale);
    Ok(pairs.zip(counts).map(|(pair, counts)| if counts { colour(pair) } else { MASKED_COLOUR }).collect())
}

/// NaN if either colour is not finite.
fn relative_error(a: Rgb, b: Rgb) -> f64 {
    if !(a.is_finite() && b.is_finite()) {
        return f64::NAN;
    }
    let (a, b) = (a.as_dvec3(), b.as_dvec3());
    ((a - b) * (a - b) / (b * b + REL_MSE_EPSILON)).element_sum().sqrt() / 3f64.sqrt()
}

fn viridis(share: f64) -> [u8; 3] {
    if share.is_nan() {
        return NOT_FINITE_COLOUR;
    }
    colorous::VIRIDIS.eval_continuous(share.min(1.0)).as_array()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::{Crop, Metrics};

    fn row(pixels: &[[f32; 3]]) -> Image {
        Image::from_pixels(pixels.len(), 1, pixels.iter().map(|&pixel| Rgb::from(pixel)).collect()).unwrap()
    }

    #[test]
    fn differences_keep_their_sign_inside_the_region() {
        let a = row(&[[9.0; 3], [1.0, 2.0, 3.0], [9.0; 3], [0.0, 0.0, 0.5]]);
        let b = row(&[[1.0; 3], [1.0, 1.0, 4.0], [1.0; 3], [0.5, 0.0, 0.5]]);
        let mask = row(&[[1.0; 3], [1.0; 3], [0.0; 3], [1.0; 3]]);
        let region = Region::of(&a).with_mask(&mask).unwrap();
        let region = region.with_crop(Crop { x: 1, y: 0, width: 3, height: 1 }).unwrap();
        let difference = signed_difference(&a, &b, &region).unwrap();
        assert_eq!(difference, row(&[[0.0, 1.0, -1.0], [0.0; 3], [-0.5, 0.0, 0.0]]));
        assert_eq!(false_colour(&a, &b, &region, 1.0).unwrap()[1], MASKED_COLOUR);
        assert!(signed_difference(&row(&[[1.0; 3]]), &b, &region).is_err());
    }

    #[test]
    fn the_squares_of_relative_errors_have_the_metric_as_their_mean() {
        let (a, b) = (row(&[[1.0, 2.0, 0.5], [0.0; 3]]), row(&[[1.0, 1.0, 0.5], [0.0, 0.0, 0.5]]));
        let errors = a.pixels().iter().zip(b.pixels()).map(|(&a, &b)| relative_error(a, b));
        let mean = errors.map(|error| error * error).sum::<f64>() / 2.0;
        assert!((mean - Metrics::between(&a, &b).unwrap().rel_mse).abs() < 1e-12);
    }

    #[test]
    fn colours_run_from_violet_to_yellow_and_shout_where_they_cannot() {
        // The ends of viridis as published: #440154 and #fde725.
        let (low, high) = ([68, 1, 84], [253, 231, 37]);
        let a = row(&[[1.0; 3], [3.0; 3], [500.0; 3], [f32::NAN; 3], [f32::INFINITY; 3]]);
        let b = row(&[[1.0; 3]; 5]);
        let colours = false_colour(&a, &b, &Region::of(&a), 1.99).unwrap();
        assert_eq!(colours, [low, high, high, NOT_FINITE_COLOUR, NOT_FINITE_COLOUR]);
        let halved = false_colour(&a, &b, &Region::of(&a), 4.0).unwrap()[1];
        assert!(halved != low && halved != high);
    }
}
