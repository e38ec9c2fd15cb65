use std::collections::BTreeMap;
use std::env;
use std::path::{Path, PathBuf};
use std::thread::available_parallelism;
use std::time::{Duration, Instant};

use clap::{ArgAction, CommandFactory};
use indicatif::ProgressBar;
use serde::Serialize;

use super::args::{
    Arguments, AtOnce, BatchArgs, BatchCommand, ReportArgs, RunBatchArgs, ShareArgs, StatusArgs,
};
use super::console::{print, print_json};
use super::error::{CliError, Outcome};
use super::interrupt::Interrupt;
use super::{progress, worker};
use crate::batch::{
    self, BatchError, Change, Crew, Job, Kind, Layout, Ledger, Lock, Options, Row, Schedule, Settings,
    Standing, State, Verdict, Vocabulary, Watch, hash_file,
};
use crate::output::write_bytes;
use crate::report::{Cell, Table};

/// Renders many scenes, or tells how that stands.
pub fn run(args: &BatchArgs) -> Result<Outcome, CliError> {
    match &args.command {
        None => start(&args.run),
        Some(BatchCommand::Resume(args)) => resume(&args.folder, &args.share),
        Some(BatchCommand::Status(args)) => status(args),
        Some(BatchCommand::Report(args)) => report(args),
    }
}

fn start(args: &RunBatchArgs) -> Result<Outcome, CliError> {
    let jobs = jobs(args)?;
    let lock = Lock::take(&args.output)?;
    let mut ledger = Ledger::open(&args.output)?;
    let here = env::current_dir().map_err(|source| BatchError::File { path: ".".into(), source })?;
    ledger.enlist(&jobs, &here)?;
    go(&args.output, ledger, &args.share, lock)
}

/// The jobs of the lists, or those that are asked for by name.
pub fn jobs(args: &RunBatchArgs) -> Result<Vec<Job>, CliError> {
    let options = Options {
        sweep: args.sweep.clone(),
        budget: budget(args),
        retries: args.retries,
        memory_limit: args.memory_limit,
    };
    let flags = flags();
    let vocabulary = Vocabulary { flags, barred: &BARRED, check: &check };
    let jobs = batch::jobs(&args.lists, &options, &vocabulary)?;
    match args.only.iter().find(|name| jobs.iter().all(|job| job.name != **name)) {
        Some(name) => Err(CliError::NoSuchJob { name: name.clone() }),
        None if args.only.is_empty() => Ok(jobs),
        None => Ok(jobs.into_iter().filter(|job| args.only.contains(&job.name)).collect()),
    }
}

fn resume(folder: &Path, share: &ShareArgs) -> Result<Outcome, CliError> {
    if !folder.join(batch::LEDGER).is_file() {
        return Err(BatchError::NoLedger { folder: folder.into() }.into());
    }
    let lock = Lock::take(folder)?;
    go(folder, Ledger::open(folder)?, share, lock)
}

/// The lock is held until all is written.
fn go(folder: &Path, mut ledger: Ledger, share: &ShareArgs, _lock: Lock) -> Result<Outcome, CliError> {
    let crew = crew(folder)?;
    let mut overseer = Overseer::new(share.json);
    let standing = batch::run(&crew, &mut ledger, |jobs| schedule(share, jobs), &mut overseer)?;
    overseer.bar.finish_and_clear();
    tell_end(folder, &ledger.rows()?, &standing, overseer.started.elapsed());
    Ok(match (overseer.interrupt.is_asked(), standing.failed) {
        (true, _) if standing.waiting() > 0 => Outcome::Interrupted,
        (_, 0) => Outcome::Done,
        _ => Outcome::SomeFailed,
    })
}

fn crew(folder: &Path) -> Result<Crew, CliError> {
    let failed = |path: &Path| {
        let path = path.to_owned();
        move |source| BatchError::File { path, source }
    };
    // The very file that runs, even where another was put in its place.
    let itself = PathBuf::from("/proc/self/exe");
    let program = if itself.exists() { Ok(itself) } else { env::current_exe() };
    let program = program.map_err(failed(Path::new("caustica")))?;
    let hash = hash_file(&program).map_err(failed(&program))?;
    let version = format!("{} ({})", env!("CARGO_PKG_VERSION"), &hash[..16]);
    let folder = folder.canonicalize().map_err(failed(folder))?;
    Ok(Crew { program, version, folder })
}

