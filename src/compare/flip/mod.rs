mod colour;
mod convolve;
mod ldr;

use super::{CompareError, Region};
use crate::film::Image;
use crate::math::Rgb;
use ldr::LdrFlip;
use serde::Serialize;
use std::fmt;

pub use ldr::PIXELS_PER_DEGREE;

/// The numerator and the denominator of the tone map, `(a x² + b x + c)`, highest power first: the fit to ACES of
/// Narkowicz (2016), without its exposure of 1 / 0.6.
const TONE_MAP: [[f32; 3]; 2] = [[0.36 * 2.51, 0.6 * 0.03, 0.0], [0.36 * 2.43, 0.6 * 0.59, 0.14]];
/// What the tone map makes of the luminance that an exposure is set by.
const EXPOSED: f32 = 0.85;

/// How different two pictures look at any exposure: HDR-FLIP, the largest LDR-FLIP of each pixel over a range of
/// exposures under a tone map, and of these the mean.
///
/// The exposures, a stop or less apart, start where the brightest luminance of the reference is mapped to 0.85 and stop
/// where its median is. Of a black median, the median of the luminances above 0 takes the place; of a reference
/// that is black everywhere, an exposure of 0. All for 67 pixels a degree ([`PIXELS_PER_DEGREE`]).
///
/// # Source
/// Andersson, Nilsson, Shirley and Akenine-Möller, "Visualizing Errors in Rendered High Dynamic Range Images",
/// Eurographics Short Papers, 2021.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Flip {
    /// Mean over the pixels, from 0 (no difference seen) to 1; NaN if any pixel that counts is not finite.
    pub mean: f64,
    /// Largest value of a pixel; NaN as above.
    pub max: f64,
    /// First exposure in stops.
    pub start: f32,
    /// Last exposure in stops.
    pub stop: f32,
    /// Number of exposures.
    pub exposures: usize,
}

impl Flip {
    /// Measures `image` against `reference` over the pixels of a region.
    ///
    /// The filters of FLIP look at a pixel's surroundings: of those, pixels outside the crop do not exist, and masked
    /// ones are the same in both pictures.
    ///
    /// # Errors
    /// When a picture differs in size from the region.
    pub fn between(image: &Image, reference: &Image, region: &Region) -> Result<Flip, CompareError> {
        region.check(image)?;
        region.check(reference)?;
        if region.pixels().any(|i| !(image.pixels()[i].is_finite() && reference.pixels()[i].is_finite())) {
            let (mean, max) = (f64::NAN, f64::NAN);
            return Ok(Flip { mean, max, start: f32::NAN, stop: f32::NAN, exposures: 0 });
        }
        let (mut image, mut reference, counts) =
            (region.cut(image), region.cut(reference), region.cut_mask());
        let masked = (0..counts.len()).filter(|&pixel| !counts[pixel]);
        masked.for_each(|pixel| even_out(&mut image.pixels_mut()[pixel], &mut reference.pixels_mut()[pixel]));
        let counted = || (0..counts.len()).filter(|&pixel| counts[pixel]);
        let exposures = Exposures::of(counted().map(|pixel| luminance(reference.pixels()[pixel])).collect());
        let map = error_map(&image, &reference, &exposures);
        Ok(Flip {
            mean: counted().map(|pixel| f64::from(map[pixel])).sum::<f64>() / region.len() as f64,
            max: counted().map(|pixel| f64::from(map[pixel])).fold(0.0, f64::max),
            start: exposures.start,
            stop: exposures.stop,
            exposures: exposures.count,
        })
    }
}

impl fmt::Display for Flip {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "flip        {:.6} (max {:.6}; {} exposures ", self.mean, self.max, self.exposures)?;
        write!(f, "from {:.2} to {:.2} stops)", self.start, self.stop)
    }
}

/// Makes a masked pixel the same in both pictures, and finite.
fn even_out(image: &mut Rgb, reference: &mut Rgb) {
    if !reference.is_finite() {
        *reference = Rgb::ZERO;
    }
    *image = *reference;
}

