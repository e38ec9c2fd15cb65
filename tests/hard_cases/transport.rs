//! Photons on their way: what is dropped, what is stored where, and whom it reaches.

use caustica::bsdf::{Bsdf, DiffuseSampling};
use caustica::effects::PathClass;
use caustica::math::{Rgb, Vec3};
use caustica::ppm::{Ledger, PassStatistics, PhotonPass, Planning, Render, Settings};
use caustica::scene::{Mesh, PointLightDesc, SceneDesc, SphereDesc};

use super::rooms::{
    GLASS, GREY, by_both_traversals, dark, floor, inward_cube, lit_box, mesh, quad, rendered,
};

const SAMPLINGS: [DiffuseSampling; 2] = [DiffuseSampling::Cosine, DiffuseSampling::Uniform];

/// The photons of a pass by both traversals and both samplings.
fn ledgers(desc: &SceneDesc) -> Vec<Ledger> {
    let scenes = by_both_traversals(desc);
    let ledger = |(scene, sampling)| {
        let settings = Settings { sampling, ..Settings::of_scene(&desc.render) };
        PhotonPass::default().trace(scene, &settings, 0).ledger
    };
    scenes.iter().flat_map(|scene| SAMPLINGS.map(|sampling| (scene, sampling))).map(ledger).collect()
}

/// A photon whose power turns into NaN is dropped and counted; the others go on, and the picture knows nothing of it.
///
/// Breaks: NaN is carried on and poisons every hit point that it reaches, or the pass never ends, since NaN is below no
/// threshold.
///
/// Mutation: `DiffuseBounce` pushes photons on without asking whether they are finite.
#[test]
fn photons_of_nan_are_dropped_and_counted() {
    let mut desc = lit_box();
    desc.materials.push(dark("poison", Bsdf::Diffuse { albedo: Rgb::new(0.8, f32::NAN, 0.8) }));
    // Behind the camera.
    desc.spheres = vec![SphereDesc { center: Vec3::new(0.3, 0.6, 0.95), radius: 0.2, material: 1 }];
    for scene in by_both_traversals(&desc) {
        for sampling in SAMPLINGS {
            let settings = Settings { sampling, ..Settings::of_scene(&desc.render) };
            let (render, passes) = rendered(&scene, settings);
            let ledger = passes[1].photons;
            assert!(ledger.dropped > 100 && ledger.emitted == 20_000, "{ledger:?}");
            assert!(ledger.flux.dropped.x > 0.0 && ledger.flux.absorbed.is_finite(), "{ledger:?}");
            assert!(render.picture().pixels().iter().all(|p| p.is_finite()));
        }
    }
}

/// A photon that a surface leaves black is dropped and counted: red light on green walls.
///
/// Breaks: photons of no power fly on, are stored, and shrink radii without bringing light.
///
/// Mutation: `LaneFlights::have_power` holds for all.
#[test]
fn black_photons_are_dropped_and_counted() {
    let mut desc = lit_box();
    desc.materials[0].bsdf = Bsdf::Diffuse { albedo: Rgb::new(0.0, 0.5, 0.0) };
    desc.point_lights[0].intensity = Rgb::X;
    for ledger in ledgers(&desc) {
        assert!(ledger.is_balanced(), "{ledger:?}");
        assert_eq!(ledger.absorbed + ledger.dropped, 20_000);
        assert!(ledger.dropped > 9000 && ledger.deposited == 0 && ledger.rays == 20_000, "{ledger:?}");
        assert_eq!(ledger.flux.absorbed, ledger.flux.emitted, "nothing is lost with them");
    }
}

/// Photons of endless power, and of none that is a number, are dropped as they leave the light, and counted as emitted.
///
/// Breaks: infinity over infinity in the choice of the light, and a pass of NaN that never ends.
///
/// Mutation: `Emission` pushes photons without asking whether they are finite.
#[test]
fn photons_of_endless_power_are_dropped_at_the_light() {
    let mut one = lit_box();
    one.point_lights[0].intensity = Rgb::splat(f32::MAX);
    // Each has a flux, but not the sum of both, which every photon carries.
    let mut two = lit_box();
    two.point_lights[0].intensity = 2e37 * Rgb::X;
    two.point_lights.push(two.point_lights[0]);
    for ledger in [one, two].iter().flat_map(ledgers) {
        assert_eq!((ledger.emitted, ledger.dropped, ledger.rays), (20_000, 20_000, 0), "{ledger:?}");
        assert!(ledger.is_balanced());
    }
}

