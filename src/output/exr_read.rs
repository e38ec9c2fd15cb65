use super::OutputError;
use super::exr_write::utf8_text;
use crate::film::Image;
use crate::input;
use crate::math::Rgb;
use exr::compression::Compression;
use exr::error::Error as ExrError;
use exr::image::read::specific_channels::ReadSpecificChannel;
use exr::math::Vec2;
use exr::meta::MetaData;
use exr::meta::header::Header;
use exr::prelude::{ReadChannels, ReadLayers, read};
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::io::{BufReader, Cursor, Read, Seek};
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
/// When the file cannot be opened, is not a flat EXR picture, has no colour or subsampled channels, holds more than
/// [`MAX_PIXELS`] or more than memory suffices for, or is too short for the pixels that it promises.
pub fn read_exr(path: &Path) -> Result<Image, OutputError> {
    let (file, length) = open(path)?;
    read_colours(path, BufReader::new(file), length, &COLOURS, |headers| no_colour(path, headers))
}

/// Reads a picture like [`read_exr`] from the bytes of a file; `name` stands for its path in errors.
///
/// # Errors
/// As those of [`read_exr`].
pub fn read_exr_bytes(name: &Path, bytes: &[u8]) -> Result<Image, OutputError> {
    read_colours(name, Cursor::new(bytes), bytes.len() as u64, &COLOURS, |headers| no_colour(name, headers))
}

fn open(path: &Path) -> Result<(std::fs::File, u64), OutputError> {
    input::open_file(path).map_err(|source| OutputError::Open { path: path.into(), source })
}

fn no_colour(path: &Path, headers: &[Header]) -> OutputError {
    OutputError::NoColour { path: path.to_path_buf(), channels: list_channels(headers) }
}

/// Reads a named layer of an OpenEXR picture like [`read_exr`]: the channels `LAYER.R`, `LAYER.G` and `LAYER.B`, or
/// else `LAYER.X`, `LAYER.Y` and `LAYER.Z`, or else, as grey, the channel `LAYER`, or else `LAYER.Y`.
///
/// # Errors
/// As those of [`read_exr`], and when the file has no such layer; the text then lists those that there are.
pub fn read_exr_layer(path: &Path, layer: &str) -> Result<Image, OutputError> {
    let (file, length) = open(path)?;
    let missing = |headers: &[Header]| OutputError::NoLayer {
        path: path.to_path_buf(),
        layer: layer.into(),
        layers: list_layers(headers),
    };
    read_colours(path, BufReader::new(file), length, &of_layer(layer), missing)
}

/// Reads the picture that `FILE.exr` or `FILE.exr:LAYER` names, by [`read_exr`] or [`read_exr_layer`].
///
/// A file whose own name looks like that of a layer takes precedence.
///
/// # Errors
/// As those of the two.
pub fn read_exr_named(name: &Path) -> Result<Image, OutputError> {
    match split_layer(name) {
        Some((path, layer)) if !name.exists() => read_exr_layer(path, layer),
        _ => read_exr(name),
    }
}

fn split_layer(name: &Path) -> Option<(&Path, &str)> {
    let text = name.to_str()?;
    let mut colons = text.match_indices(':').map(|(colon, _)| text.split_at(colon));
    let (path, layer) = colons.find(|(path, _)| path.to_ascii_lowercase().ends_with(".exr"))?;
    Some((Path::new(path), &layer[1..]))
}

/// Reads the first part of a file that has channels of the given names, of which earlier ones take precedence.
fn read_colours(
    path: &Path,
    mut file: impl Read + Seek,
    length: u64,
    names: &[Names],
    missing: impl Fn(&[Header]) -> OutputError,
) -> Result<Image, OutputError> {
    let read_error = |error| read_error(path, error);
    let headers = MetaData::read_from_buffered(&mut file, false).map_err(read_error)?.headers;
    let (header, names) = headers
        .iter()
        .find_map(|header| Some((header, names.iter().find(|names| names.are_in(header))?)))
        .ok_or_else(|| missing(&headers))?;
    check_readable(path, header)?;
    headers.iter().try_for_each(|header| check_length(path, header, length))?;
    file.rewind().map_err(|error| read_error(error.into()))?;
    match names {
        Names::Three(names) => read_three(file, names),
        Names::One(name) => read_one(file, name),
    }
    .map_err(read_error)
}

