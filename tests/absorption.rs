//! Bodies that absorb light on its way through them, by closed forms and by three estimators.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a panic is how a test fails")]

mod common;

use caustica::bsdf::{Bsdf, Ggx, Interface, RoughSurface};
use caustica::math::{DVec3, Rgb, Vec3};
use caustica::ppm::{Aiming, Render, Settings, camera_pass};
use caustica::scene::{Material, Mesh, Scene, SceneDesc, SphereDesc};
use common::agree::{BLOCK, assert_agree, in_blocks, photon_mapped};
use common::sheets::{BLACK, INTENSITY, LIGHT_HEIGHT, over_floor, photon_irradiance, sheet};
use common::{blocks_seen_diffuse, desc, light_traced, path_traced, settings};

const TINT: Rgb = Rgb::new(0.1, 0.4, 0.0);

fn glass(ior: f32, absorption: Rgb) -> Material {
    Material { absorption, ..Material::plain("glass", Bsdf::Dielectric { ior }, Rgb::ZERO) }
}

/// A closed box of glass from `low` to `high`, as wide as it is said.
fn slab([low, high]: [f32; 2], half: f32, material: u32) -> Mesh {
    let mut slab = Mesh::inward_cube("slab", material);
    let size = Vec3::new(half, 0.5 * (high - low), half);
    slab.vertices.iter_mut().for_each(|p| *p = *p * size + 0.5 * (low + high) * Vec3::Y);
    slab.triangles.iter_mut().for_each(|corners| corners.reverse());
    slab
}

/// What of a lamp of radiance 1 at y = 0.1 is seen from y = 9, straight down through these bodies: by the eye pass, and by paths.
fn seen_through(materials: Vec<Material>, meshes: Vec<Mesh>, spheres: Vec<SphereDesc>) -> [DVec3; 2] {
    let scene = Scene::new(over_a_lamp(materials, meshes, spheres)).unwrap();
    let eye = camera_pass::trace(&scene, &settings(&scene), 0);
    [mean(&eye.emitted), mean(path_traced(&scene, 1000).0.pixels())]
}

fn over_a_lamp(materials: Vec<Material>, meshes: Vec<Mesh>, spheres: Vec<SphereDesc>) -> SceneDesc {
    let mut desc = over_floor(materials, meshes);
    desc.point_lights.clear();
    desc.materials.push(Material::plain("lamp", BLACK, Rgb::ONE));
    desc.meshes.push(sheet(0.1, 20.0, true, desc.materials.len() as u32 - 1));
    (desc.spheres, desc.camera.position.y, desc.camera.fov_degrees) = (spheres, 9.0, 1.0);
    desc.render.depth = 32;
    desc
}

fn mean(pixels: &[Rgb]) -> DVec3 {
    pixels.iter().map(|pixel| pixel.as_dvec3()).sum::<DVec3>() / pixels.len() as f64
}

fn assert_colour(found: DVec3, expected: DVec3, tolerance: f64) {
    let error = (found - expected).abs().max_element();
    assert!(error <= tolerance * expected.max_element(), "{found} instead of {expected}");
}

fn left(absorption: Rgb, distance: f64) -> DVec3 {
    (-distance * absorption.as_dvec3()).map(f64::exp)
}

/// `exp(-σ d)`, where nothing is refracted.
#[test]
fn a_slab_takes_the_share_that_beer_and_lambert_say() {
    for found in seen_through(vec![glass(1.0, TINT)], vec![slab([2.0, 4.5], 30.0, 1)], vec![]) {
        assert_colour(found, left(TINT, 2.5), 1e-3);
    }
}

/// Light that goes to and fro in a slab: `T = (1 - R)² a / (1 - R² a²)`, `a = exp(-σ d)`, `R = ((n - 1) / (n + 1))²`.
#[test]
fn a_slab_of_glass_absorbs_what_goes_to_and_fro_in_it() {
    let (n, a) = (1.8f64, left(TINT, 2.5));
    let r = ((n - 1.0) / (n + 1.0)).powi(2);
    let expected = a.map(|a| (1.0 - r).powi(2) * a / (1.0 - r * r * a * a));
    let [eye, paths] = seen_through(vec![glass(n as f32, TINT)], vec![slab([2.0, 4.5], 30.0, 1)], vec![]);
    assert_colour(eye, expected, 1e-3);
    assert_colour(paths, expected, 0.01);
}

