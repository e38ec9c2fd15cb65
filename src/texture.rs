//! Pictures on surfaces: looked up by the coordinates that meshes carry.

use std::path::PathBuf;

use crate::film::Image;
use crate::math::{Rgb, Vec2};

/// What the numbers of a picture mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// Light or colours: of PNG and JPEG by sRGB's curve, which loaders undo.
    Colour,
    /// Plain numbers, such as a roughness.
    Plain,
    /// Shares of light that meet a surface, plain: alpha where a PNG has it, else luminance.
    Opacity,
}

/// The file that holds a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PictureFile {
    /// As it was asked for.
    pub path: PathBuf,
    /// How it was read.
    pub encoding: Encoding,
}

/// A picture that repeats over the plane of texture coordinates.
///
/// It fills the unit square, its first row at the top (`v = 1`); values are bilinear between the middles of pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// For messages: the file as it was asked for.
    pub name: String,
    /// None where its pixels are those of no file of its own.
    pub file: Option<PictureFile>,
    image: Image,
}

impl Texture {
    /// `None` of a picture without pixels or with numbers that are not finite.
    pub fn new(name: impl Into<String>, image: Image) -> Option<Texture> {
        let sound = !image.pixels().is_empty() && image.count_non_finite() == 0;
        sound.then(|| Texture { name: name.into(), file: None, image })
    }

    /// The same as what a file holds.
    #[must_use]
    pub fn of_file(self, path: PathBuf, encoding: Encoding) -> Texture {
        Texture { file: Some(PictureFile { path, encoding }), ..self }
    }

    /// The same as pixels that no file holds.
    #[must_use]
    pub fn without_file(&self) -> Texture {
        Texture { file: None, ..self.clone() }
    }

    /// The value at `uv`.
    ///
    /// ```
    /// use caustica::{film::Image, math::{Rgb, Vec2}, texture::Texture};
    /// let image = Image::from_pixels(1, 2, vec![Rgb::ONE, Rgb::ZERO]).ok_or("too few")?;
    /// let texture = Texture::new("two rows", image).ok_or("not finite")?;
    /// assert_eq!(texture.at(Vec2::new(0.3, 0.75)), Rgb::ONE);
    /// assert_eq!(texture.at(Vec2::new(0.3, 0.5)), Rgb::splat(0.5));
    /// # Ok::<(), &str>(())
    /// ```
    pub fn at(&self, uv: Vec2) -> Rgb {
        let (width, height) = (self.image.width(), self.image.height());
        let (left, right, x) = between(uv.x, width);
        let (top, bottom, y) = between(1.0 - uv.y, height);
        let row = |row: usize| {
            let pixel = |column: usize| self.image.pixels()[row * width + column];
            pixel(left) * (1.0 - x) + pixel(right) * x
        };
        row(top) * (1.0 - y) + row(bottom) * y
    }

    /// The largest value of each channel: no lookup gives more.
    pub fn max(&self) -> Rgb {
        self.image.pixels().iter().copied().fold(Rgb::MIN, Rgb::max)
    }

    /// The smallest value of each channel.
    pub fn min(&self) -> Rgb {
        self.image.pixels().iter().copied().fold(Rgb::MAX, Rgb::min)
    }

    /// What it shows.
    pub fn image(&self) -> &Image {
        &self.image
    }
}

/// The two pixels of `n` whose middles are around `at` of a repeating unit, and how far it is from the first to the second.
fn between(at: f32, n: usize) -> (usize, usize, f32) {
    let place = f64::from(at).rem_euclid(1.0) * n as f64 + (n as f64 - 0.5);
    let place = if place.is_finite() { place } else { 0.0 };
    let first = place as usize;
    (first % n, (first + 1) % n, (place - first as f64) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn checks() -> Texture {
        let pixels = (0..4 * 3).map(|k| Rgb::new(k as f32, (k % 4) as f32, 1.0)).collect();
        Texture::new("checks", Image::from_pixels(4, 3, pixels).unwrap()).unwrap()
    }

    /// The middles of pixels show them, first row on top.
    #[test]
    fn middles_show_their_pixels() {
        let texture = checks();
        for (x, y) in (0..4).flat_map(|x| (0..3).map(move |y| (x, y))) {
            let uv = Vec2::new((x as f32 + 0.5) / 4.0, 1.0 - (y as f32 + 0.5) / 3.0);
            assert!((texture.at(uv) - texture.image().get(x, y)).length() < 1e-5, "{x} {y}");
        }
    }

    proptest! {
        /// Repeats, stays between its extremes, and is no jump anywhere. Catches an index beyond the last pixel.
        #[test]
        fn repeats_without_a_seam(u in -3f32..3.0, v in -3f32..3.0) {
            let texture = checks();
            let here = texture.at(Vec2::new(u, v));
            prop_assert!((here - texture.at(Vec2::new(u + 1.0, v - 2.0))).length() < 1e-3);
            prop_assert!(here.cmple(texture.max() + 1e-4).all() && here.cmpge(texture.min() - 1e-4).all());
            prop_assert!((here - texture.at(Vec2::new(u + 1e-4, v + 1e-4))).length() < 0.02);
        }
    }

    #[test]
    fn a_lookup_nowhere_gives_some_pixel() {
        assert!(checks().at(Vec2::splat(f32::NAN)).is_finite());
        assert_eq!(Texture::new("nan", Image::from_pixels(1, 1, vec![Rgb::NAN]).unwrap()), None);
    }
}
