//! Photon mapping and path tracing share no estimator, so what they agree on is right.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a panic is how a test fails")]

mod common;

use caustica::bsdf::DiffuseSampling;
use caustica::compare::{BlockCriterion, BlockReport, Estimate};
use caustica::film::Image;
use caustica::math::Vec3;
use caustica::ppm::Settings;
use caustica::scene::{Mesh, Scene, SceneDesc};
use common::{desc, path_traced, photon_mapped, scene_at, settings, under_a_lamp};

fn assert_agree(image: &Image, reference: &(Image, Image), relative: f64, required: f64) {
    assert_blocks_agree(image, reference, 8, relative, required);
}

fn assert_blocks_agree(
    image: &Image,
    reference: &(Image, Image),
    block: usize,
    relative: f64,
    required: f64,
) {
    let criterion = BlockCriterion { block, ..BlockCriterion::new(relative, 3.0) };
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
    let image = photon_mapped(&scene, few_pixels(&scene), 20);
    assert_agree(&image, &path_traced(&scene, 256), 0.03, 0.97);
}

/// The scene seen through a narrow window around `target`.
fn close_up(mut desc: SceneDesc, target: Vec3, fov_degrees: f32) -> Scene {
    (desc.film.width, desc.film.height) = (32, 32);
    (desc.camera.look_at, desc.camera.fov_degrees) = (target, fov_degrees);
    Scene::new(desc).unwrap()
}

/// Every block must agree: what a wrong factor changes fills the picture.
fn assert_close_up_agrees(scene: &Scene, block: usize, relative: f64) {
    let settings = Settings { photons: 500_000, samples: 16, radius: Some(1.0), ..settings(scene) };
    let image = photon_mapped(scene, settings, 20);
    assert_blocks_agree(&image, &path_traced(scene, 3000), block, relative, 1.0);
}

/// The course's balls under a lamp in place of the point light: no path hits a point, so what a ball refracts
/// of its light would be known to photons alone.
fn balls_under_a_lamp() -> SceneDesc {
    under_a_lamp(desc("course_balls.toml"))
}

/// Task 8: fixed weights of reflection and refraction.
#[test]
fn reflecting_and_refracting_balls() {
    let mut desc = balls_under_a_lamp();
    (desc.film.width, desc.film.height) = (64, 64);
    let scene = Scene::new(desc).unwrap();
    let image = photon_mapped(&scene, few_pixels(&scene), 20);
    assert_agree(&image, &path_traced(&scene, 400), 0.03, 0.95);
}

/// The diffuse share inside a refracting ball: photons and eye paths meet there only if both treat the interface
/// alike. Catches photons scaled like radiance, and radiance after a bounce that is not scaled.
#[test]
fn inside_of_the_refracting_ball() {
    let desc = balls_under_a_lamp();
    let ball = desc.spheres[1].center;
    assert_close_up_agrees(&close_up(desc, ball, 7.0), 8, 0.04);
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

/// A floor whose shading normals all lean by 35 degrees: it receives by them (seen from above) and reflects what
/// they let it receive (seen on the wall beside it). Catches photons that go by the true normal alone.
#[test]
fn shading_normals_far_from_the_true_one() {
    let (above, beside) = (Vec3::new(0.0, 1.0, 20.0), Vec3::new(-60.0, 14.0, 20.0));
    for (target, block, relative) in [(above, 8, 0.04), (beside, 32, 0.015)] {
        let mut desc = desc("course_diffuse.toml");
        desc.spheres.clear();
        desc.meshes.push(leaning_floor());
        assert_close_up_agrees(&close_up(desc, target, 8.0), block, relative);
    }
}

fn leaning_floor() -> Mesh {
    let corner = |x: f32, z: f32| Vec3::new(59.0 * x, 1.0, 59.0 * z);
    let lean = 35f32.to_radians();
    Mesh {
        name: "floor".into(),
        vertices: vec![corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)],
        normals: Some(vec![Vec3::new(lean.sin(), lean.cos(), 0.0); 4]),
        uvs: None,
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        materials: vec![0; 2],
    }
}
