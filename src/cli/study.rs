use std::cell::{Cell, RefCell};
use std::path::Path;
use std::time::{Duration, Instant};

use indicatif::ProgressBar;

use super::args::StudyArgs;
use super::console::print;
use super::error::{CliError, Outcome};
use super::interrupt::Interrupt;
use super::loading::load;
use super::threads::use_threads;
use super::{circumstances, memory, progress};
use crate::bench::machine::Machine;
use crate::output::{check_writable, read_exr, read_exr_named, write_bytes};
use crate::ppm::{Render, Settings};
use crate::report::Table;
use crate::scene::{FilmDesc, Scene, SceneDesc};
use crate::study::reference::{self, Recipe, Reference};
use crate::study::{
    Axis, Configuration, Gallery, Journal, Plan, StudyError, StudyReport, Subject, Watch, configurations,
    measure, page, prices,
};

/// Measures error against seconds, and reports what there is however it ends.
pub fn run(args: &StudyArgs) -> Result<Outcome, CliError> {
    use_threads(args.threads)?;
    let mut desc = load(&args.scene, &args.access)?;
    let given = args.reference.as_deref().map(|path| given(path, args)).transpose()?;
    let settings = Settings::of_scene(&desc.render);
    desc.film = film(args, &desc, given.as_ref());
    memory::check_render(&desc, &settings)?;
    let subject = Subject {
        scene: args.scene.display().to_string(),
        size: (desc.film.width, desc.film.height),
        settings,
    };
    let baseline = baseline(&desc, settings, args.seed)?;
    let configurations = configurations(baseline, &axes(args));
    if args.list {
        list(&configurations, &subject)?;
        return Ok(Outcome::Done);
    }
    let study = Study { args, subject, machine: Machine::detect()?, watch: Overseer::new(args) };
    study.make(desc, configurations, baseline, given)
}

fn given(path: &Path, args: &StudyArgs) -> Result<Reference, CliError> {
    let reference = Reference::given(read_exr(path).map_err(CliError::BadImage)?, path);
    let Some(path) = &args.reference_stderr else { return Ok(reference) };
    let standard_error = read_exr_named(path).map_err(CliError::BadImage)?;
    Ok(reference.with_standard_error(standard_error).map_err(StudyError::Compare)?)
}

/// Pictures as large as asked for, as the reference that was given, or as the effort allows.
fn film(args: &StudyArgs, desc: &SceneDesc, given: Option<&Reference>) -> FilmDesc {
    let of_reference =
        given.map(|reference| (reference.image.width() as u32, reference.image.height() as u32));
    let longest = desc.film.width.max(desc.film.height);
    let side = args.effort().longest_side.map_or(longest, |side| side.min(longest));
    let scaled = |length: u32| (length * side).div_ceil(longest);
    let of_effort = (scaled(desc.film.width), scaled(desc.film.height));
    desc.film.resized(args.size.or(of_reference).unwrap_or(of_effort))
}

/// The scene's settings with the radius that it would find, so that multiples of it mean something.
fn baseline(desc: &SceneDesc, settings: Settings, seed: u64) -> Result<Settings, CliError> {
    let radius = match settings.radius {
        Some(radius) => radius,
        None => Render::new(&Scene::new(desc.clone())?, settings).setup().radius,
    };
    Ok(Settings { radius: Some(radius), seed, ..settings })
}

fn axes(args: &StudyArgs) -> Vec<Axis> {
    if args.axes.is_empty() { Axis::ALL.to_vec() } else { args.axes.clone() }
}

fn list(configurations: &[Configuration], subject: &Subject) -> Result<(), CliError> {
    for configuration in configurations {
        let command = configuration.command(subject, 64, 1);
        print(format_args!("{:<10} {:<24} {command}\n", configuration.axis, configuration.name))?;
    }
    Ok(())
}

/// A study under way.
struct Study<'a> {
    args: &'a StudyArgs,
    subject: Subject,
    machine: Machine,
    watch: Overseer,
}

/// The shares of the budget: the rest is for comparing and reporting.
const REFERENCE_SHARE: f64 = 0.25;
const RUNS_SHARE: f64 = 0.65;

