//! Photons among hit-point spheres: the sphere tree against its rivals, on the walls of a unit box or as a render has them.

use std::f64::consts::PI;
use std::sync::atomic::AtomicU32;

use serde::Serialize;

use super::gather_source::Source;
use super::machine::Machine;
use super::structures::{PhotonOrder, Rival};
use super::timing::{Spread, interleaved, timed};
use super::{BenchError, morton};
use crate::bvh::Sphere;
use crate::math::Vec3;

/// The radii of the spheres.
#[derive(Clone, Debug, PartialEq)]
pub enum RadiusChoice {
    /// In percent of [`Source::extent`]: every one with every number of points.
    Percent(Vec<f64>),
    /// For each number of points on walls the one with which a photon away from the edges lies in so many spheres.
    Overlaps(f64),
}

impl RadiusChoice {
    /// Percentages to measure with `points` points.
    fn percentages(&self, points: usize, source: &Source) -> Result<Vec<f64>, BenchError> {
        match (self, source) {
            (RadiusChoice::Percent(percentages), _) => Ok(percentages.clone()),
            // k = n π r² / 6 on the six walls of the unit box.
            (RadiusChoice::Overlaps(overlaps), Source::Walls) => {
                Ok(vec![100.0 * (6.0 * overlaps / (PI * points as f64)).sqrt()])
            }
            (RadiusChoice::Overlaps(_), Source::Render(render)) => {
                Err(BenchError::NoOverlaps { scene: render.name.into() })
            }
        }
    }
}

/// What to measure.
#[derive(Clone, Debug, PartialEq)]
pub struct GatherSettings {
    /// Numbers of spheres.
    pub points: Vec<usize>,
    /// Their radii.
    pub radii: RadiusChoice,
    /// Photons: of one gathering on walls, emitted ones in a render.
    pub photons: usize,
    /// Rounds in which every rival builds and gathers once.
    pub repetitions: usize,
}

/// What a structure took in one set-up.
#[derive(Clone, Debug, Serialize)]
pub struct GatherRow {
    /// Number of spheres.
    pub points: usize,
    /// Their radius in percent of the report's extent.
    pub radius_percent: f64,
    /// The structure.
    pub structure: &'static str,
    /// Pairs of a sphere and a photon inside it: the same for all structures.
    pub overlaps: u64,
    /// Milliseconds to build.
    pub build_ms: Spread,
    /// Memory; `None` where the structure does not tell.
    pub bytes_per_point: Option<f64>,
    /// Wall-clock nanoseconds of the gathering, divided by the photons.
    pub ns_per_photon: Spread,
    /// The median of the same, divided by the overlaps; `None` without any.
    pub ns_per_overlap: Option<f64>,
    /// How many times as long as the first structure it gathers; by the medians.
    pub times_first: f64,
}

/// The whole measurement.
#[derive(Clone, Debug, Serialize)]
pub struct GatherReport {
    /// The render that was recorded; `None` on the walls of the unit box.
    pub scene: Option<String>,
    /// What radii are percentages of, in scene units.
    pub extent: f64,
    /// Threads of the pool, and of Embree when it builds.
    pub threads: usize,
    /// Photons of one gathering.
    pub photons: usize,
    /// Photons that a render had to emit for them.
    pub emitted: Option<usize>,
    /// Rounds.
    pub repetitions: usize,
    /// Milliseconds to sort the photons along the curve, counted for no structure.
    pub sort_ms: f64,
    /// By number of points, radius, structure.
    pub rows: Vec<GatherRow>,
    /// Where it was measured.
    pub machine: Machine,
}

/// Photons in both orders.
struct Photons {
    sorted: Vec<Vec3>,
    as_traced: Vec<Vec3>,
    sort_seconds: f64,
}

impl Photons {
    fn new(as_traced: Vec<Vec3>) -> Photons {
        let mut sorted = as_traced.clone();
        let ((), sort_seconds) = timed(|| morton::sort(&mut sorted));
        Photons { sorted, as_traced, sort_seconds }
    }

    fn in_order(&self, order: PhotonOrder) -> &[Vec3] {
        match order {
            PhotonOrder::Sorted => &self.sorted,
            PhotonOrder::AsTraced => &self.as_traced,
        }
    }
}

/// One round of one rival.
struct Sample {
    build_seconds: f64,
    gather_seconds: f64,
    bytes: Option<usize>,
    counts: Vec<u32>,
}

