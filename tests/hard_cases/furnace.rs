//! A closed box that glows: with albedo ρ and emission E everywhere, the radiance is `E / (1 - ρ)` everywhere.

use caustica::bsdf::{Bsdf, DiffuseSampling};
use caustica::film::Image;
use caustica::math::{DVec3, Rgb, Vec3};
use caustica::ppm::{Ledger, Render, Settings};
use caustica::reference::{Estimator, Method};
use caustica::scene::{CameraDesc, FilmDesc, Material, RenderDesc, Scene, SceneDesc, SphereDesc};

use super::rooms::{by_both_traversals, inward_cube};

fn furnace(albedo: Rgb, spheres: Vec<SphereDesc>, ball: Bsdf) -> [Scene; 2] {
    let material = |name: &str, bsdf, emission| Material::plain(name, bsdf, emission);
    by_both_traversals(&SceneDesc {
        name: "furnace".into(),
        path: "furnace.toml".into(),
        film: FilmDesc::new(16, 16),
        // Looks at the middle of a wall, since gathering near edges is biased.
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
        meshes: vec![inward_cube(0)],
        ..SceneDesc::new(CameraDesc::pinhole(Vec3::new(0.0, 0.0, 0.9), Vec3::NEG_Z, 30.0))
    })
}

fn mean(image: &Image) -> DVec3 {
    image.pixels().iter().map(|p| p.as_dvec3()).sum::<DVec3>() / image.pixels().len() as f64
}

/// Many small passes: points of walls that shine are lit from close by in corners, and each pass samples that but once
/// at a hit point. In a mirror, which shows the corners, 40 passes leave 1.2 % of noise.
const PASSES: u32 = 40;

fn photon_mapped(scene: &Scene, sampling: DiffuseSampling) -> Image {
    let mut render = Render::new(scene, Settings { sampling, ..Settings::of_scene(scene.render()) });
    let mut all = Ledger::default();
    for _ in 0..PASSES {
        let ledger = render.pass().photons;
        assert!(ledger.is_balanced(), "{ledger:?}");
        all = all.plus(ledger);
    }
    assert_eq!(all.escaped, 0, "leaks: {all:?}");
    render.picture()
}

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

/// In a closed box of albedo ρ that glows with E the radiance is `E / (1 - ρ)` wherever one looks, by photons of either
/// sampling as by paths from either end.
///
/// Breaks: any loss or gain of energy in a bounce adds up: at albedo .8 light bounces five times on average.
///
/// Mutation: uniform bounces scaled by `2.2 cos`; in another run, the power of a lane's bounce times .99.
#[test]
fn empty_furnace() {
    let albedo = Rgb::new(0.8, 0.5, 0.2);
    let expected = 1.0 / (1.0 - albedo);
    for scene in &furnace(albedo, vec![], BLACK_BALL) {
        let traversal = scene.traversal();
        assert_mean(&format!("path tracing, {traversal:?}"), &path_traced(scene, 500), expected, 0.01);
        let light_traced = estimated(scene, Method::Light, 500);
        assert_mean(&format!("light tracing, {traversal:?}"), &light_traced, expected, 0.01);
        for sampling in [DiffuseSampling::Cosine, DiffuseSampling::Uniform] {
            let image = photon_mapped(scene, sampling);
            assert_mean(&format!("photons, {sampling:?}, {traversal:?}"), &image, expected, 0.02);
        }
    }
}

/// Whatever loses no light is invisible in a furnace, from outside and in its reflections.
///
/// Breaks: refracted radiance that is not scaled, Fresnel's shares that do not sum to one, eye paths cut too early.
///
/// Mutation: `mirrored` takes .97 of its share; in another run, `refracted` gets the share `0.9 - reflectance`.
#[test]
fn lossless_balls_vanish_in_the_furnace() {
    let ball = SphereDesc { center: Vec3::new(0.0, 0.0, 0.2), radius: 0.3, material: 1 };
    let expected = Rgb::splat(2.0);
    for bsdf in [
        Bsdf::Dielectric { ior: 1.5 },
        Bsdf::Mirror { reflectance: Rgb::ONE },
        Bsdf::FixedWeight { color: Rgb::ONE, reflectivity: 0.4, transparency: 0.6, ior: 1.5 },
    ] {
        for scene in &furnace(Rgb::splat(0.5), vec![ball], bsdf) {
            let what = format!("{bsdf:?}, {:?}", scene.traversal());
            assert_mean(&format!("path tracing {what}"), &path_traced(scene, 500), expected, 0.01);
            let image = photon_mapped(scene, DiffuseSampling::Cosine);
            assert_mean(&format!("photons {what}"), &image, expected, 0.03);
        }
    }
}

/// What a furnace emits it absorbs: the share `1 - ρ` of all that reaches its walls, to the noise of roulette, and each account
/// to 1e-12.
///
/// Breaks: a bounce that forgets or doubles power, or a photon that is lost on the way to the next wall.
///
/// Mutation: the power of a lane's bounce doubled; in another run, the last photon of a packet not pushed on; in a third, that
/// power times .99.
#[test]
fn furnaces_absorb_what_they_emit() {
    let albedo = Rgb::new(0.8, 0.5, 0.2);
    for scene in &furnace(albedo, vec![], BLACK_BALL) {
        for sampling in [DiffuseSampling::Cosine, DiffuseSampling::Uniform] {
            let settings = Settings { sampling, photons: 100_000, ..Settings::of_scene(scene.render()) };
            let ledger = Render::new(scene, settings).pass().photons;
            let flux = ledger.flux;
            assert!(ledger.is_balanced() && flux.imbalance() < 1e-12, "{ledger:?}");
            let absorbed = (flux.absorbed + flux.escaped) / flux.emitted - 1.0;
            assert!(absorbed.abs().max_element() < 0.03, "{sampling:?}: {flux:?}");
            assert!((flux.roulette / flux.emitted).abs().max_element() < 0.03, "{flux:?}");
        }
    }
}

/// A closed box of albedo exactly 1 does not hang: its photons are cut, counted, and none is missing.
///
/// Breaks: roulette never ends a path, and neither does anything else.
///
/// Mutation: photons cut at the longest path not counted in `Wavefront::follow`; in another run, their flux not booked.
#[test]
fn white_furnace_ends_and_reports_its_cut() {
    for scene in &furnace(Rgb::ONE, vec![], BLACK_BALL) {
        let settings = Settings { photons: 200, ..Settings::of_scene(scene.render()) };
        let ledger = Render::new(scene, settings).pass().photons;
        assert_eq!((ledger.emitted, ledger.terminated), (200, 200));
        assert!(ledger.is_balanced() && ledger.flux.terminated == ledger.flux.emitted, "{ledger:?}");
    }
}
