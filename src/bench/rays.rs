//! Rays of real renders: Embree in all its ways against each other and the project's own tree.

use std::hint::black_box;

use rayon::prelude::*;
use serde::Serialize;

use super::BenchError;
use super::machine::Machine;
use super::ray_engines::{BUILDS, Build, CHUNK, Disagreements, Engine, Structure};
use super::ray_scenes::{RayKind, RaySet, record, room};
use super::timing::{Spread, interleaved, timed};
use crate::math::Ray;
use crate::scene::Mesh;

/// What to measure.
#[derive(Clone, Debug, PartialEq)]
pub struct RaySettings {
    /// Triangles of each scene, at least.
    pub triangles: Vec<usize>,
    /// Photons whose rays are recorded, and about as many eye paths.
    pub photons: u64,
    /// Rounds in which everything is built and asked once.
    pub repetitions: usize,
}

/// What an engine took for the rays of one kind through one scene.
#[derive(Clone, Debug, Serialize)]
pub struct RayRow {
    /// Triangles of the scene.
    pub triangles: usize,
    /// What the rays are for: `eye`, `shadow` or `photon`.
    pub kind: &'static str,
    /// How many there are.
    pub rays: usize,
    /// Who answered.
    #[serde(skip)]
    pub engine: Engine,
    /// What was built.
    pub structure: &'static str,
    /// How it was asked.
    pub query: &'static str,
    /// Milliseconds to build, on all threads; the same in all rows of a structure.
    pub build_ms: Spread,
    /// Memory of the structure with its copy of the triangles.
    pub bytes_per_triangle: f64,
    /// Million rays a second on one thread.
    pub one_thread: Spread,
    /// Million rays a second on all threads.
    pub all_threads: Spread,
    /// How many times as fast as the first engine on one thread; by the medians.
    pub times_first: f64,
    /// Rays that it lets hit another primitive at another distance than the first engine, or misses where that hits.
    pub different: u64,
    /// The same of a million rays.
    pub different_per_million: f64,
    /// Rays for which it finds the same primitive at another distance.
    pub distances: u64,
    /// The same of a million rays.
    pub distances_per_million: f64,
    /// Rays for which it finds another primitive at the same distance: on an edge that triangles share.
    pub ties: u64,
    /// The same of a million rays.
    pub ties_per_million: f64,
}

/// The whole measurement.
#[derive(Clone, Debug, Serialize)]
pub struct RayReport {
    /// Threads of the pool, and of Embree when it builds.
    pub threads: usize,
    /// Photons whose rays were recorded.
    pub photons: u64,
    /// Rounds.
    pub repetitions: usize,
    /// By triangles, kind, engine.
    pub rows: Vec<RayRow>,
    /// Where it was measured.
    pub machine: Machine,
}

/// Measures every engine in every scene; `announce` hears of each scene before it begins.
///
/// # Errors
/// If a scene cannot be built.
pub fn measure(settings: &RaySettings, mut announce: impl FnMut(usize)) -> Result<RayReport, BenchError> {
    let mut rows = Vec::new();
    for &triangles in &settings.triangles {
        announce(triangles);
        rows.extend(measure_scene(triangles, settings)?);
    }
    Ok(RayReport {
        threads: rayon::current_num_threads(),
        photons: settings.photons,
        repetitions: settings.repetitions,
        rows,
        machine: Machine::detect()?,
    })
}

fn measure_scene(triangles: usize, settings: &RaySettings) -> Result<Vec<RayRow>, BenchError> {
    let desc = room(triangles, settings.photons);
    let meshes = desc.meshes.clone();
    let sets = record(desc)?;
    let builds = Builds::new(&meshes, settings.repetitions)?;
    let mut rows = Vec::new();
    for set in &sets {
        rows.extend(builds.measure(set, settings.repetitions)?);
    }
    Ok(rows)
}

/// A structure, and what it took to build it.
struct Built {
    build: Build,
    structure: Structure,
    build_ms: Spread,
}

/// All structures over the triangles of a scene, in the order of [`BUILDS`].
struct Builds {
    triangles: usize,
    all: Vec<Built>,
}

