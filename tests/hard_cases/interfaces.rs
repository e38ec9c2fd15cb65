//! Glass, water and what light does at them.

use caustica::bsdf::{Bsdf, Choice, Event, Scattering, SpecularLobe, Transport, refract};
use caustica::math::{Rgb, Rng, Stream, Vec3};
use caustica::ppm::{Ledger, PhotonPass, Planning, Render, Settings};
use caustica::scene::{Mesh, PointLightDesc, SceneDesc, SphereDesc};

use super::rooms::{by_both_traversals, dark, inward_cube, lit_box, mesh, rendered};

const IORS: [f32; 9] = [1.0, 1.33, 1.5, 2.42, 0.75, 0.4, 1e4, 1e20, f32::MAX];

/// Directions from straight on to exactly along the surface, from both sides.
fn directions() -> impl Iterator<Item = Vec3> {
    let degrees = (0..=90).map(f64::from).chain([89.9, 89.99, 89.999, 89.999_9, 89.999_999, 89.999_999_99]);
    degrees.flat_map(|degrees| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let (x, z) = (sin as f32, cos as f32);
        // The second is longer than 1 by a rounding or two.
        [1.0, -1.0].into_iter().flat_map(move |side| {
            [Vec3::new(x, 0.0, side * z), Vec3::new(0.6 * x * 1.000_000_1, 0.8 * x * 1.000_000_1, side * z)]
        })
    })
}

fn lobes(bsdf: Bsdf, wo: Vec3) -> Vec<SpecularLobe> {
    bsdf.scatter(wo, Transport::Power).specular().copied().collect()
}

/// Both materials that refract, with all that their specular lobes send on.
fn interfaces(ior: f32) -> [(Bsdf, f32); 2] {
    let fixed_weight = Bsdf::FixedWeight { color: Rgb::ONE, reflectivity: 0.2, transparency: 0.7, ior };
    [(Bsdf::Dielectric { ior }, 1.0), (fixed_weight, 0.9)]
}

fn share(lobes: &[SpecularLobe]) -> f32 {
    lobes.iter().map(|lobe| lobe.share.x).sum()
}

fn reflected(lobes: &[SpecularLobe]) -> f32 {
    lobes.iter().filter(|lobe| lobe.event == Event::Reflection).map(|lobe| lobe.share.x).sum()
}

/// Glass of any index splits light from any direction into shares that sum to 1, along unit directions; so does the course's
/// material, up to its own shares.
///
/// Breaks: the square of a sine above 1 by a rounding gives the root of a negative number; an index beyond 10²³ squares to
/// infinity or its inverse to 0, and 0/0 is a direction: NaN flies on.
///
/// Mutation: `refract` goes on where the squared cosine is NaN (the check for NaN left out); another: where it is negative.
#[test]
fn glass_of_any_index_splits_all_light() {
    for ior in IORS.into_iter().flat_map(|ior| [ior, ior.recip()]) {
        for (wo, (bsdf, all)) in directions().flat_map(|wo| interfaces(ior).map(|bsdf| (wo, bsdf))) {
            let lobes = lobes(bsdf, wo);
            assert!((share(&lobes) - all).abs() < 1e-6, "ior {ior}, {wo}: {lobes:?}");
            for lobe in &lobes {
                assert!((lobe.wi.length() - 1.0).abs() < 1e-5, "ior {ior}, {wo}: {lobe:?}");
                let crosses = lobe.event == Event::Transmission;
                assert!(!crosses || lobe.wi.z * wo.z <= 0.0, "ior {ior}, {wo}: {lobe:?}");
            }
        }
    }
}

/// Light at 89.999 ... 90 degrees is reflected whole: the reflectance tends to 1 as the cosine to 0, from either side.
///
/// Breaks: at 90 degrees Fresnel's formulas are 0/0, and water at the horizon shows black or white dots.
///
/// Mutation: `fresnel_reflectance` as the mean of both amplitudes, not of their squares.
#[test]
fn grazing_light_is_reflected_whole() {
    for ior in [1.33, 1.5, 2.42, 0.75] {
        for wo in directions().filter(|wo| wo.z.abs() < 1e-3) {
            let reflectance = reflected(&lobes(Bsdf::Dielectric { ior }, wo));
            assert!((0.0..=1.0).contains(&reflectance), "ior {ior}, {wo}: {reflectance}");
            // By how much less than all is known to first order: 2 (1 + 1/n²) n² / √(n² - 1) cosines make up for it.
            assert!(1.0 - reflectance <= 10.0 * wo.z.abs() + 1e-6, "ior {ior}, {wo}: {reflectance}");
        }
    }
}

