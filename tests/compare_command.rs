//! `caustica compare` as a user runs it: options, exit codes, and what it prints and writes.

// Clippy takes helpers outside `#[test]` functions for ordinary code.
#![allow(clippy::expect_used)]

use assert_cmd::Command;
use caustica::film::Image;
use caustica::math::Rgb;
use caustica::output::{Metadata, read_exr, read_png, write_exr, write_png_samples};
use serde_json::Value;
use std::path::Path;
use std::process::Output;
use tempfile::TempDir;

/// A folder with an image, a reference, a standard error of 0.25, bounds and a mask, all of 4 x 2 pixels.
///
/// The image is off by 0.5 in its two columns on the right, and the mask leaves the three on the left.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let write = |name: &str, value: fn(usize) -> Rgb| {
        let pixels = (0..8).map(|pixel| value(pixel % 4)).collect();
        let image = Image::from_pixels(4, 2, pixels).expect("the lengths agree");
        write_exr(&folder.path().join(name), &image, &Metadata::new()).expect("the folder is writable");
    };
    write("image.exr", |x| Rgb::splat(if x < 2 { 1.0 } else { 1.5 }));
    write("reference.exr", |_| Rgb::ONE);
    write("stderr.exr", |_| Rgb::splat(0.25));
    write("bound.exr", |x| if x == 0 { Rgb::splat(f32::NAN) } else { Rgb::splat(0.125 * x as f32) });
    write("broken.exr", |x| if x == 0 { Rgb::NAN } else { Rgb::ONE });
    let mask: Vec<[u8; 3]> = (0..8).map(|pixel| if pixel % 4 < 3 { [0, 0, 1] } else { [0; 3] }).collect();
    write_png_samples(&folder.path().join("mask.png"), 4, 2, &mask).expect("the folder is writable");
    folder
}

fn compare(folder: &TempDir, arguments: &str) -> Output {
    let mut program = Command::cargo_bin("caustica").expect("the program is built");
    let command = program.current_dir(folder.path()).arg("compare").args(arguments.split_whitespace());
    command.output().expect("the program runs")
}

fn code(folder: &TempDir, options: &str) -> Option<i32> {
    compare(folder, &format!("image.exr reference.exr {options}")).status.code()
}

fn json(folder: &TempDir, options: &str) -> Value {
    let output = compare(folder, &format!("image.exr reference.exr --json {options}"));
    serde_json::from_slice(&output.stdout).expect("it prints JSON")
}

fn error_of(folder: &TempDir, arguments: &str) -> String {
    let output = compare(folder, arguments);
    assert_eq!(output.status.code(), Some(2), "{arguments}");
    assert!(output.stdout.is_empty());
    String::from_utf8(output.stderr).expect("errors are text")
}

#[test]
fn crop_and_mask_choose_the_pixels() {
    let folder = folder();
    assert_eq!(json(&folder, "")["mae"], 0.25);
    assert_eq!(json(&folder, "--crop 2,0,2,1")["mae"], 0.5);
    assert_eq!(json(&folder, "--mask mask.png")["pixels"], 6);
    assert_eq!(json(&folder, "--crop 1,0,3,2 --mask mask.png")["mae"], 0.25);
    assert_eq!(json(&folder, "--crop 0,1,2,1")["flip"]["mean"], 0.0);
    assert!(error_of(&folder, "image.exr reference.exr --crop 3,0,2,2").contains("3,0,2,2 reaches beyond"));
}

