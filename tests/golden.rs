//! Golden pictures as statistics: block means of the scenes that nothing else can check as a whole.
//!
//! Shadow rays take water for opaque and the light is a point, so no path tracer knows the caustics of the water scene.
//! The numbers come from `longer_render` below (forty times the photons); they may change only with a reason.
#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

mod common;

use caustica::compare::block_means;
use caustica::film::Image;
use caustica::math::mean;
use caustica::ppm::Settings;
use common::{photon_mapped, scene_at, settings};

const SIZE: u32 = 64;
const BLOCK: usize = 16;

/// Mean over the channels of every block of the water scene, row by row.
const WATER: [f32; 16] = [
    0.1936, 0.7682, 0.7621, 0.2036, 0.1919, 0.4419, 0.4414, 0.1916, 0.1063, 0.2293, 0.2398, 0.1061, 0.1454,
    0.2170, 0.1423, 0.1308,
];

fn blocks(photons: u64, seed: u64) -> Vec<f32> {
    let scene = scene_at("course_water.toml", SIZE, SIZE);
    let settings = Settings { photons, seed, samples: 16, ..settings(&scene) };
    let image: Image = block_means(&photon_mapped(&scene, settings, 10), BLOCK);
    image.pixels().iter().map(|p| mean(*p)).collect()
}

/// Catches whatever changes the light under water: the first-bounce rule, refraction, fixed weights, the surface.
#[test]
fn water_scene_keeps_its_light() {
    let found = blocks(200_000, 1);
    for (block, (found, golden)) in found.iter().zip(WATER).enumerate() {
        assert!((found / golden - 1.0).abs() < 0.04, "block {block}: {found} instead of {golden}");
    }
}

#[test]
#[ignore = "prints the golden numbers anew"]
fn longer_render() {
    println!("{:?}", blocks(8_000_000, 0));
}