/// Bodies in a body: each absorbs where one is in it, and that around it absorbs again behind it. Clear ones do not absorb.
#[test]
fn the_innermost_body_absorbs() {
    let ball =
        |y: f32, radius: f32, material| SphereDesc { center: Vec3::new(0.0, y, 0.0), radius, material };
    let (water, dark) = (Rgb::splat(0.05), Rgb::new(0.0, 0.3, 0.6));
    let materials = vec![glass(1.0, water), glass(1.0, dark), glass(1.0, Rgb::ZERO)];
    // A dark ball with a bubble in it, and a clear ball, in water from 1 to 8.
    let spheres = vec![ball(3.0, 1.0, 2), ball(3.0, 0.5, 3), ball(6.0, 1.0, 3)];
    for found in seen_through(materials, vec![slab([1.0, 8.0], 30.0, 1)], spheres) {
        assert_colour(found, left(water, 3.0) * left(dark, 1.0), 1e-3);
    }
}

/// Photons lose on their way what the eye would, aimed or not, and the ledger books it.
#[test]
fn photons_are_absorbed_on_their_way() {
    let scene = Scene::new(over_floor(vec![glass(1.0, TINT)], vec![slab([4.0, 6.5], 200.0, 1)])).unwrap();
    let expected = f64::from(INTENSITY) / (LIGHT_HEIGHT * LIGHT_HEIGHT) * left(TINT, 2.5);
    for caustic_photons in [Aiming::Photons(0), Aiming::Photons(200_000)] {
        let settings = Settings { caustic_photons, ..settings(&scene) };
        assert_colour(photon_irradiance(&scene, settings, 8), expected, 0.02);
    }
}

/// A mask in the surface of a body is a hole in the surface, not in the body.
#[test]
fn holes_in_the_surface_of_a_body_lead_into_it() {
    let water = Material { opacity: 0.5, ..glass(1.0, TINT) };
    let scene = Scene::new(over_floor(vec![water.clone()], vec![slab([4.0, 6.5], 200.0, 1)])).unwrap();
    let expected = f64::from(INTENSITY) / (LIGHT_HEIGHT * LIGHT_HEIGHT) * left(TINT, 2.5);
    assert_colour(photon_irradiance(&scene, settings(&scene), 8), expected, 0.02);
    for found in seen_through(vec![water], vec![slab([2.0, 4.5], 30.0, 1)], vec![]) {
        assert_colour(found, left(TINT, 2.5), 1e-3);
    }
}

/// A lamp in a small body: only photons get out of it, and they lose what the way to its surface takes.
#[test]
fn a_light_in_a_body_shines_through_it() {
    let body = slab([LIGHT_HEIGHT as f32 - 2.0, LIGHT_HEIGHT as f32 + 2.0], 300.0, 1);
    let scene = Scene::new(over_floor(vec![glass(1.0, TINT)], vec![body])).unwrap();
    let expected = f64::from(INTENSITY) / (LIGHT_HEIGHT * LIGHT_HEIGHT) * left(TINT, 2.0);
    assert_colour(photon_irradiance(&scene, settings(&scene), 8), expected, 0.02);
}

/// Camera, light and floor in one body: shadow rays lose the way from the light, and what is seen that to the camera. `rough`: a floor
/// of rough metal in place of a diffuse one.
fn within_a_body(absorption: Rgb, rough: bool) -> [DVec3; 3] {
    let body = slab([-1.0, 20.0], 300.0, 1);
    let mut desc = over_floor(vec![glass(1.0, absorption)], vec![body]);
    desc.camera.fov_degrees = 2.0;
    (desc.render.photons, desc.render.radius) = (1000, Some(0.01));
    if rough {
        let interface = Interface::Conductor { eta: Rgb::ZERO, k: Rgb::ONE, reflectance: Rgb::ONE };
        desc.materials[0].bsdf = Bsdf::Rough(RoughSurface { facets: Ggx { alpha: 0.8 }, interface });
    }
    let scene = Scene::new(desc).unwrap();
    let mut render = Render::new(&scene, settings(&scene));
    (0..2).for_each(|_| assert!(render.pass().photons.is_balanced()));
    let [paths, light] = [path_traced(&scene, 2).0, light_traced(&scene, 200_000).0];
    [mean(render.picture().pixels()), mean(paths.pixels()), mean(light.pixels())]
}

