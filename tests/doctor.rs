//! `caustica doctor` as a user and a script meet it.
#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

mod common;

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use common::data;
use serde_json::Value;
use tempfile::TempDir;

/// Exit code and standard output.
fn doctor(arguments: &[&str]) -> (i32, String) {
    let output = Command::cargo_bin("caustica").unwrap().arg("doctor").args(arguments).output().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(!errors.contains("panicked"), "{errors}");
    (output.status.code().unwrap(), String::from_utf8(output.stdout).unwrap())
}

fn findings(arguments: &[&str]) -> (i32, Value) {
    let (code, text) = doctor(&[arguments, &["--json"]].concat());
    (code, serde_json::from_str(&text).unwrap())
}

/// The findings of a check, as `severity: found`.
fn of<'a>(diagnosis: &'a Value, check: &'a str) -> Vec<String> {
    let all = diagnosis["findings"].as_array().unwrap().iter();
    let line = |f: &Value| format!("{}: {}", f["severity"].as_str().unwrap(), f["found"].as_str().unwrap());
    all.filter(|finding| finding["check"] == check).map(line).collect()
}

fn name(path: &Path) -> &str {
    path.to_str().unwrap()
}

#[test]
fn the_projects_own_scenes_are_sound() {
    for scene in ["course_diffuse", "course_balls", "course_water", "cornell_a", "cornell_b"] {
        let path = data(&format!("{scene}.toml"));
        let (code, diagnosis) = findings(&[name(&path), "--strict"]);
        assert_eq!(code, 0, "{scene}: {diagnosis:#}");
        assert!(diagnosis["verdict"].as_str().unwrap().contains(": sound; "), "{scene}");
        let open = of(&diagnosis, "open glass").concat();
        assert_eq!(
            scene == "course_water",
            open.starts_with("note: 1 open sheet with 1024 free edges"),
            "{open}"
        );
    }
}

#[test]
fn the_program_is_sound() {
    let (code, text) = doctor(&[]);
    assert_eq!(code, 0, "{text}");
    assert!(text.ends_with("\nbuilt-in scenes: sound; nothing to note\n"), "{text}");
}

const ROOM: &str = r#"
[camera]
position = [0, 0, 4]
look_at = [0, 0, 0]
fov = 30
[render]
photons = 5000
radius = 0.05
[material.wall]
diffuse = { albedo = [0.5, 0.5, 0.5] }
[material.glass]
dielectric = { ior = 1.5 }
[[point_light]]
position = [0, 0.5, 0]
intensity = [1, 1, 1]
[[sphere]]
center = [0, 0.5, 0]
radius = 0.1
material = "wall"
[[quad]]
corners = [[-2, -1, -2], [-2, -1, 2], [2, -1, 2], [2, -1, -2]]
material = "wall"
[[quad]]
corners = [[-2, -1, -2], [2, -1, -2], [2, 2, -2], [-2, 2, -2]]
material = "wall"
[[mesh]]
file = "odd.obj"
material = "glass"
"#;

/// A tetrahedron wound inward, one of its faces twice, and a triangle without area.
const ODD: &str = "\
v 0.5 -0.5 0\nv 1 -0.5 0\nv 0.5 0 0\nv 0.5 -0.5 0.5\n\
f 1 2 3\nf 1 3 4\nf 1 4 2\nf 2 4 3\nf 2 3 1\nf 1 2 2\n";

fn folder(scene: &str) -> (TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("odd.obj"), ODD).unwrap();
    let path = folder.path().join("room.toml");
    fs::write(&path, scene).unwrap();
    let path = name(&path).to_owned();
    (folder, path)
}

#[test]
fn defects_are_named_and_strictness_decides_the_exit_code() {
    let (_folder, path) = folder(ROOM);
    let (code, diagnosis) = findings(&[&path]);
    assert_eq!(code, 0, "{diagnosis:#}");
    assert_eq!(diagnosis["severity"], "warning");
    for (check, line) in [
        ("repairs", "odd.obj: dropped triangles without area: 1"),
        ("duplicates", "note: 1 triangle where others are, alike: odd.obj triangle 5"),
        ("light places", "warning: point_light 1 is inside `wall`"),
        ("winding", "warning: 1 surface of glass wound inward: odd.obj triangle 1"),
    ] {
        let lines = of(&diagnosis, check);
        assert!(lines.iter().any(|found| found.contains(line)), "{check}: {lines:?}");
    }
    assert_eq!(doctor(&[&path, "--strict"]).0, 1);
    let (_, text) = doctor(&[&path]);
    assert!(text.contains("\nwarning  winding"), "{text}");
    assert!(text.trim_end().lines().last().unwrap().contains("room.toml: doubtful; "), "{text}");
    assert!(text.lines().all(|line| line.contains("room.toml") || line.chars().count() <= 100), "{text}");
}

#[test]
fn faults_are_code_1_and_scenes_that_do_not_load_code_2() {
    let (_folder, dark) = folder(&ROOM.replace("intensity = [1, 1, 1]", "intensity = [0, 0, 0]"));
    let (code, diagnosis) = findings(&[&dark]);
    assert_eq!((code, of(&diagnosis, "lights")), (1, vec!["fault: nothing shines".into()]));
    let (_folder, wrong) = folder(&ROOM.replace("radius = 0.05", "radius = nan"));
    let (code, diagnosis) = findings(&[&wrong]);
    assert_eq!((code, diagnosis["severity"].as_str()), (2, Some("fault")));
    assert!(of(&diagnosis, "loading").concat().contains("room.toml:8:10"), "{diagnosis:#}");
    let (code, text) = doctor(&["no_such.toml"]);
    assert!(code == 2 && text.contains("fault") && text.contains("no_such.toml: cannot be read"), "{text}");
}

#[test]
fn options_of_the_render_count() {
    let scene = data("course_diffuse.toml");
    let radius = |arguments: &[&str]| {
        let (_, diagnosis) = findings(&[&[name(&scene)], arguments].concat());
        of(&diagnosis, "radius").concat()
    };
    assert!(radius(&["--radius", "200"]).starts_with("warning: 200.0, as asked for"));
    let [coarse, fine] = ["128x128", "1024x1024"].map(|size| radius(&["--size", size]));
    assert!(
        coarse.starts_with("fine: 0.5000, as asked for: 0.3") && fine.contains(": 2."),
        "{coarse} {fine}"
    );
    let by = |traversal| radius(&["--traversal", traversal, "--radius", "1"]);
    assert_eq!(by("custom")[..40], by("embree")[..40]);
}

#[test]
fn wrong_arguments_are_refused() {
    assert_eq!(doctor(&["--radius", "1"]).0, 2, "a radius without a scene");
    assert_eq!(doctor(&["scene.toml", "--radius", "-1"]).0, 2);
}