impl Study<'_> {
    fn make(
        &self,
        desc: SceneDesc,
        configurations: Vec<Configuration>,
        baseline: Settings,
        given: Option<Reference>,
    ) -> Result<Outcome, CliError> {
        let folder = &self.args.output;
        for name in ["study.json", "study.csv", "study.html"] {
            check_writable(&folder.join(name)).map_err(CliError::BadOutput)?;
        }
        let measurements = folder.join("measurements.jsonl");
        let mut journal = Journal::open(&measurements)?;
        if journal.was_torn() {
            note!("warning: the last line of {} was torn, and is left out", measurements.display());
        }
        let reference = match given {
            Some(reference) => reference,
            None => match self.reference(&desc, baseline)? {
                Some(reference) => reference,
                None => return Ok(self.outcome()),
            },
        };
        let plan = self.plan(desc, configurations);
        let finished = journal.runs().len();
        let (runs, pictures) = (plan.runs(), folder.join("pictures"));
        self.watch.announce("run", runs.into());
        let measured = measure(&plan, &reference, &mut journal, &pictures, &self.watch);
        self.watch.bar.borrow().finish_and_clear();
        measured?;
        let now = journal.runs().len() - finished;
        note!("{now} runs measured now; {finished} were noted before, those of other settings included");
        let report = StudyReport::new(
            &plan,
            &self.subject,
            journal.runs(),
            &reference,
            self.machine.clone(),
            circumstances::typed(),
        );
        self.write(&report, &Gallery::read(&plan, &reference.image, &pictures)?)?;
        Ok(self.outcome())
    }

    fn outcome(&self) -> Outcome {
        if self.watch.interrupt.is_asked() { Outcome::Interrupted } else { Outcome::Done }
    }

    fn reference(&self, desc: &SceneDesc, baseline: Settings) -> Result<Option<Reference>, CliError> {
        let effort = self.args.effort();
        let seconds = REFERENCE_SHARE * self.args.budget();
        let recipe = Recipe::new(baseline, effort.reference_passes, effort.reference_renders, seconds);
        self.watch.announce("reference", recipe.renders.into());
        let made = reference::make(desc, &recipe, &self.args.output, &self.watch)?;
        self.watch.bar.borrow().finish_and_clear();
        let Some(reference) = made else {
            note!("stopped before the reference was whole; the same command goes on with it");
            return Ok(None);
        };
        if let Some(manifest) = &reference.manifest {
            let origin = if reference.cached { "was there" } else { "was made" };
            note!(
                "reference {} {origin}: {} renders of {} passes; halves differ by {:.2} %, so its own error is about {:.2} %",
                reference.path.display(),
                manifest.renders,
                manifest.passes,
                manifest.halves_differ_percent,
                manifest.error_percent
            );
        }
        Ok(Some(reference))
    }

    fn plan(&self, desc: SceneDesc, configurations: Vec<Configuration>) -> Plan {
        let runs = f64::from(self.args.repetitions) * configurations.len() as f64;
        let share = if self.args.make_reference { RUNS_SHARE } else { RUNS_SHARE + REFERENCE_SHARE };
        Plan {
            desc,
            configurations,
            repetitions: self.args.repetitions,
            seconds_per_run: share * self.args.budget() / runs,
            seed: self.args.seed,
            surroundings: format!("{:?} {} {}", self.machine, rayon::current_num_threads(), program()),
        }
    }

    fn write(&self, report: &StudyReport, gallery: &Gallery) -> Result<(), CliError> {
        let folder = &self.args.output;
        let html = folder.join("study.html");
        write_bytes(&folder.join("study.json"), format!("{:#}\n", serde_json::json!(report)))?;
        write_bytes(&folder.join("study.csv"), report.points().to_csv())?;
        write_bytes(&html, page(report, gallery))?;
        print(without_commands(prices(report)).to_text())?;
        if !report.complete {
            note!("not all was measured; the same command goes on with it");
        }
        note!("wrote {}, and study.json and study.csv beside it", html.display());
        Ok(())
    }
}

/// What tells this build from others, whose times are not its own.
fn program() -> String {
    let file = std::env::current_exe().and_then(std::fs::metadata);
    file.map_or_else(|_| String::new(), |file| format!("{} {:?}", file.len(), file.modified().ok()))
}

/// Too wide for a terminal.
fn without_commands(mut table: Table) -> Table {
    table.columns.pop();
    table.rows.iter_mut().for_each(|row| drop(row.pop()));
    table
}

/// Shows progress, and ends the study when the user or the budget says so.
struct Overseer {
    interrupt: Interrupt,
    deadline: Option<Instant>,
    /// Late or not, one run is measured: some number stands in every report.
    first_is_done: Cell<bool>,
    bar: RefCell<ProgressBar>,
}

impl Overseer {
    fn new(args: &StudyArgs) -> Overseer {
        let deadline = Instant::now().checked_add(Duration::from_secs_f64(args.budget()));
        let bar = RefCell::new(ProgressBar::hidden());
        Overseer { interrupt: Interrupt::listen(), deadline, first_is_done: Cell::new(false), bar }
    }

    fn announce(&self, what: &'static str, count: u64) {
        self.first_is_done.set(false);
        *self.bar.borrow_mut() = progress::bar(what, Some(count));
    }
}

impl Watch for Overseer {
    fn is_over(&self) -> bool {
        let is_late = self.deadline.is_some_and(|deadline| Instant::now() > deadline);
        self.interrupt.is_asked() || is_late && self.first_is_done.get()
    }

    fn begins(&self, configuration: &str, repetition: u32) {
        self.bar.borrow().set_message(format!("{configuration} ({})", repetition + 1));
    }

    fn is_done(&self) {
        self.first_is_done.set(true);
        self.bar.borrow().inc(1);
    }
}
