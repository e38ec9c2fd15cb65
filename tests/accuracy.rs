//! Whether a render knows its own error: bounds hold as often as they say, and forecasts come true.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a panic is how a test fails")]

mod common;

use caustica::compare::{Coverage, Estimate, Metrics, Region};
use caustica::film::Image;
use caustica::ppm::{Forecast, RadiusPolicy, Render, Settings};
use caustica::scene::Scene;
use common::{scene_at, settings};

/// The same hit points as in every other render of these tests, so that light alone differs.
const EYE_SEED: Option<u64> = Some(0);

/// Few pixels want large discs and few photons.
fn rough(scene: &Scene, radius: f64, photons: u64) -> Settings {
    let settings = settings(scene);
    Settings { radius: Some(radius), photons, seed: 1, eye_seed: EYE_SEED, error_estimates: true, ..settings }
}

/// Many times as many photons as the picture that it judges, in discs of half the radius.
fn fine(scene: &Scene, rough: &Settings) -> Image {
    let photons = 25 * rough.photons;
    let radius = rough.radius.map(|radius| 0.7 * radius);
    let settings = Settings { photons, radius, seed: 2, error_estimates: false, ..*rough };
    after(scene, settings, 30).picture()
}

fn after(scene: &Scene, settings: Settings, passes: u32) -> Render<'_> {
    let mut render = Render::new(scene, settings);
    for _ in 0..passes {
        render.pass();
    }
    render
}

/// Of all pixels and channels, the share whose true error is inside the bound.
fn coverage(render: &Render, reference: &Image, confidence: f64) -> f64 {
    let (picture, bound) = (render.picture(), render.accuracy(confidence).unwrap().layers().bound);
    let region = Region::of(&picture);
    let coverage = Coverage::of(&bound, &picture, Estimate::exact(reference), &region).unwrap();
    assert!(coverage.untrusted < 0.1, "{coverage:?}");
    coverage.share
}

fn assert_bounds_are_honest(name: &str, radius: f64, photons: u64) {
    let scene = scene_at(name, 48, 48);
    let settings = rough(&scene, radius, photons);
    let (render, reference) = (after(&scene, settings, 30), fine(&scene, &settings));
    for (confidence, allowed) in [(0.9, 0.85..=0.95), (0.5, 0.45..=0.55)] {
        let share = coverage(&render, &reference, confidence);
        eprintln!("{name}: {share:.3} within bounds of {confidence}");
        assert!(
            allowed.contains(&share),
            "{name}: {share:.3} of all errors are within the bounds of {confidence}"
        );
    }
    let metrics = Metrics::between(&render.picture(), &reference).unwrap();
    let (truth, said) = (metrics.rel_mse.sqrt(), render.accuracy(0.9).unwrap().picture().error);
    eprintln!("{name}: error {truth:.4}, estimated {said:.4}");
    assert!((said / truth - 1.0).abs() < 0.15, "{name}: the error is {truth:.4}, the estimate {said:.4}");
}

#[test]
fn bounds_hold_in_the_diffuse_box() {
    assert_bounds_are_honest("course_diffuse.toml", 5.0, 6000);
}

#[test]
fn bounds_hold_under_water() {
    assert_bounds_are_honest("course_water.toml", 5.0, 6000);
}

#[test]
fn bounds_hold_for_caustics_of_an_area_light() {
    assert_bounds_are_honest("cornell_b.toml", 12.0, 6000);
}

#[test]
fn bounds_hold_between_blocks() {
    assert_bounds_are_honest("cornell_a.toml", 20.0, 6000);
}

/// Blur alone: discs so large, and photons so many, that noise hardly matters.
#[test]
fn bias_is_found_where_discs_are_too_large() {
    let scene = scene_at("course_water.toml", 64, 64);
    let settings = Settings { policy: RadiusPolicy::Fixed, ..rough(&scene, 8.0, 300_000) };
    let render = after(&scene, settings, 5);
    let reference = after(&scene, Settings { seed: 3, ..rough(&scene, 2.0, 1_000_000) }, 4).picture();
    let (picture, layers) = (render.picture(), render.accuracy(0.9).unwrap().layers());
    let [mut products, mut squares, mut errors] = [0.0; 3];
    for pixel in 0..picture.pixels().len() {
        let error = (picture.pixels()[pixel] - reference.pixels()[pixel]).as_dvec3();
        let bias = layers.bias.pixels()[pixel].as_dvec3();
        products += error.dot(bias);
        squares += bias.dot(bias);
        errors += error.dot(error);
    }
    let correlation = products / (squares * errors).sqrt();
    assert!(correlation > 0.6, "estimated and true bias correlate by {correlation:.2}");
}

