//! Photons among hit-point spheres: the sphere tree against its rivals, on the walls of a unit box.

use std::f64::consts::PI;
use std::sync::atomic::AtomicU32;

use serde::Serialize;

use super::machine::Machine;
use super::structures::{PhotonOrder, Rival};
use super::timing::{Spread, interleaved, timed};
use super::{BenchError, in_order_of_appearance, morton};
use crate::bvh::Sphere;
use crate::math::{Rng, Stream, Vec3};
use crate::report::{Cell, Page, Plot, Scale, Table};

/// The radii of the spheres.
#[derive(Clone, Debug, PartialEq)]
pub enum Radii {
    /// In percent of the box's side: every one with every number of points.
    Percent(Vec<f64>),
    /// For each number of points the one with which a photon away from the edges lies in so many spheres.
    Overlaps(f64),
}

impl Radii {
    /// Percentages to measure with `points` points.
    fn percentages(&self, points: usize) -> Vec<f64> {
        match self {
            Radii::Percent(percentages) => percentages.clone(),
            // k = n π r² / 6 on the six walls of the unit box.
            Radii::Overlaps(overlaps) => vec![100.0 * (6.0 * overlaps / (PI * points as f64)).sqrt()],
        }
    }
}

/// What to measure.
#[derive(Clone, Debug, PartialEq)]
pub struct GatherSettings {
    /// Numbers of spheres.
    pub points: Vec<usize>,
    /// Their radii.
    pub radii: Radii,
    /// Photons of one gathering.
    pub photons: usize,
    /// Rounds in which every rival builds and gathers once.
    pub repetitions: usize,
}

