//! What aimed photons gain: the error of caustics at equal time, with and without them.

use serde::Serialize;

use super::BenchError;
use super::equal_time::EqualTimeSettings;
use super::machine::Machine;
use super::timing::Spread;
use crate::effects::PathClass;
use crate::math::{Rgb, mean};
use crate::ppm::{Aiming, Kinds, Render, Settings};
use crate::report::{Cell, Page, Table};
use crate::scene::Scene;

/// The rivals.
pub const AIMINGS: [Aiming; 2] = [Aiming::Photons(0), Aiming::Auto];

/// So many passes of the reference come to one of a run.
const REFERENCE: u32 = 32;

/// Pixels with at least this share of the brightest caustic are in the caustic.
const IN_THE_CAUSTIC: f32 = 0.05;

/// The measurement: one row a rival.
#[derive(Clone, Debug, Serialize)]
pub struct AimReport {
    /// The scene file.
    pub scene: String,
    /// What it was measured on.
    pub machine: Machine,
    /// Threads.
    pub threads: usize,
    /// Passes of every run.
    pub passes: u32,
    /// Photons of every pass, aimed ones included.
    pub photons: u64,
    /// Pixels in the caustic.
    pub pixels: usize,
    /// One for each of [`AIMINGS`].
    pub rows: Vec<AimRow>,
}

/// One way of aiming.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AimRow {
    /// `caustic_photons` of the settings.
    pub aiming: String,
    /// Photons of a pass that are aimed.
    pub aimed: u64,
    /// Seconds of the passes of a run.
    pub seconds: Spread,
    /// Seconds of deciding how many to aim.
    pub trial_seconds: f64,
    /// Relative mean squared error of caustic light in the caustic: the squares of errors over those of the reference.
    pub caustic: Spread,
    /// The same of all light.
    pub picture: Spread,
    /// By how much the median error of caustic light at equal time is less than in the first row.
    pub caustic_gain: f64,
    /// The same of all light.
    pub picture_gain: f64,
}

/// Renders `scene` by each of [`AIMINGS`] in turn and holds the pictures against a long render with aimed photons and another
/// seed.
///
/// A render that finds no caustic photon at all has the error 1: where that happens the gain is larger than it seems.
///
/// # Errors
/// If the reference shows no caustic.
pub fn measure(scene: &Scene, name: &str, settings: &EqualTimeSettings) -> Result<AimReport, BenchError> {
    let render = settings.held();
    let reference = Reference::new(scene, &render, REFERENCE * settings.passes);
    if reference.pixels.is_empty() {
        return Err(BenchError::NoCaustic { scene: name.into() });
    }
    let samples = settings.runs(&AIMINGS, |&caustic_photons, seed| {
        reference.sample(scene, Settings { seed, caustic_photons, ..render }, settings.passes)
    });
    let rows: Vec<AimRow> =
        AIMINGS.iter().zip(&samples).map(|(aiming, runs)| row(*aiming, runs, &samples[0])).collect();
    Ok(AimReport {
        scene: name.into(),
        machine: Machine::detect()?,
        threads: rayon::current_num_threads(),
        passes: settings.passes,
        photons: render.photons,
        pixels: reference.pixels.len(),
        rows,
    })
}

/// One run.
#[derive(Clone, Copy, Debug)]
struct Sample {
    aimed: u64,
    seconds: f64,
    trial_seconds: f64,
    caustic: f64,
    picture: f64,
}

/// Of a render that keeps them apart; nothing of another.
fn caustics(render: &Render) -> Vec<Rgb> {
    render.layer(PathClass::Caustic).map_or_else(Vec::new, |layer| layer.pixels().to_vec())
}

/// What runs are held against.
struct Reference {
    /// Those in the caustic.
    pixels: Vec<usize>,
    caustic: Vec<Rgb>,
    picture: Vec<Rgb>,
}

impl Reference {
    /// Aims half of its photons, whatever a trial would say.
    fn new(scene: &Scene, settings: &Settings, passes: u32) -> Reference {
        let caustic_photons = Aiming::Photons(settings.photons / 2);
        let kinds = Kinds::Apart;
        let mut render = Render::new(scene, Settings { caustic_photons, kinds, ..*settings });
        (0..passes).for_each(|_| drop(render.pass()));
        let caustic = caustics(&render);
        let brightest = caustic.iter().copied().map(mean).fold(0.0, f32::max);
        let is_in = |&pixel: &usize| mean(caustic[pixel]) > IN_THE_CAUSTIC * brightest;
        let pixels = (0..caustic.len()).filter(is_in).collect();
        Reference { pixels, caustic, picture: render.picture().pixels().to_vec() }
    }

