//! The whole photon pass against tracing the same rays and nothing else.

use rayon::prelude::*;
use serde::Serialize;

use super::BenchError;
use super::machine::Machine;
use super::timing::{Spread, timed};
use crate::math::Ray;
use crate::ppm::photon_pass::record_rays;
use crate::ppm::{Kinds, PassStatistics, Render, Settings};
use crate::report::{Cell, Page, Plot, Scale, Table};
use crate::scene::Scene;

/// What to measure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PassSettings {
    /// The render; its alpha is not used, since the radius is held at its initial value.
    pub render: Settings,
    /// Measured passes, after one that is not counted.
    pub repetitions: usize,
    /// Whether every pass traces its own eye paths and builds a tree over them.
    pub retrace: bool,
}

/// Seconds of the phases of a pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Phases {
    /// Tracing eye paths; zero where they are kept.
    pub eye: f64,
    /// Building the tree; zero where it is kept.
    pub tree: f64,
    /// Tracing photons.
    pub trace: f64,
    /// Adding them to hit points, radius reduction and refitting the tree: one walk.
    pub gather: f64,
    /// Shadow rays to the lights: not part of the photon pass, and not of its sum.
    pub direct: f64,
}

type Phase = (&'static str, fn(&Phases) -> f64);

const PHASES: [Phase; 5] = [
    ("eye", |p| p.eye),
    ("tree", |p| p.tree),
    ("trace", |p| p.trace),
    ("gather", |p| p.gather),
    ("direct", |p| p.direct),
];

impl Phases {
    fn photon_pass(&self) -> f64 {
        self.eye + self.tree + self.trace + self.gather
    }

    fn medians(samples: &[Sample]) -> Phases {
        let median = |phase: fn(&Phases) -> f64| Spread::of(samples.iter().map(|s| phase(&s.phases))).median;
        let [eye, tree, trace, gather, direct] = PHASES.map(|(_, phase)| median(phase));
        Phases { eye, tree, trace, gather, direct }
    }
}

/// The spread of what the report gives as medians.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PassSpread {
    /// Seconds of the pass.
    pub seconds_per_pass: Spread,
    /// Seconds of bare tracing.
    pub bare_trace_seconds: Spread,
    /// Their ratio, round by round.
    pub ratio_to_bare: Spread,
    /// Photons a second.
    pub photons_per_second: Spread,
}

/// The whole measurement.
#[derive(Clone, Debug, Serialize)]
pub struct PassReport {
    /// The scene file.
    pub scene: String,
    /// Threads of the pool.
    pub threads: usize,
    /// Photons emitted in a pass.
    pub photons: u64,
    /// Eye samples a pixel.
    pub samples: u32,
    /// The gather radius, in scene units.
    pub radius: f64,
    /// Whether eye paths were traced anew in each pass.
    pub retrace: bool,
    /// Whether caustics and indirect light were kept apart.
    pub apart: bool,
    /// Measured passes.
    pub repetitions: usize,
    /// Photons emitted, by the median second.
    pub photons_per_second: f64,
    /// Median seconds of a pass: trace, gather, update and refit; with `retrace` also eye paths and tree.
    pub seconds_per_pass: f64,
    /// Median seconds of tracing the rays of the pass alone, on the same threads.
    pub bare_trace_seconds: f64,
    /// The one median by the other.
    pub ratio_to_bare: f64,
    /// Median seconds of each phase.
    pub phases: Phases,
    /// Hit points.
    pub hit_points: u64,
    /// Tree, normals and statistics.
    pub bytes_per_hit_point: f64,
    /// Photon rays of a pass; the median.
    pub rays: f64,
    /// Photons found inside radii in a pass; the median.
    pub overlaps: f64,
    /// Medians with their smallest and largest.
    pub spread: PassSpread,
    /// The passes in their order, in seconds: whole and bare.
    pub rounds: Vec<[f64; 2]>,
    /// Where it was measured.
    pub machine: Machine,
}

/// One round.
struct Sample {
    phases: Phases,
    bare: f64,
    rays: usize,
    overlaps: u64,
    hit_points: u64,
    bytes: usize,
}

impl Sample {
    fn new(render: &Render, pass: &PassStatistics, rays: &[Ray], bare: f64) -> Sample {
        let p = pass.phases;
        Sample {
            phases: Phases { trace: p.trace, gather: p.gather, direct: p.direct, ..Phases::default() },
            bare,
            rays: rays.len(),
            overlaps: pass.gathered + pass.rejected_by_side,
            hit_points: render.setup().hit_points,
            bytes: render.collectors_bytes() + render.facets().memory_bytes(),
        }
    }
}

/// Measures passes of a scene in rounds: the pass, then the rays of that very pass alone.
///
/// The radius is held (alpha 1), so that every round does the same work: that of the first pass, the dearest.
///
/// # Errors
/// If Embree cannot tell its version.
pub fn measure(scene: &Scene, name: &str, settings: &PassSettings) -> Result<PassReport, BenchError> {
    let render = Settings { alpha: 1.0, ..settings.render };
    let samples = if settings.retrace {
        retraced(scene, &render, settings.repetitions)
    } else {
        kept(scene, &render, settings.repetitions)
    };
    let radius = render.radius.unwrap_or_else(|| Render::new(scene, render).setup().radius);
    Ok(report(name, settings, radius, &samples, Machine::detect()?))
}

