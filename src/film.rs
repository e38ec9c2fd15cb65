//! The picture: a grid of linear RGB values in memory, before any file format or display curve.

use crate::math::Rgb;

/// A picture in linear RGB, row-major from the top left.
///
/// ```
/// use caustica::{film::Image, math::Rgb};
/// let mut image = Image::new(3, 2);
/// image.pixels_mut()[4] = Rgb::ONE;
/// assert_eq!(image.get(1, 1), Rgb::ONE);
/// assert_eq!(image.get(0, 0), Rgb::ZERO);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    width: usize,
    height: usize,
    pixels: Vec<Rgb>,
}

impl Image {
    /// A black picture of `width × height` pixels; either may be 0.
    pub fn new(width: usize, height: usize) -> Image {
        Image { width, height, pixels: vec![Rgb::ZERO; width * height] }
    }

    /// The picture that holds `pixels`, row by row from the top; `None` unless there are exactly `width × height`.
    pub fn from_pixels(width: usize, height: usize, pixels: Vec<Rgb>) -> Option<Image> {
        let fits = width.checked_mul(height) == Some(pixels.len());
        fits.then_some(Image { width, height, pixels })
    }

    /// Pixels in a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Number of rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// All pixels, row by row from the top, each row from the left.
    pub fn pixels(&self) -> &[Rgb] {
        &self.pixels
    }

    /// All pixels for writing, in the order of [`Image::pixels`].
    pub fn pixels_mut(&mut self) -> &mut [Rgb] {
        &mut self.pixels
    }

    /// The pixel in column `x` and row `y`.
    ///
    /// # Panics
    /// When `(x, y)` lies outside the picture.
    pub fn get(&self, x: usize, y: usize) -> Rgb {
        assert!(x < self.width && y < self.height, "({x}, {y}) is outside {}x{}", self.width, self.height);
        self.pixels[y * self.width + x]
    }

    /// How many pixels hold a NaN or an infinity in any channel.
    pub fn count_non_finite(&self) -> usize {
        self.pixels.iter().filter(|pixel| !pixel.is_finite()).count()
    }

    /// Column and row of the first pixel, in row-major order, that holds a NaN or an infinity.
    pub fn first_non_finite(&self) -> Option<(usize, usize)> {
        let index = self.pixels.iter().position(|pixel| !pixel.is_finite())?;
        Some((index % self.width, index / self.width))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_row_major_from_the_top_left() {
        let numbered = (0..6).map(|i| Rgb::splat(i as f32)).collect();
        let image = Image::from_pixels(3, 2, numbered).unwrap();
        assert_eq!((image.width(), image.height()), (3, 2));
        assert_eq!(image.get(2, 0), Rgb::splat(2.0));
        assert_eq!(image.get(0, 1), Rgb::splat(3.0));
    }

    #[test]
    fn a_wrong_number_of_pixels_makes_no_picture() {
        assert_eq!(Image::from_pixels(3, 2, vec![Rgb::ZERO; 5]), None);
        assert_eq!(Image::from_pixels(usize::MAX, 2, vec![Rgb::ZERO; 5]), None);
        assert_eq!(Image::from_pixels(0, 7, Vec::new()), Some(Image::new(0, 7)));
    }

    #[test]
    #[should_panic(expected = "(3, 0) is outside 3x2")]
    fn a_column_beyond_the_row_is_not_the_next_row() {
        Image::new(3, 2).get(3, 0);
    }

    #[test]
    fn non_finite_pixels_are_counted_once_each_and_found_in_order() {
        let mut image = Image::new(3, 2);
        assert_eq!((image.count_non_finite(), image.first_non_finite()), (0, None));
        image.pixels_mut()[5] = Rgb::new(f32::NAN, f32::INFINITY, 0.0);
        image.pixels_mut()[3] = Rgb::new(0.0, 0.0, f32::NEG_INFINITY);
        assert_eq!((image.count_non_finite(), image.first_non_finite()), (2, Some((0, 1))));
    }
}
