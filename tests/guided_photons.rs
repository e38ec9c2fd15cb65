//! Guided photons bring the light that natural photons bring, and bring it sooner where that hardly arrives.
#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

mod common;

use caustica::effects::PathClass;
use caustica::math::mean;
use caustica::ppm::{Aiming, GuidePlan, Guiding, Kinds, PassStatistics, RadiusPolicy, Render, Settings};
use caustica::scene::Scene;
use common::{mean_and_error, scene_of};

/// A closed room with a glass ball and a window, a lamp and a point outside: some photons in a thousand arrive, most of them straight
/// through the window, others by the ground before it.
const KEYHOLE: &str = r#"
[film]
width = 24
height = 24
[camera]
position = [-4.5, 2.5, 0.5]
look_at = [0, 2, 0]
fov = 80
[render]
radius = 0.4
depth = 6
[material.grey]
diffuse = { albedo = [0.6, 0.5, 0.4] }
[material.glass]
dielectric = { ior = 1.5 }
[material.lamp]
diffuse = { albedo = [0, 0, 0] }
emission = [50, 50, 40]
[[point_light]]
position = [14, 9, 2]
intensity = [300, 200, 300]
[[sphere]]
center = [1, 1.5, 0]
radius = 1
material = "glass"
[[quad]]
corners = [[14, 10, -1], [15, 10, -1], [15, 10, 0], [14, 10, 0]]
material = "lamp"
[[quad]]
corners = [[-5, 0, -5], [-5, 0, 5], [30, 0, 5], [30, 0, -5]]
material = "grey"
[[quad]]
corners = [[-5, 5, -5], [5, 5, -5], [5, 5, 5], [-5, 5, 5]]
material = "grey"
[[quad]]
corners = [[-5, 0, -5], [-5, 5, -5], [-5, 5, 5], [-5, 0, 5]]
material = "grey"
[[quad]]
corners = [[-5, 0, -5], [5, 0, -5], [5, 5, -5], [-5, 5, -5]]
material = "grey"
[[quad]]
corners = [[-5, 0, 5], [-5, 5, 5], [5, 5, 5], [5, 0, 5]]
material = "grey"
[[quad]]
corners = [[5, 0, -5], [5, 0, 5], [5, 3, 5], [5, 3, -5]]
material = "grey"
[[quad]]
corners = [[5, 3, -5], [5, 3, -1], [5, 5, -1], [5, 5, -5]]
material = "grey"
[[quad]]
corners = [[5, 3, 1], [5, 3, 5], [5, 5, 5], [5, 5, 1]]
material = "grey"
"#;

fn settings(scene: &Scene, guiding: Guiding) -> Settings {
    Settings {
        photons: 40_000,
        samples: 1,
        policy: RadiusPolicy::Fixed,
        caustic_photons: Aiming::Photons(0),
        guiding,
        eye_seed: Some(1),
        ..Settings::of_scene(scene.render())
    }
}

fn plan(render: &Render) -> GuidePlan {
    render.setup().guide.unwrap()
}

/// The brightness of caustics and of indirect light in renders of two passes.
fn brightness(scene: &Scene, settings: Settings, renders: u64) -> [(f64, f64); 2] {
    let one = |seed| {
        let mut render = Render::new(scene, Settings { seed, kinds: Kinds::Apart, ..settings });
        for _ in 0..2 {
            let pass = render.pass();
            assert!(pass.photons.is_balanced() && pass.aimed_photons.is_balanced(), "{pass:?}");
        }
        [PathClass::Caustic, PathClass::Indirect].map(|class| {
            let layer = render.layer(class).unwrap();
            layer.pixels().iter().map(|&pixel| f64::from(mean(pixel))).sum::<f64>()
        })
    };
    let all: Vec<[f64; 2]> = (0..renders).map(one).collect();
    [0, 1].map(|class| mean_and_error(&all.iter().map(|of| of[class]).collect::<Vec<_>>()))
}