/// An interface of index exactly 1 is not there: all light goes straight on, and eye paths do not branch.
///
/// Breaks: lobes without any share are followed, a hit point for each: memory for nothing, and roulette may choose 0/0.
///
/// Mutation: `Scattering::new` keeps lobes without a share.
#[test]
fn index_one_is_no_interface() {
    let same = Bsdf::Dielectric { ior: 1.0 };
    for wo in directions().filter(|wo| wo.z.abs() > 1e-3 && wo.is_normalized()) {
        let lobes = lobes(same, wo);
        assert!(reflected(&lobes) < 1e-5 && (share(&lobes) - 1.0).abs() < 1e-6, "{wo}: {lobes:?}");
        let through = lobes.iter().find(|lobe| lobe.event == Event::Transmission).unwrap();
        assert!((through.wi + wo).length() < 1e-5, "{wo}: {through:?}");
    }
    assert_eq!(lobes(same, Vec3::Z).len(), 1);
    assert_eq!(lobes(Bsdf::Dielectric { ior: 1.5 }, Vec3::Z).len(), 2);
}

/// A ball of any index in a room leaves finite light and a balanced ledger.
///
/// Breaks: indices below 1 turn the sides around, huge ones overflow, and one NaN ray spoils the picture or hangs the tree.
///
/// Mutation: `refract` goes on where the squared cosine is negative: NaN directions, which escape from a closed room.
#[test]
fn balls_of_any_index_keep_the_light_finite() {
    for (bsdf, _) in IORS.into_iter().flat_map(interfaces) {
        let mut desc = lit_box();
        desc.materials.push(dark("ball", bsdf));
        desc.spheres = vec![SphereDesc { center: Vec3::new(0.0, -0.5, -0.3), radius: 0.4, material: 1 }];
        (desc.film.width, desc.film.height) = (8, 8);
        for scene in by_both_traversals(&desc) {
            let settings = Settings { photons: 2000, ..Settings::of_scene(&desc.render) };
            let (render, passes) = rendered(&scene, settings);
            assert!(render.picture().pixels().iter().all(|p| p.is_finite()), "{bsdf:?}");
            let ledger = passes[1].photons;
            assert!(ledger.dropped == 0 && ledger.escaped <= 1, "{bsdf:?}: {ledger:?}");
        }
    }
}

/// The photons of one pass in a body of this index around a point light, nothing else about.
fn traced_inside(body: Mesh, ior: f32, photons: u64) -> [Ledger; 2] {
    let glass = Bsdf::Dielectric { ior };
    let light = PointLightDesc { position: Vec3::new(0.12, -0.07, 0.2), intensity: Rgb::ONE };
    let desc = SceneDesc {
        materials: vec![dark("glass", glass)],
        meshes: vec![body],
        point_lights: vec![light],
        ..lit_box()
    };
    by_both_traversals(&desc).map(|scene| {
        let settings = Settings { photons, ..Settings::of_scene(&desc.render) };
        PhotonPass::default().trace(&scene, &settings, 0).ledger
    })
}

fn outward_cube() -> Mesh {
    let inward = inward_cube(0);
    let triangles = inward.triangles.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
    Mesh { triangles, ..inward }
}