/// Measures every rival in every set-up; `announce` hears of each before it begins.
///
/// # Errors
/// If `source` has too few points or no photons, or cannot tell radii by overlaps; if a rival cannot be built, or counts
/// other photons in any sphere than the first rival does.
pub fn measure(
    settings: &GatherSettings,
    source: &Source,
    rivals: &[Rival],
    mut announce: impl FnMut(usize, f64),
) -> Result<GatherReport, BenchError> {
    let photons = Photons::new(source.photons(settings.photons)?);
    let extent = source.extent();
    let mut rows = Vec::new();
    for &points in &settings.points {
        let percentages = settings.radii.percentages(points, source)?;
        let centers = in_order_of_pixels(source, points)?;
        for percent in percentages {
            announce(points, percent);
            let radius = (percent / 100.0 * extent) as f32;
            let spheres: Vec<Sphere> = centers.iter().map(|&center| Sphere { center, radius }).collect();
            rows.extend(measure_spheres(&spheres, percent, &photons, settings.repetitions, rivals)?);
        }
    }
    let render = match source {
        Source::Walls => None,
        Source::Render(render) => Some(render.name.to_owned()),
    };
    Ok(GatherReport {
        extent,
        threads: rayon::current_num_threads(),
        photons: photons.sorted.len(),
        emitted: render.as_ref().map(|_| settings.photons),
        scene: render,
        repetitions: settings.repetitions,
        sort_ms: 1e3 * photons.sort_seconds,
        rows,
        machine: Machine::detect()?,
    })
}

/// Hit points come in the order of the pixels, so neighbours are near in memory; those on walls are put so.
fn in_order_of_pixels(source: &Source, count: usize) -> Result<Vec<Vec3>, BenchError> {
    let mut points = source.points(count)?;
    if matches!(source, Source::Walls) {
        morton::sort(&mut points);
    }
    Ok(points)
}

fn measure_spheres(
    spheres: &[Sphere],
    radius_percent: f64,
    photons: &Photons,
    repetitions: usize,
    rivals: &[Rival],
) -> Result<Vec<GatherRow>, BenchError> {
    let mut expected: Option<Vec<u32>> = None;
    let samples = interleaved(repetitions, rivals, |rival| {
        let mut sample = run(rival, spheres, photons.in_order(rival.photons))?;
        let counts = std::mem::take(&mut sample.counts);
        match &expected {
            Some(expected) => check(rival, rivals[0].name, &counts, expected)?,
            None => expected = Some(counts),
        }
        Ok::<Sample, BenchError>(sample)
    })?;
    let overlaps = expected.iter().flatten().map(|&count| u64::from(count)).sum();
    let setup = Setup { points: spheres.len(), radius_percent, overlaps, photons: photons.sorted.len() };
    let mut rows: Vec<GatherRow> =
        rivals.iter().zip(&samples).map(|(rival, samples)| setup.row(rival, samples)).collect();
    let first = rows.first().map_or(f64::NAN, |row| row.ns_per_photon.median);
    rows.iter_mut().for_each(|row| row.times_first = row.ns_per_photon.median / first);
    Ok(rows)
}

/// What the rivals of one set-up share.
struct Setup {
    points: usize,
    radius_percent: f64,
    overlaps: u64,
    photons: usize,
}

impl Setup {
    fn row(&self, rival: &Rival, samples: &[Sample]) -> GatherRow {
        let gather = Spread::of(samples.iter().map(|sample| sample.gather_seconds));
        let bytes = samples.first().and_then(|sample| sample.bytes);
        GatherRow {
            points: self.points,
            radius_percent: self.radius_percent,
            structure: rival.name,
            overlaps: self.overlaps,
            build_ms: Spread::of(samples.iter().map(|sample| sample.build_seconds)).scaled(1e3),
            bytes_per_point: bytes.map(|bytes| bytes as f64 / self.points as f64),
            ns_per_photon: gather.scaled(1e9 / self.photons as f64),
            ns_per_overlap: (self.overlaps > 0).then(|| 1e9 * gather.median / self.overlaps as f64),
            times_first: f64::NAN,
        }
    }
}

/// Builds, gathers once, and puts the counts into the order of the spheres.
fn run(rival: &Rival, spheres: &[Sphere], photons: &[Vec3]) -> Result<Sample, BenchError> {
    let (structure, build_seconds) = timed(|| (rival.build)(spheres));
    let mut structure = structure?;
    let mut counts: Vec<AtomicU32> = spheres.iter().map(|_| AtomicU32::new(0)).collect();
    let ((), gather_seconds) = timed(|| structure.count(photons, &mut counts));
    let counts: Vec<u32> = counts.into_iter().map(AtomicU32::into_inner).collect();
    let counts = match structure.order() {
        Some(order) => in_order_of_spheres(&counts, order),
        None => counts,
    };
    Ok(Sample { build_seconds, gather_seconds, bytes: structure.memory_bytes(), counts })
}

fn in_order_of_spheres(counts: &[u32], order: &[u32]) -> Vec<u32> {
    let mut ordered = vec![0; counts.len()];
    for (&count, &sphere) in counts.iter().zip(order) {
        ordered[sphere as usize] = count;
    }
    ordered
}