/// A fixed radius keeps its blur, however many photons come; a shrinking one does not.
#[test]
fn error_of_a_fixed_radius_stops_falling() {
    let scene = scene_at("course_water.toml", 48, 48);
    let reference = after(&scene, Settings { seed: 3, ..rough(&scene, 2.0, 1_000_000) }, 4).picture();
    let [fixed, shared] = [RadiusPolicy::Fixed, RadiusPolicy::Shared].map(|policy| {
        let settings = Settings { policy, ..rough(&scene, 10.0, 100_000) };
        let error = |passes| {
            let picture = after(&scene, settings, passes).picture();
            Metrics::between(&picture, &reference).unwrap().rel_mse.sqrt()
        };
        error(20) / error(2)
    });
    assert!(fixed > 0.85, "ten times the photons leave {fixed:.2} of the error at a fixed radius");
    assert!(shared < 0.75, "and {shared:.2} of it at a shrinking one");
}

/// The passes that a target needs, foretold after a tenth of them.
#[test]
fn forecast_comes_true() {
    let scene = scene_at("course_water.toml", 48, 48);
    let mut render = Render::new(&scene, rough(&scene, 6.0, 4000));
    let mut forecast = Forecast::default();
    while render.passes() < 20 {
        render.pass();
        if let Some(accuracy) = render.accuracy(0.9) {
            forecast.add(&accuracy.picture(), f64::from(render.passes()));
        }
    }
    let upper = |render: &Render| render.accuracy(0.9).unwrap().picture().upper;
    let target = upper(&after(&scene, *render.settings(), 200));
    let foretold = forecast.outlook(target).unwrap();
    assert!((foretold.passes / 200.0 - 1.0).abs() < 0.25, "{foretold:?} for 200 passes");
}

/// Estimates only look on: the picture has the same bits with and without.
#[test]
fn estimates_do_not_change_the_picture() {
    let scene = scene_at("cornell_b.toml", 32, 32);
    let settings = rough(&scene, 20.0, 2000);
    let without = Settings { error_estimates: false, ..settings };
    assert_eq!(after(&scene, settings, 5).picture(), after(&scene, without, 5).picture());
    assert!(after(&scene, without, 5).accuracy(0.9).is_none());
    assert!(after(&scene, settings, 1).accuracy(0.9).is_none(), "one pass knows nothing of its noise");
}

/// Pixels that wait for photons claim nothing; those that see no surface are exact.
#[test]
fn too_few_photons_are_not_trusted() {
    let scene = scene_at("course_diffuse.toml", 32, 32);
    let render = after(&scene, rough(&scene, 0.01, 1000), 3);
    let accuracy = render.accuracy(0.9).unwrap();
    assert!(accuracy.picture().untrusted > 0.9);
    let layers = accuracy.layers();
    let untrusted = layers.bound.pixels().iter().zip(layers.photons.pixels());
    for (bound, photons) in untrusted {
        assert!(bound.is_nan() || photons.x >= 8.0, "a bound of {bound} from {} photons", photons.x);
    }
}

/// All policies find the same light where discs are small, and f32 is enough for a short render.
#[test]
fn policies_and_precisions_agree_on_the_light() {
    use caustica::ppm::Precision;
    let scene = scene_at("cornell_b.toml", 32, 32);
    let settings = rough(&scene, 12.0, 50_000);
    let mean = |settings| {
        let picture = after(&scene, settings, 10).picture();
        picture.pixels().iter().map(|pixel| f64::from(pixel.element_sum())).sum::<f64>()
    };
    let expected = mean(settings);
    for policy in [RadiusPolicy::Shared, RadiusPolicy::Tested, RadiusPolicy::Fixed] {
        let ratio = mean(Settings { policy, ..settings }) / expected;
        assert!((ratio - 1.0).abs() < 0.02, "{policy:?}: {ratio}");
    }
    let single = mean(Settings { precision: Precision::Single, ..settings }) / expected;
    assert!(single != 1.0 && (single - 1.0).abs() < 1e-5, "{single}");
}
