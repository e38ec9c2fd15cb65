//! What pictures tell about the surfaces that are seen first.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a panic is how a test fails")]

mod common;

use std::fs;

use assert_cmd::Command;
use caustica::film::Image;
use caustica::math::{Rgb, Vec3};
use caustica::output::read_exr_layer;
use caustica::ppm::{Features, Render, Settings};
use common::scene_of;

/// The camera stands 3 above a red floor, which slopes as z = -y, and looks along -z: its depth is `3 / (1/1 + slope)`.
const SLOPE: &str = r#"
[film]
width = 20
height = 16
[camera]
position = [0, 3, 0]
look_at = [0, 3, -1]
fov = 60
[render]
samples = 9
[material.red]
diffuse = { albedo = [0.7, 0.2, 0.1] }
[[point_light]]
position = [0, 5, 0]
intensity = [3, 3, 3]
[[quad]]
corners = [[-900, 300, -300], [900, 300, -300], [900, -9, 9], [-900, -9, 9]]
material = "red"
"#;

/// A glass ball, a mirror and the lamp stand before nothing.
const BALLS: &str = r#"
[film]
width = 30
height = 10
[camera]
position = [0, 0, 10]
look_at = [0, 0, 0]
fov = 60
[render]
samples = 4
[material.glass]
dielectric = { ior = 1.5 }
[material.mirror]
mirror = { reflectance = [0.9, 0.8, 0.7] }
[material.water]
fixed_weight = { color = [0.5, 0.25, 1], reflectivity = 0.2, transparency = 0.6, ior = 1.33 }
[[point_light]]
position = [0, 5, 0]
intensity = [3, 3, 3]
[[sphere]]
center = [-3, 0, 0]
radius = 1
material = "glass"
[[sphere]]
center = [0, 0, 0]
radius = 1
material = "mirror"
[[sphere]]
center = [3, 0, 0]
radius = 1
material = "water"
"#;

fn features_of(text: &str, passes: u32) -> Features {
    let scene = scene_of(text);
    let settings = Settings { photons: 100, ..Settings::of_scene(scene.render()) };
    let mut render = Render::new(&scene, settings);
    (0..passes).for_each(|_| drop(render.pass()));
    render.features()
}

fn near(found: Rgb, expected: Rgb, tolerance: f32) {
    assert!((found - expected).abs().max_element() < tolerance, "{found} instead of {expected}");
}

/// A ray `(x, s, -1)` from `(0, 3, 0)` meets `y = -z` at the depth `3 / (1 - s)`; within a pixel that is nearly linear.
#[test]
fn a_plane_has_the_depth_and_the_normal_of_its_closed_form() {
    let Features { albedo, normal, depth } = features_of(SLOPE, 0);
    let half_height = 30f32.to_radians().tan() * 16.0 / 20.0;
    for (x, y) in [(0, 0), (10, 3), (19, 8), (4, 15)] {
        let slope = half_height * (1.0 - 2.0 * (y as f32 + 0.5) / 16.0);
        near(depth.get(x, y), Rgb::splat(3.0 / (1.0 - slope)), 0.03);
        near(normal.get(x, y), Vec3::new(0.0, 0.5f32.sqrt(), 0.5f32.sqrt()), 1e-5);
        near(albedo.get(x, y), Rgb::new(0.7, 0.2, 0.1), 1e-6);
    }
}

#[test]
fn a_surface_seen_from_behind_has_its_normal_turned() {
    let reversed = "corners = [[-900, -9, 9], [900, -9, 9], [900, 300, -300], [-900, 300, -300]]";
    let line = SLOPE.lines().find(|line| line.starts_with("corners")).unwrap();
    let (front, behind) = (features_of(SLOPE, 0), features_of(&SLOPE.replace(line, reversed), 0));
    near(behind.normal.get(7, 7), front.normal.get(7, 7), 1e-5);
}

#[test]
fn mirrors_and_glass_count_for_themselves_and_nothing_is_infinitely_far() {
    let Features { albedo, normal, depth } = features_of(BALLS, 0);
    let (left, middle, right) = ((7, 5), (15, 5), (22, 5));
    near(albedo.get(left.0, left.1), Rgb::ONE, 1e-5);
    near(albedo.get(middle.0, middle.1), Rgb::new(0.9, 0.8, 0.7), 1e-5);
    near(albedo.get(right.0, right.1), Rgb::new(0.9, 0.85, 1.0), 1e-5);
    near(depth.get(middle.0, middle.1), Rgb::splat(9.05), 0.06);
    assert!(normal.get(middle.0, middle.1).z > 0.9);
    assert_eq!((albedo.get(0, 0), normal.get(0, 0)), (Rgb::ZERO, Rgb::ZERO));
    assert_eq!(depth.get(0, 0), Rgb::INFINITY);
}

/// The glass is seen by some samples of a pixel on its edge: the others do not pull its depth anywhere.
#[test]
fn depth_on_an_edge_is_that_of_what_is_met() {
    let Features { albedo, depth, .. } = features_of(BALLS, 0);
    let edges = (0..300).filter(|&k| albedo.pixels()[k].x > 0.0 && albedo.pixels()[k].x < 0.65);
    let edges: Vec<f32> = edges.map(|k| depth.pixels()[k].x).collect();
    assert!(edges.len() > 5, "{} edges", edges.len());
    assert!(edges.iter().all(|depth| (8.9..10.1).contains(depth)), "{edges:?}");
}

/// Where every pass has other eye paths, the first of them are averaged.
#[test]
fn retraced_paths_add_samples_pass_by_pass() {
    let filtered = BALLS.replace("height = 10", "height = 10\nfilter = \"gaussian\"");
    let scene = scene_of(&filtered);
    let settings = Settings { photons: 100, samples: 1, ..Settings::of_scene(scene.render()) };
    let mut render = Render::new(&scene, settings);
    let levels = |image: &Image| {
        let mut values: Vec<u32> = image.pixels().iter().map(|pixel| pixel.z.to_bits()).collect();
        values.sort_unstable();
        values.dedup();
        values.len()
    };
    let one = levels(&render.features().albedo);
    (0..16).for_each(|_| drop(render.pass()));
    let many = levels(&render.features().albedo);
    assert!(one <= 6 && many > 12, "{one}, then {many}");
}

#[test]
fn no_thread_changes_a_bit() {
    let scene = scene_of(BALLS);
    let settings = Settings { photons: 100, samples: 3, ..Settings::of_scene(scene.render()) };
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| Render::new(&scene, settings).features())
    };
    assert!(with(1) == with(5));
}

#[test]
fn the_program_writes_them_under_the_names_of_the_field() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, picture) = (folder.path().join("slope.toml"), folder.path().join("slope.exr"));
    fs::write(&scene, SLOPE).unwrap();
    let render = |more: &[&str]| {
        let mut command = Command::cargo_bin("caustica").unwrap();
        command.arg("render").arg(&scene).arg("-o").arg(&picture).args(["--passes", "1"]).args(more);
        command.assert().success();
    };
    render(&["--features"]);
    let features = features_of(SLOPE, 0);
    assert_eq!(read_exr_layer(&picture, "albedo").unwrap(), features.albedo);
    assert_eq!(read_exr_layer(&picture, "N").unwrap(), features.normal);
    assert_eq!(read_exr_layer(&picture, "Z").unwrap(), features.depth);
    render(&[]);
    assert!(read_exr_layer(&picture, "Z").unwrap_err().to_string().ends_with("it has none"));
}
