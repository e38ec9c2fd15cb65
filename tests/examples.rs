//! The programs of `examples/`, which cargo builds along with the tests: they run, and do what their pages say.

#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use caustica::math::Rgb;
use caustica::output::{read_exr, read_png};

const ROOM: &str = "[film]\nwidth = 24\nheight = 16\n[camera]\nposition = [0, 1, 3]\nlook_at = [0, 0.5, 0]\nfov = 50\n\
    [render]\npasses = 3\nphotons = 4000\nsamples = 1\n\
    [material.grey]\ndiffuse = { albedo = [0.5, 0.5, 0.5] }\n\
    [[quad]]\ncorners = [[-2, 0, -2], [-2, 0, 2], [2, 0, 2], [2, 0, -2]]\nmaterial = \"grey\"\n\
    [[quad]]\ncorners = [[-2, 0, -2], [2, 0, -2], [2, 2, -2], [-2, 2, -2]]\nmaterial = \"grey\"\n\
    [[point_light]]\nposition = [0, 1.5, 0]\nintensity = [5, 5, 5]\n";

/// Examples lie beside the folder of this test's own program.
fn example(name: &str) -> PathBuf {
    let tests = std::env::current_exe().unwrap();
    tests.parent().unwrap().parent().unwrap().join("examples").join(name)
}

fn run(name: &str, arguments: &[&Path]) -> Output {
    let done = Command::new(example(name)).args(arguments).output();
    done.expect("examples are built by `cargo test` of everything, and by `cargo build --examples`")
}

fn room(folder: &Path) -> PathBuf {
    let path = folder.join("room.toml");
    std::fs::write(&path, ROOM).unwrap();
    path
}

#[test]
fn ten_lines_make_a_picture() {
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join("room.exr");
    let done = run("picture", &[&room(folder.path()), &picture]);
    assert!(done.status.success(), "{done:?}");
    let image = read_exr(&picture).unwrap();
    assert_eq!((image.width(), image.height()), (24, 16));
    assert!(image.pixels().iter().all(|p| p.is_finite()) && image.pixels().iter().any(|p| *p != Rgb::ZERO));
}

#[test]
fn a_watched_render_tells_of_every_pass_and_stops_at_its_target() {
    let folder = tempfile::tempdir().unwrap();
    let done = run("watch", &[&room(folder.path()), Path::new("1")]);
    assert!(done.status.success(), "{done:?}");
    let text = String::from_utf8(done.stdout).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert!(lines[0].ends_with("hit points"), "{text}");
    let passes = lines.len() - 1;
    assert!((2..1000).contains(&passes), "{passes} passes");
    assert!(
        lines.iter().skip(1).zip(1..).all(|(line, pass)| line.starts_with(&format!("pass {pass}: "))),
        "{text}"
    );
    let last: f64 = lines[passes].rsplit(' ').nth(1).unwrap().parse().unwrap();
    assert!(last <= 1.0, "{text}");
}

#[test]
fn a_scene_in_code_shows_a_caustic() {
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join("ball.png");
    let done = run("scene_in_code", &[&picture]);
    assert!(done.status.success(), "{done:?}");
    let image = read_png(&picture).unwrap();
    let mean = |p: &Rgb| p.element_sum() / 3.0;
    let mut light: Vec<f32> = image.pixels().iter().map(mean).collect();
    light.sort_by(f32::total_cmp);
    let (median, brightest) = (light[light.len() / 2], light[light.len() - 1 - light.len() / 500]);
    assert!(median > 0.0 && brightest > 2.0 * median, "median {median}, brightest 500th {brightest}");
}

#[test]
fn a_wrong_call_is_told_what_would_be_right() {
    for name in ["picture", "watch", "scene_in_code"] {
        let done = run(name, &[]);
        assert!(!done.status.success());
        assert!(String::from_utf8_lossy(&done.stderr).contains(&format!("usage: {name} ")), "{done:?}");
    }
}