/// Lights, sizes and samplings of all kinds: every account of photons and flux is even.
///
/// Breaks: power that is forgotten at a mirror, a corner or a colour shows in no picture that one could hold it against.
///
/// Mutation: specular photons carry a tenth more on; in another run, `LaneFlux::escape` books nothing.
#[test]
fn every_account_is_even() {
    let balls = [
        Bsdf::Mirror { reflectance: Rgb::new(0.9, 0.6, 0.3) },
        Bsdf::Dielectric { ior: 1.5 },
        Bsdf::FixedWeight { color: Rgb::new(0.2, 0.9, 0.6), reflectivity: 0.3, transparency: 0.3, ior: 1.33 },
        Bsdf::Diffuse { albedo: Rgb::new(0.9, 0.5, 0.1) },
    ];
    for (bsdf, open) in balls.into_iter().flat_map(|bsdf| [(bsdf, false), (bsdf, true)]) {
        let mut desc = lit_box();
        desc.materials.push(dark("ball", bsdf));
        desc.spheres = vec![SphereDesc { center: Vec3::new(0.0, -0.2, 0.0), radius: 0.5, material: 1 }];
        desc.point_lights
            .push(PointLightDesc { position: Vec3::splat(-0.7), intensity: Rgb::new(3.0, 0.0, 0.5) });
        if open {
            desc.meshes[0].triangles.truncate(8);
            desc.meshes[0].materials.truncate(8);
        }
        desc.render.photons = 50_000;
        for ledger in ledgers(&desc) {
            assert!(ledger.is_balanced() && ledger.flux.imbalance() < 1e-12, "{bsdf:?}: {ledger:?}");
            assert_eq!(ledger.escaped > 1000, open, "{ledger:?}");
            let roulette = (ledger.flux.roulette / ledger.flux.emitted).abs().max_element();
            assert!(roulette > 0.0 && roulette < 0.03, "{bsdf:?}: {ledger:?}");
            assert_eq!(ledger.flux.shading, caustica::math::DVec3::ZERO);
        }
    }
}

/// Where shading normals lean away from the surface, what they add and take is booked apart, and the account is even.
///
/// Breaks: corrections for smooth normals create or destroy light, and nobody knows how much.
///
/// Mutation: `FluxLedger::correct` not called for specular photons.
#[test]
fn corrections_for_shading_normals_are_booked() {
    for bsdf in [GREY, Bsdf::Mirror { reflectance: Rgb::splat(0.9) }, GLASS] {
        let mut desc = lit_box();
        desc.materials.push(dark("smooth", bsdf));
        desc.meshes.push(leaning_cube());
        desc.render.photons = 50_000;
        for ledger in ledgers(&desc) {
            assert!(ledger.is_balanced() && ledger.flux.imbalance() < 1e-12, "{bsdf:?}: {ledger:?}");
            assert!(ledger.flux.shading.x.abs() > 1e-3 * ledger.flux.emitted.x, "{bsdf:?}: {ledger:?}");
        }
    }
}

/// A small cube whose normals are those of a ball.
fn leaning_cube() -> Mesh {
    let inward = inward_cube(1);
    let normals = inward.vertices.iter().map(|v| v.normalize()).collect();
    let triangles = inward.triangles.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
    let vertices = inward.vertices.iter().map(|v| 0.4 * *v - Vec3::new(0.0, 0.4, 0.2)).collect();
    Mesh { vertices, triangles, normals: Some(normals), uvs: None, ..inward }
}

/// A floor at y = 0 seen from above through a large radius, and a light in a bulb of glass, so that its photons are stored
/// wherever they arrive.
fn watched_floor(light: Vec3, others: Vec<Mesh>) -> SceneDesc {
    let mut desc = lit_box();
    desc.camera.position = Vec3::new(-0.6, 0.8, 0.1);
    desc.camera.look_at = Vec3::new(-0.5, 0.0, 0.0);
    desc.camera.fov_degrees = 50.0;
    desc.render.radius = Some(0.5);
    // Nothing bounces, so that whatever reaches the floor was counted where it should not have been.
    desc.materials[0].bsdf = Bsdf::Diffuse { albedo: Rgb::splat(1e-6) };
    desc.materials.push(dark("glass", GLASS));
    desc.meshes = others;
    desc.meshes.push(floor(0.0, 1.0, 0));
    desc.spheres = vec![SphereDesc { center: light, radius: 0.05, material: 1 }];
    desc.point_lights = vec![PointLightDesc { position: light, intensity: Rgb::ONE }];
    desc
}

