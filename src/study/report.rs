use serde::Serialize;

use super::fit::pareto_front;
use super::reference::{Manifest, Reference};
use super::{Axis, Curve, Duel, Parts, Plan, Run, Subject};
use crate::bench::machine::Machine;
use crate::report::{Cell, Table};

/// Errors in percent to which the seconds are told.
pub const TARGETS: [f64; 4] = [10.0, 5.0, 2.0, 1.0];

/// A configuration that gives the smallest error for its time.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrontRow {
    /// The configuration.
    pub name: &'static str,
    /// Passes, or samples a pixel.
    pub steps: u32,
    /// Median seconds.
    pub seconds: f64,
    /// Mean error in percent.
    pub error_percent: f64,
    /// The command that renders it.
    pub command: String,
}

/// A study and what it was made on.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StudyReport {
    /// The scene file.
    pub scene: String,
    /// Width and height of the pictures.
    pub size: (u32, u32),
    /// Threads that rendered.
    pub threads: usize,
    /// Seconds that each run had.
    pub seconds_per_run: f64,
    /// Repetitions asked for.
    pub repetitions: u32,
    /// Whether all of them were made.
    pub complete: bool,
    /// The file that all were held against.
    pub reference: String,
    /// How good it is; none for one that the user gave.
    pub reference_made: Option<Manifest>,
    /// Whether the variance of that file is known, and not in the squared bias.
    pub reference_noise_is_known: bool,
    /// What each configuration measured.
    pub curves: Vec<Curve>,
    /// The best of all, by ascending seconds.
    pub front: Vec<FrontRow>,
    /// Other methods beside the baseline, in equal time.
    pub duels: Vec<Duel>,
    /// What it was measured on.
    pub machine: Machine,
    /// The command that made the study.
    pub command: String,
}

impl StudyReport {
    /// Sums up what the runs of a plan measured so far.
    pub fn new(
        plan: &Plan,
        subject: &Subject,
        runs: &[Run],
        reference: &Reference,
        machine: Machine,
        command: String,
    ) -> StudyReport {
        let print = reference.fingerprint();
        let mut curves = Vec::new();
        let mut finished = 0;
        for configuration in &plan.configurations {
            let key = plan.key(configuration, print);
            let mut of_it: Vec<&Run> =
                runs.iter().filter(|run| run.key == key && run.repetition < plan.repetitions).collect();
            of_it.sort_by_key(|run| run.repetition);
            finished += of_it.len();
            curves.extend(Curve::of(configuration, &of_it, &plan.desc, subject, &TARGETS));
        }
        StudyReport {
            scene: subject.scene.clone(),
            size: subject.size,
            threads: rayon::current_num_threads(),
            seconds_per_run: plan.seconds_per_run,
            repetitions: plan.repetitions,
            complete: finished == plan.runs() as usize,
            reference: reference.path.display().to_string(),
            reference_made: reference.manifest.clone(),
            reference_noise_is_known: reference.standard_error.is_some(),
            front: front(&curves),
            duels: duels(&curves),
            curves,
            machine,
            command,
        }
    }

    /// Every point of every configuration.
    pub fn points(&self) -> Table {
        let columns = vec![
            "configuration",
            "axis",
            "steps",
            "repetitions",
            "seconds",
            "min",
            "max",
            "error (%)",
            "min (%)",
            "max (%)",
            "relative MSE",
            "variance",
            "squared bias",
            "its standard error",
            "squared bias, flat",
            "its standard error, flat",
            "command",
        ];
        let row = |curve: &Curve, point: &super::CurvePoint| {
            let (seconds, error) = (point.seconds, point.error_percent);
            let numbers =
                [seconds.median, seconds.min, seconds.max, error.mean, error.min, error.max, point.rel_mse];
            let mut cells = vec![Cell::Text(curve.name.into()), Cell::Text(curve.axis.clone())];
            cells.extend([Cell::Count(point.steps.into()), Cell::Count(point.repetitions as u64)]);
            cells.extend(numbers.map(Cell::Number));
            cells.extend(parts(point).map(Cell::Number));
            cells.push(Cell::Code(point.command.clone()));
            cells
        };
        let rows =
            self.curves.iter().flat_map(|curve| curve.points.iter().map(move |point| row(curve, point)));
        Table { columns, rows: rows.collect() }
    }
}

/// Of the baseline with every other method.
fn duels(curves: &[Curve]) -> Vec<Duel> {
    let on = |axis: Axis| curves.iter().filter(move |curve| curve.axis == axis.to_string());
    let Some(baseline) = on(Axis::Baseline).next() else { return Vec::new() };
    on(Axis::Method).filter_map(|rival| Duel::between(baseline, rival)).collect()
}

/// Variance, squared bias and its standard error of all pixels, and the latter two of those whose discs lie flat; NaN where
/// nothing is known.
fn parts(point: &super::CurvePoint) -> [f64; 5] {
    let all = point.separation.map(|separation| separation.all);
    let flat = point.separation.and_then(|separation| separation.flat);
    let of = |parts: Option<Parts>, number: fn(Parts) -> f64| parts.map_or(f64::NAN, number);
    [
        of(all, |parts| parts.variance),
        of(all, |parts| parts.bias2),
        of(all, |parts| parts.bias2_error),
        of(flat, |parts| parts.bias2),
        of(flat, |parts| parts.bias2_error),
    ]
}

/// The points that none beats in time and error, along all curves.
fn front(curves: &[Curve]) -> Vec<FrontRow> {
    let all: Vec<(&Curve, &super::CurvePoint)> =
        curves.iter().flat_map(|curve| curve.points.iter().map(move |point| (curve, point))).collect();
    let coordinates: Vec<(f64, f64)> =
        all.iter().map(|(_, point)| (point.seconds.median, point.error_percent.mean)).collect();
    let row = |index: usize| {
        let (curve, point) = all[index];
        FrontRow {
            name: curve.name,
            steps: point.steps,
            seconds: point.seconds.median,
            error_percent: point.error_percent.mean,
            command: point.command.clone(),
        }
    };
    pareto_front(&coordinates).into_iter().map(row).collect()
}
