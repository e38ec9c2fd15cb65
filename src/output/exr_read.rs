use super::OutputError;
use crate::film::Image;
use crate::math::Rgb;
use exr::error::Error as ExrError;
use exr::image::read::specific_channels::ReadSpecificChannel;
use exr::math::Vec2;
use exr::meta::MetaData;
use exr::meta::header::Header;
use exr::prelude::{ReadChannels, ReadLayers, read};
use std::path::{Path, PathBuf};

/// The largest number of pixels that [`read_exr`] takes in: 2²⁸, which fill 3 GiB.
pub const MAX_PIXELS: usize = 1 << 28;

/// Reads the colours of an OpenEXR picture of any compression, as scan lines or tiles, of half, float or integer
/// samples.
///
/// The first layer that has channels R, G, B, or else Y (read as grey), counts; alpha and all other channels are left
/// out, and so are the display window and all attributes.
///
/// # Errors
/// When the file cannot be opened, is not a flat EXR picture, has no colour or subsampled channels, or holds more than
/// [`MAX_PIXELS`].
pub fn read_exr(path: &Path) -> Result<Image, OutputError> {
    let read_error = |error| read_error(path, error);
    let headers = MetaData::read_from_file(path, false).map_err(read_error)?.headers;
    let (header, colour) =
        headers.iter().find_map(|header| Some((header, Colour::of(header)?))).ok_or_else(|| {
            OutputError::NoColour { path: path.to_path_buf(), channels: list_channels(&headers) }
        })?;
    check_readable(path, header)?;
    match colour {
        Colour::Rgb => read_rgb(path),
        Colour::Luminance => read_luminance(path),
    }
    .map_err(read_error)
}

/// The channels that a picture's colours come from.
enum Colour {
    Rgb,
    Luminance,
}

impl Colour {
    fn of(header: &Header) -> Option<Colour> {
        let has = |name: &str| {
            header.channels.list.iter().any(|channel| channel.name.as_slice() == name.as_bytes())
        };
        let rgb = ["R", "G", "B"].into_iter().all(has).then_some(Colour::Rgb);
        rgb.or_else(|| has("Y").then_some(Colour::Luminance))
    }
}

fn read_rgb(path: &Path) -> Result<Image, ExrError> {
    let reader = read().no_deep_data().largest_resolution_level().specific_channels();
    let reader = reader.required("R").required("G").required("B").collect_pixels(
        |Vec2(width, height), _| Image::new(width, height),
        |image: &mut Image, position, (r, g, b): (f32, f32, f32)| set(image, position, Rgb::new(r, g, b)),
    );
    Ok(reader
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_file(path)?
        .layer_data
        .channel_data
        .pixels)
}

fn read_luminance(path: &Path) -> Result<Image, ExrError> {
    let reader = read().no_deep_data().largest_resolution_level().specific_channels();
    let reader = reader.required("Y").collect_pixels(
        |Vec2(width, height), _| Image::new(width, height),
        |image: &mut Image, position, (y,): (f32,)| set(image, position, Rgb::splat(y)),
    );
    Ok(reader
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_file(path)?
        .layer_data
        .channel_data
        .pixels)
}

fn set(image: &mut Image, Vec2(x, y): Vec2<usize>, value: Rgb) {
    let index = y * image.width() + x;
    image.pixels_mut()[index] = value;
}

fn check_readable(path: &Path, header: &Header) -> Result<(), OutputError> {
    let path = path.to_path_buf();
    let Vec2(width, height) = header.layer_size;
    if width.checked_mul(height).is_none_or(|pixels| pixels > MAX_PIXELS) {
        return Err(OutputError::Oversize { path, width, height, limit: MAX_PIXELS });
    }
    match header.channels.list.iter().find(|channel| channel.sampling != Vec2(1, 1)) {
        Some(channel) => Err(OutputError::Subsampled { path, channel: channel.name.to_string() }),
        None => Ok(()),
    }
}

fn list_channels(headers: &[Header]) -> String {
    let names = |header: &Header| {
        header.channels.list.iter().map(|channel| channel.name.to_string()).collect::<Vec<_>>().join(", ")
    };
    headers.iter().map(names).collect::<Vec<_>>().join("; ")
}

