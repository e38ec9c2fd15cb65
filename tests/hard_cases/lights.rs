//! Lights where they should not be, and none at all.

use std::fs;

use assert_cmd::Command;
use caustica::bsdf::{Bsdf, DiffuseSampling};
use caustica::film::Image;
use caustica::light::{Light, Lights};
use caustica::math::{DVec3, Rgb, Rng, Stream, Vec3};
use caustica::ppm::{PassStatistics, Planning, Settings};
use caustica::scene::{Material, PointLightDesc, SceneDesc, SphereDesc};

use super::rooms::{GLASS, GREY, by_both_traversals, dark, floor, lit_box, quad, rendered};

fn settings(desc: &SceneDesc) -> Settings {
    Settings::of_scene(&desc.render)
}

/// Pictures by both traversals, with the last pass of each.
fn pictures(desc: &SceneDesc) -> [(Image, PassStatistics); 2] {
    pictures_by(desc, settings(desc))
}

fn pictures_by(desc: &SceneDesc, settings: Settings) -> [(Image, PassStatistics); 2] {
    by_both_traversals(desc).map(|scene| {
        let (render, mut passes) = rendered(&scene, settings);
        (render.picture(), passes.pop().unwrap())
    })
}

fn mean(image: &Image) -> f64 {
    let sum: DVec3 = image.pixels().iter().map(|p| p.as_dvec3()).sum();
    sum.element_sum() / (3 * image.pixels().len()) as f64
}

fn is_black(image: &Image) -> bool {
    image.pixels().iter().all(|p| *p == Rgb::ZERO)
}

fn point_light(position: Vec3) -> PointLightDesc {
    PointLightDesc { position, intensity: Rgb::ONE }
}

/// A light without power changes nothing beside one that has some, be it a point or an area.
///
/// Breaks: the selection divides 0 by 0 and sends photons of NaN, or wastes photons on lights that bring nothing.
///
/// Mutation: lights of zero flux taken over by `Lights::new` (`>= 0.0`): one more light is counted.
#[test]
fn lights_without_power_are_skipped() {
    let bright = lit_box();
    let mut with_dark = bright.clone();
    let black = PointLightDesc { position: Vec3::ZERO, intensity: Rgb::ZERO };
    with_dark.point_lights.splice(0..0, [black, black]);
    with_dark.point_lights.push(black);
    for (expected, found) in by_both_traversals(&bright).iter().zip(&by_both_traversals(&with_dark)) {
        assert_eq!(found.lights().len(), 1);
        let [expected, found] = [expected, found].map(|scene| rendered(scene, settings(&bright)).0.picture());
        assert_eq!(expected, found);
    }
}

/// With no light but those of zero power nothing is emitted, and the picture is black.
///
/// Breaks: every photon is drawn from an empty or all-zero distribution: an index out of range, or NaN everywhere.
///
/// Mutation: lights of zero flux taken over by `Lights::new` (`>= 0.0`): photons are emitted and dropped.
#[test]
fn only_lights_without_power_emit_nothing() {
    let mut desc = lit_box();
    desc.point_lights = vec![PointLightDesc { position: Vec3::ZERO, intensity: Rgb::ZERO }; 2];
    for (picture, pass) in pictures(&desc) {
        assert!(is_black(&picture));
        assert_eq!((pass.photons.emitted, pass.photons.dropped, pass.photons.rays), (0, 0, 0));
    }
}

/// A scene file without any light renders to a black picture, with a warning and exit code 0.
///
/// Breaks: the program stops with an error, or writes a picture of NaN, or says nothing.
///
/// Mutation: `warn_of_darkness` not called by the loader: no warning.
#[test]
fn scene_without_light_is_black_with_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let [scene, picture] = ["dark.toml", "dark.exr"].map(|name| folder.path().join(name));
    fs::write(
        &scene,
        "[film]\nwidth = 8\nheight = 8\n\
         [camera]\nposition = [0, 1, 3]\nlook_at = [0, 0, 0]\nup = [0, 1, 0]\nfov = 50\n\
         [material.grey]\ndiffuse = { albedo = [0.5, 0.5, 0.5] }\n\
         [[sphere]]\ncenter = [0, 0, 0]\nradius = 1\nmaterial = \"grey\"\n",
    )
    .unwrap();
    for traversal in ["embree", "custom"] {
        let output = Command::cargo_bin("caustica")
            .unwrap()
            .args(["render".as_ref(), scene.as_os_str(), "-o".as_ref(), picture.as_os_str()])
            .args(["--passes", "2", "--traversal", traversal])
            .output()
            .unwrap();
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success() && told.contains("no light that shines"), "{told}");
        assert!(is_black(&caustica::output::read_exr(&picture).unwrap()));
    }
}

