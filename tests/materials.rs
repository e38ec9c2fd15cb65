//! Metals, panes, rough surfaces and plastics: three estimators that join light and eye at different places must agree on them.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a panic is how a test fails")]

mod common;

use std::sync::Arc;

use caustica::bsdf::{Bsdf, Ggx, Interface, METALS, Plastic, RoughSurface};
use caustica::film::Image;
use caustica::math::{Ray, Rgb, Vec3};
use caustica::ppm::{Aiming, Guiding, Kinds, Settings};
use caustica::scene::{Material, Scene, SceneDesc};
use caustica::texture::Texture;
use common::agree::{BLOCK, assert_agree, in_blocks, photon_mapped, photon_mapped_by};
use common::{blocks_seen_diffuse, desc, light_traced, path_traced, settings, under_a_lamp};

fn rough(alpha: f32, interface: Interface) -> Bsdf {
    Bsdf::Rough(RoughSurface { facets: Ggx { alpha }, interface })
}

fn copper() -> Interface {
    let metal = METALS[3];
    Interface::Conductor { eta: metal.eta, k: metal.k, reflectance: Rgb::ONE }
}

fn gold() -> Bsdf {
    Bsdf::Conductor { eta: METALS[2].eta, k: METALS[2].k, reflectance: Rgb::ONE }
}

/// The course's box with two balls of these materials, the camera near them.
fn balls(first: Bsdf, second: Bsdf) -> SceneDesc {
    let mut desc = desc("course_balls.toml");
    desc.materials.push(Material::plain("first", first, Rgb::ZERO));
    desc.materials.push(Material::plain("second", second, Rgb::ZERO));
    let last = desc.materials.len() as u32 - 1;
    (desc.spheres[0].material, desc.spheres[1].material) = (last - 1, last);
    (desc.film.width, desc.film.height) = (48, 48);
    (desc.camera.position, desc.camera.look_at) = (Vec3::new(0.0, 50.0, 120.0), Vec3::new(0.0, 20.0, 0.0));
    desc
}

/// Paths from the eye against photons: facets, coats and panes on both, and the weights of lamps that facets find.
fn assert_photons_agree(desc: SceneDesc) {
    let scene = Scene::new(under_a_lamp(desc)).unwrap();
    assert_agree(&photon_mapped(&scene), &in_blocks(&path_traced(&scene, 400)), 1, 0.03, None);
}

#[test]
fn photons_find_rough_metal_and_ground_glass() {
    assert_photons_agree(balls(rough(0.3, copper()), rough(0.2, Interface::Dielectric { ior: 1.5 })));
}

#[test]
fn photons_find_smooth_metal_and_plastic() {
    assert_photons_agree(balls(gold(), Bsdf::Plastic(Plastic::new(Rgb::new(0.1, 0.3, 0.8), 1.5, true))));
}

#[test]
fn photons_find_panes_and_nearly_smooth_metal() {
    assert_photons_agree(balls(Bsdf::ThinDielectric { ior: 1.5 }, rough(0.05, copper())));
}

/// A point light over rough metal and plastic: what the eye sees of it facets can not find, shadow rays alone.
#[test]
fn photons_find_what_rough_metal_and_plastic_make_of_a_point_light() {
    let plastic = Bsdf::Plastic(Plastic::new(Rgb::new(0.8, 0.3, 0.1), 1.3, false));
    let scene = Scene::new(balls(rough(0.3, copper()), plastic)).unwrap();
    assert_agree(&photon_mapped(&scene), &in_blocks(&path_traced(&scene, 400)), 1, 0.03, None);
}

/// Light and sensor swapped: the same transport from both ends. Catches `f` that is no adjoint of itself, a coat that is passed
/// once too often, and radiance scaled where power is not.
#[test]
fn rough_surfaces_look_the_same_from_both_ends() {
    let scene =
        Scene::new(balls(rough(0.4, copper()), rough(0.3, Interface::Dielectric { ior: 1.5 }))).unwrap();
    let mask = blocks_seen_diffuse(&scene, BLOCK);
    assert_agree(&light_traced(&scene, 800), &path_traced(&scene, 400), BLOCK, 0.0, Some(&mask));
}