    fn sample(&self, scene: &Scene, settings: Settings, passes: u32) -> Sample {
        let mut render = Render::new(scene, Settings { kinds: Kinds::Apart, ..settings });
        let seconds = (0..passes).map(|_| render.pass().seconds).sum();
        let setup = render.setup();
        Sample {
            aimed: setup.aim.map_or(0, |aim| aim.budget.aimed),
            seconds,
            trial_seconds: setup.aim_seconds,
            caustic: self.error(&self.caustic, &caustics(&render)),
            picture: self.error(&self.picture, render.picture().pixels()),
        }
    }

    /// `Σ (a - b)² / Σ b²` over the pixels in the caustic.
    fn error(&self, expected: &[Rgb], found: &[Rgb]) -> f64 {
        let square = |rgb: Rgb| rgb.as_dvec3().length_squared();
        let sum = |of: &dyn Fn(usize) -> Rgb| self.pixels.iter().map(|&k| square(of(k))).sum::<f64>();
        sum(&|k| found[k] - expected[k]) / sum(&|k| expected[k])
    }
}

fn row(aiming: Aiming, runs: &[Sample], first: &[Sample]) -> AimRow {
    let spread = |runs: &[Sample], of: fn(&Sample) -> f64| Spread::of(runs.iter().map(of));
    let seconds = |runs| spread(runs, |run| run.seconds);
    // Medians: a mean would be that of the one run that found a photon of a rare caustic, far too bright.
    let gain = |of| {
        let cost = |runs| spread(runs, of).median * seconds(runs).median;
        cost(first) / cost(runs)
    };
    AimRow {
        aiming: aiming.to_string(),
        aimed: runs.first().map_or(0, |run| run.aimed),
        seconds: seconds(runs),
        trial_seconds: spread(runs, |run| run.trial_seconds).median,
        caustic: spread(runs, |run| run.caustic),
        picture: spread(runs, |run| run.picture),
        caustic_gain: gain(|run| run.caustic),
        picture_gain: gain(|run| run.picture),
    }
}

const COLUMNS: [&str; 8] = [
    "aiming",
    "aimed",
    "s a run",
    "s of the trial",
    "error of caustic",
    "gain at equal time",
    "error of picture",
    "gain at equal time",
];

const NOTE: &str = "\
Errors are squares of differences over squares of the reference, summed over the pixels in the caustic; medians of runs. A run \
that finds no caustic has the error 1: beside it gains are larger than they seem. Radii are held, so that errors are noise. Gains \
compare errors times seconds with those of the first row.";

impl AimReport {
    /// The numbers and the machine.
    pub fn page(&self) -> Page {
        let mut facts = vec![
            ("Scene", self.scene.clone()),
            ("Photons a pass", self.photons.to_string()),
            ("Passes a run", self.passes.to_string()),
            ("Pixels in the caustic", self.pixels.to_string()),
        ];
        facts.extend(self.machine.lines());
        facts.push(("Threads", self.threads.to_string()));
        Page {
            title: "Aimed photons".into(),
            facts,
            note: NOTE.into(),
            table: Table { columns: COLUMNS.into(), rows: self.rows.iter().map(AimRow::cells).collect() },
            plots: vec![],
        }
    }
}

impl AimRow {
    fn cells(&self) -> Vec<Cell> {
        let numbers = [
            self.seconds.median,
            self.trial_seconds,
            self.caustic.median,
            self.caustic_gain,
            self.picture.median,
            self.picture_gain,
        ];
        let mut cells = vec![Cell::Text(self.aiming.clone()), Cell::Count(self.aimed)];
        cells.extend(numbers.map(Cell::Number));
        cells
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene;
    use std::path::Path;

    #[test]
    fn a_bead_is_found_by_aimed_photons() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/glass_bead.toml");
        let mut desc = scene::load(&path).unwrap();
        (desc.film.width, desc.film.height) = (16, 16);
        let render = Settings { photons: 4000, samples: 1, ..Settings::of_scene(&desc.render) };
        let settings = EqualTimeSettings { render, passes: 2, repetitions: 2 };
        let report = measure(&Scene::new(desc).unwrap(), "bead", &settings).unwrap();
        let [natural, aimed] = &report.rows[..] else { panic!("{report:?}") };
        assert!(natural.aimed == 0 && natural.caustic.min == 1.0, "{natural:?}");
        assert!(aimed.aimed > 200 && aimed.caustic.max < 0.2 && aimed.caustic.max > 0.0, "{aimed:?}");
        assert!(report.pixels > 2 && report.page().table.rows.len() == 2);
    }

    #[test]
    fn scenes_without_caustics_say_nothing() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/course_diffuse.toml");
        let mut desc = scene::load(&path).unwrap();
        (desc.film.width, desc.film.height) = (8, 8);
        let render = Settings { photons: 100, samples: 1, ..Settings::of_scene(&desc.render) };
        let settings = EqualTimeSettings { render, passes: 1, repetitions: 1 };
        let error = measure(&Scene::new(desc).unwrap(), "box", &settings).unwrap_err();
        assert_eq!(error, BenchError::NoCaustic { scene: "box".into() });
    }
}
