//! Photon mapping and path tracing share no estimator, so what they agree on is right.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a panic is how a test fails")]

mod common;

use caustica::bsdf::DiffuseSampling;
use caustica::compare::{BlockCriterion, BlockReport, Estimate};
use caustica::film::Image;
use caustica::ppm::Settings;
use caustica::scene::{Mesh, Scene};
use common::{desc, path_traced, photon_mapped, scene_at, settings};

fn assert_agree(image: &Image, reference: &(Image, Image), relative: f64, required: f64) {
    let criterion = BlockCriterion { block: 8, ..BlockCriterion::new(relative, 3.0) };
    let reference = Estimate { mean: &reference.0, stderr: Some(&reference.1) };
    let report = BlockReport::between(Estimate::exact(image), reference, &criterion).unwrap();
    eprintln!("{} of {} blocks, worst {:?}", report.n_within, report.n_blocks, report.worst);
    assert!(report.share_within() >= required, "{report:?}");
}

/// A radius that shrinks fast: at 64 x 64 pixels bias at edges, not noise, is what would show.
fn few_pixels(scene: &Scene) -> Settings {
    Settings { photons: 500_000, samples: 16, radius: Some(1.5), ..settings(scene) }
}

/// Tasks 1 to 7: everything diffuse.
#[test]
fn diffuse_box() {
    let scene = scene_at("course_diffuse.toml", 64, 64);
    let image = photon_mapped(&scene, few_pixels(&scene), 30);
    assert_agree(&image, &path_traced(&scene, 256), 0.03, 0.97);
}

/// Task 8: fixed weights of reflection and refraction, and the diffuse share inside a refracting ball, where
/// photons and eye paths meet only if both treat the interface alike.
#[test]
fn reflecting_and_refracting_balls() {
    let scene = scene_at("course_balls.toml", 64, 64);
    let image = photon_mapped(&scene, few_pixels(&scene), 30);
    assert_agree(&image, &path_traced(&scene, 256), 0.03, 0.95);
}

/// Uniform and cosine-weighted bounces have the same mean.
#[test]
fn both_samplings_give_the_same_picture() {
    let scene = scene_at("course_diffuse.toml", 64, 64);
    let cosine = photon_mapped(&scene, few_pixels(&scene), 20);
    let uniform = Settings { sampling: DiffuseSampling::Uniform, ..few_pixels(&scene) };
    let uniform = photon_mapped(&scene, uniform, 20);
    let criterion = BlockCriterion { block: 16, ..BlockCriterion::new(0.03, 0.0) };
    let report =
        BlockReport::between(Estimate::exact(&uniform), Estimate::exact(&cosine), &criterion).unwrap();
    assert_eq!(report.n_within, report.n_blocks, "{report:?}");
}

/// Normals that are smoothed over the corners of a coarse mesh disagree with the true ones: photons and eye
/// paths must be corrected alike, and no light may leak through.
#[test]
fn shading_normals_far_from_geometric_ones() {
    let mut desc = desc("course_diffuse.toml");
    (desc.film.width, desc.film.height) = (48, 48);
    desc.spheres.clear();
    desc.meshes.push(octahedron());
    let scene = Scene::new(desc).unwrap();
    let image = photon_mapped(&scene, few_pixels(&scene), 30);
    assert_agree(&image, &path_traced(&scene, 400), 0.04, 0.97);
}

fn octahedron() -> Mesh {
    use caustica::math::Vec3;
    let center = Vec3::new(0.0, 40.0, 20.0);
    let axes = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z];
    let triangles =
        vec![[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]];
    Mesh {
        name: "octahedron".into(),
        vertices: axes.iter().map(|a| center + 30.0 * *a).collect(),
        normals: Some(axes.to_vec()),
        materials: vec![0; triangles.len()],
        triangles,
    }
}