impl Builds {
    /// Builds everything in every round, and keeps what the last one built.
    fn new(meshes: &[Mesh], repetitions: usize) -> Result<Builds, BenchError> {
        let mut latest: Vec<(Build, Structure)> = Vec::new();
        let seconds = interleaved(repetitions, &BUILDS, |&build| {
            latest.retain(|(other, _)| *other != build);
            let (structure, seconds) = Structure::build(build, meshes)?;
            latest.push((build, structure));
            Ok::<f64, BenchError>(seconds)
        })?;
        let built = |((build, structure), seconds): (_, Vec<f64>)| {
            let build_ms = Spread::of(seconds).scaled(1e3);
            Built { build, structure, build_ms }
        };
        let triangles = meshes.iter().map(|mesh| mesh.triangles.len()).sum();
        Ok(Builds { triangles, all: latest.into_iter().zip(seconds).map(built).collect() })
    }

    fn rivals(&self, kind: RayKind) -> Vec<Rival<'_>> {
        let rival = |engine: Engine| {
            let built = self.all.iter().find(|built| built.build == engine.build)?;
            Some(Rival { engine, built })
        };
        Engine::all(kind).into_iter().filter_map(rival).collect()
    }

    fn measure(&self, set: &RaySet, repetitions: usize) -> Result<Vec<RayRow>, BenchError> {
        let rivals = self.rivals(set.kind);
        let samples = interleaved(repetitions, &rivals, |rival| Ok::<_, BenchError>(rival.seconds(set)))?;
        let row = |(rival, samples): (&Rival, &Vec<[f64; 2]>)| {
            rival.row(self.triangles, set, samples, rival.disagreements(&rivals[0], set))
        };
        let mut rows: Vec<RayRow> = rivals.iter().zip(&samples).map(row).collect();
        let first = rows.first().map_or(f64::NAN, |row| row.one_thread.median);
        rows.iter_mut().for_each(|row| row.times_first = row.one_thread.median / first);
        Ok(rows)
    }
}

/// An engine with what it asks.
struct Rival<'a> {
    engine: Engine,
    built: &'a Built,
}

