//! What precision buys: the error and the price of each way to keep a number, against f64 or a closed form.

use std::hint::black_box;
use std::ops::{Add, Sub};

use serde::Serialize;

use super::BenchError;
use super::closed_meshes::ClosedMesh;
use super::machine::Machine;
use super::timing::timed;
use crate::bvh::Sphere;
use crate::effects::PathClass;
use crate::math::{DVec3, Ray, Rgb, Rng, Stream, Vec3};
use crate::ppm::{Precision, RadiusPolicy, Render, Settings};
use crate::report::{Cell, Page, Table};
use crate::scene::{PointLightDesc, Scene, SceneDesc};

/// The measurement: a row for each way to keep each number.
#[derive(Clone, Debug, Serialize)]
pub struct NumericsReport {
    /// What it was measured on.
    pub machine: Machine,
    /// In groups of one number each.
    pub rows: Vec<NumericsRow>,
}

/// One way to keep a number.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct NumericsRow {
    /// The number.
    pub number: String,
    /// How it is kept.
    pub way: &'static str,
    /// How wrong it is, in the unit that `number` tells.
    pub error: f64,
    /// Bytes that it takes.
    pub bytes: f64,
    /// Nanoseconds that an update takes, or NaN.
    pub nanoseconds: f64,
}

/// Measures all; renders run for `passes`.
///
/// # Errors
/// If Embree cannot be started.
pub fn measure(passes: u32) -> Result<NumericsReport, BenchError> {
    let scene = Scene::new(lit_room())?;
    let mut rows = statistics(&scene, passes);
    rows.extend(sums());
    rows.extend(counts());
    rows.extend(points());
    rows.extend(discs());
    Ok(NumericsReport { machine: Machine::detect()?, rows })
}

fn lit_room() -> SceneDesc {
    let mut room = ClosedMesh::Room.scene();
    room.film.width = 16;
    room.film.height = 16;
    room.render.photons = 64;
    room.render.radius = Some(0.2);
    room.render.depth = 1;
    room.point_lights = vec![PointLightDesc { position: Vec3::splat(0.3), intensity: Rgb::ONE }];
    room
}

/// A render's statistics in both precisions: the radius against its closed form, and the light against f64.
fn statistics(scene: &Scene, passes: u32) -> Vec<NumericsRow> {
    const WAYS: [(&str, Precision); 2] = [("f32", Precision::Single), ("f64", Precision::Double)];
    let shared = WAYS.map(|(way, precision)| Run::new(scene, way, precision, RadiusPolicy::Shared, passes));
    let own = WAYS.map(|(way, precision)| Run::new(scene, way, precision, RadiusPolicy::HitPoint, passes));
    let exact = closed_form(scene.render().alpha, passes);
    let radii = shared.iter().map(|run| run.row("R² by a common schedule", run.shrunk() / exact - 1.0));
    let light = own.iter().map(|run| run.row("light, RMS against f64", rms_difference(run, &own[1])));
    radii.chain(light).collect()
}

/// `Π (i + α) / (i + 1)` over the passes, by a compensated sum of logarithms.
fn closed_form(alpha: f64, passes: u32) -> f64 {
    let ratio = |i: u32| ((f64::from(i) + alpha) / (f64::from(i) + 1.0)).ln();
    let (_, sum) = (1..=passes).map(ratio).fold((0.0, 0.0), compensated);
    sum.exp()
}

struct Run<'s> {
    way: &'static str,
    render: Render<'s>,
    first_radius: f64,
    gather_seconds: f64,
}

impl<'s> Run<'s> {
    fn new(
        scene: &'s Scene,
        way: &'static str,
        precision: Precision,
        policy: RadiusPolicy,
        passes: u32,
    ) -> Run<'s> {
        let settings = Settings { precision, policy, ..Settings::of_scene(scene.render()) };
        let mut render = Render::new(scene, settings);
        let gather_seconds = (0..passes).map(|_| render.pass().phases.gather).sum();
        Run { way, first_radius: render.setup().radius, render, gather_seconds }
    }

    fn shrunk(&self) -> f64 {
        self.render
            .states(PathClass::Indirect)
            .first()
            .map_or(f64::NAN, |state| (state.radius() / self.first_radius).powi(2))
    }

    fn light(&self) -> Vec<DVec3> {
        (0..self.render.hit_points().len()).map(|position| self.render.photon_irradiance(position)).collect()
    }

    fn row(&self, what: &str, error: f64) -> NumericsRow {
        let (hit_points, passes) = (self.render.hit_points().len() as f64, self.render.passes());
        NumericsRow {
            number: format!("{what}, {passes} passes"),
            way: self.way,
            error: error.abs(),
            bytes: self.render.states_bytes() as f64 / hit_points,
            nanoseconds: 1e9 * self.gather_seconds / (hit_points * f64::from(passes)),
        }
    }
}

