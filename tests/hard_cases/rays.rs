//! Rays at edges, vertices and ends.

use caustica::bench::leaks::{self, LeakRow, Leaks};
use caustica::bsdf::{Bsdf, DiffuseSampling};
use caustica::math::{Ray, Rgb, Rng, Stream, Vec3};
use caustica::ppm::{Ledger, Settings};
use caustica::scene::{Material, PointLightDesc, Receiver, Scene, SceneDesc};

use crate::rooms::{by_both_traversals, ceiling, dark, floor, furnished_box, lit_box, rendered};

fn leak_rows(traversal: &str) -> Vec<LeakRow> {
    let mut rows = leaks::measure(40_000, |_| ()).unwrap().rows;
    rows.retain(|row| row.traversal == traversal);
    rows
}

fn leaking(rows: &[LeakRow], which: fn(&LeakRow) -> Leaks) -> Vec<String> {
    assert!(rows.len() == 4 && rows.iter().all(|row| which(row).rays > 10_000));
    rows.iter().filter(|row| which(row).leaks > 0).map(|row| format!("{row:?}")).collect()
}

/// No ray leaves a closed mesh through an edge: cube, ball, needles, far from the origin.
/// Embree lets some slip through vertices exactly aimed at; `caustica bench --leaks` tells how many.
///
/// Breaks: light seeps out along the edges of walls, and single bright pixels look through them.
/// Mutation: `SceneOptions::robust` false; `EDGE_ERRORS` 0.
#[test]
fn edges_of_closed_meshes_are_tight() {
    let far_ball = |row: &LeakRow| row.mesh == "far ball";
    let mut embree = leak_rows("embree");
    assert_eq!(leaking(&embree, |row| row.bounces), [""; 0]);
    // There, rounding moves points on the edges at the poles onto vertices.
    embree.iter_mut().filter(|row| far_ball(row)).for_each(|row| row.edges.leaks = 0);
    assert_eq!(leaking(&embree, |row| row.edges), [""; 0]);
    assert_eq!(leaking(&leak_rows("custom"), |row| row.edges), [""; 0]);
}

/// A lamp of width 2a at height a over a point: `E = π L F`, with F the configuration factor of the square.
///
/// # Source
/// Howell, "A Catalog of Radiation Heat Transfer Configuration Factors", B-4, for A = B = 1, four times.
fn irradiance_below_a_square_lamp(radiance: f64) -> f64 {
    let side = 0.5f64.sqrt();
    4.0 * radiance * side * side.atan()
}

fn with_lamp(height: f32, half: f32) -> SceneDesc {
    let mut desc = lit_box();
    desc.point_lights.clear();
    desc.materials.push(Material { emission: Rgb::ONE, ..dark("lamp", Bsdf::Diffuse { albedo: Rgb::ZERO }) });
    desc.meshes = vec![floor(0.0, 1.0, 0), ceiling(height, half, 1)];
    desc
}

fn mean_irradiance(scene: &Scene, receiver: &Receiver) -> f64 {
    const SAMPLES: u64 = 40_000;
    let sample = |index| {
        let mut rng = Rng::new(0, Stream::Test, 0, index);
        f64::from(scene.direct_from_areas(scene.lights(), receiver, &mut rng).irradiance.x)
    };
    (0..SAMPLES).map(sample).sum::<f64>() / SAMPLES as f64
}

fn receiver_at(scene: &Scene, from: Vec3, dir: Vec3) -> Receiver {
    scene.intersect(&Ray::new(from, dir)).unwrap().receiver()
}

fn assert_close(found: f64, expected: f64, tolerance: f64) {
    assert!((found / expected - 1.0).abs() < tolerance, "{found} instead of {expected}");
}

/// Lamps at distance .001 and 100,000 light a floor of size 1 as the closed form has it.
///
/// Breaks: the shadow ray starts behind the lamp, or meets the lamp itself at its far end.
/// Mutation: `offset_origin` with .01 in place of the error of the point.
#[test]
fn lamps_very_near_and_very_far_are_seen() {
    for height in [1e-3, 1e5] {
        for scene in by_both_traversals(&with_lamp(height, height)) {
            let floor = receiver_at(&scene, Vec3::new(1e-5, 0.5 * height.min(1.0), 2e-5), Vec3::NEG_Y);
            assert_close(mean_irradiance(&scene, &floor), irradiance_below_a_square_lamp(1.0), 0.01);
        }
    }
}