fn read_error(path: &Path, error: ExrError) -> OutputError {
    let path: PathBuf = path.into();
    match error {
        ExrError::Io(source) => OutputError::Open { path, source },
        other => OutputError::NotExr { path, reason: other.to_string() },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::{Metadata, write_exr};
    use exr::image::{Image as ExrImage, SpecificChannels};
    use exr::prelude::{WritableImage, f16};
    use std::fs;
    use tempfile::TempDir;

    fn folder_and_path() -> (TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.exr");
        (folder, path)
    }

    #[test]
    fn other_programs_layouts_are_read() {
        let (_folder, path) = folder_and_path();
        let value = |x: usize, y: usize| (4 * y + x) as f32;
        let expect = |colour: fn(f32) -> Rgb| {
            let image = read_exr(&path).unwrap();
            assert_eq!((image.width(), image.height()), (4, 3));
            for (x, y) in [(0, 0), (3, 0), (1, 2)] {
                assert_eq!(image.get(x, y), colour(value(x, y)));
            }
        };
        let tiled_half = SpecificChannels::rgba(|Vec2(x, y)| {
            let half = f16::from_f32(value(x, y));
            (half, half, f16::ZERO, f16::ONE)
        });
        ExrImage::from_channels((4, 3), tiled_half).write().to_file(&path).unwrap();
        expect(|v| Rgb::new(v, v, 0.0));
        let integer_grey = SpecificChannels::build()
            .with_channel::<u32>("Y")
            .with_pixel_fn(|Vec2(x, y)| (value(x, y) as u32,));
        ExrImage::from_channels((4, 3), integer_grey).write().to_file(&path).unwrap();
        expect(Rgb::splat);
    }

    #[test]
    fn a_file_without_colour_is_refused_with_its_channels() {
        let (_folder, path) = folder_and_path();
        let depth = SpecificChannels::build()
            .with_channel::<f32>("Z")
            .with_channel::<f32>("R")
            .with_pixel_fn(|_| (1.0f32, 1.0f32));
        ExrImage::from_channels((4, 3), depth).write().to_file(&path).unwrap();
        let text = read_exr(&path).unwrap_err().to_string();
        assert!(
            text.ends_with("no layer has the channels R, G and B, or Y; the channels are: R, Z"),
            "{text}"
        );
    }

    #[test]
    fn missing_foreign_and_cut_files_are_refused() {
        let (folder, path) = folder_and_path();
        assert!(matches!(read_exr(&path), Err(OutputError::Open { .. })));
        assert!(matches!(read_exr(folder.path()), Err(OutputError::Open { .. })));
        for content in ["", "P6 1 1 255 abc"] {
            fs::write(&path, content).unwrap();
            assert!(matches!(read_exr(&path), Err(OutputError::NotExr { .. })), "{content:?}");
        }
        write_exr(&path, &Image::new(37, 20), &Metadata::new()).unwrap();
        let whole = fs::read(&path).unwrap();
        for length in [4, 8, 100, whole.len() / 2, whole.len() - 1] {
            fs::write(&path, &whole[..length]).unwrap();
            let text = read_exr(&path).unwrap_err().to_string();
            assert!(text.contains("picture.exr: not a readable EXR picture"), "{length} bytes: {text}");
        }
    }

    #[test]
    fn an_oversize_picture_is_refused_before_it_takes_memory() {
        let (_folder, path) = folder_and_path();
        write_exr(&path, &Image::new(37, 20), &Metadata::new()).unwrap();
        let mut bytes = fs::read(&path).unwrap();
        let mark = b"dataWindow\0box2i\0\x10\0\0\0";
        let corner = bytes.windows(mark.len()).position(|window| window == mark).unwrap() + mark.len() + 8;
        bytes[corner..corner + 8].copy_from_slice(&[99_999i32.to_le_bytes(); 2].concat());
        fs::write(&path, &bytes).unwrap();
        let text = read_exr(&path).unwrap_err().to_string();
        assert!(text.contains("100000x100000 pixels are too many; at most 268435456"), "{text}");
    }

    #[test]
    fn a_subsampled_channel_is_refused() {
        let (_folder, path) = folder_and_path();
        write_exr(&path, &Image::new(8, 8), &Metadata::new()).unwrap();
        let mut bytes = fs::read(&path).unwrap();
        let mark = b"\0B\0\x02\0\0\0";
        let sampling =
            bytes.windows(mark.len()).position(|window| window == mark).unwrap_or(0) + mark.len() + 4;
        bytes[sampling..sampling + 8].copy_from_slice(&[2, 0, 0, 0, 2, 0, 0, 0]);
        fs::write(&path, &bytes).unwrap();
        let text = read_exr(&path).unwrap_err().to_string();
        assert!(text.contains("channel B is subsampled; save the picture"), "{text}");
    }

    #[test]
    fn pictures_of_another_renderer_are_read() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/reference/cornell_a_ref.exr");
        if !path.exists() {
            eprintln!("skipped: {} is absent", path.display());
            return;
        }
        let image = read_exr(&path).unwrap();
        assert_eq!((image.width(), image.height(), image.count_non_finite()), (512, 512, 0));
        let (left, right) = (image.get(60, 256), image.get(452, 256));
        assert!(
            left.x > 2.0 * left.y && right.y > 2.0 * right.x,
            "the left wall is red, the right one green"
        );
    }
}
