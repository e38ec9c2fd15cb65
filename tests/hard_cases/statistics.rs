//! Counts, radii and estimates: what they come to after very many photons, and after none.

use std::f64::consts::PI;

use caustica::bsdf::Bsdf;
use caustica::effects::PathClass;
use caustica::math::{DVec3, PowerLaw, Rgb, Vec3};
use caustica::ppm::{GatherState, PassSum, Planning, RadiusPolicy, Render, Settings};
use caustica::scene::{Material, Scene, SceneDesc};
use rayon::prelude::*;
use statrs::function::gamma::ln_gamma;

use super::rooms::{GREY, MIRROR, by_both_traversals, dark, floor, lit_box, rendered};

const POLICIES: [RadiusPolicy; 4] =
    [RadiusPolicy::HitPoint, RadiusPolicy::Shared, RadiusPolicy::Tested, RadiusPolicy::Fixed];

fn sum(accepted: u32) -> PassSum {
    PassSum { flux: DVec3::splat(accepted.into()), accepted }
}

/// Photon counts beyond 2³² go on right, at the hit point and in all.
///
/// Breaks: a 32-bit counter starts anew: radii jump up or the picture brightens a thousandfold.
///
/// Mutation: `GatherState::after_pass` rounds the photons to `u32`; in another run `irradiance` takes `emitted as u32`.
#[test]
fn counts_beyond_32_bits_go_on_right() {
    let start = 4_294_967_286.0;
    let mut state = GatherState { photons: start, ..GatherState::new(1.0) };
    for pass in 1..=10 {
        let before = state.radius2;
        state.after_pass(&sum(100), 0.7);
        assert_eq!(state.photons, start + 70.0 * f64::from(pass));
        assert!(state.radius2 < before && state.radius2 > 0.999_999_9);
    }
    let emitted = (1u64 << 32) - 10;
    let state = GatherState { flux: DVec3::splat(emitted as f64), ..GatherState::new(1.0) };
    for more in [0, 10, 20, 1 << 32] {
        let expected = emitted as f64 / (emitted + more) as f64 / PI;
        assert!((state.irradiance(emitted + more).x / expected - 1.0).abs() < 1e-14);
    }
}

/// After ten million photons one more still shrinks the radius by its share.
///
/// Breaks: in f32, `(N + αM) / (N + M)` is exactly 1 there: the radius stops, and the blur stays for ever.
///
/// Mutation: the ratio of `GatherState::after_pass` in f32.
#[test]
fn radii_go_on_shrinking_after_ten_million_photons() {
    let alpha = 0.7;
    let mut state = GatherState { photons: 2e7, ..GatherState::new(1.0) };
    let mut log_product = 0.0;
    for pass in 0..1000 {
        state.after_pass(&sum(1), alpha);
        let before = 2e7 + alpha * f64::from(pass);
        log_product += (-(1.0 - alpha) / (before + 1.0)).ln_1p();
    }
    assert!((state.radius2.ln() - log_product).abs() < 1e-12, "{} of {log_product}", state.radius2.ln());
}

/// After 10⁵ passes of equal counts the radius is the closed-form product, `R² = R₀² Π (k + 1) / (k + 1/α)`, to 10⁻⁹.
///
/// Breaks: radii kept in f32 drift by 10⁻⁴, differently on every machine.
///
/// Mutation: the radius rounded to f32 after each pass in `GatherState::after_pass`.
#[test]
fn radii_of_hit_points_follow_the_product() {
    const PASSES: u32 = 100_000;
    for (alpha, accepted) in [(0.5, 1), (2.0 / 3.0, 5), (0.7, 37), (0.8, 1000)] {
        let mut state = GatherState::new(0.5);
        (0..PASSES).for_each(|_| state.after_pass(&sum(accepted), alpha));
        let n = f64::from(PASSES);
        let log = ln_gamma(n + 1.0) + ln_gamma(1.0 / alpha) - ln_gamma(n + 1.0 / alpha);
        let relative = state.radius2 / (0.25 * log.exp()) - 1.0;
        assert!(relative.abs() < 1e-9, "alpha {alpha}: off by {relative}");
    }
}

/// A single pixel that sees a floor in the dark: passes take no time.
fn dark_pixel(policy: RadiusPolicy, alpha: f64) -> (SceneDesc, Settings) {
    let mut desc = lit_box();
    desc.point_lights.clear();
    (desc.film.width, desc.film.height) = (1, 1);
    let planning = Planning::Everything;
    let settings =
        Settings { policy, alpha, samples: 1, photons: 1, planning, ..Settings::of_scene(&desc.render) };
    (desc, settings)
}

