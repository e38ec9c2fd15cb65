//! Direct light in the course's box, where it is known in closed form: `albedo / π · I cos θ / d²`.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a panic is how a test fails")]

mod common;

use caustica::bsdf::Transport;
use caustica::math::{Ray, Rgb, Vec3};
use caustica::scene::Scene;
use common::{desc, scene};

/// The radiance that the surface at `p` reflects from the point light, seen from `distance` in front of it.
fn direct_radiance(scene: &Scene, p: Vec3, normal: Vec3) -> Rgb {
    let hit = scene.intersect(&Ray::new(p + 0.4 * normal, -normal)).expect("a wall");
    assert!((hit.p - p).length() < 1e-3, "hit {} instead of {p}", hit.p);
    let albedo = scene.scatter(&hit, Transport::Camera).albedo;
    albedo / std::f32::consts::PI * scene.direct_from_points(scene.lights(), &hit.receiver()).irradiance
}

fn assert_radiance(scene: &Scene, p: [f32; 3], normal: Vec3, expected: Rgb) {
    let found = direct_radiance(scene, Vec3::from(p), normal);
    let relative = (found / expected - 1.0).abs().max_element();
    assert!(relative < 1e-3, "{p:?}: {found} instead of {expected}");
}

/// The values were computed by hand from the numbers of the scene; light and walls are the only ones they need.
#[test]
fn direct_light_in_the_course_box() {
    for name in ["course_diffuse.toml", "course_balls.toml"] {
        let scene = scene(name);
        let grey = Rgb::splat;
        assert_radiance(&scene, [0.0, 0.0, 0.0], Vec3::Y, grey(0.11462));
        assert_radiance(&scene, [0.0, 0.0, 40.0], Vec3::Y, grey(0.09452));
        assert_radiance(&scene, [0.0, 60.0, -60.0], Vec3::Z, grey(0.17682));
        assert_radiance(&scene, [0.0, 100.0, -60.0], Vec3::Z, grey(0.36167));
        assert_radiance(&scene, [-60.0, 60.0, 0.0], Vec3::X, Rgb::new(0.17682, 0.02526, 0.02526));
        assert_radiance(
            &scene,
            [60.0, 100.0, 0.0],
            Vec3::NEG_X,
            Rgb::new(0.36167 / 7.0, 0.36167 / 7.0, 0.36167),
        );
        assert_radiance(&scene, [0.0, 120.0, 0.0], Vec3::NEG_Y, grey(9.284));
        assert_radiance(&scene, [40.0, 120.0, 0.0], Vec3::NEG_Y, grey(0.22027));
    }
}

/// `4 π I`.
#[test]
fn flux_of_the_course_light() {
    let flux = scene("course_diffuse.toml").lights().flux();
    assert!((flux / (4.0 * std::f32::consts::PI * 6000.0) - 1.0).abs().max_element() < 1e-6);
}

/// Water is opaque to shadow rays: below it only photons bring light.
#[test]
fn water_casts_a_shadow() {
    let scene = scene("course_water.toml");
    let hit = scene.intersect(&Ray::new(Vec3::new(0.0, 0.4, 40.0), Vec3::NEG_Y)).expect("the floor");
    assert_eq!(scene.direct_from_points(scene.lights(), &hit.receiver()).irradiance, Rgb::ZERO);
}

/// The sample is where the shadow ray ends: a light exactly on a wall must not be hidden by that wall.
#[test]
fn a_light_on_the_ceiling_is_not_hidden_by_it() {
    let mut desc = desc("course_diffuse.toml");
    desc.spheres.clear();
    desc.point_lights[0].position = Vec3::new(0.0, 120.0, 0.0);
    let scene = Scene::new(desc).unwrap();
    let expected = 0.7 / std::f32::consts::PI * 6000.0 / (120.0 * 120.0);
    assert_radiance(&scene, [0.0, 0.0, 0.0], Vec3::Y, Rgb::splat(expected));
}

/// A shading normal that leans over the horizon must not let light through from behind the true surface.
#[test]
fn light_behind_the_surface_does_not_leak_through() {
    let mut desc = desc("course_diffuse.toml");
    desc.point_lights[0].position = Vec3::new(30.0, -5.0, 20.0);
    let lean = 60f32.to_radians();
    desc.meshes[0].normals = Some(vec![Vec3::new(lean.sin(), lean.cos(), 0.0); 4]);
    let scene = Scene::new(desc).unwrap();
    let hit = scene.intersect(&Ray::new(Vec3::new(0.0, 1.0, 20.0), Vec3::NEG_Y)).unwrap();
    assert!(hit.normal.dot(Vec3::new(30.0, -5.0, 0.0)) > 0.0, "the shading normal would see it");
    assert_eq!(scene.direct_from_points(scene.lights(), &hit.receiver()).irradiance, Rgb::ZERO);
}

/// Lamps shine from the side of their normal alone, to the eye as to photons.
#[test]
fn the_back_of_a_lamp_is_dark() {
    let scene = scene("cornell_b.toml");
    let lamp = |from_y: f32, dir: Vec3| {
        let hit = scene.intersect(&Ray::new(Vec3::new(275.0, from_y, 275.0), dir)).unwrap();
        scene.emission(&hit)
    };
    assert_eq!(lamp(540.0, Vec3::Y), Rgb::splat(80.0));
    assert_eq!(lamp(549.95, Vec3::NEG_Y), Rgb::ZERO);
}
