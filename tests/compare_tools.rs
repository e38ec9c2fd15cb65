//! The metrics and the EXR files, held against what OpenImageIO's and OpenEXR's own tools say of them.

// Clippy takes helpers outside `#[test]` functions for ordinary code.
#![allow(clippy::expect_used)]

use caustica::compare::{Coverage, Crop, Estimate, Metrics, Region, signed_difference};
use caustica::film::Image;
use caustica::math::{Rgb, Rng, Stream};
use caustica::output::{Display, Metadata, Value, read_exr, read_exr_layer, read_png, write_exr, write_png};
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

/// What the tool prints, or `None`, with a notice, if it is not installed.
fn output_of(tool: &str, arguments: &[&str], files: &[&Path]) -> Option<String> {
    match Command::new(tool).args(arguments).args(files).output() {
        Ok(output) => Some(String::from_utf8_lossy(&output.stdout).into_owned()),
        Err(error) => {
            eprintln!("skipped: {tool} cannot be run ({error}); Debian: openimageio-tools, openexr");
            None
        }
    }
}

fn random_image(seed: u64, brightest: f32) -> Image {
    let mut rng = Rng::new(seed, Stream::Test, 0, 0);
    let mut value = || brightest * rng.next_f32();
    let pixels = (0..67 * 41).map(|_| Rgb::new(value(), value(), value())).collect();
    Image::from_pixels(67, 41, pixels).expect("the lengths agree")
}

fn write(folder: &TempDir, name: &str, image: &Image, metadata: &Metadata) -> PathBuf {
    let path = folder.path().join(name);
    write_exr(&path, image, metadata).expect("the folder is writable");
    path
}

/// The number after `label = ` in a tool's report.
fn number(report: &str, label: &str) -> f64 {
    let at = report.find(label).unwrap_or_else(|| panic!("no {label:?} in {report}"));
    let rest = report[at + label.len()..].trim_start_matches([' ', '=']);
    let end = rest.find(char::is_whitespace).unwrap_or(rest.len());
    rest[..end].parse().unwrap_or_else(|_| panic!("no number after {label:?} in {report}"))
}

fn assert_close(tool: f64, ours: f64) {
    // The tools print six digits.
    assert!((tool - ours).abs() <= 1e-5 * ours.abs(), "the tool says {tool}, we say {ours}");
}

fn compare_with(tool: &str, arguments: &[&str], brightest: f32) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (image, reference) = (random_image(1, brightest), random_image(2, brightest));
    let a = write(&folder, "a.exr", &image, &Metadata::new());
    let b = write(&folder, "b.exr", &reference, &Metadata::new());
    let Some(report) = output_of(tool, arguments, &[&a, &b]) else { return };
    let metrics = Metrics::between(&image, &reference).expect("the sizes agree");
    assert_close(number(&report, "Mean error"), metrics.mae);
    assert_close(number(&report, "RMS error"), metrics.rmse);
    assert_close(number(&report, "Max error"), metrics.max);
    let (x, y) = metrics.max_pixel;
    assert!(report.contains(&format!("@ ({x}, {y}, ")), "our largest error is at ({x}, {y}): {report}");
    // OpenImageIO's peak is the largest value of both pictures if that is above 1, ours is always 1.
    let values = image.pixels().iter().chain(reference.pixels());
    let peak = f64::from(values.fold(1.0, |peak: f32, pixel| peak.max(pixel.max_element())));
    assert_close(number(&report, "Peak SNR"), metrics.psnr + 20.0 * peak.log10());
}

#[test]
fn idiff_agrees_on_values_up_to_one() {
    compare_with("idiff", &["-a"], 1.0);
}

#[test]
fn idiff_agrees_on_bright_values() {
    compare_with("idiff", &["-a"], 30.0);
}

#[test]
fn oiiotool_agrees() {
    compare_with("oiiotool", &["--diff"], 1.0);
}

/// Two random pictures and the files that hold them.
fn pair_on_disk(folder: &TempDir) -> [(Image, PathBuf); 2] {
    [("a.exr", 5), ("b.exr", 6)].map(|(name, seed)| {
        let image = random_image(seed, 1.0);
        let path = write(folder, name, &image, &Metadata::new());
        (image, path)
    })
}

