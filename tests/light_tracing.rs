//! The light tracer shares no path with the other methods: closed forms, then the pictures that they agree on.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a panic is how a test fails")]

mod common;

use std::f64::consts::PI;

use caustica::bsdf::Bsdf;
use caustica::compare::{BlockCriterion, BlockReport, Estimate};
use caustica::film::Image;
use caustica::math::{Rgb, Vec2, Vec3};
use caustica::ppm::Settings;
use caustica::reference::{Method, share_seen_specular};
use caustica::scene::{CameraDesc, FilmDesc, Material, PointLightDesc, RenderDesc, Scene, SceneDesc};
use common::sheets::{BLACK, INTENSITY, sheet};
use common::{
    block_estimate, blocks_seen_diffuse, desc, estimated, light_traced, path_traced, photon_mapped, scene_at,
    settings,
};

const LIGHT: Vec3 = Vec3::new(1.0, 6.0, -2.0);
/// So little that light which bounces off the floor does not count.
const ALBEDO: f32 = 1e-3;
const REFLECTANCE: f32 = 0.8;
const MIRROR_HEIGHT: f32 = 9.0;

/// A point light between a floor at y = 0 and a second sheet of material `above`, seen askew in a picture that is no
/// square.
fn lit_floor(above: Bsdf) -> SceneDesc {
    let material = |bsdf| Material::plain("sheet", bsdf, Rgb::ZERO);
    SceneDesc {
        name: "floor".into(),
        path: "floor.toml".into(),
        film: FilmDesc::new(24, 10),
        render: RenderDesc { passes: 1, photons: 1, samples: 1, alpha: 0.7, radius: None, depth: 8 },
        materials: vec![material(Bsdf::Diffuse { albedo: Rgb::splat(ALBEDO) }), material(above)],
        meshes: vec![sheet(0.0, 300.0, true, 0), sheet(MIRROR_HEIGHT, 300.0, true, 1)],
        point_lights: vec![PointLightDesc { position: LIGHT, intensity: Rgb::splat(INTENSITY) }],
        ..SceneDesc::new(CameraDesc {
            up: Vec3::new(0.3, 1.0, 0.0),
            ..CameraDesc::pinhole(Vec3::new(2.0, 6.0, 4.0), Vec3::new(0.0, 0.0, 0.5), 95.0)
        })
    }
}

/// `albedo / π · I cos θ / d²` at the point `p` of the floor, summed over the light and its mirror image.
fn floor_radiance(p: Vec3, reflectance: f32) -> f64 {
    let image = LIGHT.with_y(2.0 * MIRROR_HEIGHT - LIGHT.y);
    let irradiance = |light: Vec3| {
        let d = (light - p).as_dvec3();
        f64::from(INTENSITY) * d.y / d.length().powi(3)
    };
    f64::from(ALBEDO) / PI * (irradiance(LIGHT) + f64::from(reflectance) * irradiance(image))
}

/// The mean over a pixel, by the midpoints of a grid.
fn pixel_radiance(scene: &Scene, (x, y): (usize, usize), reflectance: f32) -> f64 {
    const GRID: usize = 8;
    let at = |k: usize| {
        let inside = Vec2::new((k % GRID) as f32, (k / GRID) as f32) + 0.5;
        let ray = scene.camera().ray(Vec2::new(x as f32, y as f32) + inside / GRID as f32);
        let hit = scene.intersect(&ray).expect("the floor fills the picture");
        floor_radiance(hit.p, reflectance)
    };
    (0..GRID * GRID).map(at).sum::<f64>() / (GRID * GRID) as f64
}

/// Every pixel within 4.5 standard errors, and the errors themselves as large as they say.
fn assert_floor_radiance(desc: SceneDesc, reflectance: f32) {
    let scene = Scene::new(desc).unwrap();
    let (mean, stderr) = light_traced(&scene, 4000);
    let mut squares = 0.0;
    for (y, x) in (0..mean.height()).flat_map(|y| (0..mean.width()).map(move |x| (y, x))) {
        let expected = pixel_radiance(&scene, (x, y), reflectance);
        let z = (f64::from(mean.get(x, y).x) - expected) / f64::from(stderr.get(x, y).x);
        assert!(z.abs() < 4.5, "({x}, {y}): {} instead of {expected}", mean.get(x, y).x);
        squares += z * z / mean.pixels().len() as f64;
    }
    assert!((0.75..1.3).contains(&squares), "the mean square of the deviations is {squares} variances");
}

/// Catches a wrong or lost cosine, pixel area or distance, and pixels that are mixed up.
#[test]
fn point_light_over_a_floor() {
    assert_floor_radiance(lit_floor(BLACK), 0.0);
}

/// What no path from the camera finds: a mirror throws the light of a point onto the floor.
#[test]
fn point_light_by_way_of_a_mirror() {
    let mirror = Bsdf::Mirror { reflectance: Rgb::splat(REFLECTANCE) };
    assert_floor_radiance(lit_floor(mirror), REFLECTANCE);
}

