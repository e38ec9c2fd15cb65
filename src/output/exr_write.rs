use super::exr_header::sort_attributes;
use super::{ExrLayer, Metadata, OutputError, Value, check_sides, write_atomically};
use crate::film::Image;
use exr::error::UnitResult;
use exr::image::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image as ExrImage, Layer, write::WritableImage,
};
use exr::math::Vec2;
use exr::meta::attribute::{AttributeValue, Chromaticities, Text};
use exr::meta::header::{LayerAttributes, standard_names};
use exr::prelude::{SmallVec, f16};
use std::collections::HashMap;
use std::io::Cursor;
use std::path::Path;

/// Who writes the files.
const SOFTWARE: &str = concat!("Caustica ", env!("CARGO_PKG_VERSION"));

/// The colours that R, G and B stand for, and their white: those of BT.709, which sRGB shares.
const REC_709: Chromaticities = Chromaticities {
    red: Vec2(0.64, 0.33),
    green: Vec2(0.3, 0.6),
    blue: Vec2(0.15, 0.06),
    white: Vec2(0.3127, 0.329),
};

/// Writes a picture as OpenEXR: one part, scan lines, 32-bit float channels R, G, B, ZIP over 16 lines, linear values
/// of BT.709's primaries.
///
/// Equal pictures and metadata give equal bytes: attributes stand in the header sorted by name. NaN and infinities
/// are kept. The file appears whole or not at all, see [`write_atomically`].
///
/// # Errors
/// When a side of the picture is 0 or too long, when an attribute has a name that is empty, longer than 255 bytes,
/// holds control characters or belongs to the format, or when the file cannot be written.
pub fn write_exr(path: &Path, image: &Image, metadata: &Metadata) -> Result<(), OutputError> {
    write_exr_layers(path, image, &[], metadata)
}

/// The bytes of [`write_exr`]'s file; `name` is for messages.
///
/// # Errors
/// As [`write_exr`], but for those of writing.
pub fn encode_exr(name: &Path, image: &Image, metadata: &Metadata) -> Result<Vec<u8>, OutputError> {
    encode(name, image, &[], metadata, Samples::Float)
}

/// [`write_exr`] with further layers, which the EXR format keeps as channels of the same part.
///
/// # Errors
/// As [`write_exr`], and when a layer is not as large as the picture.
pub fn write_exr_layers(
    path: &Path,
    image: &Image,
    layers: &[ExrLayer],
    metadata: &Metadata,
) -> Result<(), OutputError> {
    let bytes = encode(path, image, layers, metadata, Samples::Float)?;
    write_atomically(path, |out| out.write_all(&bytes))
}

/// The largest finite number of 16 bits.
pub const LARGEST_HALF: f32 = 65504.0;

/// [`write_exr_layers`] with 16-bit samples for the picture; its layers keep 32 bits.
///
/// Returns how many values are finite but beyond ±[`LARGEST_HALF`]; they become that. NaN and infinities are kept.
///
/// # Errors
/// As [`write_exr_layers`].
pub fn write_exr_half(
    path: &Path,
    image: &Image,
    layers: &[ExrLayer],
    metadata: &Metadata,
) -> Result<usize, OutputError> {
    let bytes = encode(path, image, layers, metadata, Samples::Half)?;
    write_atomically(path, |out| out.write_all(&bytes))?;
    let values = image.pixels().iter().flat_map(|pixel| pixel.to_array());
    Ok(values.filter(|value| value.is_finite() && value.abs() > LARGEST_HALF).count())
}

/// How the samples of the picture are kept.
#[derive(Clone, Copy)]
enum Samples {
    Float,
    Half,
}

impl Samples {
    fn of(self, values: impl Iterator<Item = f32>) -> FlatSamples {
        match self {
            Samples::Float => FlatSamples::F32(values.collect()),
            Samples::Half => FlatSamples::F16(values.map(half).collect()),
        }
    }
}

fn half(value: f32) -> f16 {
    let inside = if value.is_finite() { value.clamp(-LARGEST_HALF, LARGEST_HALF) } else { value };
    f16::from_f32(inside)
}

