//! Photons aimed at glass bring the caustics that natural photons bring, and bring them sooner.
#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

mod common;

use caustica::effects::PathClass;
use caustica::math::mean;
use caustica::ppm::{
    Aiming, Kinds, Ledger, Mixture, PhotonBudget, PhotonPass, RadiusPolicy, Render, Settings,
};
use caustica::scene::Scene;
use common::{mean_and_error, scene_of};

/// A glass ball of a twentieth of its room and a ball of the course's material under a lamp and a point: each gets some 4e-4
/// of the light.
const ROOM: &str = r#"
[film]
width = 24
height = 24
[camera]
position = [3, 5, 4]
look_at = [0, 0, 0]
fov = 60
[render]
radius = 0.25
depth = 6
[material.grey]
diffuse = { albedo = [0.06, 0.05, 0.04] } # so that indirect light is not most of the noise
[material.glass]
dielectric = { ior = 1.5 }
[material.half]
fixed_weight = { color = [0.6, 0.6, 0.7], reflectivity = 0.2, transparency = 0.5, ior = 1.33 }
[material.lamp]
diffuse = { albedo = [0, 0, 0] }
emission = [50, 50, 40]
[[point_light]]
position = [1, 18, 1]
intensity = [300, 300, 300]
[[sphere]]
center = [0, 1, 0]
radius = 0.5
material = "glass"
[[sphere]]
center = [-1.5, 0.5, 1]
radius = 0.4
material = "half"
[[quad]]
corners = [[-1, 19.9, -1], [1, 19.9, -1], [1, 19.9, 1], [-1, 19.9, 1]]
material = "lamp"
[[quad]]
corners = [[-10, 0, -10], [-10, 0, 10], [10, 0, 10], [10, 0, -10]]
material = "grey"
[[quad]]
corners = [[-10, 20, -10], [10, 20, -10], [10, 20, 10], [-10, 20, 10]]
material = "grey"
[[quad]]
corners = [[-10, 0, -10], [10, 0, -10], [10, 20, -10], [-10, 20, -10]]
material = "grey"
"#;

fn settings(scene: &Scene, photons: u64, aiming: Aiming) -> Settings {
    let policy = RadiusPolicy::Fixed;
    Settings {
        photons,
        samples: 1,
        policy,
        caustic_photons: aiming,
        eye_seed: Some(1),
        ..Settings::of_scene(scene.render())
    }
}

/// The mean brightness of a layer in renders of some passes.
fn brightness(scene: &Scene, settings: Settings, class: PathClass, renders: u64) -> Vec<f64> {
    let one = |seed| {
        let mut render = Render::new(scene, Settings { seed, kinds: Kinds::Apart, ..settings });
        for _ in 0..2 {
            let pass = render.pass();
            assert!(pass.photons.is_balanced() && pass.aimed_photons.is_balanced(), "{pass:?}");
        }
        let layer = render.layer(class).unwrap();
        layer.pixels().iter().map(|&pixel| f64::from(mean(pixel))).sum::<f64>()
    };
    (0..renders).map(one).collect()
}

#[test]
fn aimed_photons_bring_the_same_caustics_with_less_noise() {
    let scene = scene_of(ROOM);
    let of = |aiming, photons, renders| {
        mean_and_error(&brightness(&scene, settings(&scene, photons, aiming), PathClass::Caustic, renders))
    };
    let (natural, natural_error) = of(Aiming::Photons(0), 200_000, 40);
    for aimed in [25_000, 100_000, 180_000] {
        let (mixed, mixed_error) = of(Aiming::Photons(aimed), 200_000, 40);
        let off = (mixed - natural) / natural_error.hypot(mixed_error);
        assert!(off.abs() < 4.0, "{aimed}: {mixed} ± {mixed_error} instead of {natural} ± {natural_error}");
        let less = (natural_error / mixed_error).powi(2);
        assert!(less > 20.0, "{aimed}: variance is {less} times less");
    }
}

