use rayon::prelude::*;

use crate::film::Image;
use crate::math::DVec3;
use crate::scene::FilmDesc;

/// Mean and standard error of every pixel over independent samples.
#[derive(Clone, Debug)]
pub struct PixelEstimates {
    width: usize,
    height: usize,
    samples: u32,
    pixels: Vec<Moments>,
}

/// Running mean and squared deviations of a pixel's samples (Welford's recurrence).
#[derive(Clone, Copy, Debug, Default)]
struct Moments {
    mean: DVec3,
    deviations: DVec3,
}

impl PixelEstimates {
    pub fn new(film: FilmDesc) -> PixelEstimates {
        let (width, height) = (film.width as usize, film.height as usize);
        PixelEstimates { width, height, samples: 0, pixels: vec![Moments::default(); width * height] }
    }

    /// Adds the sample `value(k)` to every pixel `k`, counted row by row from the top.
    pub fn add(&mut self, value: impl Fn(usize) -> DVec3 + Sync) {
        self.samples += 1;
        let (width, samples) = (self.width, f64::from(self.samples));
        self.pixels.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
            for (x, pixel) in row.iter_mut().enumerate() {
                pixel.add(value(y * width + x), samples);
            }
        });
    }

    pub fn samples(&self) -> u32 {
        self.samples
    }

    pub fn mean(&self) -> Image {
        self.image(|pixel| pixel.mean)
    }

    /// Infinite below two samples.
    pub fn standard_error(&self) -> Image {
        let n = f64::from(self.samples);
        self.image(|pixel| {
            if n < 2.0 { DVec3::INFINITY } else { (pixel.deviations / (n * (n - 1.0))).map(f64::sqrt) }
        })
    }

    fn image(&self, value: impl Fn(&Moments) -> DVec3) -> Image {
        let mut image = Image::new(self.width, self.height);
        for (out, pixel) in image.pixels_mut().iter_mut().zip(&self.pixels) {
            *out = value(pixel).as_vec3();
        }
        image
    }
}

impl Moments {
    fn add(&mut self, value: DVec3, count: f64) {
        let before = value - self.mean;
        self.mean += before / count;
        self.deviations += before * (value - self.mean);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Rgb;

    /// Of 1, 2 and 6 the mean is 3 and the standard error √(14 / (3 · 2)); pixels are numbered row by row.
    #[test]
    fn mean_and_standard_error_are_those_of_the_samples() {
        let mut pixels = PixelEstimates::new(FilmDesc::new(3, 2));
        for value in [1.0, 2.0, 6.0] {
            pixels.add(|k| DVec3::new(value, 0.0, k as f64));
        }
        assert_eq!(pixels.mean().get(1, 1), Rgb::new(3.0, 0.0, 4.0));
        let expected = Rgb::new((14f32 / 6.0).sqrt(), 0.0, 0.0);
        assert!((pixels.standard_error().get(1, 1) - expected).length() < 1e-6);
    }

    #[test]
    fn one_sample_tells_nothing_of_its_error() {
        let mut pixels = PixelEstimates::new(FilmDesc::new(1, 1));
        pixels.add(|_| DVec3::ONE);
        assert_eq!(pixels.standard_error().get(0, 0), Rgb::INFINITY);
    }
}