/// The shared schedule's radius after 10⁵ passes is `R² = R₀² Γ(n + 1 + α) / (Γ(1 + α) Γ(n + 2))` to 10⁻⁹, and one that does not
/// shrink is what it was.
///
/// Breaks: a schedule that counts its passes from 0, or sums up in f32, is off from the first pass or drifts.
///
/// Mutation: `common_ratio` by `(i - 1 + alpha) / i`; in another run `Fixed` with the ratio of `Shared`.
#[test]
fn radii_of_a_schedule_follow_the_product() {
    const PASSES: u32 = 100_000;
    let alpha = 2.0 / 3.0;
    let n = f64::from(PASSES);
    let log = ln_gamma(n + 1.0 + alpha) - ln_gamma(1.0 + alpha) - ln_gamma(n + 2.0);
    for (policy, expected) in [(RadiusPolicy::Shared, 0.0025 * log.exp()), (RadiusPolicy::Fixed, 0.0025)] {
        let (desc, settings) = dark_pixel(policy, alpha);
        let scene = Scene::new(desc).unwrap();
        let mut render = Render::new(&scene, settings);
        (0..PASSES).for_each(|_| {
            render.pass();
        });
        let state = render.states(PathClass::Indirect)[0];
        let relative = state.radius2 / expected - 1.0;
        assert!(relative.abs() < 1e-9, "{policy}: off by {relative}");
    }
}

/// A hit point that no photon reaches keeps its radius, and is black, not NaN.
///
/// Breaks: `(N + αM) / (N + M)` is 0/0 there: black dots of NaN that spread with every filter.
///
/// Mutation: `GatherState::after_pass` without its return where nothing was accepted.
#[test]
fn hit_points_without_photons_stay_as_they_are() {
    let mut state = GatherState::new(0.3);
    state.after_pass(&PassSum::default(), 0.7);
    assert_eq!(state, GatherState::new(0.3));
    let mut desc = lit_box();
    desc.render.radius = Some(1e-3);
    for scene in by_both_traversals(&desc) {
        for policy in POLICIES {
            let (render, passes) = rendered(&scene, Settings { policy, ..Settings::of_scene(&desc.render) });
            let states = render.states(PathClass::Indirect);
            let unmet = states.iter().filter(|state| state.photons == 0.0).collect::<Vec<_>>();
            assert!(unmet.len() > 1000 && passes[0].gathered > 0, "{policy}: {} unmet", unmet.len());
            assert!(unmet.iter().all(|state| state.flux == DVec3::ZERO && state.radius2 > 0.0));
            let keeps_radius = policy != RadiusPolicy::Shared;
            assert!(!keeps_radius || unmet.iter().all(|state| state.radius() == 1e-3), "{policy}");
            assert!(render.picture().pixels().iter().all(|p| p.is_finite()));
        }
    }
}

/// A camera that looks at the sky has no hit point: the picture is black, photons fly all the same.
///
/// Breaks: the mean of no radius, the tree of no sphere, the automatic radius of no footprint: each a division by 0.
///
/// Mutation: `RadiusRange::of` without its answer for no radii: NaN.
#[test]
fn cameras_at_the_sky_see_black() {
    let mut desc = lit_box();
    desc.meshes = vec![floor(-1.0, 1.0, 0)];
    desc.camera.look_at = Vec3::new(0.1, 9.0, 0.8);
    let planning = Planning::Everything;
    for scene in by_both_traversals(&desc) {
        for (policy, radius) in POLICIES.iter().flat_map(|p| [(*p, None), (*p, Some(0.1))]) {
            let (render, passes) =
                rendered(&scene, Settings { policy, radius, planning, ..Settings::of_scene(&desc.render) });
            assert_eq!((render.setup().hit_points, passes[1].gathered), (0, 0));
            assert!(passes[1].photons.absorbed > 0 && passes[1].radius.mean == 0.0);
            assert!(render.picture().pixels().iter().all(|p| *p == Rgb::ZERO));
        }
    }
}

