//! The pictures of passes, summed exactly pixel by pixel.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::exact::{SquareSum, Sum, variance_of_mean};
use crate::film::Image;
use crate::math::{DVec3, Rgb};

/// Sums of pictures and of their squares: 360 bytes a pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Sums {
    width: usize,
    height: usize,
    pixels: Vec<PixelSums>,
    /// How often the pictures had no number at a pixel, where that happened.
    not_finite: BTreeMap<u32, u32>,
}

/// Of one pixel, channel by channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct PixelSums {
    sums: [Sum; 3],
    squares: [SquareSum; 3],
}

/// Pixels that one task packs; fixed, since it is part of the file.
const BLOCK: usize = 1 << 14;

impl Sums {
    /// Bytes of memory that each pixel takes.
    pub const BYTES_A_PIXEL: usize = size_of::<PixelSums>();

    /// Of no picture yet.
    pub fn new(width: usize, height: usize) -> Sums {
        let pixels = (0..width * height).into_par_iter().map(|_| PixelSums::default()).collect();
        Sums { width, height, pixels, not_finite: BTreeMap::new() }
    }

    /// Width and height in pixels.
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// Adds a picture of the same size. Pixels that are not finite in it are left out, and counted.
    pub fn add(&mut self, picture: &Image) {
        let both = self.pixels.par_iter_mut().zip(picture.pixels());
        both.filter(|(_, x)| x.is_finite()).for_each(|(sums, x)| sums.add(*x));
        let numbered = (0..).zip(picture.pixels());
        for (pixel, _) in numbered.filter(|(_, x)| !x.is_finite()) {
            *self.not_finite.entry(pixel).or_default() += 1;
        }
    }

    /// Pixels that were not finite in some pass, and in how many.
    pub fn not_finite(&self) -> &BTreeMap<u32, u32> {
        &self.not_finite
    }

    /// The mean over so many pictures; where some were not finite, that of the others.
    pub fn mean(&self, pictures: u32) -> Image {
        self.image(pictures, |pixel, n| DVec3::from_array(pixel.sums.map(|sum| sum.to_f64() / f64::from(n))))
    }

    /// The standard error of the mean over so many pictures, `√((Σ x² - (Σ x)² / n) / (n (n - 1)))`; NaN below two.
    pub fn standard_error(&self, pictures: u32) -> Image {
        self.image(pictures, |pixel, n| {
            let of = |channel| variance_of_mean(&pixel.sums[channel], &pixel.squares[channel], n).sqrt();
            DVec3::from_array([of(0), of(1), of(2)])
        })
    }

    fn image(&self, pictures: u32, of: impl Fn(&PixelSums, u32) -> DVec3 + Sync) -> Image {
        let mut image = Image::new(self.width, self.height);
        image.pixels_mut().par_iter_mut().zip(&self.pixels).enumerate().for_each(|(k, (to, pixel))| {
            let missing = self.not_finite.get(&(k as u32)).copied().unwrap_or(0);
            *to = of(pixel, pictures.saturating_sub(missing)).as_vec3();
        });
        image
    }

    /// All pixels in few bytes, block by block.
    pub(super) fn pack(&self) -> Vec<Vec<u8>> {
        self.pixels.par_chunks(BLOCK).map(pack).collect()
    }

    /// Adds what others packed of a picture of the same size; `None`, and sums of no use, where nobody packed it.
    pub(super) fn add_packed(&mut self, blocks: &[&[u8]], not_finite: &BTreeMap<u32, u32>) -> Option<()> {
        if blocks.len() != self.pixels.len().div_ceil(BLOCK) {
            return None;
        }
        for (&pixel, &times) in not_finite {
            let count = self.not_finite.entry(pixel).or_default();
            *count = count.saturating_add(times);
        }
        let chunks = self.pixels.par_chunks_mut(BLOCK).zip(blocks);
        chunks.map(|(pixels, block)| add_packed(pixels, block)).collect()
    }
}

impl PixelSums {
    fn add(&mut self, x: Rgb) {
        for (channel, x) in x.to_array().into_iter().enumerate() {
            self.sums[channel].add(x);
            self.squares[channel].add_square_of(x);
        }
    }
}

