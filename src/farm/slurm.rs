//! Slurm's programs: `sbatch` and `squeue`.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use super::{FarmError, array_list};
use crate::output::write_bytes;

/// Which jobs were submitted for a folder.
const JOBS: &str = "jobs.txt";

/// What the tasks of an array are given.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Resources {
    /// Threads of a task.
    pub cpus: u32,
    /// Seconds before the end of a task's time at which it is told to keep what it has.
    pub grace: u32,
    /// Further flags of `sbatch`, such as a partition or a limit of time.
    pub further: Vec<String>,
}

/// The numbers of an array and of the merge that waits for it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Submitted {
    /// The array, if any task was to be done.
    pub array: Option<String>,
    /// The merge, if there is one.
    pub merge: Option<String>,
}

/// Submits `tasks` of `folder` as an array, and the merge, if the folder has one, to run when all of them have ended, however they
/// did: the merge itself finds out what is missing.
///
/// # Errors
/// When `sbatch` does not run, or refuses.
pub fn submit(
    folder: &Path,
    name: &str,
    tasks: &[u32],
    resources: &Resources,
) -> Result<Submitted, FarmError> {
    let array = if tasks.is_empty() { None } else { Some(submit_array(folder, name, tasks, resources)?) };
    let script = folder.join("merge.sh");
    if !script.exists() {
        return Ok(Submitted { array, merge: None });
    }
    let mut merge = sbatch(folder, name, "merge", &resources.further);
    merge.args(array.iter().map(|job| format!("--dependency=afterany:{job}")));
    let merge = job_of(&run("sbatch", merge.arg(script))?);
    Ok(Submitted { array, merge: Some(merge) })
}

fn submit_array(
    folder: &Path,
    name: &str,
    tasks: &[u32],
    resources: &Resources,
) -> Result<String, FarmError> {
    let mut command = sbatch(folder, name, "task-%a", &resources.further);
    command
        .arg(format!("--array={}", array_list(tasks)))
        .arg(format!("--cpus-per-task={}", resources.cpus))
        .arg(format!("--signal=B:USR1@{}", resources.grace))
        .args(["--requeue", "--open-mode=append"])
        .arg(folder.join("array.sh"));
    let job = job_of(&run("sbatch", &mut command)?);
    remember(folder, &job)?;
    Ok(job)
}

fn sbatch(folder: &Path, name: &str, log: &str, further: &[String]) -> Command {
    let mut command = Command::new("sbatch");
    let log = folder.join("logs").join(log).with_extension("log");
    command.args(["--parsable", "--job-name", name]).arg("--output").arg(log).args(further);
    command
}

/// `sbatch --parsable` prints the number, and behind a semicolon the name of the cluster.
fn job_of(text: &str) -> String {
    text.trim().split(';').next().unwrap_or_default().to_owned()
}

fn remember(folder: &Path, job: &str) -> Result<(), FarmError> {
    let before = fs::read_to_string(folder.join(JOBS)).unwrap_or_default();
    Ok(write_bytes(&folder.join(JOBS), format!("{before}{job}\n"))?)
}

/// The tasks of `folder` that Slurm has in its queue, with their states in Slurm's words.
///
/// # Errors
/// When `squeue` does not run, or refuses.
pub fn queued(folder: &Path) -> Result<BTreeMap<u32, String>, FarmError> {
    let Ok(jobs) = fs::read_to_string(folder.join(JOBS)) else { return Ok(BTreeMap::new()) };
    let all =
        run("squeue", Command::new("squeue").args(["--noheader", "--array", "--format", "%A %F %K %T"]))?;
    let ours = |job: &str| jobs.lines().any(|line| line == job);
    let task = |line: &str| {
        let mut words = line.split_whitespace().skip(1);
        let (job, number, state) = (words.next()?, words.next()?, words.next()?);
        ours(job).then(|| Some((number.parse().ok()?, state.to_owned()))).flatten()
    };
    Ok(all.lines().filter_map(task).collect())
}

fn run(program: &'static str, command: &mut Command) -> Result<String, FarmError> {
    let output = command.output().map_err(|source| FarmError::NoSlurm { program, source })?;
    let Output { status, stdout, stderr } = output;
    if !status.success() {
        let message = String::from_utf8_lossy(&stderr).trim().to_owned();
        return Err(FarmError::Refused { program, message });
    }
    Ok(String::from_utf8_lossy(&stdout).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_number_is_read_without_the_cluster() {
        assert_eq!(job_of("123\n"), "123");
        assert_eq!(job_of("123;north\n"), "123");
    }
}