/// Where no photon lands anywhere every hit point keeps its radius and the picture has its direct light alone.
///
/// Breaks: the gathering of an empty list, and estimates over no photon at all.
///
/// Mutation: `GatherState::irradiance` without its answer for no photon emitted.
#[test]
fn passes_without_any_photon_change_nothing() {
    let mut lamp_away = lit_box();
    lamp_away.point_lights.clear();
    lamp_away.meshes = vec![floor(-1.0, 1.0, 0), floor(2.0, 1.0, 1)];
    lamp_away.materials.push(Material::plain("lamp", GREY, Rgb::ONE));
    let mut none_emitted = lit_box();
    none_emitted.render.photons = 0;
    for desc in [lamp_away, none_emitted] {
        for scene in by_both_traversals(&desc) {
            for policy in [RadiusPolicy::HitPoint, RadiusPolicy::Tested, RadiusPolicy::Fixed] {
                let (render, passes) =
                    rendered(&scene, Settings { policy, ..Settings::of_scene(&desc.render) });
                assert_eq!(passes[1].photons.deposited, 0);
                let states = render.states(PathClass::Indirect);
                assert!(!states.is_empty() && states.iter().all(|s| *s == GatherState::new(0.05)));
                assert_eq!(render.picture(), render.direct_picture());
            }
        }
    }
}

/// A floor at y = 0 of `pixels²` hit points within `half` of the foot of a small lamp that shines up into a mirror: all that
/// photons bring is `E = I d² / (d² + r²)²` of an image that shines down from the height `d` = 3.
fn mirrored_lamp(pixels: u32, half: f32) -> SceneDesc {
    let lamp_half: f32 = 0.005;
    let mut desc = lit_box();
    (desc.film.width, desc.film.height) = (pixels, pixels);
    desc.camera.position = Vec3::new(0.0, 0.5, 0.0);
    (desc.camera.look_at, desc.camera.up) = (Vec3::ZERO, Vec3::Z);
    desc.camera.fov_degrees = 2.0 * (half / 0.5).atan().to_degrees();
    // So little is scattered that it does not count.
    let black = Bsdf::Diffuse { albedo: Rgb::splat(1e-4) };
    let lamp = Material { emission: Rgb::splat((2.0 * lamp_half).powi(-2)), ..dark("lamp", black) };
    desc.materials = vec![dark("floor", black), dark("mirror", MIRROR), lamp];
    desc.meshes = vec![floor(0.0, 30.0, 0), floor(2.0, 30.0, 1), floor(1.0, lamp_half, 2)];
    desc.point_lights.clear();
    desc
}

const IMAGE_HEIGHT: f64 = 3.0;

/// `E` at a point of the floor.
fn exact_irradiance(p: Vec3) -> f64 {
    let r2 = f64::from(p.x).powi(2) + f64::from(p.z).powi(2);
    (IMAGE_HEIGHT / (IMAGE_HEIGHT.powi(2) + r2)).powi(2)
}

/// What is measured of many renders of [`mirrored_lamp`].
struct Experiment {
    half: f32,
    pixels: u32,
    radius: f64,
    photons: u64,
    renders: u64,
    /// The passes after which it is looked at: each twice the one before.
    looks: Vec<u32>,
    alpha: f64,
}

impl Experiment {
    /// Relative errors of all hit points at all looks, render by render.
    fn errors(&self) -> Vec<Vec<Vec<f64>>> {
        let mut desc = mirrored_lamp(self.pixels, self.half);
        desc.render.radius = Some(self.radius);
        let scene = Scene::new(desc).unwrap();
        let settings = Settings {
            policy: RadiusPolicy::Shared,
            alpha: self.alpha,
            photons: self.photons,
            samples: 1,
            ..Settings::of_scene(scene.render())
        };
        let render = |seed| {
            let mut render = Render::new(&scene, Settings { seed, eye_seed: Some(0), ..settings });
            let mut errors = Vec::new();
            for pass in 1..=*self.looks.last().unwrap() {
                assert!(render.pass().photons.is_balanced());
                if self.looks.contains(&pass) {
                    errors.push(relative_errors(&render));
                }
            }
            errors
        };
        (0..self.renders).into_par_iter().map(render).collect()
    }

    /// The exponent of the variance at a hit point.
    fn variance_exponent(&self) -> f64 {
        let errors = self.errors();
        let n = errors.len() as f64;
        let variance = |look: usize| {
            let of_point = |k: usize| {
                let mean = errors.iter().map(|looks| looks[look][k]).sum::<f64>() / n;
                errors.iter().map(|looks| (looks[look][k] - mean).powi(2)).sum::<f64>() / (n - 1.0)
            };
            (0..errors[0][look].len()).map(of_point).sum::<f64>()
        };
        self.exponent((0..self.looks.len()).map(variance).collect())
    }