/// HDR-FLIP of every pixel.
fn error_map(image: &Image, reference: &Image, exposures: &Exposures) -> Vec<f32> {
    let flip = LdrFlip::new();
    let mut map = vec![0.0; image.pixels().len()];
    for stops in exposures.stops() {
        let shown = |image: &Image| image.pixels().iter().map(|&rgb| shown(rgb, stops)).collect::<Vec<_>>();
        let errors = flip.map(image.width(), &shown(image), &shown(reference));
        map.iter_mut().zip(errors).for_each(|(most, error): (&mut f32, f32)| *most = most.max(error));
    }
    map
}

/// A range of exposures in stops, evenly spaced.
struct Exposures {
    start: f32,
    stop: f32,
    count: usize,
}

impl Exposures {
    fn of(mut luminances: Vec<f32>) -> Exposures {
        let brightest = luminances.iter().copied().fold(0.0, f32::max);
        if brightest <= 0.0 {
            return Exposures { start: 0.0, stop: 0.0, count: 1 };
        }
        let mut middle = upper_median(&mut luminances);
        if middle <= 0.0 {
            luminances.retain(|&luminance| luminance > 0.0);
            middle = upper_median(&mut luminances);
        }
        let exposed = exposed_luminance();
        let (start, stop) = ((exposed / brightest).log2(), (exposed / middle).log2());
        Exposures { start, stop, count: (stop - start).ceil().max(2.0) as usize }
    }

    fn stops(&self) -> impl Iterator<Item = f32> {
        let (start, step) = (self.start, (self.stop - self.start) / (self.count - 1).max(1) as f32);
        (0..self.count).map(move |i| start + i as f32 * step)
    }
}

/// Of an even number of values, the larger one in the middle; `values` is not empty.
fn upper_median(values: &mut [f32]) -> f32 {
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f32::total_cmp).1
}

fn luminance(rgb: Rgb) -> f32 {
    Rgb::new(0.2126, 0.7152, 0.0722).dot(rgb)
}

/// The value that the tone map maps to [`EXPOSED`]: the larger root of a quadratic equation.
fn exposed_luminance() -> f32 {
    let [a, b, c] = [0, 1, 2].map(|i| TONE_MAP[0][i] - EXPOSED * TONE_MAP[1][i]);
    (-b + (b * b - 4.0 * a * c).sqrt()) / (2.0 * a)
}

