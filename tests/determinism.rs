//! Same scene, seed and settings: the same bytes, whatever the threads. That of small pictures is among the hard cases.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a panic is how a test fails")]

mod common;

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use common::{GLASS_AND_LAMPS, data};

fn run(arguments: &[&str]) {
    Command::cargo_bin("caustica").unwrap().args(arguments).assert().success();
}

/// The EXR of three passes of photon mapping.
fn rendered(folder: &Path, scene: &str, threads: &str, run_number: u32) -> Vec<u8> {
    let output = folder.join(format!("{threads}_{run_number}.exr"));
    let output = output.to_str().unwrap();
    #[rustfmt::skip]
    run(&[
        "render", scene, "-o", output, "--threads", threads, "--passes", "3", "--photons", "20000", "--reproducible",
    ]);
    fs::read(output).unwrap()
}

fn assert_same_bytes(folder: &Path, scene: &str) {
    let first = rendered(folder, scene, "1", 0);
    for (threads, run_number) in [("1", 1), ("2", 0), ("7", 0), ("64", 0)] {
        let other = rendered(folder, scene, threads, run_number);
        assert!(first == other, "{scene}: {threads} threads give another picture");
    }
}

/// At the size at which trees are built and walked in parallel.
#[test]
fn photon_mapping_of_the_water_scene_does_not_depend_on_threads() {
    let folder = tempfile::tempdir().unwrap();
    assert_same_bytes(folder.path(), data("course_water.toml").to_str().unwrap());
}

/// Picture and standard error by a method of reference, as files.
fn reference(folder: &Path, scene: &str, method: &str, threads: &str) -> [Vec<u8>; 2] {
    let name = |suffix: &str| folder.join(format!("{method}_{threads}{suffix}.exr"));
    let output = name("");
    #[rustfmt::skip]
    run(&[
        "reference", scene, "--method", method, "--spp", "8", "--threads", threads,
        "-o", output.to_str().unwrap(), "--reproducible",
    ]);
    [output, name("_stderr")].map(|path| fs::read(path).unwrap())
}

#[test]
fn path_and_light_tracing_do_not_depend_on_threads() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    fs::write(&scene, GLASS_AND_LAMPS.replace("width = 48", "width = 148")).unwrap();
    for method in ["path", "light"] {
        let [one, two, seven, many] = ["1", "2", "7", "64"]
            .map(|threads| reference(folder.path(), scene.to_str().unwrap(), method, threads));
        assert!(one == two && one == seven && one == many, "{method}");
    }
}

/// Without `--reproducible` only the header's seconds differ: the pixels are the same.
#[test]
fn seconds_in_the_header_are_the_only_difference() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    fs::write(&scene, GLASS_AND_LAMPS).unwrap();
    let [a, b] = ["a.exr", "b.exr"].map(|name| {
        let output = folder.path().join(name);
        run(&["render", scene.to_str().unwrap(), "-o", output.to_str().unwrap(), "--passes", "1"]);
        caustica::output::read_exr(&output).unwrap()
    });
    assert_eq!(a, b);
}