/// The camera sees one side of the floor and the light the other, whatever the shading normals say.
#[test]
fn light_behind_the_surface_does_not_leak_through() {
    for lean in [0f32, 60.0, 120.0].map(f32::to_radians) {
        let mut desc = lit_floor(BLACK);
        desc.point_lights[0].position = Vec3::new(3.0, -2.0, 1.0);
        desc.meshes[0].normals = Some(vec![Vec3::new(lean.sin(), lean.cos(), 0.0); 4]);
        let (mean, _) = light_traced(&Scene::new(desc).unwrap(), 100);
        assert!(mean.pixels().iter().all(|&pixel| pixel == Rgb::ZERO), "{lean}");
    }
}

/// Every block of pixels that shows diffuse surfaces alone must agree within four combined standard errors.
fn assert_agree(scene: &Scene, a: &(Image, Image), b: &(Image, Image)) {
    const BLOCK: usize = 8;
    let mask = blocks_seen_diffuse(scene, BLOCK);
    let criterion = BlockCriterion { block: BLOCK, mask: Some(&mask), ..BlockCriterion::new(0.0, 4.0) };
    assert_within(a, b, &criterion, 16);
}

fn assert_within(a: &(Image, Image), b: &(Image, Image), criterion: &BlockCriterion, blocks: usize) {
    let [a, b] = [a, b].map(|(mean, stderr)| Estimate { mean, stderr: Some(stderr) });
    let report = BlockReport::between(a, b, criterion).unwrap();
    eprintln!("{report:?}");
    assert!(report.n_blocks >= blocks, "{report:?}");
    assert_eq!(report.n_within, report.n_blocks, "{report:?}");
}

/// Point lights, direct and indirect.
#[test]
fn diffuse_box_as_path_traced() {
    let scene = scene_at("course_diffuse.toml", 64, 64);
    assert_eq!(share_seen_specular(&scene), 0.0);
    assert_agree(&scene, &light_traced(&scene, 400), &path_traced(&scene, 200));
}

/// A lamp that is seen, soft shadows, caustics.
#[test]
fn mirror_glass_and_area_light_as_path_traced() {
    let scene = scene_at("cornell_b.toml", 64, 64);
    assert!((share_seen_specular(&scene) - 0.11).abs() < 0.02, "two balls");
    assert_agree(&scene, &light_traced(&scene, 400), &path_traced(&scene, 400));
}

/// A floor whose shading normals lean by 35 degrees: it is seen directly, and lights the walls.
#[test]
fn shading_normals_as_path_traced() {
    let mut desc = desc("course_diffuse.toml");
    desc.spheres.clear();
    let lean = 35f32.to_radians();
    desc.meshes[0].normals = Some(vec![Vec3::new(lean.sin(), lean.cos(), 0.0); 4]);
    (desc.film.width, desc.film.height) = (32, 32);
    let scene = Scene::new(desc).unwrap();
    assert_agree(&scene, &light_traced(&scene, 1500), &path_traced(&scene, 800));
}

/// The bright spot below the glass ball of `cornell_b.toml`, from close by: path tracing hardly finds it.
#[test]
fn caustic_as_photon_mapped() {
    const BLOCK: usize = 4;
    const RENDERS: u64 = 10;
    let mut desc = desc("cornell_b.toml");
    (desc.film.width, desc.film.height) = (32, 32);
    desc.camera.position = Vec3::new(100.0, 90.0, -40.0);
    (desc.camera.look_at, desc.camera.fov_degrees) = (Vec3::new(137.0, 0.0, 146.0), 14.0);
    let scene = Scene::new(desc).unwrap();
    let photons = |seed| {
        let settings =
            Settings { seed, photons: 400_000, samples: 16, radius: Some(0.4), ..settings(&scene) };
        photon_mapped(&scene, settings, 2)
    };
    let paths = |seed| estimated(&scene, Method::Light, 400, seed).0;
    let photons = block_estimate(&(0..RENDERS).map(photons).collect::<Vec<_>>(), BLOCK);
    let paths = block_estimate(&(0..RENDERS).map(paths).collect::<Vec<_>>(), BLOCK);
    let bright = |k: &usize| photons.0.pixels()[*k].x > 1.0;
    let mask: Vec<bool> = one_in_each_block(&blocks_seen_diffuse(&scene, BLOCK), BLOCK, 32);
    assert!((0..mask.len()).filter(bright).filter(|&k| mask[k]).count() >= 10, "the caustic fills blocks");
    let criterion = BlockCriterion { block: 1, mask: Some(&mask), ..BlockCriterion::new(0.01, 4.0) };
    assert_within(&paths, &photons, &criterion, 32);
}

/// The first pixel of every block, of a picture of `width` pixels in a row.
fn one_in_each_block(mask: &[bool], block: usize, width: usize) -> Vec<bool> {
    let blocks = width / block;
    (0..blocks * blocks).map(|b| mask[b / blocks * block * width + b % blocks * block]).collect()
}