/// One render with its eye paths, pass after pass.
fn kept(scene: &Scene, settings: &Settings, repetitions: usize) -> Vec<Sample> {
    let mut render = Render::new(scene, *settings);
    let mut round = || {
        let rays = record_rays(scene, settings, render.passes());
        let pass = render.pass();
        let bare = bare_trace(scene, &rays);
        Sample::new(&render, &pass, &rays, bare)
    };
    round();
    (0..repetitions).map(|_| round()).collect()
}

/// A render of one pass with eye paths of its own, again and again.
fn retraced(scene: &Scene, settings: &Settings, repetitions: usize) -> Vec<Sample> {
    // Kept until the next one stands, so that its memory is used again: pages that the system hands out anew are a
    // cost of starting, not of a pass.
    let mut last = None;
    let mut round = |seed: u64| {
        let settings = Settings { seed: settings.seed.wrapping_add(seed), ..*settings };
        let rays = record_rays(scene, &settings, 0);
        let mut render = Render::new(scene, settings);
        let pass = render.pass();
        let bare = bare_trace(scene, &rays);
        let mut sample = Sample::new(&render, &pass, &rays, bare);
        let setup = render.setup();
        sample.phases.eye = setup.eye_seconds;
        sample.phases.tree = setup.tree_seconds;
        sample.phases.direct += setup.direct_seconds;
        last = Some(render);
        sample
    };
    round(0);
    (1..=repetitions as u64).map(round).collect()
}

/// Rays that one task traces: as many as the photon pass has in about one of its own.
const CHUNK: usize = 2048;

/// Seconds to trace `rays` and do nothing with what they hit.
fn bare_trace(scene: &Scene, rays: &[Ray]) -> f64 {
    let hits = |rays: &[Ray]| rays.iter().filter(|ray| scene.distance(ray).is_some()).count();
    let (hits, seconds) = timed(|| rays.par_chunks(CHUNK).map(hits).sum::<usize>());
    std::hint::black_box(hits);
    seconds
}

fn report(
    name: &str,
    settings: &PassSettings,
    radius: f64,
    samples: &[Sample],
    machine: Machine,
) -> PassReport {
    let spread_of = |value: fn(&Sample) -> f64| Spread::of(samples.iter().map(value));
    let photons = settings.render.photons as f64;
    let spread = PassSpread {
        seconds_per_pass: spread_of(|s| s.phases.photon_pass()),
        bare_trace_seconds: spread_of(|s| s.bare),
        ratio_to_bare: spread_of(|s| s.phases.photon_pass() / s.bare),
        photons_per_second: Spread::of(samples.iter().map(|s| photons / s.phases.photon_pass())),
    };
    let (seconds, bare) = (spread.seconds_per_pass.median, spread.bare_trace_seconds.median);
    let hit_points = samples.first().map_or(0, |s| s.hit_points);
    PassReport {
        scene: name.into(),
        threads: rayon::current_num_threads(),
        photons: settings.render.photons,
        samples: settings.render.samples,
        radius,
        retrace: settings.retrace,
        apart: settings.render.kinds == Kinds::Apart,
        repetitions: settings.repetitions,
        photons_per_second: photons / seconds,
        seconds_per_pass: seconds,
        bare_trace_seconds: bare,
        ratio_to_bare: seconds / bare,
        phases: Phases::medians(samples),
        hit_points,
        bytes_per_hit_point: spread_of(|s| s.bytes as f64 / s.hit_points as f64).median,
        rays: spread_of(|s| s.rays as f64).median,
        overlaps: spread_of(|s| s.overlaps as f64).median,
        spread,
        rounds: samples.iter().map(|s| [s.phases.photon_pass(), s.bare]).collect(),
        machine,
    }
}

const NOTE: &str = "\
A pass is tracing, gathering, updating and refitting; with new eye paths also tracing them and building the tree. Shadow \
rays (direct) are not part of it. The radius is held at its initial value. Bare tracing is Embree alone on the recorded \
rays of the same pass, on the same threads. Ratio and photons/s are by the medians of the seconds; their ends are those \
of single rounds.";

impl PassReport {
    /// The numbers, the rounds and the machine.
    pub fn page(&self) -> Page {
        let mut facts = self.machine.lines();
        facts.push(("Scene", self.scene.clone()));
        facts.push(("Threads", self.threads.to_string()));
        facts.push(("Photons a pass", self.photons.to_string()));
        facts.push(("Eye samples a pixel", self.samples.to_string()));
        facts.push(("Radius", format!("{} scene units", self.radius)));
        facts.push(("Eye paths", if self.retrace { "new in each pass" } else { "kept" }.into()));
        facts.push(("Kinds of light", if self.apart { "apart" } else { "together" }.into()));
        facts.push(("Repetitions", self.repetitions.to_string()));
        Page {
            title: "A photon pass".into(),
            facts,
            note: NOTE.into(),
            table: self.table(),
            plots: vec![self.plot()],
        }
    }

