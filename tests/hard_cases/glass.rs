//! Glass, water, and who is inside.

use caustica::bsdf::Bsdf;
use caustica::film::Image;
use caustica::math::{DVec3, Rgb, Vec3};
use caustica::ppm::Settings;
use caustica::reference::{Estimator, Method};
use caustica::scene::{CameraDesc, FilmDesc, Material, PointLightDesc, Scene, SceneDesc, SphereDesc};

use crate::rooms::{by_both_traversals, dark, floor, inward_cube, lit_box, rendered};

/// A box whose black walls shine with radiance 1: there are no photons to wait for.
fn glowing_box(balls: &[(Vec3, f32, f32)]) -> SceneDesc {
    let mut desc = lit_box();
    desc.point_lights.clear();
    desc.film = FilmDesc::new(12, 12);
    desc.render.depth = 200;
    desc.render.photons = 1000;
    desc.materials =
        vec![Material { emission: Rgb::ONE, ..dark("wall", Bsdf::Diffuse { albedo: Rgb::ZERO }) }];
    desc.meshes = vec![inward_cube(0)];
    for &(center, radius, ior) in balls {
        desc.spheres.push(SphereDesc { center, radius, material: desc.materials.len() as u32 });
        desc.materials.push(dark("ball", Bsdf::Dielectric { ior }));
    }
    desc
}

fn path_traced(scene: &Scene) -> Image {
    let mut estimator = Estimator::new(scene, Method::Path, 0);
    (0..1024).for_each(|_| estimator.add_sample());
    estimator.picture()
}

fn mean(image: &Image) -> DVec3 {
    image.pixels().iter().map(|p| p.as_dvec3()).sum::<DVec3>() / image.pixels().len() as f64
}

/// By the eye pass, which follows all lobes, and by path tracing.
fn assert_radiance(desc: &SceneDesc, expected: f64) {
    for scene in by_both_traversals(desc) {
        let (render, _) = rendered(&scene, Settings::of_scene(scene.render()));
        for (method, image) in [("eye pass", render.picture()), ("path tracing", path_traced(&scene))] {
            let found = mean(&image).x;
            assert!((found / expected - 1.0).abs() < 0.01, "{method}: {found} instead of {expected}");
        }
    }
}

const O: Vec3 = Vec3::new(0.0, -0.2, -0.2);

/// Glass in water in ice, overlapping and touching balls, balls of one and the same surface: where walls shine evenly,
/// all of them are invisible.
///
/// Breaks: a stack of media runs empty, or the wrong medium is left: dark or bright rims.
/// Mutation: `offset_origin` returning the point.
#[test]
fn nested_and_touching_glass_is_invisible_in_even_light() {
    let nested = [(O, 0.5, 1.33), (O, 0.4, 1.31), (O, 0.3, 1.5)];
    let touching = [(O, 0.3, 1.5), (O + 0.5 * Vec3::X, 0.2, 1.33)];
    let overlapping = [(O, 0.3, 1.5), (O + 0.3 * Vec3::X, 0.25, 1.33)];
    let coincident = [(O, 0.4, 1.5), (O, 0.4, 1.33)];
    let bubble = [(O, 0.5, 1.5), (O, 0.4, 1.0 / 1.5)];
    for balls in [&nested[..], &touching, &overlapping, &coincident, &bubble] {
        assert_radiance(&glowing_box(balls), 1.0);
    }
}

/// Eye paths through glass in glass end, however deep they may go, and what they leave out is nothing.
///
/// Breaks: the tree of reflections doubles at every interface: hours before the first pass.
/// Mutation: `SPLIT_WEIGHT` 1e-9: 400 million rays.
#[test]
fn deep_nests_of_glass_end() {
    let balls = [0.5, 0.45, 0.4, 0.35, 0.3].map(|radius| (O, radius, 1.2 + radius));
    let mut desc = glowing_box(&balls);
    desc.render.depth = 1024;
    for scene in by_both_traversals(&desc) {
        let (render, _) = rendered(&scene, Settings::of_scene(scene.render()));
        let samples = desc.film.width * desc.film.height * desc.render.samples;
        assert!(render.setup().eye_rays < 4000 * u64::from(samples), "{} rays", render.setup().eye_rays);
        assert!(render.setup().cut_weight < 1e-6);
        assert!((mean(&render.picture()).x - 1.0).abs() < 0.005);
    }
}

