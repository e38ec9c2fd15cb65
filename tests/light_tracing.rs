//! The light tracer shares no path with the other methods: closed forms, then the pictures that they agree on.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a panic is how a test fails")]

mod common;

use std::f64::consts::PI;

use caustica::bsdf::Bsdf;
use caustica::compare::{BlockCriterion, BlockReport, Estimate};
use caustica::film::Image;
use caustica::math::{Ray, Rgb, Vec2, Vec3};
use caustica::ppm::Settings;
use caustica::reference::{Method, share_seen_specular};
use caustica::scene::{CameraDesc, FilmDesc, Material, Mesh, PointLightDesc, RenderDesc, Scene, SceneDesc};
use common::{
    block_estimate, blocks_seen_diffuse, desc, estimated, light_traced, path_traced, photon_mapped, scene_at,
    settings,
};

const INTENSITY: f32 = 1000.0;
const LIGHT: Vec3 = Vec3::new(1.0, 6.0, -2.0);
const ALBEDO: f32 = 0.5;

/// A large floor at y = 0 and a point light above it, seen askew in a picture that is no square.
fn lit_floor() -> Scene {
    let corner = |x: f32, z: f32| Vec3::new(x * 60.0, 0.0, z * 60.0);
    Scene::new(SceneDesc {
        name: "floor".into(),
        path: "floor.toml".into(),
        film: FilmDesc { width: 24, height: 10 },
        camera: CameraDesc {
            position: Vec3::new(2.0, 4.0, 7.0),
            look_at: Vec3::new(0.0, 0.0, 0.5),
            up: Vec3::new(0.3, 1.0, 0.0),
            fov_degrees: 95.0,
        },
        render: RenderDesc { passes: 1, photons: 1, samples: 1, alpha: 0.7, radius: None, depth: 8 },
        materials: vec![Material {
            name: "floor".into(),
            bsdf: Bsdf::Diffuse { albedo: Rgb::splat(ALBEDO) },
            emission: Rgb::ZERO,
        }],
        spheres: vec![],
        meshes: vec![Mesh {
            name: "floor".into(),
            vertices: vec![corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)],
            normals: None,
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            materials: vec![0; 2],
        }],
        point_lights: vec![PointLightDesc { position: LIGHT, intensity: Rgb::splat(INTENSITY) }],
        warnings: vec![],
    })
    .unwrap()
}

/// `albedo / π · I cos θ / d²` where `ray` meets the floor.
fn floor_radiance(ray: &Ray) -> f64 {
    let p = ray.at(-ray.origin.y / ray.dir.y).as_dvec3();
    let to_light = LIGHT.as_dvec3() - p;
    let (d2, cos) = (to_light.length_squared(), to_light.y / to_light.length());
    f64::from(ALBEDO) / PI * f64::from(INTENSITY) * cos / d2
}

/// The mean over a pixel, by the midpoints of a grid.
fn pixel_radiance(scene: &Scene, x: usize, y: usize) -> f64 {
    const GRID: usize = 8;
    let at = |k: usize| {
        let inside = Vec2::new((k % GRID) as f32, (k / GRID) as f32) + 0.5;
        floor_radiance(&scene.camera().ray(Vec2::new(x as f32, y as f32) + inside / GRID as f32))
    };
    (0..GRID * GRID).map(at).sum::<f64>() / (GRID * GRID) as f64
}

/// Catches a wrong or lost cosine, pixel area or distance, and pixels that are mixed up.
#[test]
fn point_light_over_a_floor() {
    let scene = lit_floor();
    let (mean, stderr) = light_traced(&scene, 4000);
    let mut squares = 0.0;
    for (y, x) in (0..mean.height()).flat_map(|y| (0..mean.width()).map(move |x| (y, x))) {
        let (found, expected) = (f64::from(mean.get(x, y).x), pixel_radiance(&scene, x, y));
        let z = (found - expected) / f64::from(stderr.get(x, y).x);
        assert!(z.abs() < 4.5, "({x}, {y}): {found} instead of {expected}");
        squares += z * z;
    }
    let pixels = mean.pixels().len() as f64;
    assert!((0.75..1.3).contains(&(squares / pixels)), "the standard errors are off: {}", squares / pixels);
}

/// Every block that shows diffuse surfaces alone must agree within `relative` and four combined standard errors.
fn assert_agree(scene: &Scene, a: &(Image, Image), b: &(Image, Image), block: usize, relative: f64) {
    let mask = blocks_seen_diffuse(scene, block);
    let criterion = BlockCriterion { block, mask: Some(&mask), ..BlockCriterion::new(relative, 4.0) };
    let [a, b] = [a, b].map(|(mean, stderr)| Estimate { mean, stderr: Some(stderr) });
    let report = BlockReport::between(a, b, &criterion).unwrap();
    eprintln!("{report:?}");
    assert!(report.n_blocks >= 10, "{report:?}");
    assert_eq!(report.n_within, report.n_blocks, "{report:?}");
}

/// Point lights, direct and indirect.
#[test]
fn diffuse_box_as_path_traced() {
    let scene = scene_at("course_diffuse.toml", 64, 64);
    assert_eq!(share_seen_specular(&scene), 0.0);
    assert_agree(&scene, &light_traced(&scene, 1000), &path_traced(&scene, 400), 8, 0.0);
}

/// A lamp that is seen, soft shadows, caustics.
#[test]
fn mirror_glass_and_area_light_as_path_traced() {
    let scene = scene_at("cornell_b.toml", 64, 64);
    assert!((share_seen_specular(&scene) - 0.11).abs() < 0.02, "two balls");
    assert_agree(&scene, &light_traced(&scene, 1000), &path_traced(&scene, 1000), 8, 0.0);
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
    assert_agree(&scene, &light_traced(&scene, 4000), &path_traced(&scene, 2000), 8, 0.0);
}

/// The bright spot below the glass ball of `cornell_b.toml`, which path tracing hardly finds.
#[test]
fn caustic_as_photon_mapped() {
    let mut desc = desc("cornell_b.toml");
    (desc.film.width, desc.film.height) = (32, 32);
    (desc.camera.look_at, desc.camera.fov_degrees) = (Vec3::new(141.0, 0.0, 140.0), 5.0);
    let scene = Scene::new(desc).unwrap();
    let photons = |seed| {
        let settings =
            Settings { seed, photons: 400_000, samples: 16, radius: Some(0.7), ..settings(&scene) };
        photon_mapped(&scene, settings, 2)
    };
    let paths = |seed| estimated(&scene, Method::Light, 400, seed).0;
    let photons = block_estimate(&(0..10).map(photons).collect::<Vec<_>>(), 8);
    let paths = block_estimate(&(0..10).map(paths).collect::<Vec<_>>(), 8);
    eprintln!("{} {:?} {:?}", share_seen_specular(&scene), photons, paths);
}