/// What a structure took in one set-up.
#[derive(Clone, Debug, Serialize)]
pub struct GatherRow {
    /// Number of spheres.
    pub points: usize,
    /// Their radius in percent of the box's side.
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
    /// Threads of the pool, and of Embree when it builds.
    pub threads: usize,
    /// Photons of one gathering.
    pub photons: usize,
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
    fn new(count: usize) -> Photons {
        let as_traced = on_walls(count, PHOTON_KEY);
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

const POINT_KEY: u32 = 0;
const PHOTON_KEY: u32 = 1;

/// Measures every rival in every set-up; `announce` hears of each before it begins.
///
/// # Errors
/// If a rival cannot be built, or counts other photons in any sphere than the first rival does.
pub fn measure(
    settings: &GatherSettings,
    rivals: &[Rival],
    mut announce: impl FnMut(usize, f64),
) -> Result<GatherReport, BenchError> {
    let photons = Photons::new(settings.photons);
    let mut rows = Vec::new();
    for &points in &settings.points {
        let mut centers = on_walls(points, POINT_KEY);
        // Hit points come in the order of the pixels, so neighbours are near in memory.
        morton::sort(&mut centers);
        for percent in settings.radii.percentages(points) {
            announce(points, percent);
            let radius = (percent / 100.0) as f32;
            let spheres: Vec<Sphere> = centers.iter().map(|&center| Sphere { center, radius }).collect();
            rows.extend(measure_spheres(&spheres, percent, &photons, settings, rivals)?);
        }
    }
    Ok(GatherReport {
        threads: rayon::current_num_threads(),
        photons: settings.photons,
        repetitions: settings.repetitions,
        sort_ms: 1e3 * photons.sort_seconds,
        rows,
        machine: Machine::detect()?,
    })
}

/// Points on the walls of the unit box, uniform in area; every `key` gives others.
pub fn on_walls(count: usize, key: u32) -> Vec<Vec3> {
    let point = |index| {
        let mut rng = Rng::new(1, Stream::Test, key, index);
        let mut p = [rng.next_f32(), rng.next_f32(), rng.next_f32()];
        let wall = rng.next_u32() % 6;
        p[wall as usize / 2] = (wall % 2) as f32;
        Vec3::from_array(p)
    };
    (0..count as u64).map(point).collect()
}

fn measure_spheres(
    spheres: &[Sphere],
    radius_percent: f64,
    photons: &Photons,
    settings: &GatherSettings,
    rivals: &[Rival],
) -> Result<Vec<GatherRow>, BenchError> {
    let mut expected: Option<Vec<u32>> = None;
    let samples = interleaved(settings.repetitions, rivals, |rival| {
        let mut sample = run(rival, spheres, photons.in_order(rival.photons))?;
        let counts = std::mem::take(&mut sample.counts);
        match &expected {
            Some(expected) => check(rival, rivals[0].name, &counts, expected)?,
            None => expected = Some(counts),
        }
        Ok::<Sample, BenchError>(sample)
    })?;
    let overlaps = expected.iter().flatten().map(|&count| u64::from(count)).sum();
    let setup = Setup { points: spheres.len(), radius_percent, overlaps, photons: settings.photons };
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

const COLUMNS: [&str; 13] = [
    "points",
    "radius (%)",
    "structure",
    "overlaps",
    "build (ms)",
    "min",
    "max",
    "bytes/point",
    "ns/photon",
    "min",
    "max",
    "ns/overlap",
    "x first",
];

const NOTE: &str = "\
Spheres lie uniformly on the six walls of a unit box; the radius is in percent of its side. Every structure adds one to \
the count of every sphere around every photon, and all counts are the same. Times are wall-clock medians over \
interleaved rounds, each with a build of its own. Structures that go photon by photon get them sorted along a Morton \
curve, which is not counted; with more than one thread they count atomically. `x first` is the time of gathering as a \
multiple of the first structure's.";

impl GatherReport {
    /// The numbers, the plots and the machine.
    pub fn page(&self) -> Page {
        let mut facts = self.machine.lines();
        facts.push(("Threads", self.threads.to_string()));
        facts.push(("Photons", format!("{}, sorted in {:.1} ms", self.photons, self.sort_ms)));
        facts.push(("Repetitions", self.repetitions.to_string()));
        let rows = self.rows.iter().map(GatherRow::cells).collect();
        Page {
            title: "Gathering photons".into(),
            facts,
            note: NOTE.into(),
            table: Table { columns: COLUMNS.into(), rows },
            plots: self.plots(),
        }
    }

    /// One plot for each number of points, and two over the numbers of points.
    fn plots(&self) -> Vec<Plot> {
        let sizes = in_order_of_appearance(self.rows.iter().map(|row| row.points));
        let of_size = |points| {
            self.plot(
                &format!("Gathering among {points} spheres"),
                ["radius (% of the box)", "ns a photon"],
                move |row| (row.points == points).then_some((row.radius_percent, row.ns_per_photon.median)),
            )
        };
        let build = self.plot("Building", ["spheres", "ms"], |row| {
            let smallest = self.rows.iter().find(|other| other.points == row.points);
            let is_first = smallest.is_some_and(|other| other.radius_percent == row.radius_percent);
            is_first.then_some((row.points as f64, row.build_ms.median))
        });
        let overlap = self.plot("Cost of an overlap", ["overlaps a photon", "ns"], |row| {
            Some((row.overlaps as f64 / self.photons as f64, row.ns_per_overlap?))
        });
        sizes.into_iter().map(of_size).chain([build, overlap]).collect()
    }

    /// A line for each structure through the points of its rows.
    fn plot(
        &self,
        title: &str,
        [x_label, y_label]: [&str; 2],
        point: impl Fn(&GatherRow) -> Option<(f64, f64)>,
    ) -> Plot {
        let names = in_order_of_appearance(self.rows.iter().map(|row| row.structure));
        let line = |name: &'static str| {
            let rows = self.rows.iter().filter(|row| row.structure == name);
            let mut points: Vec<(f64, f64)> = rows.filter_map(&point).collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            (name.to_owned(), points)
        };
        Plot {
            title: title.into(),
            x_label: x_label.into(),
            y_label: y_label.into(),
            scale: Scale::Logarithmic,
            series: names.into_iter().map(line).collect(),
            guides: vec![],
        }
    }
}

impl GatherRow {
    fn cells(&self) -> Vec<Cell> {
        let GatherRow { build_ms: build, ns_per_photon: gather, .. } = self;
        vec![
            Cell::Count(self.points as u64),
            Cell::Number(self.radius_percent),
            Cell::Text(self.structure.into()),
            Cell::Count(self.overlaps),
            Cell::Number(build.median),
            Cell::Number(build.min),
            Cell::Number(build.max),
            Cell::Number(self.bytes_per_point.unwrap_or(f64::NAN)),
            Cell::Number(gather.median),
            Cell::Number(gather.min),
            Cell::Number(gather.max),
            Cell::Number(self.ns_per_overlap.unwrap_or(f64::NAN)),
            Cell::Number(self.times_first),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::super::structures::{OneByOne, PointSearch, RIVALS, Structure};
    use super::*;

    fn settings() -> GatherSettings {
        GatherSettings {
            points: vec![2000, 300],
            radii: Radii::Percent(vec![0.5, 5.0]),
            photons: 3000,
            repetitions: 2,
        }
    }

    fn naive_overlaps(points: usize, percent: f64, photons: usize) -> u64 {
        let radius = (percent / 100.0) as f32;
        let photons = on_walls(photons, PHOTON_KEY);
        let inside = |center| {
            let sphere = Sphere { center, radius };
            photons.iter().filter(|&&p| sphere.contains(p)).count() as u64
        };
        on_walls(points, POINT_KEY).into_iter().map(inside).sum()
    }

    #[test]
    fn all_rivals_count_what_the_naive_search_counts() {
        for threads in [1, 2] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let report = pool.install(|| measure(&settings(), &RIVALS, |_, _| ())).unwrap();
            assert_eq!((report.threads, report.rows.len()), (threads, 4 * RIVALS.len()));
            for row in &report.rows {
                assert_eq!(row.overlaps, naive_overlaps(row.points, row.radius_percent, 3000));
                assert!(row.bytes_per_point.is_some_and(|bytes| bytes > 16.0), "{row:?}");
            }
            assert!(report.rows.iter().step_by(RIVALS.len()).all(|row| row.times_first == 1.0));
        }
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
        let error = measure(&settings(), &[RIVALS[0], wrong], |_, _| ()).unwrap_err();
        let text = error.to_string();
        assert!(
            text.starts_with("forgetful finds 3000 photons in sphere 0, but sphere tree finds "),
            "{text}"
        );
    }

    #[test]
    fn equal_overlaps_shrink_the_radius_with_the_root_of_the_number() {
        let radii = Radii::Overlaps(50.0);
        let (few, many) = (radii.percentages(10_000)[0], radii.percentages(40_000)[0]);
        assert!((few / many - 2.0).abs() < 1e-12);
        let settings = GatherSettings { points: vec![10_000], radii, ..settings() };
        let report = measure(&settings, &RIVALS[..1], |_, _| ()).unwrap();
        let overlaps = report.rows[0].overlaps as f64 / 3000.0;
        assert!((overlaps / 50.0 - 1.0).abs() < 0.1, "{overlaps} overlaps a photon");
    }

    #[test]
    fn the_page_shows_every_row() {
        let report = measure(&settings(), &RIVALS, |_, _| ()).unwrap();
        let (page, html) = (report.page(), report.page().to_html());
        assert_eq!(page.table.rows.len(), report.rows.len());
        assert!(page.table.rows.iter().all(|row| row.len() == COLUMNS.len()));
        assert_eq!(html.matches("<svg").count(), 4);
        for row in &report.rows {
            let cell = format!("<td>{}</td>", Cell::Number(row.ns_per_photon.median));
            assert!(html.contains(&cell) && html.contains(row.structure));
        }
    }
}
