//! `caustica compare --batch` as a user runs it: pairs, verdicts, files, exit codes.

// Clippy takes helpers outside `#[test]` functions for ordinary code.
#![allow(clippy::expect_used)]

use assert_cmd::Command;
use caustica::film::Image;
use caustica::math::Rgb;
use caustica::output::{ExrLayer, LayerChannels, Metadata, write_exr, write_exr_layers};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Output;
use tempfile::TempDir;

fn picture(value: f32) -> Image {
    Image::from_pixels(8, 4, vec![Rgb::splat(value); 32]).expect("the lengths agree")
}

fn write(folder: &Path, name: &str, value: f32) {
    let path = folder.join(name);
    fs::create_dir_all(path.parent().expect("it has one")).expect("the folder is writable");
    write_exr(&path, &picture(value), &Metadata::new()).expect("the folder is writable");
}

/// Folders `a` and `b`: an equal pair, one off by a tenth, one of other sizes, one that is no EXR, and one in each folder alone.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (a, b) = (folder.path().join("a"), folder.path().join("b"));
    for (name, ours, theirs) in [("equal.exr", 1.0, 1.0), ("sub/near.exr", 1.1, 1.0)] {
        write(&a, name, ours);
        write(&b, name, theirs);
    }
    folder
}

fn add_faults(folder: &TempDir) {
    let (a, b) = (folder.path().join("a"), folder.path().join("b"));
    write(&a, "size.exr", 1.0);
    write_exr(&b.join("size.exr"), &Image::new(3, 3), &Metadata::new()).expect("the folder is writable");
    write(&a, "torn.exr", 1.0);
    fs::write(b.join("torn.exr"), "no picture").expect("the folder is writable");
    write(&a, "new.exr", 1.0);
    write(&b, "gone.exr", 1.0);
}

fn compare(folder: &TempDir, arguments: &str) -> Output {
    let mut program = Command::cargo_bin("caustica").expect("the program is built");
    let command =
        program.current_dir(folder.path()).args(["compare", "--batch"]).args(arguments.split_whitespace());
    command.output().expect("the program runs")
}

fn rows(output: &Output) -> Vec<Value> {
    let json: Value = serde_json::from_slice(&output.stdout).expect("it prints JSON");
    json["pictures"].as_array().expect("a list").clone()
}

fn error_of(folder: &TempDir, arguments: &str) -> String {
    let output = compare(folder, arguments);
    assert_eq!(output.status.code(), Some(2), "{arguments}");
    String::from_utf8(output.stderr).expect("errors are text")
}

#[test]
fn bounds_decide_for_every_pair() {
    let folder = folder();
    for (bounds, code, verdicts) in [
        ("", 0, ["equal", "within"]),
        ("--fail-above mae=0.2", 0, ["equal", "within"]),
        ("--fail-above mae=0.05", 1, ["equal", "beyond"]),
        ("--fail-below mae=0.05", 1, ["beyond", "within"]),
    ] {
        let output = compare(&folder, &format!("a b --json {bounds}"));
        let rows = rows(&output);
        let found: Vec<&str> = rows.iter().map(|row| row["verdict"].as_str().unwrap()).collect();
        assert_eq!((output.status.code(), &found[..]), (Some(code), &verdicts[..]), "{bounds}");
        assert_eq!(rows[1]["name"], "sub/near.exr");
        assert!((rows[1]["comparison"]["mae"].as_f64().unwrap() - 0.1).abs() < 1e-6);
    }
}

/// A picture that nobody can compare is no reason to leave out the others.
#[test]
fn what_cannot_be_compared_is_told_and_fails() {
    let folder = folder();
    add_faults(&folder);
    let output = compare(&folder, "a b --json");
    assert_eq!(output.status.code(), Some(1));
    let rows = rows(&output);
    let found: Vec<(&str, &str)> =
        rows.iter().map(|row| (row["name"].as_str().unwrap(), row["verdict"].as_str().unwrap())).collect();
    let expected = [
        ("equal.exr", "equal"),
        ("gone.exr", "no_image"),
        ("new.exr", "no_reference"),
        ("size.exr", "failed"),
        ("sub/near.exr", "within"),
        ("torn.exr", "failed"),
    ];
    assert_eq!(found, expected);
    assert!(rows[3]["because"].as_str().unwrap().contains("8x4 against 3x3"), "{}", rows[3]);
    assert!(rows[5]["because"].as_str().unwrap().contains("torn.exr"), "{}", rows[5]);
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(told.contains("2 of 6 pictures are good"), "{told}");
}

#[test]
fn the_table_is_written_in_three_forms() {
    let folder = folder();
    add_faults(&folder);
    let output = compare(&folder, "a b -o found");
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(text.lines().count(), 2 + 6, "{text}");
    let read = |kind: &str| fs::read_to_string(folder.path().join("found/regression").with_extension(kind));
    let csv = read("csv").unwrap();
    let line = csv.lines().find(|line| line.starts_with("sub/near.exr,")).unwrap();
    assert_eq!(line.split(',').collect::<Vec<_>>()[1..3], ["within", "0.1000"]);
    let json: Value = serde_json::from_str(&read("json").unwrap()).unwrap();
    assert_eq!(json["pictures"].as_array().unwrap().len(), 6);
    let html = read("html").unwrap();
    assert_eq!(html.matches("<img src=\"data:image/png;base64,").count(), 3, "of the pair that differs");
    assert!(html.contains("sub/near.exr, relmse 9."), "the worst is named");
}

#[test]
fn layers_of_the_pictures_are_their_standard_errors() {
    let folder = folder();
    let stderr = picture(0.1);
    let layers = [ExrLayer { name: "stderr", image: &stderr, channels: LayerChannels::Rgb }];
    for name in ["a/equal.exr", "a/sub/near.exr"] {
        let value = if name.ends_with("near.exr") { 1.1 } else { 1.0 };
        write_exr_layers(&folder.path().join(name), &picture(value), &layers, &Metadata::new()).unwrap();
    }
    let rows = rows(&compare(&folder, "a b --json --stderr :stderr"));
    assert!((rows[1]["comparison"]["z"]["rms"].as_f64().unwrap() - 1.0).abs() < 1e-5, "{}", rows[1]);
    let error = error_of(&folder, "a b --stderr a/equal.exr");
    assert!(error.contains("a/equal.exr") && error.contains("such as :stderr"), "{error}");
}

#[test]
fn folders_that_hold_nothing_are_refused() {
    let folder = folder();
    let error = error_of(&folder, "a/none b");
    assert!(error.contains("a/none") && error.contains("name two folders"), "{error}");
    fs::create_dir(folder.path().join("empty")).unwrap();
    let error = error_of(&folder, "empty empty");
    assert!(error.contains("there is no EXR file in empty"), "{error}");
    assert!(!folder.path().join("out/regression/regression.csv").exists());
    error_of(&folder, "a b --error-png e.png");
}
