//! The rules that photon mappers get wrong, each against a closed form or a count that is known.
#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

mod common;

use std::f64::consts::PI;

use caustica::bsdf::{Bsdf, DiffuseSampling};
use caustica::math::Rgb;
use caustica::ppm::{PhotonBatch, PhotonPass, Settings};
use caustica::scene::{Material, Mesh, Scene};
use common::settings;
use common::sheets::{
    INTENSITY, LIGHT_HEIGHT, NEARLY_BLACK, assert_close, over_floor, photon_irradiance, sheet,
};

const GREY: Bsdf = Bsdf::Diffuse { albedo: Rgb::splat(0.5) };

/// The photons of the first pass.
fn traced(scene: &Scene, settings: &Settings) -> PhotonBatch {
    PhotonPass::default().trace(scene, settings, 0).clone()
}

/// Under a point light, with another sheet of another material.
fn lit_floor(floor: Bsdf, other: Mesh, bsdf: Bsdf) -> Scene {
    let mut desc = over_floor(vec![Material::plain("other", bsdf, Rgb::ZERO)], vec![other]);
    desc.materials[0].bsdf = floor;
    desc.render.photons = 2_000_000;
    Scene::new(desc).unwrap()
}

fn far_away() -> Mesh {
    sheet(-1e4, 1.0, true, 0)
}

/// Of a render by the scene's settings.
fn irradiance(scene: &Scene, passes: u32) -> f64 {
    photon_irradiance(scene, settings(scene), passes).x
}

/// Light straight from the source is brought by shadow rays; its photons must not be stored as well.
#[test]
fn direct_light_is_not_stored() {
    let scene = lit_floor(GREY, far_away(), GREY);
    let batch = traced(&scene, &settings(&scene));
    assert_eq!(batch.ledger.deposited, 0);
    assert!(batch.ledger.absorbed > 0 && batch.ledger.escaped > 0);
    assert_eq!(batch.ledger.emitted, 2_000_000, "photons that hit nothing count as emitted");
}

/// A mirror overhead: the floor sees a second light behind it, `E = R I / d²`. Skipping the first surface
/// whatever it is, or counting only photons that hit something, fails here.
#[test]
fn mirrored_light_has_the_irradiance_of_its_image() {
    let mirror = Bsdf::Mirror { reflectance: Rgb::splat(0.8) };
    let scene = lit_floor(NEARLY_BLACK, sheet(12.0, 200.0, false, 1), mirror);
    let image_height = 2.0 * 12.0 - LIGHT_HEIGHT;
    let expected = 0.8 * f64::from(INTENSITY) / (image_height * image_height);
    assert_close(irradiance(&scene, 10), expected, 0.02);
}

/// Light through a flat sheet of water at height h above the floor: right below the light it seems to come from
/// `H - h + h / n` above, `E = T I / (H - h + h / n)²`. Water is opaque to shadow rays, so photons bring it all.
#[test]
fn refracted_light_has_the_irradiance_of_its_apparent_height() {
    let (h, n) = (4.0, 1.33);
    let water = Bsdf::FixedWeight { color: Rgb::ZERO, reflectivity: 0.0, transparency: 0.7, ior: n as f32 };
    let scene = lit_floor(NEARLY_BLACK, sheet(h as f32, 200.0, true, 1), water);
    let apparent = LIGHT_HEIGHT - h + h / n;
    let expected = 0.7 * f64::from(INTENSITY) / (apparent * apparent);
    assert_close(irradiance(&scene, 10), expected, 0.02);
}

/// Both samplings of the bounce carry the same power off a surface: the mean power of the second deposit.
#[test]
fn both_samplings_keep_the_energy_of_a_bounce() {
    let scene = lit_floor(GREY, sheet(20.0, 200.0, false, 1), GREY);
    let [cosine, uniform] = [DiffuseSampling::Cosine, DiffuseSampling::Uniform].map(|sampling| {
        let settings = Settings { sampling, photons: 400_000, ..settings(&scene) };
        let batch = traced(&scene, &settings);
        batch.photons().map(|p| f64::from(p.power.x)).sum::<f64>()
    });
    assert_close(uniform, cosine, 0.01);
    let flux = 4.0 * PI * f64::from(INTENSITY) * 400_000.0;
    assert!(cosine < 2.0 * flux, "with albedo .5 the floors store at most Σ .5^k of the flux");
}

/// Roulette by the largest linear channel keeps the colour of what survives: one bounce off red leaves red.
#[test]
fn colour_of_a_bounce_is_the_albedo() {
    let red = Bsdf::Diffuse { albedo: Rgb::new(0.8, 0.4, 0.1) };
    let scene = lit_floor(GREY, sheet(20.0, 200.0, false, 1), red);
    let batch = traced(&scene, &settings(&scene));
    let grey_then_red = batch.photons().find(|p| (p.power.y / p.power.x - 0.5).abs() < 1e-5);
    assert!(grey_then_red.is_some_and(|p| (p.power.z / p.power.x - 0.125).abs() < 1e-5));
}