fn pack(pixels: &[PixelSums]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for pixel in pixels {
        pixel.sums.iter().for_each(|sum| sum.pack(&mut bytes));
        pixel.squares.iter().for_each(|sum| sum.pack(&mut bytes));
    }
    bytes
}

fn add_packed(pixels: &mut [PixelSums], mut bytes: &[u8]) -> Option<()> {
    for pixel in pixels {
        pixel.sums.iter_mut().try_for_each(|sum| sum.add_packed(&mut bytes))?;
        pixel.squares.iter_mut().try_for_each(|sum| sum.add_packed(&mut bytes))?;
    }
    bytes.is_empty().then_some(())
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::math::{Rng, Stream};

    /// A picture of more than one block, of its own for every pass.
    pub fn picture(pass: u32) -> Image {
        let mut rng = Rng::new(3, Stream::Test, pass, 0);
        let mut image = Image::new(256, 70);
        let mut number = || (rng.next_f32() - 0.2) * f32::exp2(20.0 * rng.next_f32() - 10.0);
        image.pixels_mut().iter_mut().for_each(|pixel| *pixel = Rgb::new(number(), number(), 0.0));
        image
    }

    fn sums_of(passes: impl IntoIterator<Item = u32>) -> Sums {
        let mut sums = Sums::new(256, 70);
        passes.into_iter().for_each(|pass| sums.add(&picture(pass)));
        sums
    }

    /// Whatever `sums` has, packed and added to them.
    fn add(to: &mut Sums, sums: &Sums) {
        let blocks = sums.pack();
        let blocks: Vec<&[u8]> = blocks.iter().map(Vec::as_slice).collect();
        to.add_packed(&blocks, &sums.not_finite).unwrap();
    }

    #[test]
    fn parts_add_up_to_the_whole_in_any_order() {
        let whole = sums_of(0..9);
        for parts in [
            std::iter::once(0..9).collect(),
            vec![4..9, 0..4],
            vec![7..8, 0..7, 8..9],
            (0..9).map(|k| 8 - k..9 - k).collect(),
        ] {
            let mut merged = Sums::new(256, 70);
            parts.into_iter().for_each(|part| add(&mut merged, &sums_of(part)));
            assert!(merged == whole);
        }
    }

    #[test]
    fn means_and_errors_are_those_of_the_textbook() {
        let n = 9;
        let (mean, error) = (sums_of(0..n).mean(n), sums_of(0..n).standard_error(n));
        let pictures: Vec<Image> = (0..n).map(picture).collect();
        for pixel in (0..256 * 70).step_by(97) {
            let x = |picture: &Image| f64::from(picture.pixels()[pixel].y);
            let expected = pictures.iter().map(x).sum::<f64>() / f64::from(n);
            let squares = pictures.iter().map(|picture| (x(picture) - expected).powi(2)).sum::<f64>();
            let expected_error = (squares / f64::from(n * (n - 1))).sqrt();
            let near = |found: f32, expected: f64| (f64::from(found) / expected - 1.0).abs() < 1e-6;
            assert!(near(mean.pixels()[pixel].y, expected) && near(error.pixels()[pixel].y, expected_error));
            assert_eq!((mean.pixels()[pixel].z, error.pixels()[pixel].z), (0.0, 0.0));
        }
        assert!(sums_of(0..1).standard_error(1).pixels().iter().all(|pixel| pixel.is_nan()));
    }

    #[test]
    fn pixels_without_a_number_are_counted_and_left_out() {
        let mut broken = picture(1);
        broken.pixels_mut()[5].y = f32::NAN;
        broken.pixels_mut()[7].x = f32::INFINITY;
        let (mut sums, mut merged) = (sums_of([0, 2]), sums_of([0]));
        sums.add(&broken);
        let mut other = sums_of([2]);
        other.add(&broken);
        add(&mut merged, &other);
        assert!(merged == sums && sums.not_finite() == &[(5, 1), (7, 1)].into());
        let (mean, without) = (sums.mean(3), sums_of([0, 2]).mean(2));
        assert_eq!([5, 7].map(|k| mean.pixels()[k]), [5, 7].map(|k| without.pixels()[k]));
        assert_ne!(mean.pixels()[6], without.pixels()[6]);
    }

    #[test]
    fn sums_take_as_much_memory_as_is_said() {
        assert_eq!(Sums::BYTES_A_PIXEL, 360);
    }
}
