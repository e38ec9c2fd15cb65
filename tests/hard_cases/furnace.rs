//! A closed box that glows: with albedo ρ and emission E everywhere, the radiance is `E / (1 - ρ)` everywhere.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a panic is how a test fails")]

use caustica::bsdf::{Bsdf, DiffuseSampling};
use caustica::film::Image;
use caustica::math::{DVec3, Rgb, Vec3};
use caustica::ppm::{Ledger, Render, Settings};
use caustica::reference::{Estimator, Method};
use caustica::scene::{CameraDesc, FilmDesc, Material, Mesh, RenderDesc, Scene, SceneDesc, SphereDesc};

/// The cube from -1 to 1 with its faces turned inward.
fn inward_cube() -> Mesh {
    let vertices =
        (0..8).map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 2.0 - 1.0).collect();
    let quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let triangles: Vec<[u32; 3]> =
        quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
    Mesh { name: "cube".into(), vertices, normals: None, materials: vec![0; triangles.len()], triangles }
}

fn furnace(albedo: Rgb, spheres: Vec<SphereDesc>, ball: Bsdf) -> Scene {
    let material = |name: &str, bsdf, emission| Material { name: name.into(), bsdf, emission };
    Scene::new(SceneDesc {
        name: "furnace".into(),
        path: "furnace.toml".into(),
        film: FilmDesc { width: 16, height: 16 },
        // Looks at the middle of a wall, since gathering near edges is biased.
        camera: CameraDesc {
            position: Vec3::new(0.0, 0.0, 0.9),
            look_at: Vec3::NEG_Z,
            up: Vec3::Y,
            fov_degrees: 30.0,
        },
        render: RenderDesc {
            passes: 1,
            photons: 25_000,
            samples: 4,
            alpha: 0.7,
            radius: Some(0.05),
            depth: 64,
        },
        materials: vec![
            material("wall", Bsdf::Diffuse { albedo }, Rgb::ONE),
            material("ball", ball, Rgb::ZERO),
        ],
        spheres,
        meshes: vec![inward_cube()],
        point_lights: vec![],
        warnings: vec![],
    })
    .unwrap()
}

fn mean(image: &Image) -> DVec3 {
    image.pixels().iter().map(|p| p.as_dvec3()).sum::<DVec3>() / image.pixels().len() as f64
}

/// Many small passes: points of walls that shine are lit from close by in corners, and each pass samples that but once
/// at a hit point. In a mirror, which shows the corners, 20 passes would leave 1.7 % of noise.
const PASSES: u32 = 160;

fn photon_mapped(scene: &Scene, sampling: DiffuseSampling) -> Image {
    let mut render = Render::new(scene, Settings { sampling, ..Settings::of_scene(scene.render()) });
    let mut all = Ledger::default();
    for _ in 0..PASSES {
        let ledger = render.pass().photons;
        assert!(ledger.is_balanced(), "{ledger:?}");
        all = all.plus(ledger);
    }
    assert!(all.escaped * MAX_RAYS_PER_LEAK < all.rays, "leaks: {all:?}");
    render.picture()
}

/// A point that rounds onto the other wall of an edge may start a ray outside: a few in a million do.
const MAX_RAYS_PER_LEAK: u64 = 100_000;

fn path_traced(scene: &Scene, samples: u32) -> Image {
    estimated(scene, Method::Path, samples)
}

fn estimated(scene: &Scene, method: Method, samples: u32) -> Image {
    let mut estimator = Estimator::new(scene, method, 0);
    (0..samples).for_each(|_| estimator.add_sample());
    estimator.picture()
}

fn assert_mean(what: &str, image: &Image, expected: Rgb, tolerance: f64) {
    let relative = (mean(image) / expected.as_dvec3() - 1.0).abs().max_element();
    assert!(relative < tolerance, "{what}: {} instead of {expected}", mean(image));
}

const BLACK_BALL: Bsdf = Bsdf::Diffuse { albedo: Rgb::ZERO };

/// Catches any loss or gain of energy in a bounce: at albedo .8 light bounces five times on average.
#[test]
fn empty_furnace() {
    let albedo = Rgb::new(0.8, 0.5, 0.2);
    let expected = 1.0 / (1.0 - albedo);
    let scene = furnace(albedo, vec![], BLACK_BALL);
    assert_mean("path tracing", &path_traced(&scene, 4000), expected, 0.005);
    assert_mean("light tracing", &estimated(&scene, Method::Light, 4000), expected, 0.005);
    for sampling in [DiffuseSampling::Cosine, DiffuseSampling::Uniform] {
        let image = photon_mapped(&scene, sampling);
        assert_mean(&format!("photons, {sampling:?}"), &image, expected, 0.01);
    }
}

/// Whatever loses no light must be invisible in a furnace, seen from outside and from within its reflections.
/// Catches refracted radiance that is not scaled, Fresnel shares that do not sum to one, cut eye paths.
#[test]
fn lossless_balls_vanish_in_the_furnace() {
    let ball = SphereDesc { center: Vec3::new(0.0, 0.0, 0.2), radius: 0.3, material: 1 };
    let expected = Rgb::splat(2.0);
    for bsdf in [
        Bsdf::Dielectric { ior: 1.5 },
        Bsdf::Mirror { reflectance: Rgb::ONE },
        Bsdf::FixedWeight { color: Rgb::ONE, reflectivity: 0.4, transparency: 0.6, ior: 1.5 },
    ] {
        let scene = furnace(Rgb::splat(0.5), vec![ball], bsdf);
        assert_mean(&format!("path tracing {bsdf:?}"), &path_traced(&scene, 4000), expected, 0.005);
        let image = photon_mapped(&scene, DiffuseSampling::Cosine);
        assert_mean(&format!("photons {bsdf:?}"), &image, expected, 0.015);
    }
}

/// A closed box of albedo 1 must not hang: its photons are cut, counted, and nothing is lost from the ledger.
#[test]
fn white_furnace_ends_and_reports_its_cut() {
    let scene = furnace(Rgb::ONE, vec![], BLACK_BALL);
    let settings = Settings { photons: 200, ..Settings::of_scene(scene.render()) };
    let ledger = Render::new(&scene, settings).pass().photons;
    assert_eq!((ledger.emitted, ledger.terminated), (200, 200));
}
