use super::{MAX_PIXELS, OutputError};
use crate::film::Image;
use crate::input;
use crate::math::Rgb;
use png::{ColorType, Decoder, DecodingError, Info, Transformations};
use std::io::{BufRead, BufReader, Cursor, Seek};
use std::path::Path;

/// Reads a PNG picture of any kind as its samples, from 0 to 1, without undoing any display curve; grey gives three
/// equal channels, alpha is left out.
///
/// # Errors
/// When the file cannot be opened, is not a PNG picture, holds more than [`MAX_PIXELS`] or more than memory suffices
/// for, or is too short for the pixels that it promises.
pub fn read_png(path: &Path) -> Result<Image, OutputError> {
    let opened = input::open_file(path);
    let (file, length) = opened.map_err(|source| OutputError::Open { path: path.into(), source })?;
    decode(path, BufReader::new(file), length)
}

/// Reads a picture like [`read_png`] from the bytes of a file; `name` stands for its path in errors.
///
/// # Errors
/// As those of [`read_png`].
pub fn read_png_bytes(name: &Path, bytes: &[u8]) -> Result<Image, OutputError> {
    decode(name, Cursor::new(bytes), bytes.len() as u64)
}

/// Reads how opaque the pixels of a picture are: alpha where it has such, else its colours as by [`read_png_bytes`].
///
/// # Errors
/// As those of [`read_png`].
pub fn read_png_opacity_bytes(name: &Path, bytes: &[u8]) -> Result<Image, OutputError> {
    decode_as(name, Cursor::new(bytes), bytes.len() as u64, opacity)
}

fn decode(path: &Path, file: impl BufRead + Seek, length: u64) -> Result<Image, OutputError> {
    decode_as(path, file, length, colour)
}