fn schedule(share: &ShareArgs, jobs: usize) -> Schedule {
    let cores = available_parallelism().map_or(1, usize::from);
    match (share.jobs, share.threads) {
        (AtOnce::Auto, None) => Schedule::by_trial(cores, jobs),
        (AtOnce::Auto, Some(threads)) => Schedule::fixed(Layout { jobs: (cores / threads).max(1), threads }),
        (AtOnce::Number(jobs), threads) => {
            Schedule::fixed(Layout { jobs, threads: threads.unwrap_or((cores / jobs).max(1)) })
        }
    }
}

fn budget(args: &RunBatchArgs) -> Settings {
    let mut budget = Settings::default();
    let given = [
        ("passes", args.passes.map(|passes| passes.to_string())),
        ("time", args.time.map(|seconds| seconds.to_string())),
        ("target-error", args.target_error.map(|error| error.to_string())),
    ];
    for (flag, value) in given {
        budget.set(flag, value.map(|value| vec![value]));
    }
    budget
}

/// Flags of `caustica render` that are not for jobs.
const BARRED: [(&str, &str); 11] = [
    ("output", "its picture is FOLDER/NAME.exr; give `name`"),
    ("threads", "the batch shares them out; give --threads to `caustica batch`"),
    ("reproducible", "pictures of a batch always are"),
    ("resume", "jobs always go on from their checkpoint"),
    ("checkpoint", "the batch keeps it"),
    ("json", "the ledger keeps times and errors"),
    ("every-pass", "a job has one picture"),
    ("direct", "a job has one picture; `transport = \"direct\"` makes that of direct light"),
    ("partial", "a job has a picture, not a shard; `caustica submit` spreads one over machines"),
    ("display-server", "a viewer shows one render"),
    ("denoise", "a job has one picture"),
];

/// The flags of `caustica render`, by clap's table of them.
fn flags() -> BTreeMap<String, Kind> {
    let program = Arguments::command();
    let render = program.find_subcommand("render").into_iter();
    let kind = |flag: &clap::Arg| match flag.get_action() {
        ArgAction::SetTrue => Kind::Switch,
        ArgAction::Append if flag.get_value_delimiter().is_some() => Kind::Commas,
        ArgAction::Append => Kind::Repeated,
        _ => Kind::Value,
    };
    let flags = render.flat_map(clap::Command::get_arguments);
    let named = flags.filter_map(|flag| Some((flag.get_long()?.to_owned(), kind(flag))));
    named.filter(|(name, _)| BARRED.iter().all(|(barred, _)| barred != name) && name != "help").collect()
}

fn check(arguments: &[String]) -> Result<(), String> {
    worker::parse(arguments).map(drop).map_err(|error| {
        let text = error.render().to_string();
        let lines = text
            .lines()
            .map(|line| line.trim().trim_start_matches("error: "))
            .take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more information"));
        lines.filter(|line| !line.is_empty()).collect::<Vec<_>>().join("; ")
    })
}

fn tell_end(folder: &Path, rows: &[Row], standing: &Standing, elapsed: Duration) {
    const MOST_TOLD: usize = 20;
    let failed: Vec<&Row> = rows.iter().filter(|row| row.is_listed && row.state == State::Failed).collect();
    for row in failed.iter().take(MOST_TOLD) {
        note!("failed: {}: {}", row.job.name, row.reason.as_deref().unwrap_or("unknown"));
    }
    if failed.len() > MOST_TOLD {
        note!("and {} more; `caustica batch status {}` has all", failed.len() - MOST_TOLD, folder.display());
    }
    let Standing { jobs, unchanged, done, failed, .. } = *standing;
    let waiting = standing.waiting();
    note!(
        "{jobs} jobs: {done} done now in {:.1} s, {unchanged} unchanged, {failed} failed, {waiting} waiting",
        elapsed.as_secs_f64()
    );
    if waiting > 0 {
        note!("`caustica batch resume {}` goes on", folder.display());
    }
}

/// Shows how the batch stands, and ends it when the user says so.
struct Overseer {
    interrupt: Interrupt,
    started: Instant,
    bar: ProgressBar,
    json: bool,
    shown: Option<Instant>,
}

impl Overseer {
    fn new(json: bool) -> Overseer {
        let bar = progress::styled(ProgressBar::new(0), "job {pos}/{len} [{wide_bar}] {msg}");
        Overseer { interrupt: Interrupt::listen(), started: Instant::now(), bar, json, shown: None }
    }

    /// Whoever listens may be gone; the ledger counts.
    fn event(&self, event: &impl Serialize) {
        if self.json {
            drop(print_json(event));
        }
    }
}