fn octahedron() -> Mesh {
    let vertices = vec![Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
    let faces = (0..8u32).map(|octant| {
        let [x, y, z] = [octant & 1, 2 + (octant >> 1 & 1), 4 + (octant >> 2)];
        if octant.count_ones() % 2 == 0 { [x, y, z] } else { [x, z, y] }
    });
    mesh(vertices, faces.collect(), 0)
}

/// In a cube of index 10 only light within 5.7 degrees of a normal comes out, `3 (1 - √(1 - 1/n²))` of all; the rest is cut
/// at the longest path and counted.
///
/// Breaks: total internal reflection holds a photon for ever: the pass hangs, or what was cut is missing from the account.
///
/// Mutation: the flux on its way at the longest path not booked in `Wavefront::follow`; another: total internal reflection loses
/// half of the power (`dielectric_lobes` mirrors a share of .5).
#[test]
fn light_trapped_in_a_cube_is_cut_and_counted() {
    const PHOTONS: u64 = 2000;
    let out = 3.0 * (1.0 - (1.0 - 0.01f64).sqrt());
    for ledger in traced_inside(outward_cube(), 10.0, PHOTONS) {
        assert!(ledger.is_balanced() && ledger.dropped == 0, "{ledger:?}");
        let noise = 4.0 * (out / PHOTONS as f64).sqrt();
        let escaped = ledger.flux.escaped.x / ledger.flux.emitted.x;
        assert!((escaped - out).abs() < noise, "{escaped} instead of {out}: {ledger:?}");
        assert!(
            ledger.flux.terminated.x > 0.95 * ledger.flux.emitted.x && ledger.terminated > PHOTONS * 95 / 100
        );
    }
}

/// Light in a diamond comes out or is cut: glass takes nothing.
///
/// Breaks: shares of reflection and refraction that do not sum to 1, or corners that swallow photons.
///
/// Mutation: `refracted` gets the share `0.9 - reflectance`: photons are absorbed.
#[test]
fn light_in_a_diamond_comes_out_or_is_cut() {
    for ledger in traced_inside(octahedron(), 2.42, 3000) {
        assert!(ledger.is_balanced(), "{ledger:?}");
        assert_eq!(ledger.escaped + ledger.terminated, ledger.emitted, "{ledger:?}");
        let flux = ledger.flux;
        let kept = (flux.escaped + flux.terminated) / flux.emitted - 1.0;
        assert!(kept.abs().max_element() < 1e-12 && ledger.escaped > ledger.emitted / 2, "{flux:?}");
        assert!((flux.absorbed / flux.emitted).abs().max_element() < 1e-6, "{flux:?}");
    }
}

/// The way back through an interface has the share of the way there, and leads back: Stokes' relations.
///
/// Breaks: reflectance taken by the wrong side's cosine: paths from the eye and photons disagree about every window.
///
/// Mutation: `fresnel_reflectance` as the mean of both amplitudes, not of their squares.
#[test]
fn interfaces_are_reciprocal() {
    for ior in [1.33, 1.5, 2.42, 0.75] {
        for (bsdf, _) in interfaces(ior) {
            for wo in directions().filter(|wo| wo.is_normalized() && wo.z.abs() > 0.02) {
                let there = lobes(bsdf, wo);
                let Some(lobe) = there.iter().find(|lobe| lobe.event == Event::Transmission) else {
                    continue;
                };
                if lobe.wi.z.abs() < 0.02 {
                    continue;
                }
                let back = lobes(bsdf, lobe.wi);
                let returned = back.iter().find(|lobe| lobe.event == Event::Transmission).unwrap();
                assert!((returned.wi - wo).length() < 1e-3, "{bsdf:?}, {wo}");
                assert!((returned.share.x - lobe.share.x).abs() < 1e-4, "{bsdf:?}, {wo}");
                assert!((returned.scale * lobe.scale - 1.0).abs() < 1e-4);
                assert!(refract(wo, ior).is_some());
            }
        }
    }
}

/// Roulette at probability 0 never chooses, at probability 1 always, for the least and the largest random number.
///
/// Breaks: `u <= p` lets a black surface scatter once in 2²⁴ times, with a factor of 0/0; `u < p` against a sum that rounds
/// below 1 lets a perfect mirror absorb.
///
/// Mutation: `Scattering::choose` by `u <= below + p`.
#[test]
fn roulette_of_certain_outcomes_is_certain() {
    let numbers = [0.0, 0.5, 1.0 - f32::EPSILON / 2.0];
    let wo = Vec3::new(0.6, 0.0, 0.8);
    let chosen = |bsdf: Bsdf, u| bsdf.scatter(wo, Transport::Power).choose(u);
    for u in numbers {
        assert_eq!(chosen(Bsdf::Diffuse { albedo: Rgb::ZERO }, u), None);
        assert_eq!(chosen(Bsdf::Mirror { reflectance: Rgb::ZERO }, u), None);
        assert_eq!(chosen(Bsdf::Diffuse { albedo: Rgb::ONE }, u), Some(Choice::Diffuse { factor: Rgb::ONE }));
        let mirrored = chosen(Bsdf::Mirror { reflectance: Rgb::ONE }, u);
        assert!(matches!(mirrored, Some(Choice::Specular { factor: Rgb::ONE, .. })), "{mirrored:?}");
        assert_eq!(Scattering::diffuse(Rgb::ZERO).choose_any(u), None);
        assert!(chosen(Bsdf::Dielectric { ior: 1.5 }, u).is_some());
    }
    let mut rng = Rng::new(1, Stream::Test, 0, 0);
    let grazing = directions().filter(|wo| wo.z != 0.0).collect::<Vec<_>>();
    for wo in grazing.iter().cycle().take(100_000) {
        assert!(
            Bsdf::Dielectric { ior: 1.33 }.scatter(*wo, Transport::Power).choose(rng.next_f32()).is_some()
        );
    }
}

/// A black room takes every photon where it arrives: one ray each, nothing stored, nothing flies on.
///
/// Breaks: roulette with a least probability of survival keeps photons of no power alive.
///
/// Mutation: `diffuse_bounce::bounce` chooses by `0 <= p`: photons fly on with a factor of 0/0.
#[test]
fn black_rooms_end_every_path_at_once() {
    let mut desc = lit_box();
    desc.materials[0].bsdf = Bsdf::Diffuse { albedo: Rgb::ZERO };
    for scene in by_both_traversals(&desc) {
        let settings = Settings { planning: Planning::Everything, ..Settings::of_scene(&desc.render) };
        let ledger = Render::new(&scene, settings).pass().photons;
        assert!(ledger.is_balanced());
        let n = settings.photons;
        assert_eq!((ledger.absorbed, ledger.rays, ledger.deposited), (n, n, 0), "{ledger:?}");
        assert_eq!(ledger.flux.absorbed, ledger.flux.emitted);
    }
}