/// What a display shows of a linear colour at an exposure in stops.
fn shown(rgb: Rgb, stops: f32) -> Rgb {
    // Where squares overflow, the tone map has long reached its limit, which lies above 1.
    let x = (rgb * stops.exp2()).clamp(Rgb::ZERO, Rgb::splat(1e9));
    let [above, below] = TONE_MAP.map(|[a, b, c]| (x * a + b) * x + c);
    (above / below).clamp(Rgb::ZERO, Rgb::ONE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::Crop;

    /// Two pictures in whole numbers and powers of two, with a bright spot, that any language makes alike.
    fn pair(width: usize, height: usize) -> (Image, Image) {
        let (mut image, mut reference) = (Image::new(width, height), Image::new(width, height));
        for pixel in 0..width * height {
            let (x, y) = (pixel % width, pixel / width);
            let spot = (x, y) == (width / 2, height / 2);
            for c in 0..3 {
                let squares = ((x / 8 + y / 8) % 2 * (c + 1)) as f32 / 4.0;
                let value = if spot { 100.0 } else { ((7 * x + 13 * y + 5 * c) % 32) as f32 / 8.0 + squares };
                let error = 1.0 + (((x + 2 * y + 3 * c) % 5) as f32 - 2.0) / 16.0;
                let stripe = if x % 16 == 3 { 0.25 } else { 0.0 };
                reference.pixels_mut()[pixel][c] = value;
                image.pixels_mut()[pixel][c] = value * error + stripe;
            }
        }
        (image, reference)
    }

    fn flip(image: &Image, reference: &Image) -> Flip {
        Flip::between(image, reference, &Region::of(reference)).unwrap()
    }

    #[test]
    fn the_authors_program_finds_the_same() {
        // flip-evaluator 1.7 from PyPI: `evaluate(reference, image, "HDR")` of the pairs above.
        let published =
            [((32, 24), 0.080_361_1, 0.183_350, -0.005_625), ((67, 41), 0.075_502_3, 0.201_861, 0.056_674)];
        for ((width, height), mean, max, stop) in published {
            let (image, reference) = pair(width, height);
            let found = flip(&image, &reference);
            assert!((found.mean - mean).abs() < 2e-6 && (found.max - max).abs() < 1e-5, "{found:?}");
            assert!((found.start + 5.560_559).abs() < 1e-5 && (found.stop - stop).abs() < 1e-5, "{found:?}");
            assert_eq!(found.exposures, 6);
        }
    }

    fn rounded_to_8_bits(linear: Rgb) -> Rgb {
        let encode = |x: f32| if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
        let decode = |x: f32| if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) };
        linear.map(|x| decode((255.0 * encode(x)).round() / 255.0))
    }

    #[test]
    fn eight_bits_are_too_few() {
        let (_, reference) = pair(67, 41);
        let image =
            Image::from_pixels(67, 41, reference.pixels().iter().map(|&p| 1.002 * p).collect()).unwrap();
        let fine = flip(&image, &reference);
        let (ldr, mut map) = (LdrFlip::new(), vec![0.0f32; 67 * 41]);
        for stops in (Exposures { start: fine.start, stop: fine.stop, count: fine.exposures }).stops() {
            let rounded = |image: &Image| -> Vec<Rgb> {
                image.pixels().iter().map(|&p| rounded_to_8_bits(shown(p, stops))).collect()
            };
            let errors = ldr.map(67, &rounded(&image), &rounded(&reference));
            map.iter_mut().zip(errors).for_each(|(most, error)| *most = most.max(error));
        }
        let coarse = map.iter().sum::<f32>() / map.len() as f32;
        println!("a difference of 0.2 %: {:.6} in single precision, {coarse:.6} in 8 bits", fine.mean);
        assert!(f64::from(coarse) > 1.2 * fine.mean, "{coarse} {}", fine.mean);
    }

    #[test]
    fn equal_pictures_do_not_flicker() {
        let (image, _) = pair(9, 7);
        assert_eq!((flip(&image, &image).mean, flip(&image, &image).max), (0.0, 0.0));
        let black = Image::new(5, 4);
        let of_black = flip(&black, &black);
        assert_eq!((of_black.mean, of_black.exposures), (0.0, 1));
    }

    #[test]
    fn a_black_median_gives_way_to_that_of_the_light() {
        let lit = |n: usize| [vec![0.0; 7], vec![8.0; n], vec![1.0; 3 - n]].concat();
        let exposures = Exposures::of(lit(1));
        assert_eq!((exposures.stop - exposures.start, exposures.count), (3.0, 3));
        assert_eq!(
            exposures.stops().map(|stops| stops - exposures.start).collect::<Vec<_>>(),
            [0.0, 1.5, 3.0]
        );
        assert_eq!(Exposures::of(lit(3)).count, 2);
    }

    #[test]
    fn masked_pixels_are_not_seen_even_beside_others() {
        let (mut image, mut reference) = pair(20, 10);
        let mask: Vec<Rgb> = (0..200).map(|pixel| Rgb::splat(f32::from(pixel % 20 != 12))).collect();
        let region = Region::of(&image).with_mask(&Image::from_pixels(20, 10, mask).unwrap()).unwrap();
        let masked =
            |image: &Image, reference: &Image| Flip::between(image, reference, &region).unwrap().mean;
        let before = masked(&image, &reference);
        for y in 0..10 {
            image.pixels_mut()[20 * y + 12] = Rgb::NAN;
        }
        assert_eq!(masked(&image, &reference), before);
        assert!(flip(&image, &reference).mean.is_nan() && flip(&image, &reference).max.is_nan());
        reference.pixels_mut()[12] = Rgb::INFINITY;
        assert!(masked(&image, &reference).is_finite());
    }

    #[test]
    fn a_crop_is_a_picture_of_its_own() {
        let (image, reference) = pair(30, 20);
        let crop = Crop { x: 3, y: 5, width: 12, height: 9 };
        let region = Region::of(&image).with_crop(crop).unwrap();
        let cropped = Flip::between(&image, &reference, &region).unwrap();
        assert_eq!(cropped, flip(&region.cut(&image), &region.cut(&reference)));
    }

    #[test]
    fn enormous_and_negative_values_are_shown_white_and_black() {
        assert_eq!(shown(Rgb::new(-3.0, f32::MAX, 1e30), 20.0), Rgb::new(0.0, 1.0, 1.0));
    }
}