fn rms_difference(a: &Run, b: &Run) -> f64 {
    let (a, b) = (a.light(), b.light());
    let pairs = a.iter().zip(&b).filter(|(_, b)| b.x > 0.0).map(|(a, b)| (a.x / b.x - 1.0).powi(2));
    (pairs.sum::<f64>() / a.len() as f64).sqrt()
}

/// Adds to a sum (what rounding lost so far, the sum).
///
/// # Source
/// Kahan, "Further Remarks on Reducing Truncation Errors", Communications of the ACM 8(1), 1965.
fn compensated<F: Copy + Add<Output = F> + Sub<Output = F>>((lost, sum): (F, F), x: F) -> (F, F) {
    let x = x - lost;
    let total = sum + x;
    ((total - sum) - x, total)
}

/// Ten million photons of power .1 (in f32), whose exact sum is known.
fn sums() -> Vec<NumericsRow> {
    const N: u32 = 10_000_000;
    let power = 0.1f32;
    let exact = f64::from(power) * f64::from(N);
    let photons = || (0..N).map(|_| black_box(power));
    let naive = || f64::from(photons().fold(0f32, |sum, x| sum + x));
    let kahan = || f64::from(photons().fold((0.0, 0.0), compensated).1);
    let double = || photons().fold(0f64, |sum, x| sum + f64::from(x));
    let ways: [Way; 3] = [("f32", 4.0, &naive), ("f32, compensated", 8.0, &kahan), ("f64", 8.0, &double)];
    ways.map(|way| updated(&format!("sum of {N} powers, relative"), way, f64::from(N), exact)).into()
}

/// Photons counted one by one.
fn counts() -> Vec<NumericsRow> {
    const N: u64 = 20_000_000;
    let single = || f64::from((0..N).fold(0f32, |sum, _| black_box(sum) + 1.0));
    let whole = || (0..N).fold(0u64, |sum, _| black_box(sum) + 1) as f64;
    let ways: [Way; 2] = [("f32", 4.0, &single), ("u64", 8.0, &whole)];
    ways.map(|way| updated(&format!("count of {N}, relative"), way, N as f64, N as f64)).into()
}

/// How a number is kept, in how many bytes, and what it ends up as.
type Way<'a> = (&'static str, f64, &'a dyn Fn() -> f64);

/// The row of a number that is updated `n` times and should come to `exact`.
fn updated(number: &str, (way, bytes, end): Way, n: f64, exact: f64) -> NumericsRow {
    let (end, seconds) = timed(end);
    let error = (end / exact - 1.0).abs();
    NumericsRow { number: number.into(), way, error, bytes, nanoseconds: 1e9 * seconds / n }
}

/// How far points of triangles, computed in f32, are from where they should be, in roundings of their largest coordinate.
///
/// Triangles reach from -1 to 1, and rays come from up to 100 away.
fn points() -> Vec<NumericsRow> {
    const POINTS: u64 = 1_000_000;
    let mut worst = [0f64; 2];
    for index in 0..POINTS {
        let mut rng = Rng::new(1, Stream::Probe, 0, index);
        let corners = [(); 3].map(|()| in_cube(&mut rng));
        let (u, v) = (0.5 * rng.next_f32(), 0.5 * rng.next_f32());
        let origin = 100.0 * in_cube(&mut rng);
        let exact = weighed(corners.map(|c| c.as_dvec3()), f64::from(u), f64::from(v));
        let [a, b, c] = corners;
        let by_weights = (1.0 - u - v) * a + u * b + v * c;
        let dir = (exact - origin.as_dvec3()).as_vec3().normalize();
        let along_ray = Ray::new(origin, dir).at(exact.distance(origin.as_dvec3()) as f32);
        let largest = corners.iter().map(|c| c.abs().max_element()).fold(0.0, f32::max);
        let unit = f64::from(largest) / f64::from(1u32 << 24);
        let normal =
            (corners[1] - corners[0]).as_dvec3().cross((corners[2] - corners[0]).as_dvec3()).normalize();
        for (worst, p) in worst.iter_mut().zip([by_weights, along_ray]) {
            *worst = worst.max((p.as_dvec3() - exact).dot(normal).abs() / unit);
        }
    }
    let number = "point off its triangle, in roundings of the largest coordinate";
    let row =
        |(way, error)| NumericsRow { number: number.into(), way, error, bytes: 12.0, nanoseconds: f64::NAN };
    [("weights of the corners", worst[0]), ("along the ray", worst[1])].map(row).into()
}

