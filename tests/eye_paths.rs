//! Eye paths that are retraced in every pass: the same light as by fixed ones, and what only they can show.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a panic is how a test fails")]

mod common;

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use caustica::effects::{EyePaths, PathClass, PathClasses, Plan};
use caustica::film::Image;
use caustica::math::{DVec3, Rgb};
use caustica::ppm::{ErrorEstimates, Precision, RadiusPolicy, Render, Settings};
use caustica::scene::{PixelFilter, Scene, SceneDesc};
use common::{block_estimate, desc, desc_of, path_traced, photon_mapped, scene_at, settings};

fn with(settings: Settings, eye_paths: EyePaths, samples: u32) -> Settings {
    Settings { eye_paths: Some(eye_paths), samples, ..settings }
}

/// Mirrors, glass and diffuse walls in one room; every policy of radii and kind of statistics in turn.
#[test]
fn fixed_and_retraced_paths_find_the_same_light() {
    let scene = scene_at("cornell_b.toml", 32, 32);
    let ours = Settings { photons: 30_000, ..settings(&scene) };
    let mean_of = |settings: Settings| {
        let renders: Vec<Image> =
            (1..=4).map(|seed| photon_mapped(&scene, Settings { seed, ..settings }, 48)).collect();
        block_estimate(&renders, 8)
    };
    let (fixed, fixed_error) = mean_of(with(ours, EyePaths::Fixed, 36));
    for (policy, precision) in [
        (RadiusPolicy::HitPoint, Precision::Double),
        (RadiusPolicy::Shared, Precision::Single),
        (RadiusPolicy::Tested, Precision::Double),
    ] {
        let retraced = Settings { policy, precision, ..with(ours, EyePaths::Retraced, 2) };
        let (mean, error) = mean_of(retraced);
        for (k, (a, b)) in mean.pixels().iter().zip(fixed.pixels()).enumerate() {
            let doubt = 5.0 * error.pixels()[k].max_element().hypot(fixed_error.pixels()[k].max_element());
            let difference = (*a - *b).abs().max_element();
            assert!(difference < 0.03 * b.max_element() + doubt, "{policy}, block {k}: {a} for {b}");
            assert!(doubt < 0.4 * b.max_element(), "{policy}, block {k}: nothing is known to {doubt}");
        }
    }
}

/// A lamp that fills half of the view, out of focus.
fn lamp_edge(filter: PixelFilter, lens_radius: f32) -> SceneDesc {
    let text = "\
[film]
width = 16
height = 8
[camera]
position = [0, 0, 0]
look_at = [0, 0, -5]
fov = 53.13010235
[render]
samples = 1
photons = 10
[material.lamp]
diffuse = { albedo = [0, 0, 0] }
emission = [1, 1, 1]
[[quad]]
corners = [[0.03, -99, -2.5], [99, -99, -2.5], [99, 99, -2.5], [0.03, 99, -2.5]]
material = \"lamp\"
";
    let mut desc = desc_of(text);
    (desc.film.filter, desc.camera.lens_radius) = (filter, lens_radius);
    desc
}

fn rms(image: &Image, truth: &Image) -> f64 {
    let squares = |(a, b): (&Rgb, &Rgb)| f64::from((*a - *b).length_squared());
    let sum: f64 = image.pixels().iter().zip(truth.pixels()).map(squares).sum();
    (sum / image.pixels().len() as f64).sqrt()
}

/// At passes 1, 4, 16 ...
fn errors(scene: &Scene, settings: Settings, truth: &Image, count: u32) -> Vec<f64> {
    let mut render = Render::new(scene, settings);
    let until = |n: u32| {
        while render.passes() < n {
            render.pass();
        }
        rms(&render.picture(), truth)
    };
    (0..count).map(|k| 4u32.pow(k)).map(until).collect()
}

/// The noise of independent views falls with the root of their number.
#[test]
fn anti_aliasing_and_depth_of_field_converge_with_retraced_paths_alone() {
    for (filter, lens_radius) in
        [(PixelFilter::Box, 0.0), (PixelFilter::Gaussian, 0.0), (PixelFilter::Box, 0.5)]
    {
        let scene = Scene::new(lamp_edge(filter, lens_radius)).unwrap();
        assert_eq!(Plan::of(&scene, PathClasses::ALL).eye_paths, EyePaths::Retraced);
        let truth = path_traced(&scene, 20_000).0;
        let ours = settings(&scene);
        let fixed = errors(&scene, with(ours, EyePaths::Fixed, 1), &truth, 5);
        let retraced = errors(&scene, Settings { eye_paths: None, ..ours }, &truth, 5);
        assert!(fixed.iter().all(|error| *error == fixed[0]), "{filter}: {fixed:?}");
        assert_eq!(fixed[0], retraced[0], "the first pass is the same");
        assert!(retraced[4] < fixed[4] / 8.0, "{filter}, lens {lens_radius}: {retraced:?}");
        assert!(retraced[2] < retraced[0] / 2.0, "{filter}, lens {lens_radius}: {retraced:?}");
    }
}