/// The radiance inside glass is n² times that outside, for the camera in the middle of a ball.
///
/// Breaks: a camera inside is taken to be outside, and every path counts its interfaces wrongly from there.
/// Mutation: radiance not scaled by 1/eta² at an interface.
#[test]
fn a_camera_inside_a_ball_sees_n_squared() {
    for ior in [1.5, 1.33, 0.75] {
        let desc = glowing_box(&[(Vec3::new(0.1, 0.2, 0.3), 0.3, ior)]);
        let (position, look_at) = (desc.spheres[0].center, Vec3::new(0.0, -0.4, -1.0));
        let camera = CameraDesc { position, look_at, ..desc.camera };
        assert_radiance(&SceneDesc { camera, ..desc }, f64::from(ior * ior));
    }
}

fn fresnel_at_normal_incidence(n: f64) -> f64 {
    ((n - 1.0) / (n + 1.0)).powi(2)
}

/// From under an open sheet of water straight up, `n² (1 - F) + F`: the world above, and the floor in the mirror.
///
/// Breaks: inside and outside counted by crossings go wrong where a surface has no other side.
/// Mutation: the interface's sides exchanged.
#[test]
fn a_camera_under_an_open_sheet_sees_up() {
    let n = 1.33;
    let mut desc = glowing_box(&[]);
    desc.materials.push(dark("water", Bsdf::Dielectric { ior: n as f32 }));
    desc.meshes.push(floor(0.2, 1.0, 1));
    desc.camera = CameraDesc { up: Vec3::Z, ..CameraDesc::pinhole(Vec3::ZERO, Vec3::Y, 4.0) };
    let f = fresnel_at_normal_incidence(n);
    assert_radiance(&desc, n * n * (1.0 - f) + f);
}

/// A light and a receiver, both on one axis, that only photons can join.
fn axis(light: Vec3, receiver_height: f32, up: bool) -> SceneDesc {
    let mut desc = lit_box();
    let half = if up { 3.0 } else { -3.0 };
    desc.materials = vec![dark("receiver", Bsdf::Diffuse { albedo: Rgb::splat(1e-3) })];
    desc.meshes = vec![floor(receiver_height, half, 0)];
    desc.point_lights = vec![PointLightDesc { position: light, intensity: Rgb::ONE }];
    let near = Vec3::new(0.0, receiver_height + 0.05 * half.signum(), 0.0);
    let look_at = Vec3::new(0.0, receiver_height, 0.0);
    desc.camera = CameraDesc { up: Vec3::Z, ..CameraDesc::pinhole(near, look_at, 40.0) };
    desc.render.photons = 400_000;
    desc.render.passes = 4;
    desc.render.radius = Some(0.1);
    desc
}

fn assert_photon_irradiance(desc: &SceneDesc, expected: f64) {
    for scene in by_both_traversals(desc) {
        let (render, _) = rendered(&scene, Settings::of_scene(scene.render()));
        let sum: DVec3 = (0..render.hit_points().len()).map(|k| render.photon_irradiance(k)).sum();
        let found = sum.x / render.hit_points().len() as f64;
        assert!((found / expected - 1.0).abs() < 0.03, "{found} instead of {expected}");
    }
}

/// A light in the middle of a glass ball lights the floor as if the ball were not there: whatever is mirrored inside
/// leaves in the end.
///
/// Breaks: photons born in glass are refracted as if they came from air, and never come out.
/// Mutation: `offset_origin` returning the point.
#[test]
fn a_light_inside_a_ball_shines_as_without_it() {
    let mut desc = axis(Vec3::Y, 0.0, true);
    desc.materials.push(dark("glass", Bsdf::Dielectric { ior: 1.5 }));
    desc.spheres.push(SphereDesc { center: Vec3::Y, radius: 0.3, material: 1 });
    assert_photon_irradiance(&desc, 1.0);
}

/// Light from a depth d under an open sheet, or above one, seems to come from elsewhere: `T I / (n h + d)²` on a receiver
/// h beyond it, where n is the index on the light's side over that on the other; n below 1 as well.
///
/// Breaks: inside and outside told apart by counting crossings: an open sheet has but one.
/// Mutation: the interface's sides exchanged.
#[test]
fn open_sheets_bend_light_from_both_sides() {
    let (d, h) = (0.6, 0.4);
    for ior in [1.33, 0.8] {
        for light_is_below in [true, false] {
            let height = if light_is_below { -d } else { d };
            let mut desc = axis(height * Vec3::Y, h * -height.signum(), !light_is_below);
            desc.materials.push(dark("water", Bsdf::Dielectric { ior }));
            desc.meshes.push(floor(0.0, 3.0, 1));
            let n = f64::from(if light_is_below { ior } else { 1.0 / ior });
            let through = 1.0 - fresnel_at_normal_incidence(n);
            assert_photon_irradiance(&desc, through / (n * f64::from(h) + f64::from(d)).powi(2));
        }
    }
}