    /// The exponent of the squared bias, which is that of the mean over all hit points and renders. What the passes from one
    /// look to the next bring by themselves is free of the larger radii of the first ones.
    fn bias2_exponent(&self) -> f64 {
        let errors = self.errors();
        let mean = |look: usize| errors.iter().flat_map(|looks| &looks[look]).sum::<f64>();
        let between = |look: usize| 2.0 * mean(look) - mean(look - 1);
        let bias2 = (1..self.looks.len()).map(|look| between(look).powi(2)).collect::<Vec<_>>();
        self.exponent(bias2)
    }

    /// `s` in `y ~ passes^s`, through what was measured at the last looks.
    fn exponent(&self, measured: Vec<f64>) -> f64 {
        let looks = &self.looks[self.looks.len() - measured.len()..];
        let points: Vec<(f64, f64)> = looks.iter().map(|&n| f64::from(n)).zip(measured).collect();
        -PowerLaw::through(&points).unwrap().exponent
    }
}

fn relative_errors(render: &Render) -> Vec<f64> {
    let points = render.hit_points().iter().map(|h| h.receiver.p).enumerate();
    points.map(|(k, p)| render.photon_irradiance(k).x / exact_irradiance(p) - 1.0).collect()
}

/// `from`, twice as much, four times ... up to `to`.
fn doubling(from: u32, to: u32) -> Vec<u32> {
    std::iter::successors(Some(from), |n| Some(2 * n)).take_while(|n| *n <= to).collect()
}

/// Small discs far apart.
fn of_variance(alpha: f64, renders: u64) -> Experiment {
    let looks = doubling(8, 256);
    Experiment { half: 3.0, pixels: 16, radius: 0.18, photons: 400, renders, looks, alpha }
}

/// Large discs under the light, where the second derivative is largest.
fn of_bias(alpha: f64, renders: u64, looks: Vec<u32>) -> Experiment {
    Experiment { half: 1.0, pixels: 12, radius: 1.1, photons: 4000, renders, looks, alpha }
}

/// In a scene whose light is known, with radii by the shared schedule, the variance of an estimate falls as `N^-α`.
///
/// Breaks: passes counted twice, radii that shrink too fast or a mean over the wrong number: it converges, but to noise.
///
/// Mutation: `common_ratio` by `(i + alpha²) / (i + 1)`: the radius shrinks faster.
#[test]
fn variance_falls_as_the_theory_has_it() {
    let alpha = 2.0 / 3.0;
    let variance = of_variance(alpha, 24).variance_exponent();
    assert!((variance + alpha).abs() < 0.05, "variance falls as N^{variance}");
}

/// There, the squared bias falls as `N^(-2 (1 - α))`, to 0.1: longer renders say so more sharply.
///
/// Breaks: radii that shrink too slowly: it converges, but to a blur.
///
/// Mutation: `common_ratio` by `(i + √alpha) / (i + 1)`: the radius shrinks more slowly.
#[test]
fn bias_falls_as_the_theory_has_it() {
    let alpha = 2.0 / 3.0;
    let bias2 = of_bias(alpha, 16, doubling(8, 256)).bias2_exponent();
    assert!((bias2 + 2.0 * (1.0 - alpha)).abs() < 0.1, "bias² falls as N^{bias2}");
}

/// The same for three α, and to 0.05: variance as `N^-α`, squared bias as `N^(-2 (1 - α))`; `make convergence` runs it.
///
/// Breaks: what is right for one α may be a coincidence.
///
/// Mutation: `common_ratio` by `(i + alpha²) / (i + 1)`.
#[test]
#[ignore = "takes minutes: make convergence"]
fn both_fall_as_the_theory_has_it_for_three_alphas() {
    for alpha in [0.5, 2.0 / 3.0, 0.8] {
        let variance = of_variance(alpha, 100).variance_exponent();
        let bias2 = of_bias(alpha, 120, doubling(16, 512)).bias2_exponent();
        println!("alpha {alpha:.3}: variance falls as N^{variance:.3}, bias² as N^{bias2:.3}");
        assert!((variance + alpha).abs() < 0.05, "alpha {alpha}: variance falls as N^{variance}");
        assert!((bias2 + 2.0 * (1.0 - alpha)).abs() < 0.05, "alpha {alpha}: bias² falls as N^{bias2}");
    }
}