#[test]
fn camera_and_light_in_a_body_are_dimmed_by_it() {
    let (clear, tinted) = (within_a_body(Rgb::ZERO, false), within_a_body(TINT, false));
    let expected = left(TINT, LIGHT_HEIGHT + 0.5);
    assert_colour(tinted[0] / clear[0], expected, 1e-3);
    assert_colour(tinted[1] / clear[1], expected, 1e-3);
    assert_colour(tinted[2] / clear[2], expected, 1e-2);
}

#[test]
fn rough_metal_in_a_body_is_lit_through_it() {
    let (clear, tinted) = (within_a_body(Rgb::ZERO, true), within_a_body(TINT, true));
    for (tinted, clear) in tinted.iter().zip(&clear).take(2) {
        assert_colour(*tinted / *clear, left(TINT, LIGHT_HEIGHT + 0.5), 0.01);
    }
}

/// Beneath an open sheet of water, and in and out of nested bodies.
#[test]
fn points_know_their_media() {
    let (water, dark) = (Rgb::splat(0.5), Rgb::splat(2.0));
    let mut desc = over_floor(vec![glass(1.33, water), glass(1.5, dark)], vec![sheet(4.0, 50.0, true, 1)]);
    desc.spheres.push(SphereDesc { center: Vec3::new(0.0, 2.0, 0.0), radius: 1.0, material: 2 });
    let scene = Scene::new(desc).unwrap();
    let at = |y: f32| -f64::from(scene.transmittance(scene.media_at(Vec3::new(0.0, y, 0.0)), 1.0).x).ln();
    for (y, expected) in [(0.5, 0.5), (2.0, 2.0), (3.5, 0.5), (4.5, 0.0)] {
        assert!((at(y) - expected).abs() < 1e-4, "{y}: {}", at(y));
    }
    assert_eq!(scene.camera_media(), scene.media_at(Vec3::new(0.0, 0.5, 0.0)));
    let clear =
        Scene::new(over_floor(vec![glass(1.33, Rgb::ZERO)], vec![sheet(4.0, 50.0, true, 1)])).unwrap();
    assert!(!clear.absorbs() && clear.media_at(Vec3::Y) == clear.media_at(100.0 * Vec3::Y));
}

/// A scene looks the same at any size.
#[test]
fn scaled_bodies_absorb_alike() {
    let picture = |scale: f32| {
        let mut desc = over_a_lamp(vec![glass(1.5, TINT)], vec![slab([2.0, 4.5], 30.0, 1)], vec![]);
        desc.place(scale, Vec3::ZERO);
        let scene = Scene::new(desc).unwrap();
        mean(&camera_pass::trace(&scene, &settings(&scene), 0).emitted)
    };
    assert_colour(picture(8.0), picture(1.0), 1e-5);
    assert_colour(picture(0.125), picture(1.0), 1e-5);
}

/// The course's box with balls of tinted glass, one of them hollow and rough, under a lamp.
#[test]
fn three_estimators_agree_on_tinted_glass() {
    let mut desc = desc("course_balls.toml");
    let rough = RoughSurface { facets: Ggx { alpha: 0.2 }, interface: Interface::Dielectric { ior: 1.5 } };
    desc.materials.push(glass(1.5, Rgb::new(0.002, 0.02, 0.05)));
    desc.materials.push(Material { bsdf: Bsdf::Rough(rough), ..glass(1.5, Rgb::new(0.05, 0.01, 0.002)) });
    let last = desc.materials.len() as u32 - 1;
    (desc.spheres[0].material, desc.spheres[1].material) = (last - 1, last);
    desc.point_lights.clear();
    desc.materials.push(Material::plain("lamp", BLACK, Rgb::splat(6.0)));
    desc.meshes.push(sheet(110.0, 30.0, false, last + 1));
    (desc.film.width, desc.film.height) = (48, 48);
    (desc.camera.position, desc.camera.look_at) = (Vec3::new(0.0, 50.0, 120.0), Vec3::new(0.0, 20.0, 0.0));
    let scene = Scene::new(desc).unwrap();
    let paths = path_traced(&scene, 400);
    assert_agree(&photon_mapped(&scene), &in_blocks(&paths), 1, 0.03, None);
    let seen = blocks_seen_diffuse(&scene, BLOCK);
    assert_agree(&light_traced(&scene, 800), &paths, BLOCK, 0.0, Some(&seen));
}