    fn table(&self) -> Table {
        let s = &self.spread;
        let measured = |name: &str, median: f64, spread: Spread| {
            [median, spread.min, spread.max].iter().fold(vec![Cell::Text(name.into())], |mut row, &x| {
                row.push(Cell::Number(x));
                row
            })
        };
        let single = |name: &str, value: Cell| {
            vec![Cell::Text(name.into()), value, Cell::Text(String::new()), Cell::Text(String::new())]
        };
        let mut rows = vec![
            measured("pass (ms)", 1e3 * self.seconds_per_pass, s.seconds_per_pass.scaled(1e3)),
            measured("bare tracing (ms)", 1e3 * self.bare_trace_seconds, s.bare_trace_seconds.scaled(1e3)),
            measured("ratio to bare tracing", self.ratio_to_bare, s.ratio_to_bare),
            measured("photons/s", self.photons_per_second, s.photons_per_second),
        ];
        let phase = |(name, of): Phase| single(&format!("{name} (ms)"), Cell::Number(1e3 * of(&self.phases)));
        rows.extend(PHASES.map(phase));
        rows.extend([
            single("rays", Cell::Number(self.rays)),
            single("photons found in radii", Cell::Number(self.overlaps)),
            single("hit points", Cell::Count(self.hit_points)),
            single("bytes/hit point", Cell::Number(self.bytes_per_hit_point)),
        ]);
        Table { columns: vec!["quantity", "median", "min", "max"], rows }
    }

    fn plot(&self) -> Plot {
        let line = |name: &str, which: usize| {
            let points = self.rounds.iter().zip(1u32..).map(|(r, k)| (f64::from(k), 1e3 * r[which]));
            (name.to_owned(), points.collect())
        };
        Plot {
            title: "Rounds".into(),
            x_label: "round".into(),
            y_label: "ms".into(),
            scale: Scale::Linear,
            series: vec![line("pass", 0), line("bare tracing of its rays", 1)],
            guides: vec![],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ppm::GatherState;
    use crate::scene;
    use std::path::Path;

    fn small(retrace: bool) -> PassReport {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/cornell_b.toml");
        let mut desc = scene::load(&path).unwrap();
        (desc.film.width, desc.film.height) = (32, 32);
        let scene = Scene::new(desc).unwrap();
        let render =
            Settings { photons: 2000, samples: 1, radius: Some(20.0), ..Settings::of_scene(scene.render()) };
        measure(&scene, "small", &PassSettings { render, repetitions: 3, retrace }).unwrap()
    }

    #[test]
    fn numbers_of_a_report_fit_together() {
        for retrace in [false, true] {
            let report = small(retrace);
            assert_eq!(report.rounds.len(), 3);
            assert_eq!(report.ratio_to_bare, report.seconds_per_pass / report.bare_trace_seconds);
            assert_eq!(report.photons_per_second, 2000.0 / report.seconds_per_pass);
            assert_eq!(report.radius, 20.0);
            assert!(report.rays >= 2000.0 && report.overlaps > 0.0);
            let bytes = report.bytes_per_hit_point - size_of::<GatherState>() as f64;
            assert!((16.0..64.0).contains(&bytes), "the tree takes {bytes} bytes a hit point");
            assert_eq!(report.phases.eye > 0.0 && report.phases.tree > 0.0, retrace);
        }
    }

    #[test]
    fn direct_light_is_no_part_of_the_photon_pass() {
        let [eye, tree, trace, gather, direct] = [1.0, 2.0, 4.0, 8.0, 16.0];
        let phases = Phases { eye, tree, trace, gather, direct };
        assert_eq!(phases.photon_pass(), 15.0);
    }

    #[test]
    fn json_has_the_keys_that_scripts_read() {
        let json = serde_json::to_value(small(false)).unwrap();
        for key in [
            "scene",
            "threads",
            "photons_per_second",
            "seconds_per_pass",
            "bare_trace_seconds",
            "ratio_to_bare",
            "phases",
            "hit_points",
            "bytes_per_hit_point",
            "rays",
            "spread",
            "machine",
        ] {
            assert!(!json[key].is_null(), "{key} is missing");
        }
        for key in ["trace", "gather"] {
            assert!(json["phases"][key].is_f64(), "{key} is missing");
        }
        for key in ["cpu", "cores", "lanes", "embree", "rustc", "compiled_for", "version"] {
            assert!(!json["machine"][key].is_null(), "{key} is missing");
        }
    }

    #[test]
    fn the_page_shows_the_numbers_of_the_report() {
        let report = small(false);
        let (page, html) = (report.page(), report.page().to_html());
        for number in [1e3 * report.seconds_per_pass, report.ratio_to_bare, report.photons_per_second] {
            let text = Cell::Number(number).to_string();
            assert!(page.table.to_csv().contains(&text) && page.to_text().contains(&text));
            assert!(html.contains(&format!("<td>{text}</td>")));
        }
        assert_eq!(html.matches("<svg").count(), 1);
    }
}
