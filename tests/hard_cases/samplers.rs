//! Every sampler against its density, by chi-square: a histogram of samples against the integral of the pdf.
//!
//! A sampler that is right fails by chance with probability [`SIGNIFICANCE`]; the numbers are keyed, so it never
//! fails again once it has passed. Each test was seen to fail with the sampler's warp or pdf slightly wrong.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a panic is how a test fails")]

use std::f32::consts::{PI, TAU};

use caustica::bsdf::{DiffuseSampling, sample_diffuse};
use caustica::light::Light;
use caustica::math::{Rgb, Rng, Stream, Vec2, Vec3, warp};
use statrs::distribution::{ChiSquared, ContinuousCDF};

const SIGNIFICANCE: f64 = 1e-3;
const SAMPLES: usize = 400_000;
/// Below this a cell is merged with the next one, since chi-square wants a normal count.
const MIN_EXPECTED: f64 = 5.0;

/// Cells over (cos θ, φ) of the sphere, uniform in solid angle.
const COSINE_CELLS: usize = 20;
const AZIMUTH_CELLS: usize = 24;

fn p_value(observed: &[f64], expected: &[f64]) -> f64 {
    let (mut statistic, mut cells) = (0.0, 0);
    let (mut o, mut e) = (0.0, 0.0);
    for (&count, &mean) in observed.iter().zip(expected) {
        o += count;
        e += mean;
        if e >= MIN_EXPECTED {
            statistic += (o - e) * (o - e) / e;
            cells += 1;
            (o, e) = (0.0, 0.0);
        }
    }
    assert!(o == 0.0 || e > 0.0, "samples where the density is zero");
    1.0 - ChiSquared::new(f64::from(cells - 1)).unwrap().cdf(statistic)
}

fn cell_of(w: Vec3) -> usize {
    let cosine = ((w.z + 1.0) / 2.0 * COSINE_CELLS as f32) as usize;
    let azimuth = (w.y.atan2(w.x).rem_euclid(TAU) / TAU * AZIMUTH_CELLS as f32) as usize;
    cosine.min(COSINE_CELLS - 1) * AZIMUTH_CELLS + azimuth.min(AZIMUTH_CELLS - 1)
}

/// The integral of the density over every cell, by the midpoint rule in (cos θ, φ).
fn expected(pdf_w: impl Fn(Vec3) -> f32) -> Vec<f64> {
    const STEPS: usize = 32;
    let cells = (0..COSINE_CELLS * AZIMUTH_CELLS).map(|cell| {
        let (i, j) = (cell / AZIMUTH_CELLS, cell % AZIMUTH_CELLS);
        let mut sum = 0.0;
        for k in 0..STEPS * STEPS {
            let z = (i as f32 + ((k / STEPS) as f32 + 0.5) / STEPS as f32) / COSINE_CELLS as f32 * 2.0 - 1.0;
            let phi = (j as f32 + ((k % STEPS) as f32 + 0.5) / STEPS as f32) / AZIMUTH_CELLS as f32 * TAU;
            let r = (1.0 - z * z).sqrt();
            sum += f64::from(pdf_w(Vec3::new(r * phi.cos(), r * phi.sin(), z)));
        }
        sum / (STEPS * STEPS) as f64 * 4.0 * std::f64::consts::PI / (COSINE_CELLS * AZIMUTH_CELLS) as f64
    });
    cells.map(|probability| probability * SAMPLES as f64).collect()
}

fn assert_directions_follow(
    name: &str,
    pdf_w: impl Fn(Vec3) -> f32,
    mut sample: impl FnMut(&mut Rng) -> Vec3,
) {
    let mut rng = Rng::new(20_260_101, Stream::Test, 0, 0);
    let mut observed = vec![0.0; COSINE_CELLS * AZIMUTH_CELLS];
    for _ in 0..SAMPLES {
        let w = sample(&mut rng);
        assert!((w.length() - 1.0).abs() < 1e-5, "{name}: not unit: {w}");
        observed[cell_of(w)] += 1.0;
    }
    let expected = expected(pdf_w);
    let total: f64 = expected.iter().sum();
    assert!((total / SAMPLES as f64 - 1.0).abs() < 1e-3, "{name}: the pdf integrates to {total}");
    let p = p_value(&observed, &expected);
    assert!(p > SIGNIFICANCE, "{name}: p = {p}");
}

#[test]
fn cosine_hemisphere() {
    assert_directions_follow("cosine", warp::cosine_hemisphere_pdf_w, |rng| {
        warp::square_to_cosine_hemisphere(rng.next_vec2())
    });
}

