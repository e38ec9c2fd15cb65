//! Every sampler against its density, by chi-square: a histogram of samples against the integral of the pdf.
//!
//! A sampler that is right fails by chance with probability [`SIGNIFICANCE`]; the numbers are keyed, so it never
//! fails again once it has passed.

use std::f32::consts::{PI, TAU};

use caustica::bsdf::{Bsdf, Choice, DiffuseSampling, Transport, sample_diffuse};
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

/// Directions of the cosine-weighted hemisphere follow their density.
///
/// Breaks: bounces that lean up or sideways: a bias that looks like light.
///
/// Mutation: `square_to_disk` scales its radius by .98.
#[test]
fn cosine_hemisphere() {
    assert_directions_follow("cosine", warp::cosine_hemisphere_pdf_w, |rng| {
        warp::square_to_cosine_hemisphere(rng.next_vec2())
    });
}

/// Directions of the sphere follow their density, which is the same everywhere.
///
/// Breaks: polar angles drawn evenly crowd the poles: point lights with bright caps.
///
/// Mutation: `square_to_uniform_sphere` with `z = 1 - 2 u.x²`.
#[test]
fn uniform_sphere() {
    assert_directions_follow(
        "sphere",
        |_| warp::UNIFORM_SPHERE_PDF_W,
        |rng| warp::square_to_uniform_sphere(rng.next_vec2()),
    );
}

/// Directions found by rejection are even over the hemisphere.
///
/// Breaks: who forgets to reject favours the corners of the cube.
///
/// Mutation: `uniform_hemisphere_by_rejection` takes points up to a squared length of 1.5.
#[test]
fn uniform_hemisphere_by_rejection() {
    assert_directions_follow(
        "rejection",
        warp::uniform_hemisphere_pdf_w,
        warp::uniform_hemisphere_by_rejection,
    );
}

/// The test itself is able to fail: a hemisphere whose cosine is off by 2 % is found out.
///
/// Breaks: too few samples or too large cells let any sampler pass.
///
/// Mutation: the cosine not off: the assertion fails.
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

/// Diffuse bounces stay on the side that was hit, and both samplings follow their density there.
///
/// Breaks: surfaces seen from behind send light through themselves.
///
/// Mutation: `sample_diffuse` does not turn the direction to the side of `wo`.
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

/// Photons leave a point light evenly and a lamp by the cosine.
///
/// Breaks: lamps that shine evenly are too bright at grazing angles, and shadow rays disagree with photons.
///
/// Mutation: `Emitter::sample` of a triangle with uniform directions (`uniform_hemisphere_by_rejection`).
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

/// Points of the disc are even in area.
///
/// Breaks: radii drawn evenly crowd the centre.
///
/// Mutation: `square_to_disk` squares the radius; in another run, scales it by .98.
#[test]
fn disk_is_uniform_in_area() {
    let cell = |p: Vec2| {
        let ring = (p.length_squared() * 10.0) as usize;
        let sector = (p.y.atan2(p.x).rem_euclid(TAU) / TAU * 16.0) as usize;
        ring.min(9) * 16 + sector.min(15)
    };
    assert_points_are_uniform("disk", cell, 160, warp::square_to_disk);
}

/// Points of a triangle are even in area.
///
/// Breaks: lamps that are brighter at one corner.
///
/// Mutation: `square_to_triangle` without the root.
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

/// No surface sends on more than it receives: the integral of `f cos` over all directions, diffuse and specular together, by
/// which surfaces are sampled too, stays at or below 1.
///
/// Breaks: a closed room grows brighter with every bounce.
///
/// Mutation: the fixed weights' diffuse share not reduced by the specular ones in `Bsdf::albedo`; in another run, uniform
/// bounces scaled by `2.2 cos`.
#[test]
fn surfaces_send_on_no_more_than_they_receive() {
    const N: u32 = 20_000;
    let materials = [
        Bsdf::Diffuse { albedo: Rgb::ONE },
        Bsdf::Diffuse { albedo: Rgb::new(0.7, 0.1, 0.0) },
        Bsdf::Mirror { reflectance: Rgb::ONE },
        Bsdf::Dielectric { ior: 1.5 },
        Bsdf::FixedWeight { color: Rgb::ONE, reflectivity: 0.2, transparency: 0.7, ior: 1.33 },
    ];
    for (bsdf, sampling) in
        materials.iter().flat_map(|b| [DiffuseSampling::Cosine, DiffuseSampling::Uniform].map(|s| (b, s)))
    {
        for wo in [0.05f32, 0.5, 1.0, -0.05, -0.7].map(|z| Vec3::new((1.0 - z * z).sqrt(), 0.0, z)) {
            let scattering = bsdf.scatter(wo, Transport::Power);
            let exact = scattering.specular().fold(scattering.albedo, |sum, lobe| sum + lobe.weight());
            assert!(exact.max_element() <= 1.0 + 1e-6, "{bsdf:?}: {exact}");
            let mut rng = Rng::new(17, Stream::Test, 0, 0);
            let mut sum = 0.0;
            for _ in 0..N {
                sum += match scattering.choose(rng.next_f32()) {
                    None => 0.0,
                    Some(Choice::Specular { factor, .. }) => f64::from(factor.x),
                    Some(Choice::Diffuse { factor }) => {
                        f64::from(factor.x * sample_diffuse(sampling, wo, &mut rng).1)
                    }
                };
            }
            let mean = sum / f64::from(N);
            assert!(
                (mean - f64::from(exact.x)).abs() < 0.02,
                "{bsdf:?}, {sampling:?}: {mean} instead of {exact}"
            );
        }
    }
}

/// A Lambertian surface is reciprocal: what it sends from one direction into another it sends back as well.
///
/// Breaks: densities by the wrong cosine: `f = factor · pdf / cos` depends on the direction, and paths from the eye find
/// other light than photons.
///
/// Mutation: uniform bounces scaled by 1 in place of `2 cos`.
#[test]
fn diffuse_bounces_are_reciprocal() {
    let mut rng = Rng::new(23, Stream::Test, 0, 0);
    for wo in [Vec3::Z, Vec3::new(0.8, 0.0, 0.6), Vec3::new(0.0, 0.6, -0.8)] {
        for _ in 0..1000 {
            let (wi, factor) = sample_diffuse(DiffuseSampling::Uniform, wo, &mut rng);
            let f = factor * warp::uniform_hemisphere_pdf_w(wi.with_z(wi.z.abs())) / wi.z.abs();
            let (wi, factor) = sample_diffuse(DiffuseSampling::Cosine, wo, &mut rng);
            let g = factor * warp::cosine_hemisphere_pdf_w(wi.with_z(wi.z.abs())) / wi.z.abs();
            assert!((f * PI - 1.0).abs() < 1e-5 && (g * PI - 1.0).abs() < 1e-5, "{f} and {g}");
        }
    }
}
