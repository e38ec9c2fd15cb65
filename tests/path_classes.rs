//! Direct light, caustics and indirect light: apart and together.
#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

mod common;

use caustica::effects::{PathClass, PathClasses};
use caustica::film::Image;
use caustica::math::{Rgb, mean};
use caustica::ppm::{Aiming, Guiding, Kinds, Planning, Render, Settings};
use caustica::scene::Scene;
use common::{scene_at, settings};

/// Glass and a mirror; waves over two balls; nothing specular.
const SCENES: [&str; 3] = ["cornell_b.toml", "course_water.toml", "course_diffuse.toml"];

fn scenes() -> impl Iterator<Item = Scene> {
    SCENES.into_iter().map(|name| scene_at(name, 48, 40))
}

fn rendered<'s>(scene: &'s Scene, transport: PathClasses, planning: Planning) -> Render<'s> {
    let caustic_photons = Aiming::Photons(0);
    let (kinds, photons) = (Kinds::Apart, 20_000);
    let guiding = Guiding::Off;
    let settings =
        Settings { transport, kinds, planning, caustic_photons, guiding, photons, ..settings(scene) };
    let mut render = Render::new(scene, settings);
    (0..3).for_each(|_| assert!(render.pass().photons.is_balanced()));
    render
}

fn only(class: PathClass) -> PathClasses {
    [class].into_iter().collect()
}

fn total(image: &Image) -> f64 {
    image.pixels().iter().map(|&p| f64::from(mean(p))).sum()
}

/// Bit for bit.
#[test]
fn layers_add_up_to_the_picture() {
    for scene in scenes() {
        let render = rendered(&scene, PathClasses::ALL, Planning::Derived);
        let layers = PathClass::ALL.map(|class| render.layer(class).unwrap());
        for (k, pixel) in render.picture().pixels().iter().enumerate() {
            let sum: Rgb = layers.iter().map(|layer| layer.pixels()[k]).sum();
            assert_eq!(sum, *pixel);
        }
    }
}

/// Each kind has radii and statistics of its own: whether others are simulated makes no bit of difference, as long as no photons
/// are aimed or guided instead of others.
#[test]
fn kinds_do_not_know_of_each_other() {
    for scene in scenes() {
        let all = rendered(&scene, PathClasses::ALL, Planning::Derived);
        for class in PathClass::ALL {
            let alone = rendered(&scene, only(class), Planning::Derived);
            assert!(alone.picture() == all.layer(class).unwrap(), "{class}");
            assert!(alone.states(class) == all.states(class), "{class}");
        }
    }
}

#[test]
fn glass_and_water_make_caustics_and_walls_do_not() {
    let caustic = |scene: &Scene| {
        let render = rendered(scene, PathClasses::ALL, Planning::Everything);
        total(&render.layer(PathClass::Caustic).unwrap()) / total(&render.picture())
    };
    let [glass, water, walls] = SCENES.map(|name| caustic(&scene_at(name, 48, 40)));
    assert!(glass > 0.005 && water > 0.05 && walls == 0.0, "{glass} {water} {walls}");
}

/// What the plan leaves out brings exactly nothing: with and without it the same bytes.
#[test]
fn plans_leave_out_nothing_that_is_seen() {
    for scene in scenes() {
        let planned = rendered(&scene, PathClasses::ALL, Planning::Derived);
        let everything = rendered(&scene, PathClasses::ALL, Planning::Everything);
        assert!(planned.picture() == everything.picture());
    }
}

/// Together they share radii, apart they do not: the same light, with other noise.
#[test]
fn together_and_apart_are_the_same_light() {
    for scene in scenes() {
        let brightness = |kinds| {
            let settings = Settings { kinds, photons: 100_000, ..settings(&scene) };
            let mut render = Render::new(&scene, settings);
            (0..5).for_each(|_| drop(render.pass()));
            assert_eq!(
                render.layer(PathClass::Caustic).is_some(),
                kinds == Kinds::Apart || !scene.any_specular()
            );
            total(&render.picture())
        };
        let (together, apart) = (brightness(Kinds::Together), brightness(Kinds::Apart));
        assert!((apart / together - 1.0).abs() < 0.01, "{apart} and {together}");
    }
}

/// Direct light that is not asked for casts no shadow ray.
#[test]
fn photons_alone_need_no_shadow_rays() {
    let scene = scene_at("cornell_b.toml", 48, 40);
    for (transport, casts) in [(PathClasses::ALL.without(PathClass::Direct), false), (PathClasses::ALL, true)]
    {
        assert_eq!(rendered(&scene, transport, Planning::Derived).setup().shadow_rays > 0, casts);
    }
}