#[test]
fn oiiotool_subtracts_like_the_error_picture() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [(image, a), (reference, b)] = pair_on_disk(&folder);
    let difference = folder.path().join("difference.exr");
    if output_of("oiiotool", &[], &[&a, &b, "--sub".as_ref(), "-o".as_ref(), &difference]).is_none() {
        return;
    }
    let ours = signed_difference(&image, &reference, &Region::of(&image)).expect("the sizes agree");
    assert_eq!(read_exr(&difference).expect("oiiotool wrote a picture"), ours);
}

#[test]
fn idiff_agrees_on_pictures_that_oiiotool_cut() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let pair = pair_on_disk(&folder);
    let cut = pair.each_ref().map(|(_, path)| path.with_extension("cut.exr"));
    for ((_, whole), cut) in pair.iter().zip(&cut) {
        if output_of("oiiotool", &[], &[whole, "--cut".as_ref(), "30x17+11+5".as_ref(), "-o".as_ref(), cut])
            .is_none()
        {
            return;
        }
    }
    let Some(report) = output_of("idiff", &["-a"], &[&cut[0], &cut[1]]) else { return };
    let [(image, _), (reference, _)] = &pair;
    let crop = Crop { x: 11, y: 5, width: 30, height: 17 };
    let region = Region::of(image).with_crop(crop).expect("it lies inside");
    let metrics = Metrics::within(image, reference, &region).expect("the sizes agree");
    assert_close(number(&report, "Mean error"), metrics.mae);
    assert_close(number(&report, "RMS error"), metrics.rmse);
    assert_close(number(&report, "Max error"), metrics.max);
    let (x, y) = metrics.max_pixel;
    assert!(report.contains(&format!("@ ({}, {}, ", x - crop.x, y - crop.y)), "({x}, {y}): {report}");
}

#[test]
fn idiff_agrees_on_pictures_that_oiiotool_masked() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let pair = pair_on_disk(&folder);
    let (mask, step) = (folder.path().join("mask.png"), "checker:width=9:height=5:color1=0,0,0:color2=1,1,1");
    let pattern = ["--pattern", step, "67x41", "3", "-d", "uint16", "-o"];
    if output_of("oiiotool", &pattern, &[&mask]).is_none() {
        return;
    }
    let masked = pair.each_ref().map(|(_, path)| path.with_extension("masked.exr"));
    for ((_, whole), masked) in pair.iter().zip(&masked) {
        output_of(
            "oiiotool",
            &[],
            &[whole, &mask, "--mul".as_ref(), "-d".as_ref(), "float".as_ref(), "-o".as_ref(), masked],
        );
    }
    let Some(report) = output_of("idiff", &["-a"], &[&masked[0], &masked[1]]) else { return };
    let [(image, _), (reference, _)] = &pair;
    let mask = read_png(&mask).expect("oiiotool wrote a mask");
    let region = Region::of(image).with_mask(&mask).expect("it is of their size");
    let metrics = Metrics::within(image, reference, &region).expect("the sizes agree");
    // To the tool the masked pixels are black in both pictures and count.
    let share = region.len() as f64 / image.pixels().len() as f64;
    assert!(share > 0.4 && share < 0.6, "{share}");
    assert_close(number(&report, "Mean error"), share * metrics.mae);
    assert_close(number(&report, "RMS error"), share.sqrt() * metrics.rmse);
    assert_close(number(&report, "Max error"), metrics.max);
}

#[test]
fn idiff_counts_the_pixels_beyond_a_bound() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let grey = |seed| {
        let pixels = random_image(seed, 1.0).pixels().iter().map(|pixel| Rgb::splat(pixel.x)).collect();
        Image::from_pixels(67, 41, pixels).expect("the lengths agree")
    };
    let (image, reference) = (grey(7), grey(8));
    let a = write(&folder, "a.exr", &image, &Metadata::new());
    let b = write(&folder, "b.exr", &reference, &Metadata::new());
    let Some(report) = output_of("idiff", &["-a", "-fail", "0.25"], &[&a, &b]) else { return };
    let bound = Image::from_pixels(67, 41, vec![Rgb::splat(0.25); 67 * 41]).expect("the lengths agree");
    let coverage = Coverage::of(&bound, &image, Estimate::exact(&reference), &Region::of(&image));
    let beyond = 1.0 - coverage.expect("the sizes agree").share;
    let line = format!("{} pixels (", (beyond * 67.0 * 41.0).round());
    assert!(
        report.lines().any(|found| found.trim().starts_with(&line) && found.ends_with("over 0.25")),
        "{line}: {report}"
    );
}

