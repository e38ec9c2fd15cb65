//! Spots, light from afar, shining balls and skies: three estimators that join light and eye at different places must agree.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a panic is how a test fails")]

mod common;

use std::sync::Arc;

use caustica::bsdf::{Bsdf, Ggx, Interface, RoughSurface};
use caustica::film::Image;
use caustica::light::{Panorama, Spot};
use caustica::math::{Rgb, Vec3};
use caustica::ppm::Render;
use caustica::scene::{LightDesc, Material, Scene, SceneDesc, SphereDesc};
use common::agree::{BLOCK, assert_agree, in_blocks, photon_mapped};
use common::{blocks_seen_diffuse, desc, light_traced, path_traced, settings};

/// The course's box without its light and its ceiling, so that light from outside comes in, with a ball of this material.
fn open_box(ball: Bsdf, light: LightDesc) -> SceneDesc {
    let mut desc = desc("course_balls.toml");
    desc.point_lights.clear();
    desc.meshes.retain(|mesh| mesh.vertices.iter().any(|v| v.y < 100.0));
    desc.materials.push(Material::plain("ball", ball, Rgb::ZERO));
    desc.spheres.truncate(1);
    desc.spheres[0].material = desc.materials.len() as u32 - 1;
    desc.further_lights = vec![light];
    (desc.film.width, desc.film.height) = (48, 48);
    desc.without_places()
}

fn rough_metal() -> Bsdf {
    let interface = Interface::Conductor { eta: Rgb::splat(0.5), k: Rgb::splat(3.0), reflectance: Rgb::ONE };
    Bsdf::Rough(RoughSurface { facets: Ggx { alpha: 0.3 }, interface })
}

fn spot() -> LightDesc {
    let axis = Vec3::new(0.2, -1.0, 0.1).normalize();
    let position = Vec3::new(0.0, 100.0, 20.0);
    LightDesc::Spot(Spot { position, axis, intensity: Rgb::splat(9000.0), inner: 0.2, outer: 0.7 })
}

fn sun() -> LightDesc {
    LightDesc::Distant { direction: Vec3::new(0.3, -0.9, -0.2).normalize(), irradiance: Rgb::splat(2.0) }
}

/// A dim sky with a bright patch.
fn panorama() -> LightDesc {
    let mut pixels = vec![Rgb::new(0.1, 0.2, 0.3); 32 * 16];
    (3..5).for_each(|y| pixels[y * 32 + 18..y * 32 + 22].fill(Rgb::new(20.0, 18.0, 15.0)));
    let picture = Image::from_pixels(32, 16, pixels).unwrap();
    LightDesc::Panorama { file: "sky".into(), panorama: Arc::new(Panorama::new(picture, 1.0, 0.5).unwrap()) }
}

fn assert_photons_agree(desc: SceneDesc) {
    let scene = Scene::new(desc).unwrap();
    assert_agree(&photon_mapped(&scene), &in_blocks(&path_traced(&scene, 400)), 1, 0.03, None);
}

fn assert_both_ends_agree(desc: SceneDesc) {
    let scene = Scene::new(desc).unwrap();
    let mask = blocks_seen_diffuse(&scene, BLOCK);
    assert_agree(&light_traced(&scene, 3000), &path_traced(&scene, 400), BLOCK, 0.0, Some(&mask));
}

#[test]
fn a_spot_shines_the_same_from_both_ends() {
    assert_photons_agree(open_box(rough_metal(), spot()));
    assert_both_ends_agree(open_box(rough_metal(), spot()));
}

#[test]
fn light_from_afar_comes_in_the_same_from_both_ends() {
    assert_photons_agree(open_box(rough_metal(), sun()));
    assert_both_ends_agree(open_box(rough_metal(), sun()));
}

#[test]
fn a_sky_shines_the_same_from_both_ends() {
    let sky = LightDesc::Sky(Rgb::new(0.5, 0.7, 0.9));
    assert_photons_agree(open_box(Bsdf::Dielectric { ior: 1.5 }, sky));
}

#[test]
fn a_picture_of_a_sky_shines_the_same_from_both_ends() {
    assert_photons_agree(open_box(rough_metal(), panorama()));
    assert_both_ends_agree(open_box(rough_metal(), panorama()));
}

/// A ball that shines near one of rough metal, which finds it by facets and by shadow rays.
#[test]
fn a_ball_shines_the_same_from_both_ends() {
    let mut desc = open_box(rough_metal(), spot());
    desc.further_lights.clear();
    let black = Bsdf::Diffuse { albedo: Rgb::ZERO };
    desc.materials.push(Material::plain("lamp", black, Rgb::splat(20.0)));
    let material = desc.materials.len() as u32 - 1;
    desc.spheres.push(SphereDesc { center: Vec3::new(-20.0, 70.0, 10.0), radius: 8.0, material });
    desc.spheres.push(SphereDesc { center: Vec3::new(10.0, 8.0, 50.0), radius: 6.0, material });
    assert_photons_agree(desc.clone());
    assert_both_ends_agree(desc);
}

/// What nothing stands before shows the sky itself, and no photon is needed for that.
#[test]
fn an_empty_scene_shows_its_sky() {
    let mut desc = open_box(rough_metal(), LightDesc::Sky(Rgb::new(0.5, 0.7, 0.9)));
    (desc.meshes, desc.spheres) = (vec![], vec![]);
    let scene = Scene::new(desc).unwrap();
    let render = Render::new(&scene, settings(&scene));
    assert!(!render.plan().photons);
    let shown =
        render.picture().pixels().iter().all(|pixel| (*pixel - Rgb::new(0.5, 0.7, 0.9)).length() < 1e-6);
    assert!(shown);
}