/// They come from natural photons alone, of which there are fewer.
#[test]
fn indirect_light_stays() {
    let scene = scene_of(ROOM);
    let of = |aiming| {
        mean_and_error(&brightness(&scene, settings(&scene, 50_000, aiming), PathClass::Indirect, 16))
    };
    let ((natural, natural_error), (mixed, mixed_error)) =
        (of(Aiming::Photons(0)), of(Aiming::Photons(25_000)));
    let off = (mixed - natural) / natural_error.hypot(mixed_error);
    assert!(off.abs() < 4.0, "{mixed} ± {mixed_error} instead of {natural} ± {natural_error}");
}

/// Byte for byte.
#[test]
fn without_aimed_photons_nothing_changes() {
    let scene = scene_of(ROOM);
    let settings = settings(&scene, 20_000, Aiming::Photons(0));
    let batch = PhotonPass::default().trace(&scene, &settings, 3).clone();
    let mut pass = PhotonPass::default();
    let mixed = pass.trace_mixed(&scene, &settings, 3, None);
    assert!(mixed.photons().eq(batch.photons()) && mixed.ledger == batch.ledger);
    assert_eq!(mixed.aimed, Ledger::default());
    assert!(Render::new(&scene, settings).setup().aim.is_none());
}

/// The natural photons of a mixture fly as they do alone: only what caustics weigh differs.
#[test]
fn natural_photons_fly_as_ever() {
    let scene = scene_of(ROOM);
    let settings = settings(&scene, 20_480, Aiming::Photons(0));
    let alone = PhotonPass::default().trace(&scene, &settings, 3).clone();
    let aim = caustica::light::Aim::new(scene.lights(), &scene.casters()).unwrap();
    let budget = PhotonBudget { natural: 20_480, aimed: 5000 };
    let mut pass = PhotonPass::default();
    let mixed = pass.trace_mixed(&scene, &settings, 3, Some(&Mixture { aim, budget }));
    assert_eq!(mixed.ledger, alone.ledger);
    assert!(mixed.of(PathClass::Indirect).iter().eq(alone.of(PathClass::Indirect).iter()));
    let both = mixed.of(PathClass::Caustic);
    let caustics = alone.of(PathClass::Caustic);
    assert!(caustics.iter().count() > 10);
    for (lighter, photon) in both.iter().zip(caustics.iter()) {
        assert!(lighter.wi == photon.wi && mean(lighter.power) < 0.5 * mean(photon.power));
    }
    let aimed = &mixed.aimed;
    assert!(aimed.emitted == 5000 && aimed.deposited > 2000 && aimed.is_balanced(), "{aimed:?}");
    assert!(aimed.rays < 5 * aimed.emitted, "they end where they first bounce off grey");
}

#[test]
fn the_trial_aims_where_it_pays() {
    let scene = scene_of(ROOM);
    let render = Render::new(&scene, settings(&scene, 100_000, Aiming::Auto));
    let aim = render.setup().aim.unwrap();
    assert_eq!(aim.balls, 2);
    assert!(aim.gain.unwrap() > 1.2 && aim.budget.aimed >= 6_000, "{aim:?}");
    assert_eq!(aim.budget.natural + aim.budget.aimed, 100_000);
    let diffuse = common::scene_at("course_diffuse.toml", 16, 16);
    assert!(Render::new(&diffuse, Settings::of_scene(diffuse.render())).setup().aim.is_none());
}

/// Whatever the trial decides and the passes bring.
#[test]
fn threads_do_not_matter() {
    let scene = scene_of(ROOM);
    let rendered = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut render = Render::new(&scene, settings(&scene, 20_000, Aiming::Auto));
            (0..2).for_each(|_| assert!(render.pass().aimed_photons.emitted > 0));
            (render.setup().aim, render.picture())
        })
    };
    let expected = rendered(1);
    for threads in [2, 5] {
        assert!(rendered(threads) == expected, "{threads}");
    }
}
