//! Pictures that scenes are lit or coloured by: EXR, PNG, JPEG.

use std::path::{Path, PathBuf};

use glam::{DAffine2, DMat2, DVec2};
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use super::super::SceneError;
use super::access::Reader;
use super::fields::Field;
use crate::film::Image;
use crate::input;
use crate::math::Rgb;
use crate::output::{MAX_PIXELS, read_exr_bytes, read_png_bytes, read_png_opacity_bytes};
use crate::texture::Encoding;

/// From the texture coordinates of glTF and Mitsuba, whose pictures have their first row at `v = 0`, to those here, where it is at `v = 1`.
pub(super) const UPRIGHT: DAffine2 =
    DAffine2 { matrix2: DMat2 { x_axis: DVec2::X, y_axis: DVec2::NEG_Y }, translation: DVec2::Y };

const KIND: &str = "a picture (EXR, PNG or JPEG)";

impl Reader<'_> {
    /// The picture that a field of a scene file names, and its path.
    pub fn picture(&self, field: &Field, encoding: Encoding) -> Result<(PathBuf, Image), SceneError> {
        let path = self.beside_scene(field.string()?);
        match self.picture_at(&path, encoding) {
            Ok(picture) => Ok((path, picture)),
            Err(reason) => Err(field.error(format!(": {}: {reason}", path.display()))),
        }
    }

    /// The picture in a file, by its extension.
    pub fn picture_at(&self, path: &Path, encoding: Encoding) -> Result<Image, String> {
        let kind = Kind::of_name(path)?;
        let bytes = self.read(path, KIND).map_err(|denial| denial.reason())?;
        decode(kind, path, &bytes, encoding)
    }
}

/// How a picture is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Exr,
    Png,
    Jpeg,
}

impl Kind {
    fn of_name(path: &Path) -> Result<Kind, String> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        match extension.as_str() {
            "exr" => Ok(Kind::Exr),
            "png" => Ok(Kind::Png),
            "jpg" | "jpeg" => Ok(Kind::Jpeg),
            other => Err(format!("`.{other}` is no picture that is read; allowed: exr, png, jpg, jpeg")),
        }
    }

    /// PNG or JPEG by the first bytes.
    pub fn of_content(bytes: &[u8]) -> Option<Kind> {
        match bytes {
            [0x89, b'P', b'N', b'G', ..] => Some(Kind::Png),
            [0xff, 0xd8, 0xff, ..] => Some(Kind::Jpeg),
            _ => None,
        }
    }
}

/// The picture in the bytes of a file; `name` is for messages.
pub(super) fn decode(kind: Kind, name: &Path, bytes: &[u8], encoding: Encoding) -> Result<Image, String> {
    let mut picture = match kind {
        Kind::Exr => read_exr_bytes(name, bytes).map_err(|e| e.to_string())?,
        Kind::Png if encoding == Encoding::Opacity => {
            read_png_opacity_bytes(name, bytes).map_err(|e| e.to_string())?
        }
        Kind::Png => read_png_bytes(name, bytes).map_err(|e| e.to_string())?,
        Kind::Jpeg => read_jpeg(bytes)?,
    };
    match encoding {
        Encoding::Colour if kind != Kind::Exr => {
            picture.pixels_mut().iter_mut().for_each(|pixel| *pixel = pixel.map(linear));
        }
        Encoding::Colour | Encoding::Plain => (),
        Encoding::Opacity => picture = grey(picture),
    }
    Ok(picture)
}

/// The luminance of every pixel in all three channels.
pub(super) fn grey(mut picture: Image) -> Image {
    picture.pixels_mut().iter_mut().for_each(|pixel| *pixel = Rgb::splat(luminance(*pixel)));
    picture
}

/// Of linear RGB; of three equal numbers that number.
pub(super) fn luminance(color: Rgb) -> f32 {
    if color.min_element() == color.max_element() {
        return color.x;
    }
    color.dot(Rgb::new(0.2126, 0.7152, 0.0722))
}

/// Undoes sRGB's curve.
///
/// # Source
/// IEC 61966-2-1.
fn linear(value: f32) -> f32 {
    if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

fn read_jpeg(bytes: &[u8]) -> Result<Image, String> {
    let bad = |error: &dyn std::fmt::Display| format!("is no JPEG picture: {error}");
    let options = DecoderOptions::default()
        .jpeg_set_out_colorspace(ColorSpace::RGB)
        .set_max_width(MAX_PIXELS)
        .set_max_height(MAX_PIXELS);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(|e| bad(&e))?;
    let (width, height) = decoder.dimensions().ok_or_else(|| bad(&"it has no size"))?;
    if width.checked_mul(height).is_none_or(|pixels| pixels > MAX_PIXELS) {
        return Err(format!("has {width} x {height} pixels; allowed: {MAX_PIXELS} at most"));
    }
    input::check_memory((size_of::<Rgb>() + 8) as u64 * (width * height) as u64)
        .map_err(|e| e.to_string())?;
    let samples = decoder.decode().map_err(|e| bad(&e))?;
    let pixel = |rgb: &[u8]| Rgb::new(f32::from(rgb[0]), f32::from(rgb[1]), f32::from(rgb[2])) / 255.0;
    Image::from_pixels(width, height, samples.chunks_exact(3).map(pixel).collect())
        .ok_or_else(|| bad(&"it has not as many pixels as it says"))
}
