//! Pictures on their way to the disk, and back.

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use caustica::film::Image;
use caustica::math::Rgb;
use caustica::output::{
    Display, LARGEST_HALF, Metadata, read_exr, read_exr_bytes, read_png, read_png_bytes, write_exr,
    write_exr_half, write_png,
};

/// A picture of 4 x 3 pixels, grey from 0 to 1.1.
fn greys() -> Image {
    Image::from_pixels(4, 3, (0..12).map(|i| Rgb::splat(0.1 * i as f32)).collect()).unwrap()
}

fn bits(image: &Image) -> Vec<[u32; 3]> {
    image.pixels().iter().map(|pixel| pixel.to_array().map(f32::to_bits)).collect()
}

/// In 16 bits, values beyond 65504 become that and are counted; NaN and infinities stay what they are. By default nothing is lost, for samples have 32 bits.
///
/// Breaks: a light seen directly is infinite in the file, and every mean over the picture with it.
///
/// Mutation: `half` does not clamp.
#[test]
fn values_beyond_16_bits_are_clamped_and_counted() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let mut image = greys();
    image.pixels_mut()[5] = Rgb::new(1e6, -7e4, 65504.0);
    image.pixels_mut()[6] = Rgb::new(65519.0, f32::INFINITY, f32::MAX);
    image.pixels_mut()[7] = Rgb::new(f32::NAN, f32::NEG_INFINITY, 1e-9);
    assert_eq!(write_exr_half(&path, &image, &[], &Metadata::new()).unwrap(), 4);
    let back = read_exr(&path).unwrap();
    assert_eq!(back.get(1, 1), Rgb::new(LARGEST_HALF, -LARGEST_HALF, LARGEST_HALF));
    assert_eq!(back.get(2, 1), Rgb::new(LARGEST_HALF, f32::INFINITY, LARGEST_HALF));
    assert!(back.get(3, 1).x.is_nan() && back.get(3, 1).y == f32::NEG_INFINITY && back.get(3, 1).z == 0.0);
    assert!((back.get(3, 0).x - 0.3).abs() < 2e-4, "16 bits have 11 digits");
    write_exr(&path, &image, &Metadata::new()).unwrap();
    assert_eq!(bits(&read_exr(&path).unwrap()), bits(&image));
}

const BRIGHT: &str = "\
film = { width = 8, height = 8 }
camera = { position = [0, 0, 5], look_at = [0, 0, 0], fov = 40 }
render = { passes = 1, photons = 100, samples = 1, radius = 0.1 }
material.lamp = { diffuse = { albedo = [0, 0, 0] }, emission = [1e5, 1, 1] }
[[quad]]
corners = [[-9, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0]]
material = 'lamp'
";

/// `render` and `reference` tell how many values `--half` clamped, and keep all of them without it.
///
/// Breaks: the bright half of a picture is lost, and nobody is told.
///
/// Mutation: `PicturePath::write_layers` does not warn.
#[test]
fn clamped_values_are_told_on_the_command_line() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("s.toml"), BRIGHT).unwrap();
    let path = folder.path().join("a.exr");
    for command in ["render", "reference"] {
        for (half, largest) in [(&["--half"][..], LARGEST_HALF), (&[], 1e5)] {
            let mut program = Command::cargo_bin("caustica").unwrap();
            let program =
                program.current_dir(folder.path()).args([command, "s.toml", "-o", "a.exr"]).args(half);
            let told = String::from_utf8(program.output().unwrap().stderr).unwrap();
            assert_eq!(told.contains("a.exr: 64 values beyond ±65504"), half.len() == 1, "{told}");
            assert!(
                read_exr(&path).unwrap().pixels().iter().all(|pixel| *pixel == Rgb::new(largest, 1.0, 1.0))
            );
        }
    }
}

