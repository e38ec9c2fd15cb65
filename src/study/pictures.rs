//! Pictures and their errors for a page: PNG inside the HTML.

use std::path::Path;

use super::{Plan, StudyError, picture_path};
use crate::compare::{REL_MSE_EPSILON, thumbnail};
use crate::film::Image;
use crate::math::Rgb;
use crate::output::{Display, OutputError, read_exr};

/// The widest picture of a page, in pixels; larger ones are shown by the means of their blocks.
const WIDEST: usize = 320;

/// Relative errors at the ends of the false colours: 1 and 100 %.
const COLOUR_RANGE: (f64, f64) = (0.01, 1.0);

/// From small to large errors: dark blue over green to yellow, as bright as they are large.
const COLOURS: [[f32; 3]; 6] = [
    [0.27, 0.00, 0.33],
    [0.25, 0.27, 0.53],
    [0.16, 0.47, 0.56],
    [0.13, 0.66, 0.52],
    [0.48, 0.82, 0.32],
    [0.99, 0.91, 0.14],
];

/// A picture and how far it is from the reference, both as `data:` addresses.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    /// The configuration.
    pub name: &'static str,
    /// The picture.
    pub picture: String,
    /// Its errors in false colours.
    pub errors: String,
}

/// The pictures of a study.
#[derive(Clone, Debug, PartialEq)]
pub struct Gallery {
    /// The reference, as a `data:` address.
    pub reference: String,
    /// A picture of each configuration that has one.
    pub shown: Vec<Shown>,
}

impl Gallery {
    /// Reads the pictures that the measurement left in `folder`.
    ///
    /// # Errors
    /// When a picture cannot be read or encoded.
    pub fn read(plan: &Plan, reference: &Image, folder: &Path) -> Result<Gallery, StudyError> {
        let mut shown = Vec::new();
        for configuration in &plan.configurations {
            let path = picture_path(folder, configuration);
            if !path.exists() {
                continue;
            }
            let picture = read_exr(&path)?;
            let errors = errors_in_colour(&picture, reference);
            shown.push(Shown {
                name: configuration.name,
                picture: address(&path, &picture, &Display::default())?,
                errors: address(&path, &errors, &Display { gamma: 1.0, ..Display::default() })?,
            });
        }
        Ok(Gallery { reference: address(folder, reference, &Display::default())?, shown })
    }
}

fn address(path: &Path, image: &Image, display: &Display) -> Result<String, OutputError> {
    thumbnail(image, WIDEST, display).map_err(|source| OutputError::Write { path: path.into(), source })
}

/// Each pixel's relative error, as the metric of the study has it, in false colours of a display without gamma.
fn errors_in_colour(picture: &Image, reference: &Image) -> Image {
    let mut image = Image::new(reference.width(), reference.height());
    let pairs = picture.pixels().iter().zip(reference.pixels());
    for (pixel, (a, b)) in image.pixels_mut().iter_mut().zip(pairs) {
        let (a, b) = (a.as_dvec3(), b.as_dvec3());
        let squares = (a - b) * (a - b) / (b * b + REL_MSE_EPSILON);
        *pixel = false_colour((squares.element_sum() / 3.0).sqrt());
    }
    image
}

fn false_colour(error: f64) -> Rgb {
    let (low, high) = COLOUR_RANGE;
    let share = (error.max(low) / low).ln() / (high / low).ln();
    let place = share.clamp(0.0, 1.0) as f32 * (COLOURS.len() - 1) as f32;
    let index = (place as usize).min(COLOURS.len() - 2);
    Rgb::from(COLOURS[index]).lerp(Rgb::from(COLOURS[index + 1]), place - index as f32)
}

/// The false colours as a CSS gradient.
pub(super) fn gradient() -> String {
    let stops = COLOURS.map(|c| {
        let [r, g, b] = c.map(|x| (255.0 * x).round());
        format!("rgb({r},{g},{b})")
    });
    format!("linear-gradient(to right,{})", stops.join(","))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_grow_with_the_error() {
        assert_eq!(false_colour(0.0), Rgb::from(COLOURS[0]));
        assert_eq!(false_colour(0.01), Rgb::from(COLOURS[0]));
        assert!((false_colour(1.0) - Rgb::from(COLOURS[5])).length() < 1e-6);
        assert_eq!(false_colour(f64::INFINITY), false_colour(1.0));
        let middle = 0.5 * (Rgb::from(COLOURS[2]) + Rgb::from(COLOURS[3]));
        assert!((false_colour(0.1) - middle).length() < 1e-5);
        let brightness: Vec<f32> =
            (0..20).map(|k| false_colour(0.01 * 1.25f64.powi(k)).element_sum()).collect();
        assert!(brightness.is_sorted(), "{brightness:?}");
    }

    #[test]
    fn errors_are_those_of_the_metric() {
        let image = |pixels: [f32; 2]| Image::from_pixels(2, 1, pixels.map(Rgb::splat).to_vec()).unwrap();
        let errors = errors_in_colour(&image([0.03, 1.0]), &image([0.0, 1.0]));
        assert!((errors.get(0, 0) - false_colour(0.3)).length() < 1e-5, "{}", errors.get(0, 0));
        assert_eq!(errors.get(1, 0), false_colour(0.0));
    }
}