fn encode(
    path: &Path,
    image: &Image,
    layers: &[ExrLayer],
    metadata: &Metadata,
    samples: Samples,
) -> Result<Vec<u8>, OutputError> {
    check_sides(path, image.width(), image.height())?;
    check_layers(path, image, layers)?;
    let attributes = LayerAttributes {
        other: attributes(path, metadata)?,
        software_name: Some(utf8_text(SOFTWARE)),
        world_to_camera: metadata.world_to_camera(),
        ..LayerAttributes::default()
    };
    let mut bytes = Vec::new();
    let encode_error = |reason| OutputError::Encode { path: path.to_path_buf(), reason };
    let channels = AnyChannels::sort(channels(image, layers, samples));
    let size = (image.width(), image.height());
    encode_channels(size, channels, attributes, &mut bytes)
        .map_err(|error| encode_error(error.to_string()))?;
    sort_attributes(&mut bytes).ok_or_else(|| encode_error("its header does not parse".into()))?;
    Ok(bytes)
}

fn encode_channels(
    size: (usize, usize),
    channels: AnyChannels<FlatSamples>,
    attributes: LayerAttributes,
    bytes: &mut Vec<u8>,
) -> UnitResult {
    let layer = Layer::new(size, attributes, Encoding::SMALL_LOSSLESS, channels);
    let mut image = ExrImage::from_layer(layer);
    image.attributes.chromaticities = Some(REC_709);
    image.write().non_parallel().to_buffered(Cursor::new(bytes))
}

fn channels(image: &Image, layers: &[ExrLayer], main: Samples) -> SmallVec<[AnyChannel<FlatSamples>; 4]> {
    let of_picture = ["R", "G", "B"].into_iter().enumerate();
    let of_picture = of_picture.map(|(index, name)| (name.into(), image, index, main));
    let more = layers.iter().flat_map(|layer| {
        let named = |(index, name)| (name, layer.image, index, Samples::Float);
        layer.channels.names(layer.name).into_iter().enumerate().map(named)
    });
    let channel = |(name, image, index, samples): (String, &Image, usize, Samples)| {
        AnyChannel::new(utf8_text(&name), samples.of(image.pixels().iter().map(|pixel| pixel[index])))
    };
    of_picture.chain(more).map(channel).collect()
}

fn check_layers(path: &Path, image: &Image, layers: &[ExrLayer]) -> Result<(), OutputError> {
    let size = |image: &Image| (image.width(), image.height());
    match layers.iter().find(|layer| size(layer.image) != size(image)) {
        Some(layer) => Err(OutputError::LayerSize {
            path: path.to_path_buf(),
            layer: layer.name.into(),
            size: size(layer.image),
            picture: size(image),
        }),
        None => Ok(()),
    }
}

fn attributes(path: &Path, metadata: &Metadata) -> Result<HashMap<Text, AttributeValue>, OutputError> {
    metadata
        .entries()
        .iter()
        .map(|(name, value)| Ok((attribute_name(path, name)?, attribute_value(value))))
        .collect()
}

fn attribute_name(path: &Path, name: &str) -> Result<Text, OutputError> {
    let refuse =
        |reason| Err(OutputError::AttributeName { path: path.to_path_buf(), name: name.into(), reason });
    match name {
        "" => refuse("it is empty"),
        long if long.len() > 255 => refuse("it is longer than 255 bytes"),
        odd if odd.contains(char::is_control) => refuse("it holds a control character"),
        taken if standard_names::ALL.contains(&taken.as_bytes()) => {
            refuse("the EXR format keeps it for itself")
        }
        fine => Ok(utf8_text(fine)),
    }
}

fn attribute_value(value: &Value) -> AttributeValue {
    match value {
        Value::Text(text) => AttributeValue::Text(utf8_text(text)),
        Value::Integer(integer) => i32::try_from(*integer)
            .map_or_else(|_| AttributeValue::Text(utf8_text(&integer.to_string())), AttributeValue::I32),
        Value::Float(float) => AttributeValue::F32(*float),
        Value::Double(double) => AttributeValue::F64(*double),
    }
}