/// Photons leave every light in proportion to its flux, and together they carry the flux of all.
///
/// Breaks: a light chosen by its number or its area, without the probability in the power, is too bright or too dark.
///
/// Mutation: `flux / p` without `/ p` in `Sources::set`; in another run, in `Lights::sample_emission`.
#[test]
fn every_light_sends_its_flux() {
    const N: u32 = 100_000;
    let point = |x: f32, intensity| Light::Point { position: Vec3::X * x, intensity };
    let sources = [point(1.0, Rgb::ONE), point(2.0, Rgb::new(6.0, 3.0, 0.0)), point(3.0, Rgb::splat(12.0))];
    let lights = Lights::new(sources.clone());
    let mut rng = Rng::new(1, Stream::Test, 0, 0);
    let mut flux = [DVec3::ZERO; 3];
    for _ in 0..N {
        let photon = lights.sample_emission(&mut rng).unwrap();
        flux[photon.origin.x as usize - 1] += photon.power.as_dvec3() / f64::from(N);
    }
    for (found, light) in flux.iter().zip(&sources) {
        let expected = light.flux().as_dvec3();
        assert!(
            (found - expected).abs().max_element() < 0.02 * expected.max_element(),
            "{found} of {expected}"
        );
    }
    let mut desc = lit_box();
    desc.point_lights = vec![
        PointLightDesc { intensity: Rgb::new(0.5, 0.1, 0.0), ..desc.point_lights[0] },
        PointLightDesc { intensity: Rgb::new(0.0, 2.0, 1.0), ..desc.point_lights[0] },
    ];
    for scene in by_both_traversals(&desc) {
        let (_, passes) = rendered(&scene, settings(&desc));
        let emitted = passes[0].photons.flux.emitted / passes[0].photons.emitted as f64;
        let relative = (emitted / scene.lights().flux().as_dvec3() - 1.0).abs();
        assert!(relative.max_element() < 0.03, "{emitted} of {}", scene.lights().flux());
    }
}

/// Of two lights whose fluxes are as 1 to 10¹² the faint one gets no more photons than its share, and every photon carries
/// the flux of both.
///
/// Breaks: random numbers of 24 bits choose it every 2²⁴ times, sixty thousand times too often: fireflies of the whole flux.
///
/// Mutation: the fine number left out of `light::selection::choice`.
#[test]
fn lights_as_one_to_a_trillion_share_photons_fairly() {
    // The paths below draw 0 first, which 24 bits take for the faint light.
    const FIRST_DRAW_0: [u64; 6] = [1_579_993, 7_205_156, 19_487_750, 31_069_240, 34_520_621, 39_078_722];
    let rng = |index| Rng::new(3, Stream::Test, 0, index);
    let faint = Light::Point { position: Vec3::X, intensity: Rgb::ONE };
    let bright = Light::Point { position: Vec3::ZERO, intensity: Rgb::splat(1e12) };
    for index in FIRST_DRAW_0 {
        assert_eq!(rng(index).next_f32(), 0.0);
        let photon = Lights::new([faint.clone(), bright.clone()]).sample_emission(&mut rng(index)).unwrap();
        assert_eq!(photon.origin, Vec3::ZERO, "2⁻²⁴ is far more than the faint light's share");
        assert!((photon.power / bright.flux() - 1.0).abs().max_element() < 1e-6);
    }
    let mut desc = lit_box();
    desc.point_lights[0].intensity = Rgb::splat(1e12);
    desc.point_lights.insert(0, point_light(Vec3::splat(0.5)));
    for (picture, pass) in pictures(&desc) {
        let flux = pass.photons.flux.emitted.x / pass.photons.emitted as f64;
        assert!((flux / f64::from(bright.flux().x) - 1.0).abs() < 1e-6, "{flux}");
        assert!(picture.pixels().iter().all(|p| p.is_finite()));
    }
}

/// A point light that lies exactly on the floor lights the ceiling like one a hair above it.
///
/// Breaks: shadow rays that reach all the way find the floor at their end and leave the ceiling black, or nothing is ever
/// hit, since intersections at the distance 0 are anybody's guess.
///
/// Mutation: `target_error` of point lights set to -1e-3, so that shadow rays end behind the light.
#[test]
fn point_light_on_the_floor_lights_the_ceiling() {
    let mut desc = lit_box();
    desc.camera.look_at = Vec3::new(0.0, 1.0, -0.2);
    desc.camera.position = Vec3::new(0.0, 0.0, 0.3);
    let mut lit_from = |y: f32| {
        desc.point_lights[0].position = Vec3::new(0.2, y, 0.1);
        by_both_traversals(&desc).map(|scene| {
            let (render, passes) = rendered(&scene, settings(&desc));
            assert!(render.picture().pixels().iter().all(|p| p.is_finite()));
            (mean(&render.direct_picture()), passes[0].photons.flux)
        })
    };
    for ((on, flux), (above, _)) in lit_from(-1.0).into_iter().zip(lit_from(-0.998)) {
        assert!((on / above - 1.0).abs() < 0.01, "{on} of {above}");
        // Half of the photons start downward, where nothing is.
        assert!(flux.escaped.x < 0.51 * flux.emitted.x);
    }
}

