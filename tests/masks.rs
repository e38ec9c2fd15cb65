//! Masks: surfaces that let a share of the light go straight on as if nothing were there.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a panic is how a test fails")]

mod common;

use std::sync::Arc;

use caustica::bsdf::Bsdf;
use caustica::film::Image;
use caustica::math::{Rgb, Vec3};
use caustica::ppm::{Aiming, Render, Settings};
use caustica::reference::share_seen_specular;
use caustica::scene::{FilmDesc, Material, Mesh, PointLightDesc, Scene, SceneDesc};
use caustica::texture::Texture;
use common::agree::{BLOCK, assert_agree, in_blocks, photon_mapped};
use common::sheets::{
    BLACK, INTENSITY, LIGHT_HEIGHT, assert_close, over_floor, photon_irradiance, sheet, under_lamp,
};
use common::{blocks_seen_diffuse, desc, light_traced, path_traced, settings};

const WHITE: Bsdf = Bsdf::Diffuse { albedo: Rgb::ONE };

fn mask(bsdf: Bsdf, opacity: f32) -> Material {
    Material { opacity, ..Material::plain("mask", bsdf, Rgb::ZERO) }
}

/// A black sheet in the way takes the share `opacity` of a point light's irradiance `I / H²`; photons bring all that is left,
/// be they aimed at the sheet or not.
#[test]
fn a_mask_lets_the_rest_of_the_light_through() {
    for opacity in [0.3, 0.0] {
        let scene =
            Scene::new(over_floor(vec![mask(BLACK, opacity)], vec![sheet(5.0, 200.0, true, 1)])).unwrap();
        let expected = (1.0 - f64::from(opacity)) * f64::from(INTENSITY) / (LIGHT_HEIGHT * LIGHT_HEIGHT);
        for caustic_photons in [Aiming::Photons(0), Aiming::Photons(200_000)] {
            let settings = Settings { caustic_photons, ..settings(&scene) };
            let found = photon_irradiance(&scene, settings, 8);
            assert_close(found.x, expected, 0.02);
        }
    }
}

fn mean(image: &Image) -> f64 {
    image.pixels().iter().map(|p| f64::from(p.x)).sum::<f64>() / image.pixels().len() as f64
}

fn ppm(scene: &Scene, passes: u32) -> f64 {
    let mut render = Render::new(scene, settings(scene));
    (0..passes).for_each(|_| assert!(render.pass().photons.is_balanced()));
    mean(&render.picture())
}

/// Under a lamp paths find it, too.
#[test]
fn photons_and_paths_darken_the_floor_by_the_opacity() {
    let lit =
        |masks: Vec<Mesh>| Scene::new(under_lamp(over_floor(vec![mask(BLACK, 0.3)], masks), 4.0)).unwrap();
    let (bare, masked) = (lit(vec![]), lit(vec![sheet(5.0, 200.0, false, 1)]));
    let traced = |scene: &Scene| mean(&path_traced(scene, 4000).0);
    let clear = traced(&bare);
    assert_close(traced(&masked), 0.7 * clear, 0.02);
    assert_close(ppm(&masked, 20), 0.7 * clear, 0.02);
}

/// Shadow rays take masks for opaque, so paths from the camera find nothing of a point light behind one; those from the light do.
#[test]
fn only_paths_from_a_point_light_pass_a_mask() {
    let lit = |masks: Vec<Mesh>| Scene::new(over_floor(vec![mask(BLACK, 0.3)], masks)).unwrap();
    let (bare, masked) = (lit(vec![]), lit(vec![sheet(5.0, 200.0, true, 1)]));
    assert!(mean(&path_traced(&masked, 16).0) == 0.0);
    let clear = mean(&path_traced(&bare, 16).0);
    assert_close(mean(&light_traced(&masked, 20_000).0), 0.7 * clear, 0.25);
}

/// A glowing room of albedo 1/2 with a white, half opaque sheet across: it loses nothing, so radiance is `E / (1 - ρ)` everywhere.
#[test]
fn a_white_mask_vanishes_in_a_furnace() {
    let mut desc = over_floor(vec![mask(WHITE, 0.5)], vec![]);
    desc.materials[0] = Material::plain("wall", Bsdf::Diffuse { albedo: Rgb::splat(0.5) }, Rgb::ONE);
    desc.meshes = vec![Mesh::inward_cube("room", 0), sheet(0.0, 0.7, true, 1)];
    desc.point_lights.clear();
    desc.camera =
        caustica::scene::CameraDesc::pinhole(Vec3::new(0.3, 0.9, 0.2), Vec3::new(0.0, -1.0, 0.0), 30.0);
    (desc.render.photons, desc.render.radius) = (25_000, Some(0.05));
    let scene = Scene::new(desc).unwrap();
    assert_close(mean(&path_traced(&scene, 1000).0), 2.0, 0.01);
    assert_close(ppm(&scene, 40), 2.0, 0.03);
}

