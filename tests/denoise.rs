//! Denoised pictures: `OIDN_DIR=.. cargo test --features oidn --test denoise`.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a panic is how a test fails")]
#![cfg(feature = "oidn")]

use std::fs;

use assert_cmd::Command;
use caustica::compare::Metrics;
use caustica::denoise::Denoiser;
use caustica::film::Image;
use caustica::math::{Rgb, Rng, Stream};
use caustica::output::read_exr;

mod common;

fn error(image: &Image, truth: &Image) -> f64 {
    Metrics::between(image, truth).unwrap().rel_mse
}

/// Grey light under noise of half its size, in which no two pixels have to do with each other.
#[test]
fn noise_goes_and_light_stays() {
    let image = |of: &mut dyn FnMut() -> Rgb| {
        Image::from_pixels(128, 96, (0..128 * 96).map(|_| of()).collect()).unwrap()
    };
    let mut rng = Rng::new(5, Stream::Test, 0, 0);
    let noisy = image(&mut || Rgb::new(rng.next_f32(), rng.next_f32(), rng.next_f32()) + 0.5);
    let (flat, albedo, normal) = (Rgb::ONE, Rgb::splat(0.5), Rgb::Z);
    let [flat, albedo, normal] = [flat, albedo, normal].map(|value| image(&mut || value));
    let denoised = Denoiser::new().unwrap().denoise(&noisy, &albedo, &normal).unwrap();
    let (before, after) = (error(&noisy, &flat), error(&denoised, &flat));
    assert!(after < 0.02 * before, "relMSE {before} became {after}");
    assert!(
        after > 0.0
            && denoised.pixels()
                == Denoiser::new().unwrap().denoise(&noisy, &albedo, &normal).unwrap().pixels()
    );
}

#[test]
fn other_sizes_are_refused() {
    let denoiser = Denoiser::new().unwrap();
    let told = denoiser.denoise(&Image::new(8, 8), &Image::new(4, 8), &Image::new(8, 8));
    assert!(told.unwrap_err().to_string().starts_with("Open Image Denoise fails: "));
}

#[test]
fn the_program_writes_another_picture_beside_the_true_one() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    let render = |name: &str, more: &[&str]| {
        let output = folder.path().join(name);
        let size = ["--size", "128x104", "--samples", "4", "--eye-seed", "1", "--reproducible"];
        fs::write(&scene, common::GLASS_AND_LAMPS).unwrap();
        let mut command = Command::cargo_bin("caustica").unwrap();
        command.arg("render").arg(&scene).arg("-o").arg(&output).args(size).args(more).assert().success();
        read_exr(&output).unwrap()
    };
    let truth = render("truth.exr", &["--passes", "60", "--photons", "200000"]);
    let few = ["--passes", "2", "--photons", "5000", "--seed", "7"];
    let raw = render("raw.exr", &few);
    assert_eq!(render("asked.exr", &[&few[..], &["--denoise"]].concat()), raw, "the picture itself stays");
    let denoised = read_exr(&folder.path().join("asked_denoised.exr")).unwrap();
    assert!(folder.path().join("asked_denoised.png").exists());
    let (before, after) = (error(&raw, &truth), error(&denoised, &truth));
    eprintln!("relMSE {before:.4} became {after:.4}");
    assert!(after < before && denoised != raw);
}