/// The names of the channels that a picture's colours come from.
enum Names {
    Three([Cow<'static, str>; 3]),
    One(Cow<'static, str>),
}

/// Those of the picture itself.
const COLOURS: [Names; 2] = [
    Names::Three([Cow::Borrowed("R"), Cow::Borrowed("G"), Cow::Borrowed("B")]),
    Names::One(Cow::Borrowed("Y")),
];

/// Those of a layer.
fn of_layer(layer: &str) -> [Names; 4] {
    let channel = |name| Cow::Owned(format!("{layer}.{name}"));
    [
        Names::Three(["R", "G", "B"].map(channel)),
        Names::Three(["X", "Y", "Z"].map(channel)),
        Names::One(layer.to_owned().into()),
        Names::One(channel("Y")),
    ]
}

impl Names {
    fn are_in(&self, header: &Header) -> bool {
        let has = |name| header.channels.list.iter().any(|channel| channel.name == utf8_text(name));
        match self {
            Names::Three(names) => names.iter().all(|name| has(name)),
            Names::One(name) => has(name),
        }
    }
}

fn read_three(file: impl Read + Seek, names: &[Cow<str>; 3]) -> Result<Image, ExrError> {
    let [r, g, b] = names.each_ref().map(|name| utf8_text(name));
    let reader = read().no_deep_data().largest_resolution_level().specific_channels();
    let reader = reader.required(r).required(g).required(b).collect_pixels(
        |Vec2(width, height), _| Image::new(width, height),
        |image: &mut Image, position, (r, g, b): (f32, f32, f32)| set(image, position, Rgb::new(r, g, b)),
    );
    Ok(reader
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(file)?
        .layer_data
        .channel_data
        .pixels)
}

fn read_one(file: impl Read + Seek, name: &str) -> Result<Image, ExrError> {
    let reader = read().no_deep_data().largest_resolution_level().specific_channels();
    let reader = reader.required(utf8_text(name)).collect_pixels(
        |Vec2(width, height), _| Image::new(width, height),
        |image: &mut Image, position, (y,): (f32,)| set(image, position, Rgb::splat(y)),
    );
    Ok(reader
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(file)?
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
    let memory = (width * height).saturating_mul(size_of::<Rgb>());
    input::check_memory(memory as u64).map_err(|source| OutputError::Open { path: path.clone(), source })?;
    match header.channels.list.iter().find(|channel| channel.sampling != Vec2(1, 1)) {
        Some(channel) => Err(OutputError::Subsampled { path, channel: channel.name.to_string() }),
        None => Ok(()),
    }
}

/// So many bytes of pixels may be promised by a file however short it is.
const ALWAYS_FINE: u64 = 1 << 24;
/// Bytes of pixels that one of a file can stand for, with some room: a bit of deflate's output is 258 bytes or less.
const MOST_PER_BYTE: u64 = 1100;
/// The same for the lossy kinds, which moreover keep one of 64 values where all are alike.
const MOST_PER_LOSSY_BYTE: u64 = 64 * MOST_PER_BYTE;

/// Refuses a file that promises more pixels than it can hold, before memory is taken for them.
fn check_length(path: &Path, header: &Header, length: u64) -> Result<(), OutputError> {
    let most_per_byte = match header.compression {
        Compression::DWAA(_) | Compression::DWAB(_) => MOST_PER_LOSSY_BYTE,
        _ => MOST_PER_BYTE,
    };
    let Vec2(width, height) = header.layer_size;
    let of_pixel: usize =
        header.channels.list.iter().map(|channel| channel.sample_type.bytes_per_sample()).sum();
    let promised = (width as u64).saturating_mul(height as u64).saturating_mul(of_pixel as u64);
    if promised <= ALWAYS_FINE || promised <= length.saturating_mul(most_per_byte) {
        return Ok(());
    }
    let reason = format!("{length} bytes cannot hold the {width}x{height} pixels that it promises");
    Err(OutputError::NotExr { path: path.into(), reason })
}

fn list_channels(headers: &[Header]) -> String {
    let names = |header: &Header| {
        header.channels.list.iter().map(|channel| channel.name.to_string()).collect::<Vec<_>>().join(", ")
    };
    headers.iter().map(names).collect::<Vec<_>>().join("; ")
}

/// The layers, each once, by name: whole sets of channels, and channels without a dot that are no part of the picture.
fn list_layers(headers: &[Header]) -> String {
    let channels = headers.iter().flat_map(|header| header.channels.list.iter());
    let layers = channels.filter_map(|channel| {
        let name = String::from_utf8_lossy(channel.name.as_slice()).into_owned();
        match name.rsplit_once('.') {
            Some((layer, _)) => {
                let names = of_layer(layer);
                let is_whole = |header: &Header| names.iter().any(|names| names.are_in(header));
                headers.iter().any(is_whole).then(|| layer.to_owned())
            }
            None => (!["R", "G", "B", "A"].contains(&name.as_str())).then_some(name),
        }
    });
    let layers: BTreeSet<String> = layers.collect();
    let layers: Vec<&str> = layers.iter().map(String::as_str).collect();
    if layers.is_empty() { "it has none".into() } else { format!("it has {}", layers.join(", ")) }
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
    use exr::image::{AnyChannel, AnyChannels, FlatSamples, Image as ExrImage, SpecificChannels};
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

    /// Colour, a layer `stderr` of three channels, a direction, two grey layers, and a channel that makes no layer.
    fn layered_file(path: &Path) {
        let colours = ["R", "G", "B", "stderr.R", "stderr.G", "stderr.B"];
        let names = [&colours[..], &["depth.far.Y", "half.R", "N.X", "N.Y", "N.Z", "Z"]].concat();
        let channel = |(index, name): (usize, &str)| {
            AnyChannel::new(utf8_text(name), FlatSamples::F32(vec![index as f32; 12]))
        };
        let channels = AnyChannels::sort(names.into_iter().enumerate().map(channel).collect());
        ExrImage::from_channels((4, 3), channels).write().to_file(path).unwrap();
    }

    #[test]
    fn layers_are_read_by_name() {
        let (_folder, path) = folder_and_path();
        layered_file(&path);
        let named = |layer: &str| read_exr_named(Path::new(&format!("{}{layer}", path.display())));
        let pixel = |layer: &str| named(layer).unwrap().get(3, 2);
        assert_eq!((pixel(""), pixel(":stderr")), (Rgb::new(0.0, 1.0, 2.0), Rgb::new(3.0, 4.0, 5.0)));
        assert_eq!(pixel(":depth.far"), Rgb::splat(6.0));
        assert_eq!((pixel(":N"), pixel(":Z")), (Rgb::new(8.0, 9.0, 10.0), Rgb::splat(11.0)));
        assert_eq!(pixel(":half.R"), Rgb::splat(7.0), "a channel by its whole name");
        for missing in ["bound", "half", "depth", ""] {
            let text = named(&format!(":{missing}")).unwrap_err().to_string();
            let right =
                format!("picture.exr: there is no layer \"{missing}\"; it has N, Z, depth.far, stderr");
            assert!(text.ends_with(&right), "{text}");
        }
        write_exr(&path, &Image::new(4, 3), &Metadata::new()).unwrap();
        assert!(named(":stderr").unwrap_err().to_string().ends_with("\"stderr\"; it has none"));
    }

    #[test]
    fn names_are_split_at_the_colon_behind_the_file() {
        let split = |name: &'static str| split_layer(Path::new(name));
        assert_eq!(split("a:b/c.EXR:d:e"), Some((Path::new("a:b/c.EXR"), "d:e")));
        assert_eq!((split("a.exr"), split("a:b"), split("a.png:b")), (None, None, None));
        let (folder, _) = folder_and_path();
        let odd = folder.path().join("a.exr:b");
        write_exr(&odd, &Image::new(2, 1), &Metadata::new()).unwrap();
        assert_eq!(read_exr_named(&odd).unwrap(), Image::new(2, 1));
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