/// How often a line of JSON tells how the batch stands.
const BETWEEN_LINES: Duration = Duration::from_secs(1);

impl Watch for Overseer {
    fn is_over(&self) -> bool {
        self.interrupt.is_asked()
    }

    fn step(&mut self, change: &Change) {
        self.event(change);
        if let Change::Ended {
            job,
            verdict: verdict @ (Verdict::Failed { reason } | Verdict::Died { reason, .. }),
            ..
        } = change
        {
            let again =
                if matches!(verdict, Verdict::Died { again: true, .. }) { "; it is begun again" } else { "" };
            self.bar.suspend(|| note!("{job}: {reason}{again}"));
        }
    }

    fn layout(&mut self, layout: Layout, measured: &str) {
        let Layout { jobs, threads } = layout;
        self.event(
            &serde_json::json!({ "layout": { "jobs": jobs, "threads": threads, "measured": measured } }),
        );
        self.bar.suspend(|| note!("{jobs} jobs at once with {threads} threads each ({measured})"));
    }

    fn standing(&mut self, standing: &Standing) {
        let Standing { jobs, unchanged, done, failed, rendering, loading, seconds_left } = *standing;
        self.bar.set_length(jobs as u64);
        self.bar.set_position((unchanged + done + failed) as u64);
        let left = seconds_left.map_or(String::new(), |seconds| format!(", {} left", duration(seconds)));
        self.bar.set_message(format!("{failed} failed, {rendering} rendering, {loading} loading{left}"));
        if self.json && self.shown.is_none_or(|shown| shown.elapsed() > BETWEEN_LINES) {
            self.shown = Some(Instant::now());
            self.event(&serde_json::json!({ "standing": standing }));
        }
    }
}

fn duration(seconds: f64) -> String {
    let seconds = seconds.clamp(0.0, 1e9).round() as u64;
    match (seconds / 3600, seconds / 60 % 60, seconds % 60) {
        (0, 0, seconds) => format!("{seconds} s"),
        (0, minutes, seconds) => format!("{minutes} min {seconds} s"),
        (hours, minutes, _) => format!("{hours} h {minutes} min"),
    }
}

fn status(args: &StatusArgs) -> Result<Outcome, CliError> {
    let ledger = Ledger::look(&args.folder)?;
    let rows: Vec<Row> = ledger.rows()?.into_iter().filter(|row| row.is_listed).collect();
    if args.json {
        for row in &rows {
            print_json(&status_line(row, &ledger)?)?;
        }
        return Ok(Outcome::Done);
    }
    let cells = |row: &Row| {
        let number = |number: Option<f64>| {
            Cell::Number(number.filter(|_| row.state == State::Done).unwrap_or(f64::NAN))
        };
        vec![
            Cell::Text(row.job.name.clone()),
            Cell::Text(row.state.name().into()),
            number(row.seconds),
            number(row.error.map(|error| 100.0 * error)),
            Cell::Text(row.reason.clone().unwrap_or_default()),
        ]
    };
    let columns = vec!["job", "state", "seconds", "error (%)", "reason"];
    print(Table { columns, rows: rows.iter().map(cells).collect() }.to_text())?;
    let count = |state| rows.iter().filter(|row| row.state == state).count();
    let counts = State::ALL.map(|state| format!("{} {}", count(state), state.name()));
    print(format_args!("\n{} jobs: {}\n", rows.len(), counts.join(", ")))?;
    Ok(Outcome::Done)
}

/// A job with its files and attempts.
fn status_line(row: &Row, ledger: &Ledger) -> Result<serde_json::Value, CliError> {
    let attempts = ledger.attempts(&row.job.name)?;
    Ok(serde_json::json!({
        "job": row.job.name,
        "scene": row.job.scene,
        "settings": row.job.settings,
        "state": row.state.name(),
        "reason": row.reason,
        "program": row.program,
        "passes": row.passes,
        "seconds": row.seconds,
        "error": row.error,
        "error_bound": row.error_bound,
        "inputs": ledger.inputs(&row.job.name)?,
        "outputs": ledger.outputs(&row.job.name)?,
        "attempts": attempts,
    }))
}

fn report(args: &ReportArgs) -> Result<Outcome, CliError> {
    let ledger = Ledger::look(&args.folder)?;
    let (html, path) = (batch::page(&ledger, &args.folder)?, args.folder.join("batch.html"));
    write_bytes(&path, html)?;
    note!("wrote {}", path.display());
    Ok(Outcome::Done)
}