fn decode_as(
    path: &Path,
    file: impl BufRead + Seek,
    length: u64,
    value: fn(&[u8], ColorType, usize) -> Rgb,
) -> Result<Image, OutputError> {
    let not_png = |error: DecodingError| OutputError::NotPng { path: path.into(), reason: error.to_string() };
    let mut decoder = Decoder::new(file);
    decoder.set_transformations(Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(not_png)?;
    let (width, height) = (reader.info().width as usize, reader.info().height as usize);
    let oversize = || OutputError::Oversize { path: path.into(), width, height, limit: MAX_PIXELS };
    if width.checked_mul(height).is_none_or(|pixels| pixels > MAX_PIXELS) {
        return Err(oversize());
    }
    // The decoder takes the colours out three bytes at a time.
    if reader.info().palette.as_ref().is_some_and(|palette| palette.len() % 3 != 0) {
        let reason = "its palette holds no whole number of colours".into();
        return Err(OutputError::NotPng { path: path.into(), reason });
    }
    check_length(path, reader.info(), length)?;
    let memory = (size_of::<Rgb>() + MOST_BYTES_A_PIXEL) * width * height;
    input::check_memory(memory as u64).map_err(|source| OutputError::Open { path: path.into(), source })?;
    let mut bytes = vec![0; reader.output_buffer_size().ok_or_else(oversize)?];
    let frame = reader.next_frame(&mut bytes).map_err(not_png)?;
    let bytes_each = if frame.bit_depth == png::BitDepth::Sixteen { 2 } else { 1 };
    let pixels = bytes[..frame.buffer_size()].chunks_exact(frame.color_type.samples() * bytes_each);
    let pixels = pixels.map(|pixel| value(pixel, frame.color_type, bytes_each)).collect();
    Image::from_pixels(width, height, pixels).ok_or_else(|| OutputError::NotPng {
        path: path.into(),
        reason: "it has not as many pixels as it says".into(),
    })
}

/// Of four channels of 16 bits.
const MOST_BYTES_A_PIXEL: usize = 8;
/// So many bytes of pixels may be promised by a file however short it is.
const ALWAYS_FINE: usize = 1 << 24;
/// Bytes that deflate makes of one, at most, with some room.
const MOST_PER_BYTE: u64 = 1100;

/// Refuses a file that promises more pixels than it can hold, before memory is taken for them.
fn check_length(path: &Path, info: &Info, length: u64) -> Result<(), OutputError> {
    let (width, height) = (info.width, info.height);
    let promised = info.raw_bytes();
    if promised <= ALWAYS_FINE || promised as u64 <= length.saturating_mul(MOST_PER_BYTE) {
        return Ok(());
    }
    let reason = format!("{length} bytes cannot hold the {width}x{height} pixels that it promises");
    Err(OutputError::NotPng { path: path.into(), reason })
}

/// The colour of a pixel whose samples are big-endian integers.
fn colour(bytes: &[u8], kind: ColorType, bytes_each: usize) -> Rgb {
    let value = |number| sample(bytes, number, bytes_each);
    match kind {
        ColorType::Grayscale | ColorType::GrayscaleAlpha => Rgb::splat(value(0)),
        _ => Rgb::new(value(0), value(1), value(2)),
    }
}

/// Alpha, or the colour of a pixel without.
fn opacity(bytes: &[u8], kind: ColorType, bytes_each: usize) -> Rgb {
    match kind {
        ColorType::GrayscaleAlpha => Rgb::splat(sample(bytes, 1, bytes_each)),
        ColorType::Rgba => Rgb::splat(sample(bytes, 3, bytes_each)),
        ColorType::Grayscale | ColorType::Rgb | ColorType::Indexed => colour(bytes, kind, bytes_each),
    }
}

/// From 0 to 1.
fn sample(bytes: &[u8], number: usize, bytes_each: usize) -> f32 {
    match bytes[number * bytes_each..][..bytes_each] {
        [high, low] => f32::from(u16::from_be_bytes([high, low])) / 65535.0,
        _ => f32::from(bytes[number]) / 255.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::{Display, write_png};
    use png::{BitDepth, Encoder};
    use std::fs::{self, File};
    use std::path::PathBuf;
    use tempfile::TempDir;

    fn folder_and_path() -> (TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mask.png");
        (folder, path)
    }

    #[test]
    fn samples_of_every_kind_are_read() {
        let (_folder, path) = folder_and_path();
        let read = |kind, depth, palette: Option<&[u8]>, bytes: &[u8]| {
            let mut encoder = Encoder::new(File::create(&path).unwrap(), 2, 1);
            encoder.set_color(kind);
            encoder.set_depth(depth);
            palette.into_iter().for_each(|palette| encoder.set_palette(palette.to_vec()));
            encoder.write_header().unwrap().write_image_data(bytes).unwrap();
            read_png(&path).unwrap().pixels().to_vec()
        };
        let dots = [Rgb::ONE, Rgb::ZERO];
        assert_eq!(read(ColorType::Grayscale, BitDepth::One, None, &[0x80]), dots);
        assert_eq!(read(ColorType::Grayscale, BitDepth::Eight, None, &[255, 0]), dots);
        assert_eq!(read(ColorType::GrayscaleAlpha, BitDepth::Eight, None, &[255, 0, 0, 255]), dots);
        assert_eq!(read(ColorType::Rgba, BitDepth::Eight, None, &[255, 255, 255, 0, 0, 0, 0, 9]), dots);
        let faint = read(ColorType::Grayscale, BitDepth::Sixteen, None, &[0, 1, 0, 0]);
        assert_eq!(faint, [Rgb::splat(1.0 / 65535.0), Rgb::ZERO]);
        let palette: &[u8] = &[0, 0, 0, 255, 0, 51];
        let indexed = read(ColorType::Indexed, BitDepth::Eight, Some(palette), &[1, 0]);
        assert_eq!(indexed, [Rgb::new(1.0, 0.0, 0.2), Rgb::ZERO]);
    }

    #[test]
    fn our_own_pictures_come_back() {
        let (_folder, path) = folder_and_path();
        let image = Image::from_pixels(2, 1, vec![Rgb::X, Rgb::splat(0.2)]).unwrap();
        write_png(&path, &image, &Display { gamma: 1.0, ..Display::default() }).unwrap();
        assert_eq!(read_png(&path).unwrap(), image);
    }

    #[test]
    fn missing_foreign_and_cut_files_are_refused() {
        let (_folder, path) = folder_and_path();
        assert!(matches!(read_png(&path), Err(OutputError::Open { .. })));
        write_png(&path, &Image::new(9, 7), &Display::default()).unwrap();
        let whole = fs::read(&path).unwrap();
        for length in [0, 8, 40, whole.len() / 2] {
            fs::write(&path, &whole[..length]).unwrap();
            let text = read_png(&path).unwrap_err().to_string();
            assert!(text.contains("mask.png: not a readable PNG picture"), "{length} bytes: {text}");
        }
    }
}