fn in_cube(rng: &mut Rng) -> Vec3 {
    2.0 * Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32()) - 1.0
}

fn weighed([a, b, c]: [DVec3; 3], u: f64, v: f64) -> DVec3 {
    (1.0 - u - v) * a + u * b + v * c
}

/// How many of a million photons beside a hit point are counted otherwise by the test in f32 than by one in f64.
fn discs() -> Vec<NumericsRow> {
    const PHOTONS: u64 = 1_000_000;
    let row = |radius: f32| {
        let parts = |index| {
            let mut rng = Rng::new(2, Stream::Probe, 0, index);
            let center = in_cube(&mut rng);
            let photon = center + 1.1 * radius * in_cube(&mut rng);
            let exact = center.as_dvec3().distance_squared(photon.as_dvec3()) <= f64::from(radius).powi(2);
            Sphere { center, radius }.contains(photon) != exact
        };
        let wrong = (0..PHOTONS).filter(|&index| parts(index)).count();
        NumericsRow {
            number: format!("photon in a disc of {radius} at up to 1, wrong in a million"),
            way: "f32",
            error: wrong as f64,
            bytes: 16.0,
            nanoseconds: f64::NAN,
        }
    };
    [0.1, 1e-3, 1e-5].map(row).into()
}

const COLUMNS: [&str; 5] = ["number", "way", "error", "bytes", "ns an update"];

const NOTE: &str = "\
Each number, and the ways to keep it. Statistics are those of renders of a lit box: bytes a hit point, nanoseconds of the \
whole gather a hit point and pass. Sums and counts run one after the other, as in a disc that sees photon after photon; \
they are single runs. What is exact is a closed form or the same in f64.";

impl NumericsReport {
    /// The table and the machine.
    pub fn page(&self) -> Page {
        Page {
            title: "What precision buys".into(),
            facts: self.machine.lines(),
            note: NOTE.into(),
            table: Table {
                columns: COLUMNS.into(),
                rows: self.rows.iter().map(NumericsRow::cells).collect(),
            },
            plots: vec![],
        }
    }
}

impl NumericsRow {
    fn cells(&self) -> Vec<Cell> {
        vec![
            Cell::Text(self.number.clone()),
            Cell::Text(self.way.into()),
            Cell::Text(format!("{:.1e}", self.error)),
            Cell::Number(self.bytes),
            Cell::Number(self.nanoseconds),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The claims that the choices of the program rest on.
    #[test]
    fn what_the_choices_rest_on() {
        let rows = measure(300).unwrap().rows;
        let error = |number: &str, way: &str| {
            rows.iter().find(|row| row.number.starts_with(number) && row.way == way).unwrap().error
        };
        assert!(error("R²", "f64") < 1e-12 && error("R²", "f32") > 1e-7);
        assert!(error("light", "f32") > 1e-8 && error("light", "f64") == 0.0);
        assert!(error("sum", "f32") > 0.01 && error("sum", "f64") < 1e-9);
        assert!(error("sum", "f32, compensated") < 1e-6);
        assert!(error("count", "f32") > 0.1 && error("count", "u64") == 0.0);
        // The one epsilon of the renderer is 32 of these.
        assert!(error("point", "weights of the corners") < 4.0 && error("point", "along the ray") > 32.0);
        assert!(error("photon in a disc of 0.1", "f32") < 10.0);
    }
}
