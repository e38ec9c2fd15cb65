//! What shells run.

use super::FarmError;

/// Commands, one a line, quoted for a POSIX shell.
///
/// # Errors
/// When an argument cannot be quoted.
pub(super) fn lines<'a>(commands: impl Iterator<Item = &'a Vec<String>>) -> Result<String, FarmError> {
    commands.map(|command| Ok(line(command)? + "\n")).collect()
}

fn line(command: &[String]) -> Result<String, FarmError> {
    shlex::try_join(command.iter().map(String::as_str))
        .map_err(|_| FarmError::Path { path: command.join(" ").into() })
}

/// A task of a Slurm array: the line of `tasks` that belongs to its index.
///
/// TERM and USR1, which Slurm sends before it ends a job, let the render finish its pass and keep what it has (exit code 130);
/// then the task goes back into the queue. `wait` returns early where a signal comes, so it is asked until the render is gone.
pub(super) fn array(tasks: &str) -> Result<String, FarmError> {
    let tasks = line(&[tasks.to_owned()])?;
    Ok(format!(
        r#"#!/bin/bash
# Written by `caustica submit`: one task of an array is one line of tasks.txt.
command=$(sed -n "$((SLURM_ARRAY_TASK_ID + 1))p" {tasks})
if [ -z "$command" ]; then
    echo "tasks.txt has no line for task $SLURM_ARRAY_TASK_ID" >&2
    exit 2
fi
export CAUSTICA_THREADS="${{SLURM_CPUS_PER_TASK:-1}}"
asked=
trap 'asked=yes; kill -USR1 "$render" 2>/dev/null' TERM USR1
eval "$command &"
render=$!
while true; do
    wait "$render"
    code=$?
    kill -0 "$render" 2>/dev/null || break
done
if [ "$code" -eq 130 ] && [ -n "$asked" ]; then
    echo "stopped by the scheduler; back into the queue"
    exec scontrol requeue "$SLURM_JOB_ID"
fi
exit "$code"
"#
    ))
}

/// What makes the picture when the array has ended.
pub(super) fn merge(command: &[String]) -> Result<String, FarmError> {
    Ok(format!("#!/bin/bash\n# Written by `caustica submit`.\nexec {}\n", line(command)?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::process::Command;

    #[test]
    fn a_shell_gets_the_arguments_back() {
        let command = ["printf", "%s|", "a b", "it's", "$HOME", "\"q\"", "*", "", "x;y", "--f=1"];
        let text = lines([command.map(str::to_owned).to_vec()].iter()).unwrap();
        assert_eq!(text.lines().count(), 1);
        let output = Command::new("sh").args(["-c", &text]).output().unwrap();
        assert_eq!(String::from_utf8(output.stdout).unwrap(), "a b|it's|$HOME|\"q\"|*||x;y|--f=1|");
    }

    /// Runs the script of an array whose tasks are `sh` lines, with an `scontrol` that tells what it was called with.
    fn run_array(tasks: &str, signal: Option<&str>) -> (Option<i32>, String) {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
        std::fs::write(path("tasks.txt"), tasks).unwrap();
        std::fs::write(path("array.sh"), array(&path("tasks.txt")).unwrap()).unwrap();
        std::fs::write(path("scontrol"), "#!/bin/sh\necho scontrol \"$@\"\n").unwrap();
        let script = format!(
            "chmod +x {0}; PATH={1}:$PATH exec bash {2}",
            path("scontrol"),
            folder.path().display(),
            path("array.sh")
        );
        let mut command = Command::new("sh");
        command.args(["-c", &script]).current_dir(folder.path());
        command.env("SLURM_ARRAY_TASK_ID", "1").env("SLURM_JOB_ID", "77").env("SLURM_CPUS_PER_TASK", "3");
        let child = command.stdout(std::process::Stdio::piped()).spawn().unwrap();
        if let Some(signal) = signal {
            while !folder.path().join("ready").exists() {
                std::thread::sleep(std::time::Duration::from_millis(5));
            }
            Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
        }
        let output = child.wait_with_output().unwrap();
        (output.status.code(), String::from_utf8(output.stdout).unwrap())
    }

    #[test]
    fn a_task_runs_its_own_line_with_the_threads_it_was_given() {
        let tasks = "echo no\nsh -c 'echo threads $CAUSTICA_THREADS; exit 5'\n";
        assert_eq!(run_array(tasks, None), (Some(5), "threads 3\n".into()));
        assert_eq!(run_array("echo no\n", None).0, Some(2));
    }

    /// The render ends in its own time, after the signal, and then the task is queued again.
    #[test]
    fn signals_of_the_scheduler_reach_the_render() {
        let tasks = "\nsh -c 'trap \"sleep 0.3; echo kept; exit 130\" USR1; touch ready; while true; do sleep 0.05; done'\n";
        for signal in ["-TERM", "-USR1"] {
            let (code, text) = run_array(tasks, Some(signal));
            assert_eq!(code, Some(0));
            assert_eq!(text, "kept\nstopped by the scheduler; back into the queue\nscontrol requeue 77\n");
        }
        let ends = "\nsh -c 'trap \"exit 0\" USR1; touch ready; while true; do sleep 0.05; done'\n";
        assert_eq!(run_array(ends, Some("-USR1")), (Some(0), String::new()), "whole before it was stopped");
    }
}
