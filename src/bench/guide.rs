//! What guided photons gain: the error at equal time, with and without them.

use serde::Serialize;

use super::BenchError;
use super::equal_time::EqualTimeSettings;
use super::machine::Machine;
use super::timing::Spread;
use crate::math::{DVec3, Rgb};
use crate::ppm::{Guiding, Render, Settings};
use crate::report::{Cell, Page, Table};
use crate::scene::Scene;

/// The rivals.
pub const GUIDINGS: [Guiding; 3] = [Guiding::Off, Guiding::Auto, Guiding::On];

/// So many passes of the reference come to one of a run.
const REFERENCE: u32 = 64;

/// The measurement: one row a rival.
#[derive(Clone, Debug, Serialize)]
pub struct GuideReport {
    /// The scene file.
    pub scene: String,
    /// What it was measured on.
    pub machine: Machine,
    /// Threads.
    pub threads: usize,
    /// Passes of every run.
    pub passes: u32,
    /// Photons of every pass.
    pub photons: u64,
    /// One for each of [`GUIDINGS`].
    pub rows: Vec<GuideRow>,
}

/// One way of guiding.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GuideRow {
    /// `guiding` of the settings.
    pub guiding: String,
    /// The part of the photons that is guided.
    pub share: f64,
    /// The part of the photons that arrives by nature, and if guided; nothing where that was not tried.
    pub arriving: Option<[f64; 2]>,
    /// Seconds of a run: of its passes, and of learning where to guide.
    pub seconds: Spread,
    /// Seconds of learning and of all other trials, which are part of those.
    pub trial_seconds: f64,
    /// Relative mean squared error of the light that photons bring.
    pub photons: Spread,
    /// The same of all light.
    pub picture: Spread,
    /// The mean of those.
    pub mean_error: f64,
    /// By how much the mean error of the light that photons bring is less at equal time than in the first row.
    pub gain: f64,
}

/// Renders `scene` by each of [`GUIDINGS`] in turn and holds the pictures against a long render with guided photons and another
/// seed.
///
/// # Errors
/// If photons bring no light.
pub fn measure(scene: &Scene, name: &str, settings: &EqualTimeSettings) -> Result<GuideReport, BenchError> {
    let render = settings.held();
    let reference = Lights::of(&rendered(
        scene,
        Settings { guiding: Guiding::On, ..render },
        REFERENCE * settings.passes,
    ));
    if reference.photons.iter().all(|&light| light == Rgb::ZERO) {
        return Err(BenchError::NoPhotons { scene: name.into() });
    }
    let samples = settings.runs(&GUIDINGS, |&guiding, seed| {
        reference.sample(scene, Settings { seed, guiding, ..render }, settings.passes)
    });
    let rows = GUIDINGS.iter().zip(&samples).map(|(guiding, runs)| row(*guiding, runs, &samples[0]));
    Ok(GuideReport {
        scene: name.into(),
        machine: Machine::detect()?,
        threads: rayon::current_num_threads(),
        passes: settings.passes,
        photons: render.photons,
        rows: rows.collect(),
    })
}

fn rendered(scene: &Scene, settings: Settings, passes: u32) -> Render<'_> {
    let mut render = Render::new(scene, settings);
    (0..passes).for_each(|_| drop(render.pass()));
    render
}

/// One run.
#[derive(Clone, Copy, Debug)]
struct Sample {
    share: f64,
    arriving: Option<[f64; 2]>,
    seconds: f64,
    trial_seconds: f64,
    photons: f64,
    picture: f64,
}

/// What runs are held against: pixel by pixel.
struct Lights {
    photons: Vec<Rgb>,
    picture: Vec<Rgb>,
}

impl Lights {
    fn of(render: &Render) -> Lights {
        let picture = render.picture().pixels().to_vec();
        let direct = render.direct_picture();
        let photons = picture.iter().zip(direct.pixels()).map(|(all, direct)| all - direct).collect();
        Lights { photons, picture }
    }

    fn sample(&self, scene: &Scene, settings: Settings, passes: u32) -> Sample {
        let mut render = Render::new(scene, settings);
        let seconds: f64 = (0..passes).map(|_| render.pass().seconds).sum();
        let found = Lights::of(&render);
        let (guide, trial_seconds) = (render.setup().guide, render.setup().aim_seconds);
        Sample {
            share: guide.map_or(0.0, |guide| guide.share),
            arriving: guide.map(|guide| [guide.arriving, guide.guided_arriving]),
            seconds: seconds + trial_seconds,
            trial_seconds,
            photons: error(&self.photons, &found.photons),
            picture: error(&self.picture, &found.picture),
        }
    }
}

