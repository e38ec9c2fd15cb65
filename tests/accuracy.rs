//! Whether a render knows its own error: bounds hold as often as they say, and forecasts come true.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a panic is how a test fails")]

mod common;

use caustica::compare::{Coverage, Estimate, Metrics, Region};
use caustica::film::Image;
use caustica::math::Rgb;
use caustica::ppm::{ErrorEstimates, Forecast, RadiusPolicy, Render, Settings};
use caustica::scene::Scene;
use common::{scene_at, settings};

/// The same hit points as in every other render of these tests, so that light alone differs.
const EYE_SEED: Option<u64> = Some(0);

/// Few pixels want large discs and few photons.
fn rough(scene: &Scene, radius: f64, photons: u64) -> Settings {
    let settings = settings(scene);
    Settings {
        radius: Some(radius),
        photons,
        seed: 1,
        eye_seed: EYE_SEED,
        error_estimates: ErrorEstimates::Pixels,
        ..settings
    }
}

/// Many times as many photons as the picture that it judges, in discs of half the radius.
fn fine(scene: &Scene, rough: &Settings) -> Image {
    let photons = 25 * rough.photons;
    let radius = rough.radius.map(|radius| 0.7 * radius);
    let settings = Settings { photons, radius, seed: 2, error_estimates: ErrorEstimates::None, ..*rough };
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
    let (picture, bound) = (render.picture(), render.accuracy(confidence).unwrap().layers().unwrap().bound);
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
    assert!((said / truth - 1.0).abs() < 0.2, "{name}: the error is {truth:.4}, the estimate {said:.4}");
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
    assert_bounds_are_honest("cornell_b.toml", 10.0, 6000);
}

#[test]
fn bounds_hold_between_blocks() {
    assert_bounds_are_honest("cornell_a.toml", 20.0, 6000);
}

/// Discs so large that blur is most of the error: their shrinking tells, where noise alone would claim too much.
#[test]
fn blur_of_large_discs_is_in_the_bounds() {
    let scene = scene_at("course_water.toml", 64, 64);
    let render = after(&scene, rough(&scene, 8.0, 60_000), 24);
    let reference = after(&scene, Settings { seed: 3, ..rough(&scene, 2.0, 1_000_000) }, 5).picture();
    let (picture, layers) = (render.picture(), render.accuracy(0.9).unwrap().layers().unwrap());
    let mut by_noise = layers.stderr.clone();
    // Student's quantile of 90 % for the batches of 24 passes.
    by_noise.pixels_mut().iter_mut().for_each(|pixel| *pixel *= 2.0);
    let share = |bound| {
        let region = Region::of(&picture);
        Coverage::of(bound, &picture, Estimate::exact(&reference), &region).unwrap().share
    };
    let (bounds, noise) = (share(&layers.bound), share(&by_noise));
    eprintln!("{bounds:.3} within bounds, {noise:.3} within those of noise alone");
    assert!(noise < 0.75 && bounds > noise + 0.05, "{bounds} {noise}");
}

/// Radii that stay tell nothing of their blur, so nothing is claimed.
#[test]
fn fixed_radii_have_no_bounds() {
    let scene = scene_at("course_diffuse.toml", 16, 16);
    for settings in [
        Settings { policy: RadiusPolicy::Fixed, ..rough(&scene, 10.0, 5000) },
        Settings { alpha: 1.0, ..rough(&scene, 10.0, 5000) },
    ] {
        let render = after(&scene, settings, 4);
        let bound = render.accuracy(0.9).unwrap().layers().unwrap().bound;
        assert!(bound.pixels().iter().all(|bound| bound.is_nan()));
    }
}

/// The error of the picture is told from the same batches, whether all pixels are looked at or few.
#[test]
fn picture_errors_do_not_depend_on_layers() {
    let scene = scene_at("cornell_b.toml", 201, 200);
    let settings = rough(&scene, 5.0, 20_000);
    let few = Settings { error_estimates: ErrorEstimates::Picture, ..settings };
    let error = |settings| after(&scene, settings, 6).accuracy(0.9).unwrap().picture();
    assert_eq!(error(settings), error(few));
    assert!(after(&scene, few, 6).accuracy(0.9).unwrap().layers().is_none());
}