/// A pixel that is not a number stays alone: in the EXR of either width and in the PNG all others are what they were, and whoever compares is told where it is.
///
/// Breaks: a NaN spreads through the encoder's filter or the mean of a comparison, and nobody finds where it came from.
///
/// Mutation: `Display::encode` takes NaN for black.
#[test]
fn one_nan_pixel_poisons_itself_alone_and_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let clean = greys();
    let mut image = clean.clone();
    image.pixels_mut()[4 + 2] = Rgb::new(0.1, f32::NAN, 0.1);
    assert_eq!((image.count_non_finite(), image.first_non_finite()), (1, Some((2, 1))));
    let differing = |a: &Image, b: &Image| {
        let (a, b) = (bits(a), bits(b));
        (0..12).filter(|&i| a[i] != b[i]).collect::<Vec<usize>>()
    };
    write_exr(&path("clean.exr"), &clean, &Metadata::new()).unwrap();
    write_exr(&path("nan.exr"), &image, &Metadata::new()).unwrap();
    assert_eq!(differing(&read_exr(&path("nan.exr")).unwrap(), &clean), [6]);
    write_exr_half(&path("nan_half.exr"), &image, &[], &Metadata::new()).unwrap();
    write_exr_half(&path("clean_half.exr"), &clean, &[], &Metadata::new()).unwrap();
    let halves = ["nan_half.exr", "clean_half.exr"].map(|name| read_exr(&path(name)).unwrap());
    assert_eq!(differing(&halves[0], &halves[1]), [6]);
    write_png(&path("nan.png"), &image, &Display::default()).unwrap();
    write_png(&path("clean.png"), &clean, &Display::default()).unwrap();
    let shown = ["nan.png", "clean.png"].map(|name| read_png(&path(name)).unwrap());
    assert_eq!((differing(&shown[0], &shown[1]), shown[0].get(2, 1)), (vec![6], Rgb::new(1.0, 0.0, 1.0)));
    let mut program = Command::cargo_bin("caustica").unwrap();
    let program = program.current_dir(folder.path()).args(["compare", "nan.exr", "clean.exr"]);
    let told = String::from_utf8(program.output().unwrap().stdout).unwrap();
    assert!(told.contains("(2, 1)") && told.contains("non-finite  1 pixels"), "{told}");
}

/// A file of a few hundred bytes that promises many pixels is refused before memory is taken for them.
///
/// Breaks: a header of 300 bytes takes 3 GB.
///
/// Mutation: `check_length` of both readers lets everything through.
#[test]
fn pictures_that_promise_more_than_they_hold_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (exr, png) = (folder.path().join("a.exr"), folder.path().join("a.png"));
    write_exr(&exr, &greys(), &Metadata::new()).unwrap();
    write_png(&png, &greys(), &Display::default()).unwrap();
    let mut bytes = fs::read(&exr).unwrap();
    let mark = b"dataWindow\0box2i\0\x10\0\0\0";
    let corner = bytes.windows(mark.len()).position(|window| window == mark).unwrap() + mark.len() + 8;
    bytes[corner..corner + 8].copy_from_slice(&[15_999i32.to_le_bytes(); 2].concat());
    let refusal = read_exr_bytes(Path::new("a.exr"), &bytes).unwrap_err().to_string();
    assert!(refusal.contains("a.exr") && refusal.contains("cannot hold the 16000x16000 pixels"), "{refusal}");
    let mut bytes = fs::read(&png).unwrap();
    bytes[16..24].copy_from_slice(&[16_000i32.to_be_bytes(); 2].concat());
    let sum = crc(&bytes[12..29]);
    bytes[29..33].copy_from_slice(&sum.to_be_bytes());
    let refusal = read_png_bytes(Path::new("a.png"), &bytes).unwrap_err().to_string();
    assert!(refusal.contains("a.png") && refusal.contains("cannot hold the 16000x16000 pixels"), "{refusal}");
}

/// The checksum of PNG chunks, bit by bit.
fn crc(bytes: &[u8]) -> u32 {
    let step = |sum: u32, _| if sum & 1 == 1 { 0xEDB8_8320 ^ (sum >> 1) } else { sum >> 1 };
    !bytes.iter().fold(u32::MAX, |sum, byte| (0..8).fold(sum ^ u32::from(*byte), step))
}
