use super::{Curve, OutputError, check_sides, write_atomically};
use crate::film::Image;
use crate::math::Rgb;
use std::io::{self, Write};
use std::path::Path;

/// What stands for a pixel with a NaN, so that nobody takes it for black.
const NAN_COLOUR: [u8; 3] = [255, 0, 255];

/// From linear values to display values: `curve(2^exposure · x)^(1/gamma)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Display {
    /// Brightening in stops; 1 doubles, -1 halves.
    pub exposure: f32,
    /// What becomes of the brightened light.
    pub curve: Curve,
    /// Exponent of the display; more than 0.
    pub gamma: f32,
}

impl Default for Display {
    /// No brightening, no curve, and the gamma 2.2 of common displays.
    fn default() -> Display {
        Display { exposure: 0.0, curve: Curve::Plain, gamma: 2.2 }
    }
}

impl Display {
    /// The 8-bit display value of a linear colour, each channel rounded to nearest.
    ///
    /// Negative values become 0, infinity 255; a NaN in any channel makes the pixel magenta.
    ///
    /// ```
    /// use caustica::{math::Rgb, output::Display};
    /// let display = Display { exposure: 1.0, gamma: 2.0, ..Display::default() };
    /// assert_eq!(display.encode(Rgb::new(0.0, 0.125, 7.0)), [0, 128, 255]); // √(2 · 0.125) · 255 = 127.5
    /// ```
    pub fn encode(&self, linear: Rgb) -> [u8; 3] {
        if linear.is_nan() {
            return NAN_COLOUR;
        }
        let scale = self.exposure.exp2();
        linear.to_array().map(|x| (self.curve.apply(scale * x).powf(1.0 / self.gamma) * 255.0).round() as u8)
    }

    fn check(&self, path: &Path) -> Result<(), OutputError> {
        let refuse = |what, right| Err(OutputError::Display { path: path.to_path_buf(), what, right });
        if !self.exposure.is_finite() || self.exposure.abs() > 100.0 {
            return refuse(format!("an exposure of {}", self.exposure), "give stops from -100 to 100");
        }
        if !self.gamma.is_finite() || self.gamma <= 0.0 {
            return refuse(format!("a gamma of {}", self.gamma), "give a number above 0, such as 2.2");
        }
        Ok(())
    }
}

/// Writes a picture as an 8-bit RGB PNG file through a display curve.
///
/// The file has no `gAMA` or `sRGB` chunk: its samples are what the display is to show. A `gAMA` chunk would have some
/// viewers undo the chosen gamma and others not, and the picture would differ between them. The file appears whole
/// or not at all, see [`write_atomically`].
///
/// # Errors
/// When a side of the picture is 0 or too long, when the exposure is beyond ±100 stops or the gamma is not above 0, or
/// when the file cannot be written.
pub fn write_png(path: &Path, image: &Image, display: &Display) -> Result<(), OutputError> {
    display.check(path)?;
    let samples: Vec<[u8; 3]> = image.pixels().iter().map(|&pixel| display.encode(pixel)).collect();
    write_png_samples(path, image.width(), image.height(), &samples)
}

/// Writes display values, row by row from the top, as an 8-bit RGB PNG file like [`write_png`].
///
/// # Errors
/// When a side of the picture is 0 or too long, when there are not exactly `width · height` samples, or when the file
/// cannot be written.
pub fn write_png_samples(
    path: &Path,
    width: usize,
    height: usize,
    samples: &[[u8; 3]],
) -> Result<(), OutputError> {
    check_sides(path, width, height)?;
    write_atomically(path, |out| encode_samples(out, width as u32, height as u32, samples.as_flattened()))
}

/// Encodes a picture as [`write_png`] does, for a page that carries it inside.
///
/// # Errors
/// When a side of the picture is 0 or too long, or when `out` fails.
pub fn encode_png(out: &mut dyn Write, image: &Image, display: &Display) -> io::Result<()> {
    let samples: Vec<u8> = image.pixels().iter().flat_map(|&pixel| display.encode(pixel)).collect();
    encode_samples(out, image.width() as u32, image.height() as u32, &samples)
}

fn encode_samples(out: &mut dyn Write, width: u32, height: u32, samples: &[u8]) -> io::Result<()> {
    let mut encoder = png::Encoder::new(out, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(samples)?;
    Ok(writer.finish()?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::File;
    use std::io::BufReader;

    #[test]
    fn the_curve_rounds_to_nearest_and_clamps() {
        let linear = Display { gamma: 1.0, ..Display::default() };
        let just = |code: f32| Rgb::splat(code / 255.0);
        assert_eq!(linear.encode(just(99.49)), [99; 3]);
        assert_eq!(linear.encode(just(99.51)), [100; 3]);
        assert_eq!(linear.encode(Rgb::new(-1.0, f32::NEG_INFINITY, f32::INFINITY)), [0, 0, 255]);
    }

    #[test]
    fn the_default_is_gamma_2_2_without_brightening() {
        // 0.5^(1/2.2) · 255 = 186.08
        assert_eq!(Display::default().encode(Rgb::new(0.5, 1.0, 0.0)), [186, 255, 0]);
        let brighter = Display { exposure: 1.0, ..Display::default() };
        assert_eq!(brighter.encode(Rgb::splat(0.25)), [186; 3]);
    }

    /// 0.80380 · 255 = 204.97 and 0.26690 · 255 = 68.06.
    #[test]
    fn the_curve_comes_between_exposure_and_gamma() {
        let filmic = Display { exposure: 1.0, curve: Curve::Filmic, gamma: 1.0 };
        assert_eq!(filmic.encode(Rgb::new(0.5, 0.09, 9.0)), [205, 68, 255]);
    }

    #[test]
    fn a_nan_is_seen() {
        assert_eq!(Display::default().encode(Rgb::new(0.5, f32::NAN, 0.5)), NAN_COLOUR);
    }

    #[test]
    fn a_decoder_finds_the_samples_in_their_places() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.png");
        let mut image = Image::new(3, 2);
        image.pixels_mut()[1] = Rgb::X;
        image.pixels_mut()[5] = Rgb::splat(0.5);
        write_png(&path, &image, &Display::default()).unwrap();
        let decoder = png::Decoder::new(BufReader::new(File::open(&path).unwrap()));
        let mut reader = decoder.read_info().unwrap();
        let mut samples = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut samples).unwrap();
        assert_eq!((info.width, info.height, info.color_type), (3, 2, png::ColorType::Rgb));
        let mut expected = [0; 18];
        expected[3] = 255;
        expected[15..].fill(186);
        assert_eq!(samples, expected);
        assert!(reader.info().source_gamma.is_none() && reader.info().srgb.is_none());
    }

    #[test]
    fn unusable_settings_are_named() {
        let write = |exposure, gamma, image: &Image| {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("picture.png");
            let text = write_png(&path, image, &Display { exposure, gamma, ..Display::default() })
                .unwrap_err()
                .to_string();
            assert!(!path.exists());
            text
        };
        let image = Image::new(1, 1);
        assert!(write(f32::NAN, 2.2, &image).contains("an exposure of NaN; give stops"));
        assert!(write(0.0, 0.0, &image).contains("a gamma of 0; give a number above 0"));
        assert!(write(0.0, 2.2, &Image::new(0, 3)).contains("a picture of 0x3 pixels cannot be written"));
    }
}