/// Of either kind, so each path belongs to one; with photons that are aimed at the ball as well.
#[test]
fn guided_photons_bring_the_same_light_with_less_noise() {
    let scene = scene_of(KEYHOLE);
    let natural = brightness(&scene, settings(&scene, Guiding::Off), 48);
    for aimed in [0, 10_000] {
        let mixed = Settings { caustic_photons: Aiming::Photons(aimed), ..settings(&scene, Guiding::On) };
        let guided = brightness(&scene, mixed, 32);
        for ((natural, its), (guided, theirs)) in natural.into_iter().zip(guided) {
            let off = (guided - natural) / its.hypot(theirs);
            assert!(off.abs() < 4.0, "{aimed}: {guided} ± {theirs} instead of {natural} ± {its}");
            let less = its / theirs * (48.0f64 / 32.0).sqrt();
            assert!(less > 1.5, "{aimed}: noise is {less} times less");
        }
    }
}

#[test]
fn all_photons_together_carry_what_the_lights_emit() {
    let scene = scene_of(KEYHOLE);
    let mut render = Render::new(&scene, settings(&scene, Guiding::On));
    assert!(plan(&render).share > 0.0);
    let flux = mean(scene.lights().flux());
    let emitted = |PassStatistics { photons, .. }: PassStatistics| {
        photons.flux.emitted.element_sum() / 3.0 / photons.emitted as f64
    };
    let emitted: Vec<f64> = (0..8).map(|_| emitted(render.pass()) / f64::from(flux)).collect();
    let (all, error) = mean_and_error(&emitted);
    // Every cell of starts gets as many photons as its probability says, to one.
    assert!((all - 1.0).abs() < 4.0 * error + 1e-5 && error < 1e-3, "{all} ± {error}");
}

#[test]
fn the_trial_guides_where_light_hardly_arrives() {
    let scene = scene_of(KEYHOLE);
    let render = Render::new(&scene, settings(&scene, Guiding::Auto));
    let GuidePlan { share, arriving, guided_arriving, gain, .. } = plan(&render);
    assert!(
        share > 0.0 && gain > 1.5 && arriving < 0.02 && guided_arriving > 5.0 * arriving,
        "{gain} {arriving}"
    );
    let decision = render.plan().decisions.iter().find(|decision| decision.what == "guided photons").unwrap();
    assert!(decision.on && decision.because.contains("arrive at what is seen"), "{decision:?}");
}

/// The same bytes as without the trial.
#[test]
fn where_light_arrives_nothing_changes() {
    for name in ["course_diffuse.toml", "cornell_b.toml"] {
        let scene = common::scene_at(name, 24, 24);
        let rendered = |guiding| {
            let settings = Settings { guiding, photons: 10_000, ..Settings::of_scene(scene.render()) };
            let mut render = Render::new(&scene, settings);
            let pass = render.pass();
            (render.picture(), pass.photons, pass.aimed_photons, render.setup().guide)
        };
        let ((auto, its, aimed, plan), (off, theirs, theirs_aimed, none)) =
            (rendered(Guiding::Auto), rendered(Guiding::Off));
        let plan = plan.unwrap();
        assert!(
            plan.share == 0.0 && plan.arriving > 0.002 && plan.rounds <= 4 && none.is_none(),
            "{name}: {plan:?}"
        );
        assert!(auto == off && its == theirs && aimed == theirs_aimed, "{name}");
    }
}

/// Whatever the trial decides and the passes bring, with aimed photons and without.
#[test]
fn threads_do_not_matter() {
    let scene = scene_of(KEYHOLE);
    let rendered = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let settings =
                Settings { caustic_photons: Aiming::Photons(5000), ..settings(&scene, Guiding::On) };
            let mut render = Render::new(&scene, settings);
            (0..2).for_each(|_| drop(render.pass()));
            (render.setup().guide, render.picture())
        })
    };
    let expected = rendered(1);
    assert!(expected.0.unwrap().share > 0.0);
    for threads in [2, 7] {
        assert!(rendered(threads) == expected, "{threads}");
    }
}

#[test]
fn a_render_goes_on_with_the_guide_that_it_had() {
    let scene = scene_of(KEYHOLE);
    let settings = settings(&scene, Guiding::Auto);
    let (mut whole, mut first) = (Render::new(&scene, settings), Render::new(&scene, settings));
    assert!(plan(&whole).share > 0.0);
    (0..4).for_each(|_| drop(whole.pass()));
    (0..2).for_each(|_| drop(first.pass()));
    let mut second = Render::new(&scene, settings);
    second.restore(first.state()).unwrap();
    (0..2).for_each(|_| drop(second.pass()));
    assert!(second.picture() == whole.picture());
}