/// The library's own conversion takes Latin-1 alone, while text in EXR files is taken for UTF-8.
pub(super) fn utf8_text(text: &str) -> Text {
    Text::from_slice_unchecked(text.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Rgb;
    use crate::output::{LayerChannels, read_exr};
    use exr::image::write::samples::WritableLevel;
    use exr::prelude::{FlatImage, SampleType, read_all_flat_layers_from_file};
    use std::path::PathBuf;
    use tempfile::TempDir;

    fn folder_and_path() -> (TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.exr");
        (folder, path)
    }

    #[test]
    fn layers_stand_beside_the_picture_under_their_names() {
        let (_folder, path) = folder_and_path();
        let (image, noise) =
            (odd_image(), Image::from_pixels(37, 20, vec![Rgb::new(1.0, 2.0, 3.0); 740]).unwrap());
        let layer = |name, channels| ExrLayer { name, channels, image: &noise };
        let layers = [
            layer("stderr", LayerChannels::Rgb),
            layer("N", LayerChannels::Xyz),
            layer("photons", LayerChannels::Single),
        ];
        write_exr_layers(&path, &image, &layers, &Metadata::new()).unwrap();
        let channels = inspect(&path).layer_data[0].channel_data.list.clone();
        let names: Vec<String> = channels.iter().map(|channel| channel.name.to_string()).collect();
        assert_eq!(
            names,
            ["B", "G", "N.X", "N.Y", "N.Z", "R", "photons", "stderr.B", "stderr.G", "stderr.R"]
        );
        let first = |index: usize| channels[index].sample_data.values_as_f32().next().unwrap();
        assert_eq!([2, 3, 4].map(first), [1.0, 2.0, 3.0]);
        assert_eq!([6, 7, 8, 9].map(first), [1.0, 3.0, 2.0, 1.0]);
        assert_eq!(bits(&read_exr(&path).unwrap()), bits(&image), "layers do not hide the picture");
    }

    #[test]
    fn layers_of_another_size_are_refused() {
        let (_folder, path) = folder_and_path();
        let small = Image::new(2, 1);
        let layers = [ExrLayer { name: "bias", channels: LayerChannels::Rgb, image: &small }];
        let error = write_exr_layers(&path, &Image::new(3, 1), &layers, &Metadata::new()).unwrap_err();
        let text = error.to_string();
        assert!(text.contains("bias") && text.contains("2x1") && text.contains("3x1"), "{text}");
    }

    /// Every bit pattern of a float may come up: subnormals, infinities and NaN among them.
    fn odd_image() -> Image {
        let bits = |i: u32| f32::from_bits(i.wrapping_mul(0x9E37_79B9));
        let pixels = (0..37 * 20).map(|i| Rgb::new(bits(3 * i), bits(3 * i + 1), bits(3 * i + 2))).collect();
        Image::from_pixels(37, 20, pixels).unwrap()
    }

    fn bits(image: &Image) -> Vec<[u32; 3]> {
        image.pixels().iter().map(|pixel| pixel.to_array().map(f32::to_bits)).collect()
    }

    fn inspect(path: &Path) -> FlatImage {
        read_all_flat_layers_from_file(path).unwrap()
    }

    fn refusal(name: &str) -> String {
        let (_folder, path) = folder_and_path();
        let metadata = Metadata::new().with(name, Value::Integer(1));
        let text = write_exr(&path, &Image::new(1, 1), &metadata).unwrap_err().to_string();
        assert!(!path.exists() && text.contains("caustica:passes"), "{text}");
        text
    }

    #[test]
    fn every_bit_comes_back() {
        let (_folder, path) = folder_and_path();
        let image = odd_image();
        write_exr(&path, &image, &Metadata::new()).unwrap();
        let back = read_exr(&path).unwrap();
        assert_eq!((back.width(), back.height()), (37, 20));
        assert_eq!(bits(&back), bits(&image));
    }

    #[test]
    fn the_layout_is_float_scan_lines_under_zip() {
        let (_folder, path) = folder_and_path();
        write_exr(&path, &odd_image(), &Metadata::new()).unwrap();
        let file = inspect(&path);
        assert_eq!(file.layer_data.len(), 1);
        assert_eq!(file.layer_data[0].encoding, Encoding::SMALL_LOSSLESS);
        let channels = &file.layer_data[0].channel_data.list;
        let names: Vec<_> = channels.iter().map(|channel| channel.name.to_string()).collect();
        assert_eq!(names, ["B", "G", "R"]);
        assert!(channels.iter().all(|channel| channel.sample_data.values_as_f32().count() == 37 * 20));
        assert!(channels.iter().all(|channel| channel.sample_data.sample_type() == SampleType::F32));
    }

    #[test]
    fn attributes_keep_their_types() {
        let (_folder, path) = folder_and_path();
        let long_name = format!("caustica:{}", "n".repeat(200));
        let metadata = Metadata::new()
            .with("caustica:scene", Value::Text("Kaffeetasse, süß ☕".into()))
            .with("caustica:passes", Value::Integer(-7))
            .with("caustica:photons", Value::Integer(1 << 40))
            .with("caustica:alpha", Value::Float(0.7))
            .with("caustica:error", Value::Double(0.1))
            .with(long_name.as_str(), Value::Text(String::new()));
        write_exr(&path, &Image::new(2, 2), &metadata).unwrap();
        let file = inspect(&path);
        let found = |name: &str| file.layer_data[0].attributes.other.get(&utf8_text(name)).unwrap();
        assert_eq!(found("caustica:scene"), &AttributeValue::Text(utf8_text("Kaffeetasse, süß ☕")));
        assert_eq!(found("caustica:passes"), &AttributeValue::I32(-7));
        assert_eq!(found("caustica:photons"), &AttributeValue::Text(utf8_text("1099511627776")));
        assert_eq!(found("caustica:alpha"), &AttributeValue::F32(0.7));
        assert_eq!(found("caustica:error"), &AttributeValue::F64(0.1));
        assert_eq!(found(&long_name), &AttributeValue::Text(utf8_text("")));
    }

    #[test]
    fn attributes_of_the_format_tell_colours_camera_and_writer() {
        let (_folder, path) = folder_and_path();
        let matrix: [f32; 16] = std::array::from_fn(|k| k as f32);
        write_exr(&path, &Image::new(2, 2), &Metadata::new().with_world_to_camera(matrix)).unwrap();
        let file = inspect(&path);
        assert_eq!(file.attributes.chromaticities, Some(REC_709));
        assert_eq!(file.attributes.pixel_aspect, 1.0);
        let layer = &file.layer_data[0].attributes;
        assert_eq!(layer.world_to_camera, Some(matrix));
        assert_eq!(layer.software_name, Some(utf8_text(SOFTWARE)));
        assert!(SOFTWARE.starts_with("Caustica 0."));
    }

    #[test]
    fn equal_pictures_give_equal_bytes_with_sorted_names() {
        let metadata = (0..40).fold(Metadata::new(), |metadata, i| {
            metadata.with(format!("caustica:{:02}", (i * 27) % 40), Value::Integer(i))
        });
        let bytes =
            || encode(Path::new("picture.exr"), &odd_image(), &[], &metadata, Samples::Float).unwrap();
        let first = bytes();
        assert!((0..20).all(|_| bytes() == first));
        let place = |i: usize| {
            let name = format!("caustica:{i:02}\0");
            first.windows(name.len()).position(|window| window == name.as_bytes()).unwrap()
        };
        assert!((1..40).all(|i| place(i - 1) < place(i)));
    }

    #[test]
    fn names_that_the_format_cannot_take_are_refused() {
        assert!(refusal("").contains("it is empty"));
        assert!(refusal(&"n".repeat(256)).contains("longer than 255 bytes"));
        assert!(refusal("a\0b").contains("control character"));
        assert!(
            refusal("channels").contains("\"channels\" cannot name an attribute: the EXR format keeps it")
        );
    }

    #[test]
    fn an_empty_picture_is_refused() {
        let (_folder, path) = folder_and_path();
        let text = write_exr(&path, &Image::new(4, 0), &Metadata::new()).unwrap_err().to_string();
        assert!(text.contains("a picture of 4x0 pixels cannot be written"), "{text}");
    }
}