#[test]
fn uniform_sphere() {
    assert_directions_follow(
        "sphere",
        |_| warp::UNIFORM_SPHERE_PDF_W,
        |rng| warp::square_to_uniform_sphere(rng.next_vec2()),
    );
}

#[test]
fn uniform_hemisphere_by_rejection() {
    assert_directions_follow(
        "rejection",
        warp::uniform_hemisphere_pdf_w,
        warp::uniform_hemisphere_by_rejection,
    );
}

/// The test itself must be able to fail: a hemisphere whose cosine is off by 2 % is found out.
#[test]
fn chi_square_notices_a_wrong_density() {
    let mut rng = Rng::new(1, Stream::Test, 0, 0);
    let mut observed = vec![0.0; COSINE_CELLS * AZIMUTH_CELLS];
    for _ in 0..SAMPLES {
        let w = warp::square_to_cosine_hemisphere(rng.next_vec2());
        observed[cell_of((w + Vec3::new(0.0, 0.0, 0.02)).normalize())] += 1.0;
    }
    assert!(p_value(&observed, &expected(warp::cosine_hemisphere_pdf_w)) < SIGNIFICANCE);
}

/// Diffuse bounces stay on the side of `wo`, and both samplings follow their density there.
#[test]
fn diffuse_bounces_on_both_sides() {
    for wo in [Vec3::Z, Vec3::NEG_Z] {
        let mirrored = |w: Vec3| if wo.z < 0.0 { w.with_z(-w.z) } else { w };
        assert_directions_follow(
            "cosine bounce",
            |w| warp::cosine_hemisphere_pdf_w(mirrored(w)),
            |rng| sample_diffuse(DiffuseSampling::Cosine, wo, rng).0,
        );
        assert_directions_follow(
            "uniform bounce",
            |w| warp::uniform_hemisphere_pdf_w(mirrored(w)),
            |rng| sample_diffuse(DiffuseSampling::Uniform, wo, rng).0,
        );
    }
}

#[test]
fn photons_leave_a_point_light_uniformly_and_a_lamp_by_the_cosine() {
    let point = Light::Point { position: Vec3::ZERO, intensity: Rgb::ONE };
    assert_directions_follow("point light", |_| 0.25 / PI, |rng| point.sample_emission(rng).dir);
    let lamp = Light::Triangle { corners: [Vec3::ZERO, Vec3::X, Vec3::Y], radiance: Rgb::ONE };
    assert_directions_follow("lamp", warp::cosine_hemisphere_pdf_w, |rng| lamp.sample_emission(rng).dir);
}

fn assert_points_are_uniform(
    name: &str,
    cell: impl Fn(Vec2) -> usize,
    cells: usize,
    sample: impl Fn(Vec2) -> Vec2,
) {
    let mut rng = Rng::new(9, Stream::Test, 0, 0);
    let mut observed = vec![0.0; cells];
    for _ in 0..SAMPLES {
        observed[cell(sample(rng.next_vec2()))] += 1.0;
    }
    let p = p_value(&observed, &vec![SAMPLES as f64 / cells as f64; cells]);
    assert!(p > SIGNIFICANCE, "{name}: p = {p}");
}

/// Cells of equal area: rings by r², sectors by angle.
#[test]
fn disk_is_uniform_in_area() {
    let cell = |p: Vec2| {
        let ring = (p.length_squared() * 10.0) as usize;
        let sector = (p.y.atan2(p.x).rem_euclid(TAU) / TAU * 16.0) as usize;
        ring.min(9) * 16 + sector.min(15)
    };
    assert_points_are_uniform("disk", cell, 160, warp::square_to_disk);
}

/// The four similar triangles that the middles of the edges cut off, twice over: sixteen cells of equal area.
#[test]
fn triangle_is_uniform_in_area() {
    fn quarter(b: Vec2) -> (usize, Vec2) {
        let b0 = 1.0 - b.x - b.y;
        match (b0 > 0.5, b.x > 0.5, b.y > 0.5) {
            (true, _, _) => (0, 2.0 * b),
            (_, true, _) => (1, Vec2::new(2.0 * b.x - 1.0, 2.0 * b.y)),
            (_, _, true) => (2, Vec2::new(2.0 * b.x, 2.0 * b.y - 1.0)),
            _ => (3, 1.0 - 2.0 * b),
        }
    }
    let cell = |b: Vec2| {
        let (first, inner) = quarter(b);
        4 * first + quarter(inner).0
    };
    assert_points_are_uniform("triangle", cell, 16, warp::square_to_triangle);
}