fn assert_nothing_is_counted(desc: &SceneDesc) {
    let settings = Settings::of_scene(&desc.render);
    for scene in by_both_traversals(desc) {
        let (render, passes) = rendered(&scene, settings);
        let found = |pass: &PassStatistics| (pass.gathered, pass.rejected_by_side > 1000);
        assert!(passes.iter().all(|pass| found(pass) == (0, true)), "{passes:?}");
        let mut states = PathClass::ALL.into_iter().flat_map(|class| render.states(class));
        assert!(states.all(|state| state.radius2 == 0.25 && state.photons == 0.0));
    }
}

/// Photons on the lower side of a thin floor count nothing above it.
///
/// Breaks: both sides of a sheet lie within any radius: light leaks through paper, blinds and floors.
///
/// Mutation: `LaneFacets::responses` lets every photon be seen (`seen = Mask::MAX`).
#[test]
fn photons_below_a_thin_floor_count_nothing() {
    assert_nothing_is_counted(&watched_floor(Vec3::new(-0.5, -0.5, 0.0), vec![]));
}

/// Photons on the back of a wall, on the other side of which the floor ends, count nothing on that floor.
///
/// Breaks: a wall seen edge on is within the radius of the floor before it: its light bleeds around the corner.
///
/// Mutation: `MIN_NORMAL_COSINE` -2: the wall's photons are taken for the floor's.
#[test]
fn photons_around_a_corner_count_nothing() {
    let wall = quad(
        [
            Vec3::new(0.0, -3.0, 9.0),
            Vec3::new(0.0, -3.0, -9.0),
            Vec3::new(0.0, 3.0, -9.0),
            Vec3::new(0.0, 3.0, 9.0),
        ],
        0,
    );
    let mut desc = watched_floor(Vec3::new(0.8, 0.6, 0.0), vec![wall]);
    // Only the part before the wall, so that no light comes from the right of it.
    let left = [
        Vec3::new(-1.0, 0.0, 1.0),
        Vec3::new(0.0, 0.0, 1.0),
        Vec3::new(0.0, 0.0, -1.0),
        Vec3::new(-1.0, 0.0, -1.0),
    ];
    *desc.meshes.last_mut().unwrap() = quad(left, 0);
    assert_nothing_is_counted(&desc);
}

/// Photons on the ceiling of the room below, a hand's breadth under the floor, count nothing on it.
///
/// Breaks: a radius larger than a wall is thick gathers the next room's light.
///
/// Mutation: `LaneFacets::responses` lets every photon be seen (`seen = Mask::MAX`).
#[test]
fn photons_on_the_wall_behind_count_nothing() {
    let mut ceiling = floor(-0.1, 1.0, 0);
    ceiling.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    assert_nothing_is_counted(&watched_floor(Vec3::new(-0.5, -0.6, 0.0), vec![ceiling]));
}

/// A pass of more bounces than any path has ends, for an open mirror box as for a closed one.
///
/// Breaks: two mirrors face to face hold a photon for ever.
///
/// Mutation: `terminated` not counted in `Wavefront::follow`.
#[test]
fn mirrors_face_to_face_do_not_hang() {
    let mut desc = lit_box();
    desc.materials[0].bsdf = Bsdf::Mirror { reflectance: Rgb::ONE };
    desc.meshes.push(mesh(vec![Vec3::splat(0.01), Vec3::X * 0.01, Vec3::Y * 0.01], vec![[0, 1, 2]], 0));
    for scene in by_both_traversals(&desc) {
        let planning = Planning::Everything;
        let settings = Settings { photons: 500, planning, ..Settings::of_scene(&desc.render) };
        let ledger = Render::new(&scene, settings).pass().photons;
        assert!(ledger.is_balanced() && ledger.terminated + ledger.escaped == 500, "{ledger:?}");
        assert!(ledger.terminated > 490, "{ledger:?}");
        assert!(
            (ledger.flux.terminated + ledger.flux.escaped - ledger.flux.emitted).abs().max_element() == 0.0
        );
    }
}