#[test]
fn thresholds_up_and_down_decide_the_exit_code() {
    let folder = folder();
    for (options, expected) in [
        ("--fail-above smape=0.1 --fail-above p99=0.5", 0),
        ("--fail-above smape=0.099", 1),
        ("--fail-above p99=0.49", 1),
        ("--fail-above flip=0.001", 1),
        ("--fail-above flip=0.9", 0),
        ("--block 2 --fail-above block-max=0.49", 1),
        ("--block 2 --fail-below block-share=0.5", 0),
        ("--block 2 --fail-below block-share=0.51", 1),
        ("--block 2 --block-tolerance 0.5 --fail-below block-share=1", 0),
        ("--stderr stderr.exr --fail-above z-rms=1.5", 0),
        ("--stderr stderr.exr --fail-above z-rms=1.4", 1),
        ("--reference-stderr stderr.exr --fail-below z2=0.51", 1),
        ("--stderr stderr.exr --reference-stderr stderr.exr --fail-below z2=1", 0),
        ("--bound bound.exr --fail-below coverage=0.34 --fail-above coverage=0.9", 1),
        ("--bound bound.exr --fail-below coverage=0.33 --fail-above coverage=0.34", 0),
        ("--bound bound.exr --fail-above coverage=0.33", 1),
        ("--bound bound.exr --fail-above untrusted=0.24", 1),
        ("--fail-above coverage=0.9", 2),
        ("--fail-above coverage=90", 2),
    ] {
        assert_eq!(code(&folder, options), Some(expected), "{options}");
    }
}

#[test]
fn a_nan_fails_every_threshold_and_is_counted() {
    let folder = folder();
    let nan = |options: &str| compare(&folder, &format!("broken.exr broken.exr {options}"));
    for options in
        ["--fail-above mse=1e300", "--fail-above flip=1", "--bound bound.exr --fail-above coverage=1"]
    {
        let output = nan(options);
        assert_eq!(output.status.code(), Some(1), "{options}");
        assert!(String::from_utf8_lossy(&output.stdout).contains("non-finite  2 pixels"));
    }
    assert_eq!(nan("--bound bound.exr --fail-below coverage=0").status.code(), Some(1));
    assert_eq!(nan("--crop 1,0,3,2 --fail-above mse=0").status.code(), Some(0));
}

#[test]
fn bounds_are_judged_and_counted() {
    let folder = folder();
    let coverage = json(&folder, "--bound bound.exr --reference-stderr stderr.exr")["coverage"].clone();
    // Bounds of 0.125, 0.25 and 0.375 on errors of 0, 0.5 and 0.5; widened by 0.25 they hold all.
    assert_eq!(coverage["share"].as_f64(), Some(1.0 / 3.0));
    assert_eq!((&coverage["untrusted"], &coverage["trusted_values"]), (&0.25.into(), &18.into()));
    assert_eq!(coverage["reference_noise"]["share_with_stderr"], 1.0);
    assert_eq!(json(&folder, "")["coverage"], Value::Null);
}

#[test]
fn error_pictures_show_the_region() {
    let folder = folder();
    let written = "--crop 1,0,3,2 --mask mask.png --error-exr e.exr --error-png out/e.png --error-scale 0.25";
    let output = compare(&folder, &format!("image.exr reference.exr {written}"));
    assert!(output.status.success());
    assert!(String::from_utf8_lossy(&output.stderr).contains("violet 0 to yellow 0.25"));
    let picture = |name: &str| folder.path().join(name);
    let signed = read_exr(&picture("e.exr")).expect("it is written");
    assert_eq!([0, 1, 2].map(|x| signed.get(x, 1).x), [0.0, 0.5, 0.0]);
    let colours = read_png(&picture("out/e.png")).expect("it is written");
    let codes = [0, 1, 2].map(|x| (colours.get(x, 1) * 255.0).round().to_array().map(|code| code as u8));
    assert_eq!(codes, [[68, 1, 84], [253, 231, 37], [128; 3]]);
    assert!(error_of(&folder, "image.exr reference.exr --error-png e.exr").contains("ends in .png"));
    assert!(!Path::new(&picture("e.png")).exists());
}

#[test]
fn a_layer_that_is_missing_is_named() {
    let folder = folder();
    let text = error_of(&folder, "image.exr reference.exr --bound image.exr:bound");
    assert_eq!(text, "error: image.exr: there is no layer \"bound\"; it has none\n");
}