/// The mean over pixels of `(a - b)² / (b² + m²)`, with the mean `m` of the reference `b`: dark pixels count as well, black ones
/// not without end.
fn error(expected: &[Rgb], found: &[Rgb]) -> f64 {
    let n = expected.len() as f64;
    let mean = expected.iter().map(|rgb| rgb.as_dvec3()).sum::<DVec3>() / n;
    let errors = expected.iter().zip(found).map(|(b, a)| {
        let (a, b) = (a.as_dvec3(), b.as_dvec3());
        (a - b).length_squared() / (b.length_squared() + mean.length_squared())
    });
    errors.sum::<f64>() / n
}

fn row(guiding: Guiding, runs: &[Sample], first: &[Sample]) -> GuideRow {
    let spread = |runs: &[Sample], of: fn(&Sample) -> f64| Spread::of(runs.iter().map(of));
    let seconds = |runs| spread(runs, |run| run.seconds);
    // A median would be blind to rare bright photons, which is what guiding may remove, or make.
    let mean = |runs: &[Sample]| runs.iter().map(|run| run.photons).sum::<f64>() / runs.len() as f64;
    let cost = |runs| mean(runs) * seconds(runs).median;
    GuideRow {
        guiding: guiding.to_string(),
        share: spread(runs, |run| run.share).median,
        arriving: runs.first().and_then(|run| run.arriving),
        seconds: seconds(runs),
        trial_seconds: spread(runs, |run| run.trial_seconds).median,
        photons: spread(runs, |run| run.photons),
        picture: spread(runs, |run| run.picture),
        mean_error: mean(runs),
        gain: cost(first) / cost(runs),
    }
}

const COLUMNS: [&str; 10] = [
    "guiding",
    "guided",
    "arrive by nature",
    "arrive if guided",
    "s a run",
    "s of trials",
    "error",
    "least",
    "most",
    "gain at equal time",
];

const NOTE: &str = "\
Errors are squares of differences over the squares of the reference and of its mean, in the mean over pixels, of the light that photons \
bring; means of runs, and the least and the most of one. Seconds are medians, and include those of learning where to guide. Radii are held, so that errors are noise. Gains compare \
errors times seconds with those of the first row.";

impl GuideReport {
    /// The numbers and the machine.
    pub fn page(&self) -> Page {
        let mut facts = vec![
            ("Scene", self.scene.clone()),
            ("Photons a pass", self.photons.to_string()),
            ("Passes a run", self.passes.to_string()),
        ];
        facts.extend(self.machine.lines());
        facts.push(("Threads", self.threads.to_string()));
        Page {
            title: "Guided photons".into(),
            facts,
            note: NOTE.into(),
            table: Table { columns: COLUMNS.into(), rows: self.rows.iter().map(GuideRow::cells).collect() },
            plots: vec![],
        }
    }
}

impl GuideRow {
    fn cells(&self) -> Vec<Cell> {
        let [natural, guided] = self.arriving.map_or([f64::NAN; 2], |arriving| arriving);
        let numbers = [
            self.share,
            natural,
            guided,
            self.seconds.median,
            self.trial_seconds,
            self.mean_error,
            self.photons.min,
            self.photons.max,
            self.gain,
        ];
        [Cell::Text(self.guiding.clone())].into_iter().chain(numbers.map(Cell::Number)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene;
    use std::path::Path;

    fn report(name: &str, photons: u64) -> GuideReport {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name);
        let mut desc = scene::load(&path).unwrap();
        (desc.film.width, desc.film.height) = (12, 12);
        let render = Settings { photons, samples: 1, ..Settings::of_scene(&desc.render) };
        let settings = EqualTimeSettings { render, passes: 1, repetitions: 2 };
        measure(&Scene::new(desc).unwrap(), name, &settings).unwrap()
    }

    #[test]
    fn guided_photons_find_the_keyhole() {
        let report = report("keyhole.toml", 20_000);
        let [natural, auto, guided] = &report.rows[..] else { panic!("{report:?}") };
        assert!(natural.share == 0.0 && natural.arriving.is_none(), "{natural:?}");
        let [by_nature, if_guided] = guided.arriving.unwrap();
        assert!(guided.share > 0.0 && if_guided > 10.0 * by_nature, "{guided:?}");
        assert!((natural.gain - 1.0).abs() < 1e-12 && auto.photons.max > 0.0, "{report:?}");
        assert_eq!(report.page().table.rows.len(), 3);
    }

    #[test]
    fn rivals_that_do_the_same_err_alike() {
        let report = report("course_diffuse.toml", 2000);
        assert!(report.rows[1].share == 0.0 && report.rows[0].photons == report.rows[1].photons);
    }
}
