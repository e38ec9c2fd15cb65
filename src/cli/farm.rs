use std::collections::BTreeMap;
use std::path::{Path, PathBuf, absolute};

use clap::Parser;

use super::args::{Arguments, FarmStatusArgs, SubmitArgs};
use super::console::print;
use super::error::{CliError, Outcome};
use crate::farm::slurm::{self, Jobs, Resources};
use crate::farm::{Progress, Submission, TaskState, array_list};
use crate::output::check_writable;

/// Writes the folder of a picture that is made of shards, and submits the tasks that are not whole.
pub fn submit(args: &SubmitArgs) -> Result<Outcome, CliError> {
    let submission = submission(args)?;
    check_flags(&submission)?;
    if submission.output.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("exr")) {
        return Err(CliError::NotExrName { path: submission.output });
    }
    check_writable(&submission.output).map_err(CliError::BadOutput)?;
    let folder = args.folder.clone().unwrap_or_else(|| args.output.with_extension("farm"));
    let folder = absolute_path(&folder)?;
    submission.write(&folder)?;
    let progress = Progress::of(&submission, &folder)?;
    if args.dry_run {
        note!("{}: a command a line, and merge.sh to end with", folder.join("tasks.txt").display());
        print(format_args!("{}\n", array_list(&progress.unfinished())))?;
        return Ok(Outcome::Done);
    }
    submit_unfinished(args, &folder, &progress)
}

fn submit_unfinished(args: &SubmitArgs, folder: &Path, progress: &Progress) -> Result<Outcome, CliError> {
    let queued = slurm::queued(folder)?;
    let tasks: Vec<u32> =
        progress.unfinished().into_iter().filter(|number| !queued.contains_key(number)).collect();
    if tasks.is_empty() && !queued.is_empty() {
        note!("{} tasks are in the queue, the others are whole: nothing to submit", queued.len());
        return Ok(Outcome::Done);
    }
    let name = args.scene.file_stem().unwrap_or_default().to_string_lossy();
    let resources = Resources { cpus: args.cpus, grace: args.grace, further: further(args)? };
    let Jobs { array, merge } = slurm::submit(folder, &format!("caustica-{name}"), &tasks, &resources)?;
    let array =
        array.map_or_else(|| "no task is missing".into(), |job| format!("job {job}, {} tasks", tasks.len()));
    note!("{array}; the merge is job {merge}; caustica status {} tells how far it is", folder.display());
    print(format_args!("{merge}\n"))?;
    Ok(Outcome::Done)
}

fn submission(args: &SubmitArgs) -> Result<Submission, CliError> {
    let program = std::env::current_exe().map_err(|source| CliError::Program { source })?;
    Ok(Submission {
        version: env!("CARGO_PKG_VERSION").into(),
        program,
        scene: absolute_path(&args.scene)?,
        flags: args.flags.clone(),
        passes: args.passes,
        shard_passes: args.shard_passes,
        output: absolute_path(&args.output)?,
    })
}

/// Whether `caustica render` understands the commands: better now than a thousand times on other machines.
fn check_flags(submission: &Submission) -> Result<(), CliError> {
    let first = submission.tasks(Path::new("."))?.into_iter().next();
    let Some(task) = first else { return Ok(()) };
    match Arguments::try_parse_from(&task.command) {
        Ok(_) => Ok(()),
        Err(error) => Err(CliError::RenderFlags { message: error.to_string() }),
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
    let queued = slurm::queued(&folder);
    if args.json {
        let queue = queued.as_ref().ok();
        print(format_args!("{}\n", serde_json::json!({ "progress": progress, "queue": queue })))?;
    } else {
        print(told(&submission, &progress, queued.as_ref().ok()))?;
        if let Err(error) = &queued {
            note!("warning: {error}");
        }
    }
    Ok(if progress.picture { Outcome::Done } else { Outcome::BoundExceeded })
}

fn told(submission: &Submission, progress: &Progress, queued: Option<&BTreeMap<u32, String>>) -> String {
    let Progress { passes, of, tasks, picture } = progress;
    let [whole, begun, missing] =
        [TaskState::Whole, TaskState::Begun, TaskState::Missing].map(|state| progress.count(state));
    let mut text = format!(
        "{passes} of {of} passes; of {} tasks {whole} whole, {begun} begun, {missing} missing\n",
        tasks.len()
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
    let there = if *picture { "there" } else { "not there yet" };
    text + &format!("{}: {there}\n", submission.output.display())
}
