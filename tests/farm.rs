//! `caustica submit` and `caustica status` as a user runs them; Slurm's programs are played by scripts. `make slurm-test` asks Slurm itself.

// Clippy takes helpers outside `#[test]` functions for ordinary code.
#![allow(clippy::expect_used)]

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Output;

use assert_cmd::Command;
use serde_json::Value;
use tempfile::TempDir;

const SUBMISSION: &str = "scene.toml --passes 7 --shard-passes 3 -o out/a.exr";
const RENDER_FLAGS: &str = "-- --size 12x8 --photons 500 --seed 5";

/// A folder with a scene, and a `bin` whose `sbatch` notes what it is given and whose `squeue` tells `queue.txt`.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/cornell_b.toml");
    fs::copy(data, folder.path().join("scene.toml")).expect("the scene is there");
    program(&folder, "sbatch", "echo \"$@\" >> sbatch.txt; echo \"1$(wc -l < sbatch.txt);here\"");
    program(&folder, "squeue", "cat queue.txt");
    fs::write(folder.path().join("queue.txt"), "").expect("the folder is writable");
    folder
}

fn program(folder: &TempDir, name: &str, script: &str) {
    let path = folder.path().join("bin").join(name);
    fs::create_dir_all(folder.path().join("bin")).expect("the folder is writable");
    fs::write(&path, format!("#!/bin/sh\n{script}\n")).expect("the folder is writable");
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).expect("it is ours");
}