/// What a mask emits does not depend on its opacity.
#[test]
fn a_mask_emits_as_if_it_were_opaque() {
    let shining = Material { emission: Rgb::splat(2.0), ..mask(BLACK, 0.25) };
    let mut desc = over_floor(vec![shining], vec![sheet(0.25, 20.0, true, 1)]);
    desc.point_lights.clear();
    let scene = Scene::new(desc).unwrap();
    assert_close(mean(&path_traced(&scene, 64).0), 2.0, 1e-3);
    assert_close(ppm(&scene, 1), 2.0, 1e-3);
}

/// Many masks behind one another: branches get faint, and one way is chosen by roulette. `0.5^20` of a lamp is left.
#[test]
fn faint_branches_go_on_by_roulette() {
    let masks = (1..=20).map(|k| sheet(0.5 + 0.01 * k as f32, 20.0, true, 1)).collect();
    let mut desc = over_floor(vec![mask(BLACK, 0.5)], masks);
    desc.materials.push(Material::plain("lamp", BLACK, Rgb::splat(1e6)));
    desc.meshes.push(sheet(0.2, 20.0, true, 2));
    desc.point_lights.clear();
    (desc.camera.position.y, desc.render.depth, desc.film) = (3.0, 64, FilmDesc::new(64, 64));
    desc.render.samples = 256;
    let scene = Scene::new(desc).unwrap();
    let eye = caustica::ppm::camera_pass::trace(&scene, &settings(&scene), 0);
    let found = eye.emitted.iter().map(|e| f64::from(e.x)).sum::<f64>() / eye.emitted.len() as f64;
    assert_close(found, 1e6 * 0.5f64.powi(20), 0.1);
    assert_eq!(eye.cut_weight, 0.0);
}

/// The course's box with a screen of squares cut out in front of its wall, under a lamp or a point light.
fn behind_a_screen() -> SceneDesc {
    let mut desc = desc("course_diffuse.toml");
    desc.spheres.clear();
    (desc.film.width, desc.film.height) = (48, 48);
    let checks = [1.0, 0.0, 0.25, 1.0].map(Rgb::splat).to_vec();
    let texture = Texture::new("checks", Image::from_pixels(2, 2, checks).unwrap()).unwrap();
    let grey = Bsdf::Diffuse { albedo: Rgb::new(0.7, 0.5, 0.3) };
    let mut screen = Material::plain("screen", grey, Rgb::ZERO);
    screen.textures.opacity = Some(Arc::new(texture));
    desc.materials.push(screen);
    let mut mesh = sheet(40.0, 35.0, true, desc.materials.len() as u32 - 1);
    mesh.uvs.as_mut().unwrap().iter_mut().for_each(|uv| *uv *= 2.0);
    desc.meshes.push(mesh);
    desc
}

#[test]
fn photons_find_what_paths_find_through_cut_outs() {
    let mut desc = behind_a_screen();
    desc.point_lights.clear();
    desc.materials.push(Material::plain("lamp", BLACK, Rgb::splat(6.0)));
    desc.meshes.push(sheet(110.0, 30.0, false, desc.materials.len() as u32 - 1));
    let scene = Scene::new(desc).unwrap();
    let paths = path_traced(&scene, 400);
    assert_agree(&photon_mapped(&scene), &in_blocks(&paths), 1, 0.03, None);
    let seen = blocks_seen_diffuse(&scene, BLOCK);
    assert_agree(&light_traced(&scene, 400), &paths, BLOCK, 0.0, Some(&seen));
    let share = share_seen_specular(&scene);
    assert!(share > 0.005, "{share}: what is seen through the screen is none of the light tracer's");
}

/// The shadow of cut-outs under a point light, which photons and light paths find.
#[test]
fn photons_find_what_light_paths_find_through_cut_outs() {
    let mut desc = behind_a_screen();
    desc.point_lights =
        vec![PointLightDesc { position: Vec3::new(10.0, 105.0, 0.0), intensity: Rgb::splat(6000.0) }];
    let scene = Scene::new(desc).unwrap();
    let seen = blocks_seen_diffuse(&scene, BLOCK);
    let blocks: Vec<bool> =
        seen.chunks(48 * BLOCK).flat_map(|rows| rows[..48].iter().step_by(BLOCK).copied()).collect();
    let photons = photon_mapped(&scene);
    assert_agree(&photons, &in_blocks(&light_traced(&scene, 600)), 1, 0.03, Some(&blocks));
}