/// A light outside a closed room lights none of it, however thin the walls are.
///
/// Breaks: photons on the far side of a wall, within the radius of what is seen, are counted: light leaks in.
///
/// Mutation: `LaneFacets::responses` lets every photon be seen (`seen = Mask::MAX`).
#[test]
fn light_outside_a_closed_room_leaves_it_black() {
    let mut desc = lit_box();
    desc.materials.push(dark("mirror", super::rooms::MIRROR));
    // Sends light back onto the outer sides, so that photons are stored there.
    desc.meshes.push(quad(
        [
            Vec3::new(9.0, 3.0, 9.0),
            Vec3::new(9.0, 3.0, -9.0),
            Vec3::new(-9.0, 3.0, -9.0),
            Vec3::new(-9.0, 3.0, 9.0),
        ],
        1,
    ));
    desc.point_lights = vec![point_light(Vec3::new(0.0, 2.0, 0.0))];
    desc.camera.look_at = Vec3::Y;
    desc.camera.position = Vec3::new(0.0, 0.0, 0.3);
    // A plan would leave the light out.
    let settings = Settings { planning: Planning::Everything, ..settings(&desc) };
    for (picture, pass) in pictures_by(&desc, settings) {
        assert!(is_black(&picture) && pass.gathered == 0);
        assert!(pass.rejected_by_side > 100 && pass.photons.deposited > 100, "{pass:?}");
    }
}

/// Lights behind the floor, behind the camera's back, or turned away from all there is leave a black picture.
///
/// Breaks: floors lit through their backs, or a lamp that shines to both sides.
///
/// Mutation: shadow rays and `Light::Triangle` take all cosines without their signs.
#[test]
fn lights_behind_everything_bring_nothing() {
    let mut below = lit_box();
    (below.meshes, below.camera.position) = (vec![floor(-1.0, 1.0, 0)], Vec3::new(0.0, 0.5, 0.9));
    below.point_lights = vec![point_light(Vec3::new(0.2, -1.5, 0.1))];
    let mut turned_away = below.clone();
    turned_away.point_lights.clear();
    turned_away.materials.push(Material::plain("lamp", GREY, Rgb::ONE));
    turned_away.meshes.push(floor(1.5, 0.5, 1));
    for desc in [below, turned_away] {
        for (picture, pass) in pictures(&desc) {
            assert!(is_black(&picture));
            assert_eq!((pass.gathered, pass.photons.deposited), (0, 0));
            assert!(pass.photons.escaped > 0 && pass.photons.emitted == 20_000);
        }
    }
}

/// A lamp of clear glass around a light lights the room as the bare light does: its rays meet the glass at right angles.
///
/// Breaks: glass is opaque to shadow rays, so whoever skips photons at their first diffuse surface loses all the light; whoever
/// keeps all of them has the bare light's twice.
///
/// Mutation: photons stored from their second bounce on alone (`draws.segment > 3` in place of `is_first_flight`).
#[test]
fn light_in_a_glass_bulb_lights_the_room() {
    let bare = lit_box();
    let mut lamp = bare.clone();
    lamp.materials.push(dark("glass", GLASS));
    lamp.spheres = vec![SphereDesc { center: bare.point_lights[0].position, radius: 0.1, material: 1 }];
    for ((bare, _), (lamp, pass)) in pictures(&bare).into_iter().zip(pictures(&lamp)) {
        let [lamp, bare] = [mean(&lamp), mean(&bare)];
        assert!((lamp / bare - 1.0).abs() < 0.04, "{lamp} instead of {bare}");
        assert!(pass.photons.flux.escaped.x < 1e-3 * pass.photons.flux.emitted.x);
    }
}

/// Light in an opaque bulb stays in it: the room is black, and the bulb absorbs all.
///
/// Breaks: photons that start their next ray on the wrong side of the surface leak out, one after the other.
///
/// Mutation: bounced rays begin below the surface (`-side` in the offset of `diffuse_bounce::bounce`).
#[test]
fn light_in_an_opaque_bulb_stays_there() {
    let mut desc = lit_box();
    desc.materials.push(dark("paint", Bsdf::Diffuse { albedo: Rgb::splat(0.9) }));
    desc.spheres = vec![SphereDesc { center: desc.point_lights[0].position, radius: 0.1, material: 1 }];
    for sampling in [DiffuseSampling::Cosine, DiffuseSampling::Uniform] {
        for scene in by_both_traversals(&desc) {
            let (render, passes) = rendered(&scene, Settings { sampling, ..settings(&desc) });
            assert!(is_black(&render.picture()));
            let ledger = passes[1].photons;
            assert_eq!((ledger.absorbed, ledger.escaped), (ledger.emitted, 0));
            let taken = ledger.flux.absorbed / (ledger.flux.emitted + ledger.flux.roulette) - 1.0;
            assert!(taken.abs().max_element() < 1e-12, "{:?}", ledger.flux);
            assert!(ledger.deposited > 5 * ledger.emitted);
        }
    }
}
