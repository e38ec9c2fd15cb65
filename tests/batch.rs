//! `caustica batch`: what becomes of many jobs, whatever becomes of some of them.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a panic is how a test fails")]

use std::collections::BTreeMap;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::thread;
use std::time::{Duration, Instant, SystemTime};

use assert_cmd::cargo::CommandCargoExt;
use serde_json::Value;
use tempfile::TempDir;

fn caustica(folder: &Path) -> Command {
    let mut command = Command::cargo_bin("caustica").unwrap();
    command.current_dir(folder);
    command
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// A small scene of one triangle mesh in `mesh`, which may be missing.
fn scene(mesh: &str, albedo: f64) -> String {
    format!(
        "[film]\nwidth = 16\nheight = 16\n[camera]\nposition = [0, 1, 4]\nlook_at = [0, 0, 0]\nfov = 40\n\
         [material.grey]\ndiffuse = {{ albedo = [{albedo}, 0.5, 0.5] }}\n[[point_light]]\nposition = [0, 3, 0]\nintensity = [9, 9, 9]\n\
         [render]\npasses = 2\nphotons = 500\n[[mesh]]\nfile = \"{mesh}\"\nmaterial = \"grey\"\n"
    )
}

const FLOOR: &str = "v -2 0 -2\nv -2 0 2\nv 2 0 2\nv 2 0 -2\nf 1 2 3 4\n";

/// A folder with files.
fn folder(files: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

/// Three scenes, of which two share a mesh.
fn three() -> TempDir {
    let [a, b, c] = [scene("one.obj", 0.3), scene("one.obj", 0.6), scene("two.obj", 0.9)];
    folder(&[("a.toml", &a), ("b.toml", &b), ("c.toml", &c), ("one.obj", FLOOR), ("two.obj", FLOOR)])
}

fn batch(folder: &Path, arguments: &[&str]) -> Output {
    caustica(folder).arg("batch").args(arguments).output().unwrap()
}

/// A line of the status for each job.
fn status(folder: &Path, out: &str) -> BTreeMap<String, Value> {
    let done = batch(folder, &["status", out, "--json"]);
    assert!(done.status.success(), "{}", text(&done.stderr));
    let lines = text(&done.stdout);
    let rows = lines.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
    rows.map(|row| (row["job"].as_str().unwrap().to_owned(), row)).collect()
}

fn attempts(folder: &Path, out: &str) -> BTreeMap<String, usize> {
    let count = |row: &Value| row["attempts"].as_array().unwrap().len();
    status(folder, out).iter().map(|(job, row)| (job.clone(), count(row))).collect()
}

fn bytes(folder: &Path, name: &str) -> Vec<u8> {
    fs::read(folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// The end of a summary: `(done now, unchanged, failed, waiting)`.
fn told(done: &Output) -> String {
    let told = text(&done.stderr);
    let line =
        told.lines().find(|line| line.contains(" jobs: ")).unwrap_or_else(|| panic!("no summary: {told}"));
    line.split(", ")
        .map(|part| part.split(": ").last().unwrap().split(' ').next().unwrap())
        .collect::<Vec<_>>()
        .join(" ")
}

#[test]
fn pictures_are_those_of_render_byte_by_byte() {
    let folder = three();
    let done = batch(folder.path(), &["*.toml", "-o", "out", "--set", "seed=5,6", "--jobs", "2"]);
    assert_eq!(done.status.code(), Some(0), "{}", text(&done.stderr));
    assert_eq!(told(&done), "6 0 0 0");
    for (scene, seed) in [("a", "5"), ("c", "6")] {
        let arguments =
            ["render", &format!("{scene}.toml"), "--seed", seed, "-o", "alone.exr", "--reproducible"];
        assert!(caustica(folder.path()).args(arguments).output().unwrap().status.success());
        for end in ["exr", "png"] {
            let of_batch = bytes(folder.path(), &format!("out/{scene}_seed={seed}.{end}"));
            assert!(of_batch == bytes(folder.path(), &format!("alone.{end}")), "{scene} {seed} {end}");
        }
    }
    assert!(bytes(folder.path(), "out/a_seed=5.exr") != bytes(folder.path(), "out/a_seed=6.exr"));
}

/// Frames of a large mesh in another color each.
fn frames(count: usize) -> TempDir {
    let mut surface = Vec::new();
    caustica::scene::water::write_obj(&mut surface, 600).unwrap();
    let folder = folder(&[("large.obj", &text(&surface))]);
    for frame in 0..count {
        let text = scene("large.obj", 0.1 + 0.1 * frame as f64);
        fs::write(folder.path().join(format!("frame_{frame}.toml")), text).unwrap();
    }
    folder
}

fn processes(folder: &Path, out: &str) -> Vec<u64> {
    let process = |row: &Value| row["attempts"][0]["process"].as_u64().unwrap();
    status(folder, out).values().map(process).collect()
}

/// What takes long to load is loaded once, and no bit of a picture tells.
#[test]
fn frames_of_a_large_mesh_go_through_one_process() {
    let folder = frames(4);
    let run = |arguments: &[&str]| {
        let done =
            batch(folder.path(), &[&["frame_*.toml", "--jobs", "1", "--threads", "2"], arguments].concat());
        assert_eq!(told(&done), "4 0 0 0", "{}", text(&done.stderr));
    };
    run(&["-o", "shared"]);
    let shared = processes(folder.path(), "shared");
    assert_eq!(shared, [shared[0]; 4]);
    run(&["-o", "apart", "--memory-limit", "8G"]);
    let mut apart = processes(folder.path(), "apart");
    apart.sort_unstable();
    apart.dedup();
    assert_eq!(apart.len(), 4, "a limit of memory is for one job alone");
    for frame in 0..4 {
        let picture = |out: &str| bytes(folder.path(), &format!("{out}/frame_{frame}.exr"));
        assert!(picture("shared") == picture("apart"), "frame {frame}");
        assert!(frame == 0 || picture("shared") != bytes(folder.path(), "shared/frame_0.exr"));
    }
}

#[test]
fn a_changed_file_renders_what_used_it_and_nothing_else() {
    let folder = three();
    let run = |arguments: &[&str]| {
        let done = batch(folder.path(), &[&["*.toml", "-o", "out", "--jobs", "2"], arguments].concat());
        assert_eq!(done.status.code(), Some(0), "{}", text(&done.stderr));
        told(&done)
    };
    assert_eq!(run(&[]), "3 0 0 0");
    assert_eq!(run(&[]), "0 3 0 0", "nothing changed");
    for seconds in [0, 5_000_000_000] {
        let file = fs::File::options().write(true).open(folder.path().join("one.obj")).unwrap();
        file.set_modified(SystemTime::UNIX_EPOCH + Duration::from_secs(seconds)).unwrap();
        assert_eq!(run(&[]), "0 3 0 0", "the date alone changed");
    }
    fs::write(folder.path().join("one.obj"), FLOOR.replace("v 2 0 2", "v 2 1 2")).unwrap();
    assert_eq!(run(&[]), "2 1 0 0", "the mesh of two scenes");
    assert_eq!(
        attempts(folder.path(), "out"),
        [("a", 2), ("b", 2), ("c", 1)].map(|(n, k)| (n.into(), k)).into()
    );
    fs::write(folder.path().join("c.toml"), scene("two.obj", 0.8)).unwrap();
    assert_eq!(run(&[]), "1 2 0 0", "a scene");
    fs::remove_file(folder.path().join("out/b.png")).unwrap();
    fs::write(folder.path().join("out/a.exr"), "altered").unwrap();
    assert_eq!(run(&[]), "2 1 0 0", "pictures that are gone or altered");
    assert_eq!(run(&["--passes", "3"]), "3 0 0 0", "other settings");
    assert_eq!(run(&["--passes", "3"]), "0 3 0 0");
}

#[test]
fn a_file_that_turns_up_counts_as_a_change() {
    let text =
        scene("one.obj", 0.5).replace("file = \"one.obj\"\nmaterial = \"grey\"\n", "file = \"one.obj\"\n");
    let folder = folder(&[("a.toml", &text), ("one.obj", &format!("mtllib m.mtl\nusemtl x\n{FLOOR}"))]);
    let run = || told(&batch(folder.path(), &["a.toml", "-o", "out"]));
    assert_eq!((run(), run()), ("1 0 0 0".into(), "0 1 0 0".into()));
    let grey = bytes(folder.path(), "out/a.exr");
    let attempt = &status(folder.path(), "out")["a"]["attempts"][0];
    assert!(attempt["last_words"].as_str().unwrap().contains("m.mtl: cannot be read"), "{attempt}");
    fs::write(folder.path().join("m.mtl"), "newmtl x\nKd 1 0 0\n").unwrap();
    assert_eq!(run(), "1 0 0 0");
    assert!(bytes(folder.path(), "out/a.exr") != grey);
}

#[test]
fn jobs_of_higher_priority_go_first() {
    let list = "[[job]]\nscene = \"a.toml\"\n[[job]]\nscene = \"b.toml\"\npriority = 2\n[[job]]\nscene = \"c.toml\"\npriority = 1\n";
    let folder = three();
    fs::write(folder.path().join("list.toml"), list).unwrap();
    let done = batch(folder.path(), &["list.toml", "-o", "out", "--jobs", "1", "--json"]);
    let lines = text(&done.stdout);
    let events = lines.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
    let began: Vec<String> =
        events.filter_map(|event| Some(event["began"]["job"].as_str()?.to_owned())).collect();
    assert_eq!(began, ["b", "c", "a"]);
}

#[test]
fn wrong_lists_are_refused_before_any_work() {
    let folder = three();
    for (list, words) in [
        (
            "[[job]]\nscene = \"a.toml\"\npasses = \"many\"\n",
            "list.toml:2: invalid value 'many' for '--passes <N|A..B>'",
        ),
        ("[[job]]\nscene = \"a.toml\"\npases = 3\n", "list.toml:3: unknown key `pases`"),
        ("[[job]]\nscene = \"a.toml\"\noutput = \"x.exr\"\n", "`output` is not for jobs"),
        ("[[job]]\nscene = \"a.toml\"\nlayers = true\nno_error_estimates = true\n", "cannot be used with"),
    ] {
        fs::write(folder.path().join("list.toml"), list).unwrap();
        let done = batch(folder.path(), &["list.toml", "-o", "out"]);
        let told = text(&done.stderr);
        assert_eq!(done.status.code(), Some(2), "{told}");
        assert!(told.contains(words), "{words}: {told}");
        assert!(!folder.path().join("out").exists());
    }
    let done = batch(folder.path(), &["a.toml", "--set", "alpha=2", "-o", "out"]);
    assert!(
        done.status.code() == Some(2) && text(&done.stderr).contains("--alpha"),
        "{}",
        text(&done.stderr)
    );
}

#[test]
fn status_and_report_tell_what_failed() {
    let folder = three();
    fs::write(folder.path().join("bad.toml"), "[camera]\nposition = 3\n").unwrap();
    assert_eq!(batch(folder.path(), &["status", "out"]).status.code(), Some(2), "there is none yet");
    let done = batch(folder.path(), &["*.toml", "-o", "out", "--retries", "3"]);
    assert_eq!((done.status.code(), told(&done).as_str()), (Some(1), "3 0 1 0"), "{}", text(&done.stderr));
    let row = &status(folder.path(), "out")["bad"];
    assert!(row["reason"].as_str().unwrap().contains("bad.toml:"), "{row}");
    assert_eq!(row["attempts"].as_array().unwrap().len(), 1, "a broken scene is not tried again");
    let told = text(&batch(folder.path(), &["status", "out"]).stdout);
    assert!(told.contains("4 jobs: 0 waiting, 0 running, 3 done, 1 failed"), "{told}");
    assert!(batch(folder.path(), &["report", "out"]).status.success());
    let html = text(&bytes(folder.path(), "out/batch.html"));
    assert_eq!(html.matches("<img ").count(), 3);
    assert!(html.contains("bad.toml:"));
}

/// A batch under way.
struct Running {
    child: Child,
    lines: BufReader<std::process::ChildStdout>,
}

impl Running {
    fn start(folder: &Path, arguments: &[&str]) -> Running {
        let mut command = caustica(folder);
        command.arg("batch").args(arguments).arg("--json").stdout(Stdio::piped()).stderr(Stdio::null());
        let mut child = command.spawn().unwrap();
        let lines = BufReader::new(child.stdout.take().unwrap());
        Running { child, lines }
    }

    /// The next event; `None` at the end.
    fn next(&mut self) -> Option<Value> {
        let mut line = String::new();
        let length = self.lines.read_line(&mut line).unwrap();
        (length > 0).then(|| serde_json::from_str(&line).unwrap())
    }

    /// Goes on until so many jobs are done, or the batch is, and kills the processes of those that would take forever.
    fn kill_the_endless(&mut self, count: usize) {
        let (mut done, mut processes) = (0, BTreeMap::new());
        while done < count {
            let Some(event) = self.next() else { return };
            done += usize::from(event["ended"]["verdict"]["done"].is_object());
            if let Some(job) = event["began"]["job"].as_str() {
                processes.insert(job.to_owned(), event["began"]["process"].as_u64().unwrap());
            }
            if let Some(job) = event["loaded"]["job"].as_str().filter(|job| job.starts_with("killed")) {
                signal(processes[job], "-KILL");
            }
        }
    }

    fn kill(mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }
}

fn signal(process: u64, name: &str) {
    assert!(Command::new("kill").args([name, &process.to_string()]).status().unwrap().success());
}

#[test]
fn two_batches_do_not_share_a_folder() {
    let folder = three();
    let mut first = Running::start(folder.path(), &["a.toml", "--passes", "1000000", "-o", "out"]);
    assert!(first.next().unwrap()["began"].is_object());
    for arguments in [&["b.toml", "-o", "out"][..], &["resume", "out"]] {
        let done = batch(folder.path(), arguments);
        let told = text(&done.stderr);
        assert_eq!(done.status.code(), Some(2), "{told}");
        assert!(told.contains("another batch writes there (process "), "{told}");
    }
    assert_eq!(status(folder.path(), "out")["a"]["state"], "running", "looking is allowed");
    first.kill();
    assert_eq!(
        batch(folder.path(), &["b.toml", "-o", "out"]).status.code(),
        Some(0),
        "the lock went with its holder"
    );
}

/// Whether the process is there; one that ended but was not waited for is not.
fn lives(process: u64) -> bool {
    let stat = fs::read_to_string(format!("/proc/{process}/stat")).unwrap_or_default();
    stat.rsplit(") ").next().is_some_and(|rest| !rest.is_empty() && !rest.starts_with('Z'))
}

#[test]
fn no_process_outlives_its_batch() {
    let folder = three();
    let mut running = Running::start(folder.path(), &["a.toml", "--passes", "1000000", "-o", "out"]);
    let worker = running.next().unwrap()["began"]["process"].as_u64().unwrap();
    while running.next().unwrap()["loaded"].is_null() {}
    assert!(lives(worker));
    running.kill();
    let started = Instant::now();
    while lives(worker) {
        assert!(started.elapsed() < Duration::from_secs(30), "process {worker} is still there");
        thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn an_interrupted_job_goes_on_from_its_checkpoint() {
    let folder = three();
    let passes = ["--passes", "4000"];
    let mut running = Running::start(folder.path(), &[&["a.toml", "-o", "out"], &passes[..]].concat());
    while running.next().unwrap()["loaded"].is_null() {}
    thread::sleep(Duration::from_millis(300));
    signal(running.child.id().into(), "-INT");
    while running.next().is_some() {}
    assert_eq!(running.child.wait().unwrap().code(), Some(130));
    assert_eq!(status(folder.path(), "out")["a"]["state"], "waiting");
    assert!(!folder.path().join("out/a.exr").exists(), "no picture that lacks passes");
    assert!(folder.path().join("out/checkpoints/a.checkpoint").exists());
    let done = batch(folder.path(), &["resume", "out"]);
    assert_eq!((done.status.code(), told(&done).as_str()), (Some(0), "1 0 0 0"), "{}", text(&done.stderr));
    let alone = [&["render", "a.toml", "-o", "alone.exr", "--reproducible"], &passes[..]].concat();
    assert!(caustica(folder.path()).args(alone).output().unwrap().status.success());
    assert!(bytes(folder.path(), "out/a.exr") == bytes(folder.path(), "alone.exr"));
    assert_eq!(fs::read_dir(folder.path().join("out/checkpoints")).unwrap().count(), 0);
}

#[test]
fn a_checkpoint_of_the_scene_before_is_not_used() {
    let folder = three();
    let mut running = Running::start(folder.path(), &["a.toml", "-o", "out", "--passes", "100000"]);
    while running.next().unwrap()["loaded"].is_null() {}
    thread::sleep(Duration::from_millis(300));
    signal(running.child.id().into(), "-INT");
    while running.next().is_some() {}
    running.child.wait().unwrap();
    fs::write(folder.path().join("a.toml"), scene("one.obj", 0.8)).unwrap();
    let done = batch(folder.path(), &["a.toml", "-o", "out", "--passes", "2"]);
    assert_eq!((done.status.code(), told(&done).as_str()), (Some(0), "1 0 0 0"), "{}", text(&done.stderr));
}

/// 80 good jobs, 10 broken scenes, 5 that meet a memory limit, 5 that are killed; and the batch itself is killed twice.
fn hundred() -> TempDir {
    let folder = folder(&[("floor.obj", FLOOR)]);
    let mut list = String::from("[defaults]\npasses = 2\nretries = 0\nguiding = \"off\"\n");
    for number in 0..100 {
        let (name, text, more) = match number {
            k if k % 10 == 3 => (format!("broken{k}"), scene("missing.obj", 0.5), String::new()),
            k if k % 20 == 7 => (
                format!("large{k}"),
                scene("floor.obj", 0.5),
                "size = \"4000x4000\"\nmemory_limit = \"200M\"\n".into(),
            ),
            k if k % 20 == 17 => {
                (format!("killed{k}"), scene("floor.obj", 0.5), "passes = 1000000\npriority = 1\n".into())
            }
            k => (format!("good{k}"), scene("floor.obj", f64::from(k) / 100.0), String::new()),
        };
        fs::write(folder.path().join(format!("{name}.toml")), text).unwrap();
        let passes = if more.contains("passes") { String::new() } else { format!("seed = {number}\n") };
        list += &format!("[[job]]\nscene = \"{name}.toml\"\n{more}{passes}");
    }
    fs::write(folder.path().join("jobs.toml"), list).unwrap();
    folder
}

#[test]
fn of_a_hundred_jobs_every_good_one_has_its_picture_and_every_bad_one_its_reason() {
    let folder = hundred();
    let out = folder.path().join("out");
    for (arguments, done) in [(["jobs.toml", "-o", "out"], 15), (["resume", "out", "--jobs=auto"], 20)] {
        let mut running = Running::start(folder.path(), &arguments);
        running.kill_the_endless(done);
        running.kill();
    }
    let mut last = Running::start(folder.path(), &["resume", "out"]);
    last.kill_the_endless(100);
    assert_eq!(last.child.wait().unwrap().code(), Some(1));
    check_reasons(&status(folder.path(), "out"));
    let rows = status(folder.path(), "out");
    let good = rows.keys().filter_map(|job| job.strip_prefix("good")?.parse().ok());
    assert_eq!(good.map(|number| check_picture(folder.path(), &out, number)).count(), 80);
}

fn check_reasons(rows: &BTreeMap<String, Value>) {
    assert_eq!(rows.len(), 100);
    for (job, row) in rows {
        let (state, reason) = (row["state"].as_str().unwrap(), row["reason"].as_str().unwrap_or_default());
        let words = match job.trim_end_matches(|c: char| c.is_ascii_digit()) {
            "good" => "",
            "broken" => "missing.obj",
            "large" => "it ran into its memory limit of ",
            _ => "its process was killed by SIGKILL",
        };
        assert_eq!(state, if words.is_empty() { "done" } else { "failed" }, "{job}: {row}");
        assert!(reason.contains(words) && reason.is_empty() == words.is_empty(), "{job}: {reason}");
    }
    let count = |start: &str| rows.keys().filter(|job| job.starts_with(start)).count();
    assert_eq!(["good", "broken", "large", "killed"].map(count), [80, 10, 5, 5]);
}

fn check_picture(folder: &Path, out: &Path, number: u32) {
    let (scene, alone) = (format!("good{number}.toml"), folder.join("alone.exr"));
    let arguments = [
        "render",
        &scene,
        "--passes",
        "2",
        "--seed",
        &number.to_string(),
        "--guiding=off",
        "--reproducible",
        "-o",
        "alone.exr",
    ];
    assert!(caustica(folder).args(arguments).output().unwrap().status.success());
    assert!(fs::read(alone).unwrap() == fs::read(out.join(format!("good{number}.exr"))).unwrap(), "{number}");
}

/// Runs a batch whose folder lies on a disk of so many KiB; `None` where none can be mounted.
fn on_small_disk(folder: &Path, kib: u32, then: &str) -> Option<Output> {
    let program: PathBuf = assert_cmd::cargo::cargo_bin("caustica");
    let script = format!(
        "mkdir -p disk && mount -t tmpfs -o size={kib}k none disk || exit 99; \"$0\" batch '*.toml' -o disk/out --jobs 1; \
         code=$?; {then}; exit $code"
    );
    let mut command = Command::new("unshare");
    command
        .current_dir(folder)
        .args(["--user", "--map-root-user", "--mount", "sh", "-c", &script])
        .arg(program);
    let done = command.output().ok()?;
    let is_mounted = done.status.code() != Some(99) && !text(&done.stderr).contains("unshare");
    is_mounted.then_some(done)
}

#[test]
fn a_full_disk_stops_the_batch_and_harms_no_ledger() {
    let folder = three();
    for kib in [16, 48, 64, 80] {
        let then = "mount -o remount,size=10000k none disk; \"$0\" batch resume disk/out; again=$?; \
                    \"$0\" batch '*.toml' -o disk/out; echo again $again $?; ls disk/out";
        let Some(done) = on_small_disk(folder.path(), kib, then) else {
            eprintln!("skipped: no disk of {kib} KiB can be mounted here");
            return;
        };
        let (out, told) = (text(&done.stdout), text(&done.stderr));
        assert!(!told.contains("panicked"), "{told}");
        let again = out.lines().find(|line| line.starts_with("again ")).unwrap_or_default();
        assert!(again.ends_with(" 0"), "{kib} KiB: the batch given again did not end well: {out}{told}");
        assert!(
            out.contains("a.exr") && out.contains("b.exr") && out.contains("c.exr"),
            "{kib} KiB: {out}{told}"
        );
        assert_eq!(done.status.code(), Some(1), "{kib} KiB: {told}");
    }
}