fn caustica(folder: &TempDir, arguments: &str) -> Output {
    let mut program = Command::cargo_bin("caustica").expect("the program is built");
    let path = format!("{}/bin:{}", folder.path().display(), std::env::var("PATH").unwrap_or_default());
    program.current_dir(folder.path()).env("PATH", path).args(arguments.split_whitespace());
    program.output().expect("the program runs")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn submitted(folder: &TempDir) -> Vec<String> {
    let text = fs::read_to_string(folder.path().join("sbatch.txt")).unwrap_or_default();
    text.lines().map(str::to_owned).collect()
}

fn status(folder: &TempDir) -> (Option<i32>, Value) {
    let output = caustica(folder, "status out/a.farm --json");
    (output.status.code(), serde_json::from_slice(&output.stdout).expect("it prints JSON"))
}

fn run_line(folder: &TempDir, line: usize) {
    let tasks = fs::read_to_string(folder.path().join("out/a.farm/tasks.txt")).expect("it was written");
    let line = tasks.lines().nth(line).expect("there is such a task");
    let done = std::process::Command::new("sh").args(["-c", line]).output().expect("sh runs");
    assert!(done.status.success(), "{}", text(&done.stderr));
}

/// What GNU parallel would do: any shell runs the commands, in any order.
#[test]
fn the_list_of_commands_is_all_that_an_engine_needs() {
    let folder = folder();
    let output = caustica(&folder, &format!("submit --dry-run {SUBMISSION} {RENDER_FLAGS}"));
    assert_eq!(
        (output.status.code(), text(&output.stdout)),
        (Some(0), "0-2\n".into()),
        "{}",
        text(&output.stderr)
    );
    assert_eq!(status(&folder).1["progress"]["tasks"], serde_json::json!(["missing", "missing", "missing"]));
    run_line(&folder, 2);
    run_line(&folder, 0);
    let (code, json) = status(&folder);
    assert_eq!((code, &json["progress"]["passes"]), (Some(1), &serde_json::json!([4, 7])));
    assert_eq!(json["progress"]["tasks"], serde_json::json!(["whole", "missing", "whole"]));
    let output = caustica(&folder, &format!("submit --dry-run {SUBMISSION} {RENDER_FLAGS}"));
    assert_eq!(text(&output.stdout), "1\n", "what is whole is not to be made again");
    let merge = || std::process::Command::new("sh").arg(folder.path().join("out/a.farm/merge.sh")).output();
    let early = merge().unwrap();
    assert_eq!(early.status.code(), Some(1));
    assert!(text(&early.stdout).contains("--array=1"), "{}", text(&early.stdout));
    run_line(&folder, 1);
    assert!(merge().unwrap().status.success());
    assert_eq!(status(&folder).0, Some(0));
    // The header of a picture names the scene as the command does.
    let scene = folder.path().join("scene.toml");
    let flags = "--size 12x8 --photons 500 --seed 5 --passes 0..7 --partial -o whole.shard";
    assert!(caustica(&folder, &format!("render {} {flags}", scene.display())).status.success());
    assert!(caustica(&folder, "merge whole.shard -o whole.exr").status.success());
    let read = |name: &str| fs::read(folder.path().join(name)).unwrap();
    assert!(read("out/a.exr") == read("whole.exr"), "the picture has the bytes of one piece");
}

#[test]
fn slurm_gets_an_array_and_a_merge_behind_it() {
    let folder = folder();
    let command =
        format!("submit --slurm {SUBMISSION} --cpus 4 --sbatch --time=10 --grace 30 {RENDER_FLAGS}");
    let output = caustica(&folder, &command);
    assert_eq!(
        (output.status.code(), text(&output.stdout)),
        (Some(0), "12\n".into()),
        "{}",
        text(&output.stderr)
    );
    let calls = submitted(&folder);
    assert_eq!(calls.len(), 2, "{calls:?}");
    for part in [
        "--array=0-2 ",
        "--cpus-per-task=4 ",
        "--signal=B:USR1@30 ",
        "--requeue",
        "--time=10 ",
        "a.farm/array.sh",
    ] {
        assert!(calls[0].contains(part), "{part}: {}", calls[0]);
    }
    assert!(
        calls[1].contains("--dependency=afterany:11 ") && calls[1].ends_with("a.farm/merge.sh"),
        "{}",
        calls[1]
    );
}

/// Tasks that wait or run are not submitted twice, those of other arrays do not count.
#[test]
fn given_again_it_submits_what_is_missing() {
    let folder = folder();
    let command = format!("submit --slurm {SUBMISSION} {RENDER_FLAGS}");
    assert!(caustica(&folder, &command).status.success());
    run_line(&folder, 0);
    fs::write(folder.path().join("queue.txt"), "20 11 1 RUNNING\n21 99 2 RUNNING\n22 12 N/A PENDING\n")
        .unwrap();
    assert_eq!(status(&folder).1["queue"], serde_json::json!({ "1": "RUNNING" }));
    assert!(caustica(&folder, &command).status.success());
    let calls = submitted(&folder);
    assert!(calls.len() == 4 && calls[2].contains("--array=2 "), "{calls:?}");
    fs::write(folder.path().join("queue.txt"), "20 11 1 RUNNING\n21 13 2 PENDING\n").unwrap();
    let output = caustica(&folder, &command);
    assert!(text(&output.stderr).contains("nothing to submit"), "{}", text(&output.stderr));
    assert_eq!(submitted(&folder).len(), 4);
    run_line(&folder, 1);
    run_line(&folder, 2);
    fs::write(folder.path().join("queue.txt"), "").unwrap();
    assert!(caustica(&folder, &command).status.success());
    let calls = submitted(&folder);
    assert!(calls.len() == 5 && !calls[4].contains("--dependency"), "the merge alone is left: {calls:?}");
}

const JOBS: &str = "submit --slurm --each scene.toml -o night --cpus 2 -- --set size=8x6 --set photons=300 --set seed=1,2,3 --passes 2";

/// Each job is a batch of its own, with its ledger: what is whole is not made again, what failed is told.
#[test]
fn jobs_of_a_batch_are_tasks_of_an_array() {
    let folder = folder();
    let output = caustica(&folder, JOBS);
    assert_eq!(
        (output.status.code(), text(&output.stdout)),
        (Some(0), "11\n".into()),
        "{}",
        text(&output.stderr)
    );
    let calls = submitted(&folder);
    assert!(
        calls.len() == 1 && calls[0].contains("--array=0-2 ") && calls[0].contains("--cpus-per-task=2 "),
        "{calls:?}"
    );
    let status = || {
        let output = caustica(&folder, "status night --json");
        let json: Value = serde_json::from_slice(&output.stdout).unwrap();
        (output.status.code(), json["progress"]["tasks"].clone())
    };
    assert_eq!(status(), (Some(1), serde_json::json!(["missing", "missing", "missing"])));
    let run = |number: usize| {
        let tasks = fs::read_to_string(folder.path().join("night/tasks.txt")).unwrap();
        let line = tasks.lines().nth(number).unwrap().to_owned();
        std::process::Command::new("sh").args(["-c", &line]).output().unwrap().status.code()
    };
    assert_eq!((run(1), run(1), run(2)), (Some(0), Some(0), Some(0)));
    fs::rename(folder.path().join("scene.toml"), folder.path().join("away.toml")).unwrap();
    fs::write(folder.path().join("scene.toml"), "no scene").unwrap();
    assert_eq!(run(0), Some(1));
    assert_eq!(status(), (Some(1), serde_json::json!(["failed", "whole", "whole"])));
    fs::rename(folder.path().join("away.toml"), folder.path().join("scene.toml")).unwrap();
    assert!(caustica(&folder, JOBS).status.success());
    assert!(submitted(&folder)[1].contains("--array=0 "), "{:?}", submitted(&folder));
    assert_eq!((run(0), status().0), (Some(0), Some(0)));
    let output = caustica(&folder, JOBS);
    assert!(text(&output.stderr).contains("nothing to submit"), "{}", text(&output.stderr));
    // The header of a picture names the scene as the command does.
    let scene = folder.path().join("scene.toml");
    let batch = "-o local --set size=8x6 --set photons=300 --set seed=1,2,3 --passes 2";
    assert!(caustica(&folder, &format!("batch {} {batch}", scene.display())).status.success());
    for entry in fs::read_dir(folder.path().join("night/jobs")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let ours = fs::read(folder.path().join(format!("night/jobs/{name}/{name}.exr"))).unwrap();
        assert!(ours == fs::read(folder.path().join(format!("local/{name}.exr"))).unwrap(), "{name}");
    }
}

#[test]
fn what_cannot_work_is_refused_before_anything_is_submitted() {
    let folder = folder();
    for (arguments, words) in [
        (format!("submit --slurm {SUBMISSION} -- --alpha 7"), "refused for what stands behind `--`"),
        (format!("submit --slurm {SUBMISSION} -- --layers --sead 3"), "--sead"),
        (format!("submit --slurm {SUBMISSION} --sbatch 'open"), "a quote is not closed"),
        (format!("submit {SUBMISSION}"), "--slurm"),
        ("submit --slurm scene.toml --passes 7 --shard-passes 0 -o a.exr".into(), "shard-passes"),
        ("submit --slurm scene.toml --passes 7 --shard-passes 2 -o a.png".into(), ".exr"),
        ("submit --slurm scene.toml other.toml --passes 7 --shard-passes 2 -o a.exr".into(), "one scene"),
        ("submit --slurm --each none.toml -o a".into(), "none.toml"),
        ("submit --slurm --each scene.toml -o a -- --sett seed=1".into(), "--sett"),
        ("submit --slurm --each scene.toml -o a --passes 4".into(), "--each"),
        ("status out".into(), "submission.json"),
    ] {
        let output = caustica(&folder, &arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments}");
        assert!(text(&output.stderr).contains(words), "{arguments}: {}", text(&output.stderr));
    }
    assert!(submitted(&folder).is_empty());
    assert!(caustica(&folder, &format!("submit --dry-run {SUBMISSION}")).status.success());
    let other = "submit --dry-run scene.toml --passes 8 --shard-passes 3 -o out/a.exr";
    let output = caustica(&folder, other);
    assert!(text(&output.stderr).contains("whose number of passes differs"), "{}", text(&output.stderr));
}

#[test]
fn what_slurm_says_is_told() {
    let folder = folder();
    program(
        &folder,
        "sbatch",
        "echo 'sbatch: error: Batch job submission failed: Invalid account' >&2; exit 1",
    );
    let output = caustica(&folder, &format!("submit --slurm {SUBMISSION}"));
    assert_eq!(output.status.code(), Some(2));
    assert!(
        text(&output.stderr)
            .contains("sbatch refuses: sbatch: error: Batch job submission failed: Invalid account")
    );
    fs::remove_file(folder.path().join("bin/sbatch")).unwrap();
    if std::process::Command::new("sbatch").arg("--version").output().is_err() {
        let output = caustica(&folder, &format!("submit --slurm {SUBMISSION}"));
        assert!(text(&output.stderr).contains("cannot run sbatch"), "{}", text(&output.stderr));
    }
}