/// A lamp that lies in the very plane of the floor lights the ceiling as if the floor were not there.
///
/// Breaks: the floor hides the lamp, wholly or in stripes.
/// Mutation: shadow rays a thousandth longer than the way to the lamp.
#[test]
fn a_lamp_in_the_plane_of_a_floor_is_seen() {
    let mut desc = with_lamp(0.0, 1.0);
    desc.meshes = vec![floor(0.0, 2.0, 0), floor(0.0, 1.0, 1), ceiling(1.0, 1.0, 0)];
    for scene in by_both_traversals(&desc) {
        let ceiling = receiver_at(&scene, Vec3::new(1e-3, 0.5, 2e-3), Vec3::Y);
        assert_close(mean_irradiance(&scene, &ceiling), irradiance_below_a_square_lamp(1.0), 0.01);
    }
}

/// Point lights at distance .001 and 100,000 give `I / d²`.
///
/// Breaks: distances are clamped so that nothing divides by zero, and near lights lose their power.
/// Mutation: distances to lights taken for .01 where they are less.
#[test]
fn point_lights_very_near_and_very_far_are_seen() {
    for height in [1e-3f32, 1e5] {
        let mut desc = with_lamp(height, height);
        desc.meshes.truncate(1);
        let intensity = Rgb::splat(height * height);
        desc.point_lights = vec![PointLightDesc { position: Vec3::new(1e-5, height, 2e-5), intensity }];
        for scene in by_both_traversals(&desc) {
            let floor = receiver_at(&scene, Vec3::new(1e-5, 0.5 * height.min(1.0), 2e-5), Vec3::NEG_Y);
            assert_close(scene.direct_from_points(scene.lights(), &floor).irradiance.x.into(), 1.0, 0.005);
        }
    }
}

/// A ray with a NaN in its origin or direction, without direction, or of no length meets nothing.
///
/// Breaks: NaN hits spread through the picture; traversal that never ends.
/// Mutation: `PreparedRay::new` taking everything for a ray. Embree has its own check.
#[test]
fn rays_that_are_none_meet_nothing() {
    let rays = [
        (Vec3::splat(f32::NAN), Vec3::X),
        (Vec3::new(0.0, f32::NAN, 0.0), Vec3::NEG_Y),
        (Vec3::ZERO, Vec3::splat(f32::NAN)),
        (Vec3::ZERO, Vec3::new(1.0, f32::NAN, 0.0)),
        (Vec3::ZERO, Vec3::ZERO),
    ];
    for scene in by_both_traversals(&furnished_box()) {
        for (origin, dir) in rays {
            let ray = Ray::new(origin, dir);
            assert!(scene.intersect(&ray).is_none() && !scene.occluded(&ray), "{ray:?}");
        }
        let short = Ray { t_max: 0.0, ..Ray::new(Vec3::ZERO, Vec3::X) };
        assert!(scene.intersect(&short).is_none() && !scene.occluded(&short));
    }
}

/// Half a million segments of photons in a closed room of albedo .9: none of them escapes.
///
/// Breaks: rooms lose light at their seams, photon by photon.
/// Mutation: `offset_origin` returning `p`.
#[test]
fn closed_rooms_keep_their_photons() {
    let mut desc = lit_box();
    desc.materials[0].bsdf = Bsdf::Diffuse { albedo: Rgb::splat(0.9) };
    for scene in by_both_traversals(&desc) {
        for sampling in [DiffuseSampling::Cosine, DiffuseSampling::Uniform] {
            let settings = Settings { sampling, photons: 25_000, ..Settings::of_scene(scene.render()) };
            let (_, passes) = rendered(&scene, settings);
            let all = passes.iter().fold(Ledger::default(), |sum, pass| sum.plus(pass.photons));
            assert!(all.rays > 400_000 && all.escaped == 0, "{all:?}");
        }
    }
}