#[test]
fn layers_that_oiiotool_appended_are_read() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [(image, a), (stderr, b)] = pair_on_disk(&folder);
    let layered = folder.path().join("layered.exr");
    let words = ["--chnames", "stderr.R,stderr.G,stderr.B", "--chappend", "-o"].map(Path::new);
    if output_of("oiiotool", &[], &[&a, &b, words[0], words[1], words[2], words[3], &layered]).is_none() {
        return;
    }
    assert_eq!(read_exr(&layered).expect("it has colours"), image);
    assert_eq!(read_exr_layer(&layered, "stderr").expect("it has the layer"), stderr);
}

fn described_picture(folder: &TempDir) -> PathBuf {
    let metadata = Metadata::new()
        .with("caustica:scene", Value::Text("süße Tasse".into()))
        .with("caustica:passes", Value::Integer(123))
        .with("caustica:alpha", Value::Float(0.5))
        .with("caustica:seconds", Value::Double(1.25));
    write(folder, "described.exr", &random_image(3, 1.0), &metadata)
}

fn assert_lines(report: &str, lines: &[&str]) {
    for line in lines {
        assert!(report.lines().any(|found| found.trim() == *line), "no line {line:?} in {report}");
    }
}

#[test]
fn oiiotool_sees_the_layout_and_the_attributes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = described_picture(&folder);
    let Some(report) = output_of("oiiotool", &["--info", "-v"], &[&path]) else { return };
    assert!(report.contains("67 x   41, 3 channel, float openexr"), "{report}");
    assert_lines(
        &report,
        &[
            "channel list: R, G, B",
            "compression: \"zip\"",
            "caustica:scene: \"süße Tasse\"",
            "caustica:passes: 123",
            "caustica:alpha: 0.5",
            "caustica:seconds: 1.25",
        ],
    );
}

#[test]
fn exrheader_sees_the_layout_and_the_attributes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = described_picture(&folder);
    let Some(report) = output_of("exrheader", &[], &[&path]) else { return };
    assert_lines(
        &report,
        &[
            "B, 32-bit floating-point, sampling 1 1",
            "G, 32-bit floating-point, sampling 1 1",
            "R, 32-bit floating-point, sampling 1 1",
            "compression (type compression): zip, multi-scanline blocks",
            "lineOrder (type lineOrder): increasing y",
            "dataWindow (type box2i): (0 0) - (66 40)",
            "caustica:scene (type string): \"süße Tasse\"",
            "caustica:passes (type int): 123",
            "caustica:alpha (type float): 0.5",
            "caustica:seconds (type double): 1.25",
        ],
    );
}

#[test]
fn oiiotool_rewrites_what_we_read_back() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let image = random_image(4, 1.0);
    let path = write(&folder, "ours.exr", &image, &Metadata::new());
    let tiled = folder.path().join("tiled.exr");
    let arguments = ["--compression", "piz", "--tile", "16", "16", "-o"];
    if Command::new("oiiotool").arg(&path).args(arguments).arg(&tiled).status().is_err() {
        eprintln!("skipped: oiiotool cannot be run; Debian: openimageio-tools");
        return;
    }
    assert_eq!(read_exr(&tiled).expect("oiiotool wrote a picture"), image);
}

#[test]
fn oiiotool_finds_the_display_values_of_a_png() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("grey.png");
    let image = Image::from_pixels(2, 1, vec![Rgb::splat(0.5); 2]).expect("the lengths agree");
    write_png(&path, &image, &Display::default()).expect("the folder is writable");
    let Some(report) = output_of("oiiotool", &["--info", "--stats"], &[&path]) else { return };
    assert_lines(&report, &["Stats Max: 186 186 186 (of 255)"]);
}
