use std::collections::BTreeMap;
use std::path::{Path, PathBuf, absolute};

use clap::Parser;

use super::args::{Arguments, Command, FarmStatusArgs, SubmitArgs};
use super::batch;
use super::console::{print, print_json};
use super::error::{CliError, Outcome};
use super::pictures::PicturePath;
use crate::farm::slurm::{self, Resources, Submitted};
use crate::farm::{FarmError, Jobs, Picture, Progress, Submission, TaskState, Work, array_list};

/// Writes the folder of what is to be spread over machines, and submits the tasks that are not whole.
pub fn submit(args: &SubmitArgs) -> Result<Outcome, CliError> {
    let work = if args.each { Work::Jobs(jobs(args)?) } else { Work::Picture(picture(args)?) };
    let program = std::env::current_exe().map_err(|source| CliError::Program { source })?;
    let submission = Submission { version: env!("CARGO_PKG_VERSION").into(), program, work };
    check_commands(&submission)?;
    let folder = folder(args)?;
    submission.write(&folder)?;
    let progress = Progress::of(&submission, &folder)?;
    if args.dry_run {
        note!("{} holds the commands, one a line", folder.join("tasks.txt").display());
        print(format_args!("{}\n", array_list(&progress.unfinished())))?;
        return Ok(Outcome::Done);
    }
    submit_unfinished(args, &folder, &progress)
}

fn folder(args: &SubmitArgs) -> Result<PathBuf, CliError> {
    let beside = || if args.each { args.output.clone() } else { args.output.with_extension("farm") };
    absolute_path(&args.folder.clone().unwrap_or_else(beside))
}

fn submit_unfinished(args: &SubmitArgs, folder: &Path, progress: &Progress) -> Result<Outcome, CliError> {
    let queued = slurm::queued(folder)?;
    let tasks: Vec<u32> =
        progress.unfinished().into_iter().filter(|number| !queued.contains_key(number)).collect();
    if tasks.is_empty() && (!queued.is_empty() || progress.is_complete) {
        note!("{} tasks are in the queue, the others are whole: nothing to submit", queued.len());
        return Ok(Outcome::Done);
    }
    let resources = Resources { cpus: args.cpus, grace: args.grace, further: further(args)? };
    let Submitted { array, merge } = slurm::submit(folder, &name(args), &tasks, &resources)?;
    let told = [
        array.as_ref().map(|job| format!("job {job}, {} tasks", tasks.len())),
        merge.as_ref().map(|job| format!("job {job} merges")),
    ];
    let told = told.into_iter().flatten().collect::<Vec<_>>().join("; ");
    note!("{told}; `caustica status {}` tells how far it is", folder.display());
    print(format_args!("{}\n", merge.or(array).unwrap_or_default()))?;
    Ok(Outcome::Done)
}

/// By which Slurm calls it.
fn name(args: &SubmitArgs) -> String {
    let of = args.output.file_stem().unwrap_or_default();
    format!("caustica-{}", of.to_string_lossy())
}

fn picture(args: &SubmitArgs) -> Result<Picture, CliError> {
    let [scene] = &args.work[..] else { return Err(CliError::OneScene) };
    let output = absolute_path(&args.output)?;
    PicturePath::new(&output)?;
    Ok(Picture {
        scene: absolute_path(Path::new(scene))?,
        flags: args.flags.clone(),
        passes: args.passes.unwrap_or(1),
        shard_passes: args.shard_passes.unwrap_or(1),
        output,
    })
}

/// The jobs that the lists come to now.
fn jobs(args: &SubmitArgs) -> Result<Jobs, CliError> {
    let lists: Vec<PathBuf> =
        args.work.iter().map(|list| absolute_path(Path::new(list))).collect::<Result<_, _>>()?;
    let words = ["caustica", "batch"].map(PathBuf::from).into_iter().chain(lists.iter().cloned());
    let words = words.chain(args.flags.iter().map(PathBuf::from));
    let refused = |message: String| CliError::BatchFlags { message };
    let parsed = Arguments::try_parse_from(words.map(PathBuf::into_os_string));
    let Command::Batch(batch) = parsed.map_err(|error| refused(error.to_string()))?.command else {
        return Err(refused("they name another command".into()));
    };
    let names = batch::jobs(&batch.run)?.into_iter().map(|job| job.name).collect();
    Ok(Jobs { lists, flags: args.flags.clone(), names, threads: args.cpus })
}

/// Whether the program understands the commands: better now than a thousand times on other machines.
fn check_commands(submission: &Submission) -> Result<(), CliError> {
    let first = submission.tasks(Path::new("."))?.into_iter().next();
    let Some(task) = first else { return Ok(()) };
    match Arguments::try_parse_from(&task.command) {
        Ok(_) => Ok(()),
        Err(error) => Err(CliError::TaskFlags { message: error.to_string() }),
    }
}

fn further(args: &SubmitArgs) -> Result<Vec<String>, CliError> {
    let flags = args.sbatch.as_deref().unwrap_or_default();
    shlex::split(flags).ok_or_else(|| CliError::Quotes { flags: flags.into() })
}

fn absolute_path(path: &Path) -> Result<PathBuf, CliError> {
    absolute(path).map_err(|source| CliError::Program { source })
}

/// Tells how far the tasks of a folder are.
pub fn status(args: &FarmStatusArgs) -> Result<Outcome, CliError> {
    let folder = absolute_path(&args.folder)?;
    let submission = Submission::read(&folder)?;
    let progress = Progress::of(&submission, &folder)?;
    // Files tell what is done wherever they are looked at, Slurm only where it is.
    let queued: Result<BTreeMap<u32, String>, FarmError> = slurm::queued(&folder);
    if args.json {
        let queue = queued.as_ref().ok();
        print_json(&serde_json::json!({ "progress": progress, "queue": queue }))?;
    } else {
        print(told(&progress, queued.as_ref().ok()))?;
        if let Err(error) = &queued {
            note!("warning: {error}");
        }
    }
    Ok(if progress.is_complete { Outcome::Done } else { Outcome::Incomplete })
}

fn told(progress: &Progress, queued: Option<&BTreeMap<u32, String>>) -> String {
    let passes = progress.passes.map_or(String::new(), |(there, all)| format!("{there} of {all} passes; "));
    let [missing, begun, failed, whole] = TaskState::ALL.map(|state| progress.count(state));
    let tasks = progress.tasks.len();
    let mut text = format!(
        "{passes}of {tasks} tasks {whole} whole, {begun} begun, {failed} failed, {missing} missing\n"
    );
    let unfinished = progress.unfinished();
    if !unfinished.is_empty() {
        text += &format!("unfinished: --array={}\n", array_list(&unfinished));
    }
    let mut states: BTreeMap<&str, usize> = BTreeMap::new();
    for state in queued.into_iter().flat_map(BTreeMap::values) {
        *states.entry(state).or_default() += 1;
    }
    for (state, count) in states {
        text += &format!("in the queue: {count} {state}\n");
    }
    text + if progress.is_complete { "complete\n" } else { "not complete\n" }
}