/// Checks of three colours on the floor, and bands of roughness on a ball of metal.
#[test]
fn photons_find_pictures_on_surfaces() {
    let mut desc = balls(rough(0.6, copper()), rough(0.2, Interface::Dielectric { ior: 1.5 }));
    let texture = |size: (usize, usize), pixels: Vec<Rgb>| {
        let image = Image::from_pixels(size.0, size.1, pixels).unwrap();
        Some(Arc::new(Texture::new("checks", image).unwrap()))
    };
    let floor = desc.meshes[0].materials[0] as usize;
    let colours = vec![Rgb::new(0.8, 0.1, 0.1), Rgb::new(0.1, 0.8, 0.1), Rgb::splat(0.5), Rgb::ZERO];
    desc.materials[floor].textures.color = texture((2, 2), colours);
    desc.materials[floor].bsdf = Bsdf::Diffuse { albedo: Rgb::new(0.8, 0.8, 0.5) };
    let metal = desc.spheres[0].material as usize;
    desc.materials[metal].textures.roughness = texture((1, 2), vec![Rgb::splat(0.6), Rgb::splat(0.1)]);
    assert_photons_agree(desc);
}

/// The quarters of a quad show the pixels of its picture, the first row at the corners 2 and 3.
#[test]
fn a_picture_lies_on_a_quad_as_its_corners_say() {
    let mut desc = balls(gold(), gold());
    let pixels: Vec<Rgb> = (0..4).map(|k| Rgb::splat(0.2 * k as f32)).collect();
    let image = Image::from_pixels(2, 2, pixels).unwrap();
    let floor = &desc.meshes[0];
    let corners = floor.vertices.clone();
    let material = floor.materials[0] as usize;
    desc.materials[material].textures.color = Some(Arc::new(Texture::new("four", image).unwrap()));
    desc.spheres.clear();
    let scene = Scene::new(desc).unwrap();
    // (corner, pixel): lower left, lower right, upper right, upper left.
    for (corner, pixel) in [(0, 2), (1, 3), (2, 1), (3, 0)] {
        let middle = 0.25 * corners.iter().sum::<Vec3>();
        let over = corners[corner].lerp(middle, 0.5) + 50.0 * Vec3::Y;
        let hit = scene.intersect(&Ray::new(over, Vec3::NEG_Y)).unwrap();
        assert!((scene.albedo(&hit).x - 0.2 * pixel as f32).abs() < 1e-3, "{corner}: {}", scene.albedo(&hit));
    }
}

/// A glass ball over a floor, under a point light. Its caustic lies across the diagonal: on a white half and a rough one.
fn caustic_on(rough_half: Bsdf) -> Scene {
    let mut desc = balls(Bsdf::Dielectric { ior: 1.5 }, gold());
    desc.meshes.truncate(1);
    desc.meshes[0].materials[0] = desc.materials.len() as u32;
    desc.materials.push(Material::plain("rough", rough_half, Rgb::ZERO));
    desc.spheres.truncate(1);
    (desc.spheres[0].center, desc.spheres[0].radius) = (Vec3::new(0.0, 25.0, 10.0), 15.0);
    desc.point_lights[0].position = Vec3::new(-40.0, 90.0, -10.0);
    (desc.camera.position, desc.camera.look_at) = (Vec3::new(0.0, 100.0, 110.0), Vec3::new(8.0, 0.0, 18.0));
    desc.camera.fov_degrees = 30.0;
    Scene::new(desc).unwrap()
}

/// Facets never find a point light and shadow rays do not pass glass, so photons alone bring its caustics to rough surfaces:
/// naturally, aimed and guided, and joined with those on diffuse walls.
#[test]
fn caustics_of_a_point_light_lie_on_rough_surfaces() {
    let scene = caustic_on(rough(0.5, copper()));
    let expected = in_blocks(&light_traced(&scene, 1000));
    let pixels = blocks_seen_diffuse(&scene, BLOCK);
    let blocks = |k: usize| pixels[(k / 6 * BLOCK) * 48 + k % 6 * BLOCK];
    let mask: Vec<bool> = (0..36).map(blocks).collect();
    let (caustic_photons, guiding, kinds) = (Aiming::Photons(0), Guiding::Off, Kinds::Together);
    let natural = Settings { caustic_photons, guiding, kinds, ..settings(&scene) };
    for settings in [
        Settings { caustic_photons: Aiming::Photons(30_000), ..natural },
        Settings { caustic_photons: Aiming::Photons(30_000), guiding: Guiding::On, ..natural },
        Settings { kinds: Kinds::Apart, ..natural },
    ] {
        assert_agree(&photon_mapped_by(&scene, settings), &expected, 1, 0.03, Some(&mask));
    }
}
