//! Long renders, and what ends them.

use std::fs::{self, Permissions};
use std::io::{BufRead, BufReader, Read};
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::os::unix::process::ExitStatusExt;
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Output, Stdio};
use std::thread::sleep;
use std::time::Duration;

use caustica::math::{Rng, Stream};
use tempfile::TempDir;

use crate::common::GLASS_AND_LAMPS;

/// All that a render samples anew in each pass, and small.
fn scene_text() -> String {
    let small = GLASS_AND_LAMPS.replace("width = 48", "width = 40").replace("height = 40", "height = 32");
    format!("[render]\nphotons = 4000\nsamples = 2\n{small}")
}

/// A folder with the scene in it, and the program at work there.
struct Bench {
    folder: TempDir,
}

impl Bench {
    fn new() -> Bench {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("scene.toml"), scene_text()).unwrap();
        Bench { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// `caustica render scene.toml` and what `arguments`, parted by blanks, say.
    fn command(&self, arguments: &str) -> Command {
        self.wrapped(&[], arguments)
    }

    /// The same, started by `wrapper`.
    fn wrapped(&self, wrapper: &[&str], arguments: &str) -> Command {
        let words = wrapper.iter().copied().chain([env!("CARGO_BIN_EXE_caustica"), "render", "scene.toml"]);
        let words: Vec<&str> = words.chain(arguments.split_whitespace()).collect();
        let mut command = Command::new(words[0]);
        command.current_dir(&self.folder).args(&words[1..]).arg("--reproducible");
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    fn run(&self, arguments: &str) -> Output {
        self.command(arguments).output().unwrap()
    }

    fn succeed(&self, arguments: &str) -> String {
        let output = self.run(arguments);
        assert!(output.status.success(), "{arguments}: {}", message(&output));
        message(&output)
    }

    /// It ends with this code and a text with all `words`.
    fn fail(&self, arguments: &str, code: i32, words: &[&str]) {
        assert_failed(&self.run(arguments), code, words);
    }

    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(&self.folder).unwrap();
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    fn remove(&self, names: &[&str]) {
        for name in names {
            drop(fs::remove_file(self.path(name)));
        }
    }

    fn leftovers(&self) -> usize {
        self.names().iter().filter(|name| name.ends_with(".part")).count()
    }
}

fn message(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn assert_failed(output: &Output, code: i32, words: &[&str]) {
    let message = message(output);
    assert_eq!(output.status.code(), Some(code), "{message}");
    for word in words {
        assert!(message.contains(word), "`{word}` is not in: {message}");
    }
    assert!(!message.contains("panicked"), "{message}");
}

fn signal(child: &Child, name: &str) {
    let sent = Command::new("kill").args([name, &child.id().to_string()]).status();
    assert!(sent.unwrap().success());
}

/// Waits until so many lines of statistics came.
fn wait_for_lines(child: &mut Child, lines: usize) -> BufReader<std::process::ChildStdout> {
    let mut reader = BufReader::new(child.stdout.take().unwrap());
    let mut line = String::new();
    for _ in 0..lines {
        assert!(reader.read_line(&mut line).unwrap() > 0, "the render ended early");
    }
    reader
}

/// 1, 2, 7 and 64 threads write identical bytes, by both traversals and both ways of bouncing.
///
/// Breaks: sums follow the order in which threads happen to finish, so no two renders are alike, or more threads than there
/// are tasks leave some out.
///
/// Mutation: `PhotonPass::trace` keys the random numbers of photons by the thread that follows them, too.
#[test]
fn pictures_do_not_depend_on_threads() {
    let bench = Bench::new();
    for options in ["--traversal embree", "--traversal custom", "--sampling uniform"] {
        let render = |threads: u32| {
            let picture = "--layers --passes 3 --photons 20000 -o a.exr";
            bench.succeed(&format!("{options} {picture} --threads {threads}"));
            bench.read("a.exr")
        };
        let one = render(1);
        for threads in [2, 7, 64] {
            assert!(render(threads) == one, "{options}: {threads} threads give another picture");
        }
    }
}

/// A render killed 20 times at any moment, and resumed each time with another number of threads, writes the bytes of one that ran
/// undisturbed: picture, error layers and statistics of passes.
///
/// Breaks: a kill between two steps of replacing the checkpoint loses all work; something that passes add up is not kept, so the
/// picture is another one; torn lines stay in the statistics.
///
/// Mutation: `Render::restore` leaves the samples of area lights as they are.
#[test]
fn twenty_kills_do_not_change_a_byte() {
    let bench = Bench::new();
    let render = "--passes 300 --layers --direct direct.exr -o a.exr";
    bench.succeed(render);
    let (picture, direct) = (bench.read("a.exr"), bench.read("direct.exr"));
    let resume = "--json a.jsonl --checkpoint a.checkpoint --checkpoint-every 0 --resume";
    let mut rng = Rng::new(26, Stream::Test, 0, 0);
    let mut kills = 0;
    for threads in [1, 2, 7].into_iter().cycle() {
        let mut child = bench.command(&format!("{render} {resume} --threads {threads}")).spawn().unwrap();
        if kills < 20 {
            // One in four while it sets up, or is not even there; the others in any step of a later pass.
            if rng.next_f32() < 0.75 {
                wait_for_a_new_checkpoint(&bench, &mut child);
            }
            sleep(Duration::from_micros((rng.next_f32() * 50_000.0) as u64));
            child.kill().unwrap();
        }
        let output = child.wait_with_output().unwrap();
        match (output.status.success(), kills) {
            (true, 20) => break,
            // It was faster than the kills: more of them, from the beginning.
            (true, _) => bench.remove(&["a.checkpoint", "a.checkpoint.previous", "a.jsonl"]),
            (false, _) => {
                assert_eq!(output.status.signal(), Some(9), "{}", message(&output));
                kills += 1;
            }
        }
    }
    assert!(bench.read("a.exr") == picture, "the picture is another one");
    assert!(bench.read("direct.exr") == direct, "direct light is another one");
    assert_eq!(bench.leftovers(), 0, "{:?}", bench.names());
    let passes: Vec<u64> =
        records(&bench.read("a.jsonl")).iter().map(|r| r["pass"].as_u64().unwrap()).collect();
    assert!(passes.iter().copied().eq(1..=300), "{passes:?}");
}

/// Or until the render is over.
fn wait_for_a_new_checkpoint(bench: &Bench, child: &mut Child) {
    let number = || fs::metadata(bench.path("a.checkpoint")).ok().map(|file| (file.ino(), file.mtime_nsec()));
    let before = number();
    while number() == before && child.try_wait().unwrap().is_none() {
        sleep(Duration::from_millis(1));
    }
}

fn records(jsonl: &[u8]) -> Vec<serde_json::Value> {
    let text = std::str::from_utf8(jsonl).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// A render that is to stop at an error stops at the same pass, with the same bytes, however often it was resumed, even after
/// it had stopped there.
///
/// Breaks: what was known of the error is lost, so the end depends on where the stops were, and a command that is given once more
/// changes the picture.
///
/// Mutation: `ErrorWatch::resume` forgets the last look.
#[test]
fn targets_are_met_at_the_same_pass() {
    let bench = Bench::new();
    let target = "--radius 4 --target-error 5%";
    bench.succeed(&format!("{target} -o whole.exr --json whole.jsonl"));
    let passes = records(&bench.read("whole.jsonl")).len();
    for stop in [3, 7, passes - 1, 1_000_000, 1_000_000] {
        let resumed = bench.succeed(&format!("{target} --resume -o a.exr --passes {stop}"));
        assert!(resumed.contains(&format!("\n{} passes in", stop.min(passes))), "{resumed}");
    }
    assert!(bench.read("a.exr") == bench.read("whole.exr"), "the picture is another one");
}

/// A render that INT, TERM or HUP ends keeps a checkpoint of its last pass beside the picture so far, and goes on from it, also to
/// more passes than were first asked for.
///
/// Breaks: the checkpoint is as old as the last interval, or a closed terminal loses everything.
///
/// Mutation: `Session::finish` writes no checkpoint.
#[test]
fn signals_leave_a_checkpoint_and_a_picture() {
    let bench = Bench::new();
    bench.succeed("--passes 40 -o whole.exr");
    for name in ["-INT", "-TERM", "-HUP"] {
        let render = "-o a.exr --checkpoint-every 1e6 --json -";
        let mut child = bench.command(&format!("{render} --passes 100000000")).spawn().unwrap();
        let lines = wait_for_lines(&mut child, 3);
        signal(&child, name);
        let passes = 3 + lines.lines().count();
        assert_eq!(child.wait().unwrap().code(), Some(130));
        let resumed = bench.succeed("-o a.exr --resume --passes 0");
        assert!(resumed.contains(&format!("going on from a.checkpoint: {passes} passes")), "{resumed}");
        if passes <= 40 {
            bench.succeed("-o a.exr --resume --passes 40");
            assert!(bench.read("a.exr") == bench.read("whole.exr"), "{name}");
        }
        bench.remove(&["a.checkpoint", "a.checkpoint.previous"]);
    }
}

/// A checkpoint of another scene, or made with other settings, is refused by the name of every difference; the passes, the time and
/// the threads may be others.
///
/// Breaks: two renders are mixed into a picture that is neither.
///
/// Mutation: `CheckpointFile::load` compares no facts.
#[test]
fn checkpoints_of_other_renders_are_refused_by_name() {
    let bench = Bench::new();
    let render = "-o a.exr --checkpoint a.checkpoint";
    bench.succeed(&format!("{render} --passes 2"));
    let kept = bench.read("a.checkpoint");
    for (options, words) in [
        ("--alpha 0.5", &["alpha: the checkpoint has 0.7, this render 0.5"][..]),
        (
            "--photons 5 --seed 3",
            &["photons: the checkpoint has 4000, this render 5", "seed: the checkpoint has 0"],
        ),
        ("--size 41x32", &["size: the checkpoint has 40x32, this render 41x32"]),
        ("--layers", &["error estimates: the checkpoint has picture, this render pixels"]),
        ("--traversal custom", &["traversal: the checkpoint has embree, this render custom"]),
    ] {
        bench.fail(&format!("{render} --resume {options}"), 2, &[words, &["a.checkpoint: "]].concat());
    }
    fs::write(bench.path("scene.toml"), scene_text().replace("0.7, 0.7]", "0.7, 0.8]")).unwrap();
    bench.fail(&format!("{render} --resume"), 2, &["material", "(white): the checkpoint has", "0.8"]);
    fs::write(bench.path("scene.toml"), scene_text().replace("radius = 20", "radius = 21")).unwrap();
    bench.fail(&format!("{render} --resume"), 2, &["sphere 1: the checkpoint has"]);
    fs::write(bench.path("scene.toml"), scene_text()).unwrap();
    bench.fail(render, 2, &["a.checkpoint: there is a checkpoint already", "--resume"]);
    assert!(bench.read("a.checkpoint") == kept);
    let resumed =
        bench.succeed(&format!("{render} --resume --passes 3 --threads 1 --time 1e6 --target-error 1e-6"));
    assert!(resumed.contains("2 passes in") && resumed.contains("3 passes in"), "{resumed}");
}

/// A damaged checkpoint is found out and the one before it used, with the same bytes in the end; without a good one the render is refused, and a
/// missing one starts it anew.
///
/// Breaks: a cut or flipped file is read as numbers, and the picture is silently wrong.
///
/// Mutation: `checkpoint::parse` does not look at the hash.
#[test]
fn a_damaged_checkpoint_gives_way_to_the_one_before() {
    let bench = Bench::new();
    let render = "-o a.exr --checkpoint a.checkpoint --checkpoint-every 0 --resume";
    let anew = bench.succeed(&format!("{render} --passes 6"));
    assert!(anew.contains("a.checkpoint: no checkpoint yet; starting anew"), "{anew}");
    let (picture, latest, previous) =
        (bench.read("a.exr"), bench.read("a.checkpoint"), bench.read("a.checkpoint.previous"));
    let flipped = |place: usize| {
        let mut bytes = latest.clone();
        bytes[place] ^= 4;
        bytes
    };
    let middle = latest.len() / 2;
    for damaged in [vec![], flipped(3), flipped(17), flipped(middle), latest[..middle].to_vec()] {
        fs::write(bench.path("a.checkpoint"), &damaged).unwrap();
        fs::write(bench.path("a.checkpoint.previous"), &previous).unwrap();
        let resumed = bench.succeed(&format!("{render} --passes 6"));
        assert!(
            resumed.contains("a.checkpoint is damaged") && resumed.contains(": 5 passes in"),
            "{resumed}"
        );
        assert!(bench.read("a.exr") == picture, "the picture is another one");
    }
    for name in ["a.checkpoint", "a.checkpoint.previous"] {
        fs::write(bench.path(name), flipped(middle)).unwrap();
    }
    bench.fail(&format!("{render} --passes 6"), 2, &["a.checkpoint: damaged", "remove it to start anew"]);
}

/// Memory after 10,000 passes, with checkpoints on the way, is that after 500, within 1 %.
///
/// Breaks: something is kept of every pass, and a render that runs for days is killed by the system.
///
/// Mutation: `Render::pass` keeps the positions of all photons.
#[test]
fn memory_stays_flat_over_ten_thousand_passes() {
    let bench = Bench::new();
    bench.succeed("-o a.exr --size 8x8 --samples 1 --photons 100 --passes 10000 --threads 2 --json a.jsonl --checkpoint-every 0.1");
    let records = records(&bench.read("a.jsonl"));
    let peak = |pass: usize| records[pass - 1]["peak_memory_bytes"].as_f64().unwrap();
    let growth = peak(10_000) / peak(500);
    assert!((1.0..1.01).contains(&growth), "{} bytes, {growth} times those after 500 passes", peak(10_000));
}

/// A full disk is a clear error: what was there stays whole, and nothing else is left; a render goes on when a checkpoint finds no room.
///
/// Breaks: the former picture is cut to nothing, half a file takes its place, or hours of passes are lost to a checkpoint.
///
/// Mutation: `write_atomically` writes to the path itself.
#[test]
fn a_full_disk_leaves_what_was_there() {
    let bench = Bench::new();
    for name in ["a.exr", "a.png", "a.checkpoint"] {
        fs::write(bench.path(name), "former").unwrap();
    }
    // Files may have 8 blocks of 512 bytes, and no signal tells: as on a full disk, writing more is an error.
    let limited = ["sh", "-c", "trap '' XFSZ; ulimit -f 8; exec \"$@\"", "sh"];
    let output = bench.wrapped(&limited, "-o a.exr --passes 1").output().unwrap();
    assert_failed(&output, 1, &["a.exr: writing failed: ", "whatever the file held before is untouched"]);
    assert_eq!(bench.read("a.exr"), b"former");
    fs::remove_file(bench.path("a.checkpoint")).unwrap();
    let every = "-o small.exr --size 4x4 --passes 3 --checkpoint a.checkpoint --checkpoint-every 0";
    let output = bench.wrapped(&limited, &format!("{every} --samples 64")).output().unwrap();
    let words = ["warning: no checkpoint after 1 passes", "warning: no checkpoint after 2 passes"];
    assert_failed(&output, 1, &[&words[..], &["a.checkpoint: writing failed"]].concat());
    assert!(bench.path("small.exr").is_file(), "the picture has room");
    assert_eq!(bench.names(), ["a.exr", "a.png", "scene.toml", "small.exr", "small.png"]);
}

/// The same on a file system of 64 KiB, where the system lets us mount one.
///
/// Breaks: as above, and the temporary file itself fills the disk for good.
///
/// Mutation: `write_atomically` keeps its temporary file when writing fails.
#[test]
fn a_full_file_system_leaves_what_was_there() {
    let bench = Bench::new();
    fs::create_dir(bench.path("disk")).unwrap();
    let script = "mount -t tmpfs -o size=64k none disk || exit 99; echo former > disk/a.exr; \"$@\"; \
                  code=$?; ls -A disk; cat disk/a.exr; exit $code";
    let small = ["unshare", "-rm", "sh", "-c", script, "sh"];
    let output = bench.wrapped(&small, "-o disk/a.exr --size 200x200 --passes 1").output();
    let Some(output) =
        output.ok().filter(|output| output.status.code() != Some(99) && !output.stdout.is_empty())
    else {
        eprintln!("skipped: this user may not mount a small file system");
        return;
    };
    assert_failed(&output, 1, &["disk/a.exr: writing failed: No space left on device"]);
    assert_eq!(String::from_utf8_lossy(&output.stdout), "a.exr\nformer\n");
}

/// A read-only folder, a folder in the file's place and one that cannot be made are refused before any work is done.
///
/// Breaks: the render takes its hours and then has nowhere to put them.
///
/// Mutation: `check_writable` makes no file.
#[test]
fn places_that_take_no_file_are_refused_at_once() {
    let bench = Bench::new();
    fs::create_dir(bench.path("taken.exr")).unwrap();
    fs::create_dir(bench.path("a.checkpoint")).unwrap();
    fs::write(bench.path("file"), "").unwrap();
    bench.fail("-o taken.exr", 2, &["taken.exr: this is a folder, not a file"]);
    bench.fail("-o file/a.exr", 2, &["file/a.exr: cannot make its folder"]);
    bench.fail("-o a.exr --checkpoint-every 9", 2, &["a.checkpoint: this is a folder, not a file"]);
    bench.fail("-o a.exr --json taken.exr", 2, &["taken.exr: this is a folder, not a file"]);
    // Where even root may make no file.
    bench.fail("-o /proc/a.exr", 2, &["/proc/a.exr: cannot make a file in the folder /proc"]);
    let locked = bench.path("locked");
    fs::create_dir(&locked).unwrap();
    fs::set_permissions(&locked, Permissions::from_mode(0o555)).unwrap();
    if fs::write(locked.join("probe"), "").is_ok() {
        eprintln!("skipped: this user may write to read-only folders");
    } else {
        bench.fail("-o locked/a.exr", 2, &["locked/a.exr: cannot make a file in the folder"]);
    }
    fs::set_permissions(&locked, Permissions::from_mode(0o755)).unwrap();
    assert!(!bench.path("a.exr").exists());
}

/// A folder that disappears during the render is made again; where that cannot be, errors name what is lost, and all
/// else is written.
///
/// Breaks: the picture of a long render is lost, or an error about one file keeps the others from being written.
///
/// Mutation: `Session::finish` stops at the first error.
#[test]
fn a_disappearing_folder_is_made_again_or_named() {
    let bench = Bench::new();
    for (in_its_place, code) in [(false, 130), (true, 1)] {
        let render = "-o a.exr --direct out/direct.exr --checkpoint out/a.checkpoint --json -";
        let mut child = bench.command(&format!("{render} --passes 100000000")).spawn().unwrap();
        let mut lines = wait_for_lines(&mut child, 2);
        fs::remove_dir_all(bench.path("out")).unwrap();
        if in_its_place {
            fs::write(bench.path("out"), "a file").unwrap();
        }
        signal(&child, "-INT");
        lines.read_to_end(&mut Vec::new()).unwrap();
        let output = child.wait_with_output().unwrap();
        let lost =
            ["out/a.checkpoint: cannot make its folder out", "out/direct.exr: cannot make its folder out"];
        assert_failed(&output, code, if in_its_place { &lost } else { &[] });
        assert!(bench.path("a.exr").is_file());
        if !in_its_place {
            assert!(bench.path("out/a.checkpoint").is_file() && bench.path("out/direct.exr").is_file());
            fs::remove_file(bench.path("out/a.checkpoint")).unwrap();
        }
        bench.remove(&["a.exr"]);
    }
}

/// What killed writers left beside an output is removed by the next run; what a living one writes is not.
///
/// Breaks: folders fill with `.caustica-*.part`, or one render deletes what another is writing.
///
/// Mutation: `remove_leftovers` removes what is locked, too.
#[test]
fn leftovers_of_killed_renders_are_removed() {
    let bench = Bench::new();
    fs::write(bench.path(".caustica-dead.part"), "half a picture").unwrap();
    let living = fs::File::create(bench.path(".caustica-living.part")).unwrap();
    living.lock().unwrap();
    bench.succeed("-o a.exr --passes 1");
    assert_eq!(bench.names(), [".caustica-living.part", "a.exr", "a.png", "scene.toml"]);
    drop(living);
    bench.succeed("-o a.exr --passes 1");
    assert_eq!(bench.names(), ["a.exr", "a.png", "scene.toml"]);
}

/// What reads standard output or standard error may close it: no command panics, the exit code is that of SIGPIPE, and a render still writes its
/// picture and checkpoint.
///
/// Breaks: a reader like `head` ends the render in a panic, and the picture is lost.
///
/// Mutation: `console::print` prints by `print!`; and another one, `note!` by `eprintln!`.
#[test]
fn closed_pipes_are_told_and_lose_nothing() {
    let bench = Bench::new();
    let mut child =
        bench.command("-o a.exr --passes 100000000 --json - --checkpoint a.checkpoint").spawn().unwrap();
    drop(wait_for_lines(&mut child, 1));
    let output = child.wait_with_output().unwrap();
    assert_failed(&output, 141, &["cannot write to standard output: Broken pipe", "passes in"]);
    assert!(bench.path("a.exr").is_file() && bench.path("a.checkpoint").is_file());
    let (scene, picture) = (bench.path("scene.toml"), bench.path("a.exr"));
    let [scene, picture] = [&scene, &picture].map(|path| path.to_str().unwrap());
    let bench_pass = ["bench", "--pass", scene, "--photons", "1e3", "--samples", "1", "--repetitions", "1"];
    let commands: [&[&str]; 5] = [
        &["info", scene],
        &["info", scene, "--json"],
        &["compare", picture, picture],
        &["study", scene, "--list"],
        &bench_pass,
    ];
    for arguments in commands {
        let (status, told) = with_closed(arguments, "stdout");
        assert_eq!(status.code(), Some(141), "{arguments:?}: {told}");
        assert!(told.contains("cannot write to standard output") && !told.contains("panicked"), "{told}");
    }
    let spoken = ["render", scene, "-o", picture, "--passes", "1"];
    fs::remove_file(bench.path("a.exr")).unwrap();
    assert!(with_closed(&spoken, "stderr").0.success() && bench.path("a.exr").is_file());
}

/// Runs the program with a pipe that nobody reads; what it said on standard error, where that is not the closed one.
fn with_closed(arguments: &[&str], stream: &str) -> (ExitStatus, String) {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let mut command = Command::new(env!("CARGO_BIN_EXE_caustica"));
    command.args(arguments).stdin(Stdio::null());
    match stream {
        "stdout" => command.stdout(writer).stderr(Stdio::piped()),
        _ => command.stdout(Stdio::null()).stderr(writer),
    };
    let output = command.output().unwrap();
    (output.status, message(&output))
}