/// Every layer holds what its name says, pixel by pixel; the noise of a pixel is that between renders from other seeds.
#[test]
fn layers_hold_what_their_names_say() {
    let scene = scene_at("cornell_b.toml", 24, 24);
    let settings = Settings { seed: 40, ..rough(&scene, 20.0, 3000) };
    let render = after(&scene, settings, 26);
    let accuracy = render.accuracy(0.9).unwrap();
    let (layers, pixels) = (accuracy.layers().unwrap(), accuracy.pixels().unwrap());
    for (k, pixel) in pixels.iter().enumerate() {
        let same = |layer: &Image, value: Rgb| {
            layer.pixels()[k].to_array().map(f32::to_bits) == value.to_array().map(f32::to_bits)
        };
        assert!(same(&layers.stderr, pixel.stderr.as_vec3()) && same(&layers.bias, pixel.bias.as_vec3()));
        assert!(same(&layers.bound, pixel.bound.as_vec3()));
        assert!(same(&layers.photons, Rgb::splat(pixel.photons as f32)));
        assert!((0.0..=20.0).contains(&layers.radius.pixels()[k].x));
    }
    let others: Vec<Image> =
        (0..24).map(|seed| after(&scene, Settings { seed, ..settings }, 26).picture()).collect();
    let (mut low, mut high) = (0, 0);
    for (k, pixel) in pixels.iter().enumerate() {
        let values = || others.iter().map(|picture| f64::from(picture.pixels()[k].y));
        let mean = values().sum::<f64>() / 24.0;
        let deviation = (values().map(|value| (value - mean).powi(2)).sum::<f64>() / 23.0).sqrt();
        low += u32::from(pixel.stderr.y < 0.4 * deviation);
        high += u32::from(pixel.stderr.y > 2.5 * deviation);
    }
    assert!(low + high < 576 / 10, "{low} of 576 standard errors are far too small, {high} far too large");
}

/// A fixed radius keeps its blur, however many photons come; a shrinking one does not.
#[test]
fn error_of_a_fixed_radius_stops_falling() {
    let scene = scene_at("course_water.toml", 48, 48);
    let reference = after(&scene, Settings { seed: 3, ..rough(&scene, 2.0, 1_000_000) }, 4).picture();
    let [fixed, shared] = [RadiusPolicy::Fixed, RadiusPolicy::Shared].map(|policy| {
        let settings = Settings { policy, alpha: 0.5, ..rough(&scene, 10.0, 100_000) };
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
    let scene = scene_at("cornell_a.toml", 48, 48);
    let mut render = Render::new(&scene, rough(&scene, 15.0, 3000));
    let mut forecast = Forecast::new(render.settings().policy, render.settings().alpha);
    let mut error_after = |passes: u32| {
        while render.passes() < passes {
            render.pass();
        }
        let error = render.accuracy(0.9).unwrap().picture();
        if passes <= 24 {
            forecast.add(&error, f64::from(passes));
        }
        error.error
    };
    for passes in [3, 6, 8, 10, 13, 16, 20, 24] {
        error_after(passes);
    }
    let target = error_after(240);
    let foretold = forecast.outlook(target).unwrap();
    assert!((foretold.passes / 240.0 - 1.0).abs() < 0.25, "{foretold:?} for 240 passes");
}

/// Estimates only look on: the picture has the same bits with and without.
#[test]
fn estimates_do_not_change_the_picture() {
    let scene = scene_at("cornell_b.toml", 32, 32);
    let settings = rough(&scene, 20.0, 2000);
    let without = Settings { error_estimates: ErrorEstimates::None, ..settings };
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
    let layers = accuracy.layers().unwrap();
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