/// Light by photons, too: a room of diffuse walls and lamps that is out of focus.
#[test]
fn depth_of_field_in_photon_light_tends_to_the_path_tracers() {
    let mut desc = desc("cornell_a.toml");
    (desc.film.width, desc.film.height, desc.film.filter) = (24, 24, PixelFilter::Tent);
    let distance = desc.camera.focus_distance;
    (desc.camera.lens_radius, desc.camera.focus_distance) = (0.06 * distance, 0.6 * distance);
    let scene = Scene::new(desc).unwrap();
    let truth = path_traced(&scene, 1500).0;
    let ours = Settings { photons: 20_000, ..settings(&scene) };
    let fixed = errors(&scene, with(ours, EyePaths::Fixed, 1), &truth, 4);
    let retraced = errors(&scene, with(ours, EyePaths::Retraced, 1), &truth, 4);
    assert!(retraced[3] < 0.6 * retraced[2] && retraced[2] < 0.6 * retraced[1], "{retraced:?}");
    assert!(fixed[3] > 0.8 * fixed[2], "{fixed:?}");
    assert!(retraced[3] < 0.5 * fixed[3], "{retraced:?} against {fixed:?}");
}

#[test]
fn points_of_a_pinhole_call_for_fixed_paths() {
    for (filter, lens_radius, called_for) in [
        (PixelFilter::Points, 0.0, EyePaths::Fixed),
        (PixelFilter::Points, 0.1, EyePaths::Retraced),
        (PixelFilter::Tent, 0.0, EyePaths::Retraced),
    ] {
        let scene = Scene::new(lamp_edge(filter, lens_radius)).unwrap();
        assert_eq!(Plan::of(&scene, PathClasses::ALL).eye_paths, called_for, "{filter}, lens {lens_radius}");
    }
}

/// Retraced paths differ from pass to pass, so the passes tell of their noise, too.
#[test]
fn the_noise_of_retraced_paths_is_known() {
    let scene = Scene::new(lamp_edge(PixelFilter::Box, 0.5)).unwrap();
    let truth = path_traced(&scene, 20_000).0;
    let error_estimates = ErrorEstimates::Pixels;
    let (mut squares, mut count) = (0.0f64, 0.0);
    for seed in 0..20 {
        let mut render = Render::new(&scene, Settings { seed, error_estimates, ..settings(&scene) });
        for _ in 0..200 {
            render.pass();
        }
        let (picture, errors) = (render.picture(), render.accuracy(0.9).unwrap().pixels().unwrap());
        for (k, error) in errors.iter().enumerate() {
            let wrong: DVec3 = (picture.pixels()[k] - truth.pixels()[k]).as_dvec3();
            if error.stderr.x > 0.01 {
                squares += (wrong.x / error.stderr.x).powi(2);
                count += 1.0;
            }
        }
    }
    assert!(count > 300.0, "{count} noisy pixels");
    let ratio = (squares / count).sqrt();
    assert!((0.8..1.3).contains(&ratio), "errors are {ratio} times their estimates");
}

#[test]
fn no_thread_changes_a_bit_of_retraced_paths() {
    let scene = scene_at("cornell_b.toml", 48, 40);
    let error_estimates = ErrorEstimates::Pixels;
    let settings =
        Settings { photons: 20_000, error_estimates, ..with(settings(&scene), EyePaths::Retraced, 2) };
    let rendered = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut render = Render::new(&scene, settings);
            (0..4).for_each(|_| drop(render.pass()));
            let states = [PathClass::Caustic, PathClass::Indirect].map(|class| render.states(class));
            (states, render.picture(), render.direct_picture())
        })
    };
    let one = rendered(1);
    assert_eq!(one.0[1].len(), 48 * 40, "pixels keep the statistics");
    assert!(one == rendered(7));
}

/// Renders through a lens, with layers and a picture of every pass.
fn run(folder: &Path, scene: &Path, name: &str, arguments: &[&str]) -> Vec<u8> {
    let output = folder.join(name).with_extension("exr");
    #[rustfmt::skip]
    Command::cargo_bin("caustica").unwrap()
        .arg("render").arg(scene).arg("-o").arg(&output).arg("--every-pass").arg(folder)
        .args(["--reproducible", "--layers", "--photons", "3000"])
        .args(arguments)
        .assert().success();
    fs::read(output).unwrap()
}

#[test]
fn a_resumed_render_through_a_lens_writes_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    let lens = "fov = 52\nlens_radius = 6\nfocus_distance = 120";
    fs::write(&scene, common::GLASS_AND_LAMPS.replace("fov = 52", lens)).unwrap();
    let whole = run(folder.path(), &scene, "whole", &["--passes", "5"]);
    let first = run(folder.path(), &scene, "parts", &["--passes", "2", "--resume"]);
    let both = run(folder.path(), &scene, "parts", &["--passes", "5", "--resume"]);
    assert!(first != whole && both == whole);
    let picture = |name: &str| caustica::output::read_exr(&folder.path().join(name)).unwrap();
    assert_eq!(picture("pass_0005.exr"), picture("whole.exr"));
    let other = ["--passes", "6", "--resume", "--eye-paths", "fixed"];
    let refused = Command::cargo_bin("caustica")
        .unwrap()
        .arg("render")
        .arg(&scene)
        .arg("-o")
        .arg(folder.path().join("parts.exr"))
        .args(["--reproducible", "--layers", "--photons", "3000"])
        .args(other)
        .assert()
        .failure();
    let told = String::from_utf8(refused.get_output().stderr.clone()).unwrap();
    assert!(
        told.contains("eye paths: the checkpoint has as the scene calls for, this render fixed"),
        "{told}"
    );
}