impl Rival<'_> {
    fn rays<'a>(&self, set: &'a RaySet) -> &'a [Ray] {
        if self.engine.query.wants_sorted_rays() { &set.sorted } else { &set.as_traced }
    }

    /// On one thread, and on all.
    fn seconds(&self, set: &RaySet) -> [f64; 2] {
        let ask = |rays: &[Ray]| {
            self.built.structure.ask(self.engine.query, rays, |answer| {
                black_box(answer);
            });
        };
        let rays = self.rays(set);
        let ((), one) = timed(|| rays.chunks(CHUNK).for_each(ask));
        let ((), all) = timed(|| rays.par_chunks(CHUNK).for_each(ask));
        [one, all]
    }

    /// How often it says otherwise than `reference` does of the same rays.
    fn disagreements(&self, reference: &Rival, set: &RaySet) -> Disagreements {
        let in_chunk = |rays: &[Ray]| {
            let answers = |rival: &Rival| {
                let mut answers = Vec::with_capacity(rays.len());
                rival.built.structure.ask(rival.engine.query, rays, |answer| answers.push(answer));
                answers
            };
            let pairs = answers(self).into_iter().zip(answers(reference));
            pairs.map(|(found, expected)| Disagreements::between(found, expected)).collect::<Vec<_>>()
        };
        let chunks = self.rays(set).par_chunks(CHUNK).flat_map_iter(in_chunk);
        chunks.reduce(Disagreements::default, Disagreements::plus)
    }

    fn row(
        &self,
        triangles: usize,
        set: &RaySet,
        samples: &[[f64; 2]],
        Disagreements { different, distances, ties }: Disagreements,
    ) -> RayRow {
        let rays = set.as_traced.len();
        let per_million = |count: u64| 1e6 * count as f64 / rays as f64;
        let millions = |which: usize| Spread::of(samples.iter().map(|s| 1e-6 * rays as f64 / s[which]));
        RayRow {
            triangles,
            kind: set.kind.name(),
            rays,
            engine: self.engine,
            structure: self.engine.structure(),
            query: self.engine.query(),
            build_ms: self.built.build_ms,
            bytes_per_triangle: self.built.structure.memory_bytes() as f64 / triangles as f64,
            one_thread: millions(0),
            all_threads: millions(1),
            times_first: f64::NAN,
            different,
            different_per_million: per_million(different),
            distances,
            distances_per_million: per_million(distances),
            ties,
            ties_per_million: per_million(ties),
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::ray_engines::{Answer, Query};
    use super::*;

    pub fn small() -> RayReport {
        let settings = RaySettings { triangles: vec![36, 500], photons: 900, repetitions: 2 };
        measure(&settings, |_| ()).unwrap()
    }

    #[test]
    fn numbers_of_a_report_fit_together() {
        let mut announced = Vec::new();
        let settings = RaySettings { triangles: vec![1, 500], photons: 900, repetitions: 3 };
        let report = measure(&settings, |triangles| announced.push(triangles)).unwrap();
        assert_eq!(announced, [1, 500]);
        assert_eq!(report.rows.len(), 2 * (11 + 18 + 11));
        let mut first = &report.rows[0];
        for row in &report.rows {
            assert!(row.one_thread.min <= row.one_thread.median && row.all_threads.max < 1e3);
            assert!(row.one_thread.min > 0.001 && row.build_ms.min > 0.0 && row.rays > 400);
            if row.engine == (Engine { build: BUILDS[0], query: Query::Nearest }) {
                first = row;
                assert_eq!((row.different, row.distances, row.ties), (0, 0, 0));
            }
            assert_eq!(row.times_first, row.one_thread.median / first.one_thread.median);
            assert_eq!((row.rays, row.kind, row.triangles), (first.rays, first.kind, first.triangles));
            assert_eq!((row.different, row.different_per_million), (0, 0.0), "{row:?}");
            assert_eq!(row.ties_per_million, 1e6 * row.ties as f64 / row.rays as f64);
        }
        let triangles: Vec<usize> = report.rows.iter().map(|row| row.triangles).collect();
        assert!(triangles.starts_with(&[36]) && triangles.ends_with(&[36 + 2 * 16 * 16]));
    }

    /// A tree that lacks the water differs wherever rays meet water first.
    #[test]
    fn an_engine_that_errs_is_found_out() {
        let desc = room(500, 900);
        let [eye, shadow, _] = record(desc.clone()).unwrap();
        let built = |build, meshes: &[Mesh]| Built {
            build,
            structure: Structure::build(build, meshes).unwrap().0,
            build_ms: Spread::default(),
        };
        let (right, wrong) = (built(BUILDS[0], &desc.meshes), built(BUILDS[1], &desc.meshes[..1]));
        let rival = |built, query| Rival { engine: Engine { build: BUILDS[0], query }, built };
        let reference = rival(&right, Query::Nearest);
        let mut met_water = 0;
        eye.as_traced.chunks(CHUNK).for_each(|rays| {
            right.structure.ask(Query::Nearest, rays, |answer| {
                met_water += u64::from(matches!(answer, Answer::Nearest(Some(hit)) if hit.geometry == 1));
            });
        });
        let found = rival(&wrong, Query::Nearest).disagreements(&reference, &eye);
        assert!(met_water > 100);
        assert_eq!((found.different, found.ties), (met_water, 0));
        let found = rival(&wrong, Query::Any).disagreements(&reference, &shadow);
        assert!(found.different > 100, "{found:?}");
    }

    #[test]
    fn json_has_the_keys_that_scripts_read() {
        let json = serde_json::to_value(small()).unwrap();
        for key in ["threads", "photons", "repetitions", "rows", "machine"] {
            assert!(!json[key].is_null(), "{key} is missing");
        }
        for key in [
            "triangles",
            "kind",
            "rays",
            "structure",
            "query",
            "build_ms",
            "bytes_per_triangle",
            "one_thread",
            "all_threads",
            "times_first",
            "different",
            "different_per_million",
            "distances",
            "distances_per_million",
            "ties",
            "ties_per_million",
        ] {
            assert!(!json["rows"][0][key].is_null(), "{key} is missing");
        }
        for key in ["median", "min", "max"] {
            assert!(json["rows"][0]["one_thread"][key].is_f64(), "{key} is missing");
        }
    }
}