fn check(rival: &Rival, reference: &'static str, counts: &[u32], expected: &[u32]) -> Result<(), BenchError> {
    match counts.iter().zip(expected).position(|(count, expected)| count != expected) {
        None => Ok(()),
        Some(sphere) => Err(BenchError::Counts {
            structure: rival.name,
            reference,
            sphere,
            found: counts[sphere],
            expected: expected[sphere],
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::super::gather_source::Rendered;
    use super::super::ray_scenes::room;
    use super::super::structures::{OneByOne, PointSearch, RIVALS, Structure, variants};
    use super::*;
    use crate::ppm::Settings;
    use crate::scene::Scene;

    fn settings() -> GatherSettings {
        GatherSettings {
            points: vec![2000, 300],
            radii: RadiusChoice::Percent(vec![0.5, 5.0]),
            photons: 3000,
            repetitions: 2,
        }
    }

    fn naive_overlaps(source: &Source, row: &GatherRow) -> u64 {
        let radius = (row.radius_percent / 100.0 * source.extent()) as f32;
        let photons = source.photons(settings().photons).unwrap();
        let inside = |center| {
            let sphere = Sphere { center, radius };
            photons.iter().filter(|&&p| sphere.contains(p)).count() as u64
        };
        source.points(row.points).unwrap().into_iter().map(inside).sum()
    }

    fn check_against_naive(source: &Source, rivals: &[Rival], threads: usize) -> GatherReport {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let report = pool.install(|| measure(&settings(), source, rivals, |_, _| ())).unwrap();
        assert_eq!((report.threads, report.rows.len()), (threads, 4 * rivals.len()));
        for rows in report.rows.chunks(rivals.len()) {
            let overlaps = naive_overlaps(source, &rows[0]);
            assert!(overlaps > 0);
            for row in rows {
                assert_eq!(row.overlaps, overlaps);
                assert!(row.bytes_per_point.is_some_and(|bytes| bytes > 16.0), "{row:?}");
            }
            assert_eq!(rows[0].times_first, 1.0);
        }
        report
    }

    #[test]
    fn all_rivals_count_what_the_naive_search_counts() {
        for threads in [1, 2] {
            let report = check_against_naive(&Source::Walls, &RIVALS, threads);
            assert_eq!(
                (report.photons, report.extent, report.scene, report.emitted),
                (3000, 1.0, None, None)
            );
        }
    }

    /// The room with water in it, by 256 pixels.
    fn with_render(look: impl Fn(&Source)) {
        let scene = Scene::new(room(500, 256)).unwrap();
        let settings = Settings::of_scene(scene.render());
        look(&Source::Render(Rendered { scene: &scene, name: "room", settings }));
    }

    #[test]
    fn all_rivals_count_what_the_naive_search_counts_of_recorded_photons() {
        with_render(|source| {
            for threads in [1, 2] {
                let report = check_against_naive(source, &[&RIVALS[..], &variants()].concat(), threads);
                assert_eq!((report.scene.as_deref(), report.emitted), (Some("room"), Some(3000)));
                assert_eq!(report.photons, source.photons(3000).unwrap().len());
                assert_eq!(report.extent, 2.0);
            }
        });
    }

    #[test]
    fn a_render_has_no_radii_by_overlaps() {
        with_render(|source| {
            let settings = GatherSettings { radii: RadiusChoice::Overlaps(5.0), ..settings() };
            let error = measure(&settings, source, &RIVALS, |_, _| ()).unwrap_err();
            assert!(error.to_string().starts_with("room: radii cannot be chosen by overlaps"), "{error}");
        });
    }

    /// Forgets every sphere but the first.
    struct Forgetful;

    impl PointSearch for Forgetful {
        fn for_each_containing(&self, _: Vec3, mut visit: impl FnMut(usize)) {
            visit(0);
        }

        fn memory_bytes(&self) -> Option<usize> {
            None
        }
    }

    fn forgetful(_: &[Sphere]) -> Result<Box<dyn Structure>, BenchError> {
        Ok(Box::new(OneByOne(Forgetful)))
    }

    #[test]
    fn a_rival_that_counts_otherwise_ends_the_measurement() {
        let wrong = Rival { name: "forgetful", photons: PhotonOrder::AsTraced, build: forgetful };
        let error = measure(&settings(), &Source::Walls, &[RIVALS[0], wrong], |_, _| ()).unwrap_err();
        let text = error.to_string();
        assert!(
            text.starts_with("forgetful finds 3000 photons in sphere 0, but sphere tree finds "),
            "{text}"
        );
    }

    #[test]
    fn equal_overlaps_shrink_the_radius_with_the_root_of_the_number() {
        let radii = RadiusChoice::Overlaps(50.0);
        let radius = |points| radii.percentages(points, &Source::Walls).unwrap()[0];
        let (few, many) = (radius(10_000), radius(40_000));
        assert!((few / many - 2.0).abs() < 1e-12);
        let settings = GatherSettings { points: vec![10_000], radii, ..settings() };
        let report = measure(&settings, &Source::Walls, &RIVALS[..1], |_, _| ()).unwrap();
        let overlaps = report.rows[0].overlaps as f64 / 3000.0;
        assert!((overlaps / 50.0 - 1.0).abs() < 0.1, "{overlaps} overlaps a photon");
    }
}
