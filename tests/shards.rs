//! A picture in shards: the same bytes whatever the split, and what keeps wrong shards out.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a panic is how a test fails")]

mod common;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::thread;
use std::time::{Duration, SystemTime};

use assert_cmd::cargo::CommandCargoExt;
use caustica::film::Image;
use caustica::output::{read_exr, read_exr_layer};
use caustica::ppm::{IndependentPasses, RadiusPolicy, Settings};
use caustica::shard::Sums;
use tempfile::TempDir;

/// A folder that commands run in.
struct Bench(TempDir);

const TINY: &str = "--size 24x20 --samples 1 --photons 2000";

impl Bench {
    fn new() -> Bench {
        Bench(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn command(&self, arguments: &str) -> Command {
        let mut command = Command::cargo_bin("caustica").unwrap();
        command.current_dir(self.0.path()).args(arguments.split_whitespace());
        command
    }

    fn run(&self, arguments: &str) -> Output {
        self.command(arguments).output().unwrap()
    }

    /// What it said on standard error.
    fn succeed(&self, arguments: &str) -> String {
        let done = self.run(arguments);
        assert!(done.status.success(), "{arguments}: {}", told(&done));
        told(&done)
    }

    fn fails(&self, arguments: &str, code: i32, words: &[&str]) {
        let done = self.run(arguments);
        let told = told(&done);
        assert_eq!(done.status.code(), Some(code), "{arguments}: {told}");
        words.iter().for_each(|word| assert!(told.contains(word), "`{word}` is not in: {told}"));
        assert!(!told.contains("panicked"), "{told}");
    }

    /// Shards of a scene, `name.A-B.shard` each, by turns with one thread and with two.
    fn render(&self, scene: &str, name: &str, ends: &[u32]) -> Vec<String> {
        let shard = |(threads, pair): (usize, &[u32])| {
            let (first, end) = (pair[0], pair[1]);
            let file = format!("{name}.{first}-{end}.shard");
            let threads = threads % 2 + 1;
            let passes = format!("--passes {first}..{end} --partial --threads {threads} -o {file}");
            self.succeed(&format!("render {} {TINY} {passes}", scene_file(scene)));
            file
        };
        ends.windows(2).enumerate().map(shard).collect()
    }

    /// The bytes of what some shards merge to.
    fn merged(&self, shards: &[String]) -> Vec<u8> {
        self.succeed(&format!("merge {} -o merged.exr", shards.join(" ")));
        fs::read(self.path("merged.exr")).unwrap()
    }

    fn start(&self, arguments: &str) -> Child {
        self.command(arguments).stderr(Stdio::piped()).spawn().unwrap()
    }
}

fn scene_file(name: &str) -> String {
    common::data(&format!("{name}.toml")).display().to_string()
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn out(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Fixed eye paths under a lamp of an area; retraced ones through a lens; caustics on rough surfaces; aimed photons.
#[test]
fn the_bytes_do_not_depend_on_the_split() {
    let splits: [&[u32]; 4] =
        [&[0, 10], &[0, 3, 10], &[0, 2, 4, 6, 8, 10], &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10]];
    for (scene, splits) in [
        ("cornell_b", &splits[..]),
        ("depth_of_field", &splits[..2]),
        ("ground_glass", &splits[..2]),
        ("glass_bead", &splits[..2]),
    ] {
        let bench = Bench::new();
        let mut pictures = Vec::new();
        for (number, ends) in splits.iter().enumerate() {
            let mut shards = bench.render(scene, &format!("{scene}_{number}"), ends);
            pictures.push(bench.merged(&shards));
            shards.reverse();
            shards.rotate_left(number);
            pictures.push(bench.merged(&shards));
        }
        let differ = pictures.iter().position(|picture| *picture != pictures[0]);
        assert_eq!(differ, None, "{scene}");
    }
}

/// Merging in steps is merging at once.
#[test]
fn merged_shards_are_shards() {
    let bench = Bench::new();
    let shards = bench.render("cornell_b", "a", &[0, 2, 3, 5, 6]);
    let at_once = bench.merged(&shards);
    bench.succeed(&format!("merge {} {} -o left.shard", shards[3], shards[0]));
    bench.succeed(&format!("merge {} {} -o right.shard", shards[1], shards[2]));
    assert!(bench.merged(&["right.shard".into(), "left.shard".into()]) == at_once);
}

/// The largest difference beside the brightest pixel of the block around: pictures of single passes are brighter than their mean.
fn worst(a: &Image, b: &Image) -> f32 {
    let brightest = a.pixels().iter().map(|pixel| pixel.max_element()).fold(0.0, f32::max);
    let differences = a.pixels().iter().zip(b.pixels()).map(|(a, b)| (*a - *b).abs().max_element());
    differences.fold(0.0, f32::max) / brightest
}

#[test]
fn the_picture_is_that_of_a_render_by_the_shared_schedule() {
    for scene in ["cornell_b", "depth_of_field", "glass_bead"] {
        let bench = Bench::new();
        let shards = bench.render(scene, "a", &[0, 4, 7]);
        bench.merged(&shards);
        let whole = "--radius-policy shared --passes 7 -o whole.exr";
        bench.succeed(&format!("render {} {TINY} {whole}", scene_file(scene)));
        let [merged, whole] = ["merged.exr", "whole.exr"].map(|name| read_exr(&bench.path(name)).unwrap());
        let worst = worst(&merged, &whole);
        eprintln!("{scene}: {worst:e}");
        assert!(worst < 1e-6, "{scene}: {worst}");
    }
}

/// The standard error of a merged picture, squared and averaged over seeds, is the variance between the pictures of seeds.
#[test]
fn standard_errors_are_the_spread_between_seeds() {
    const SEEDS: u64 = 40;
    const PASSES: u32 = 8;
    let scene = common::scene_at("cornell_b.toml", 24, 20);
    let render = |seed| {
        let settings = common::settings(&scene);
        let policy = RadiusPolicy::Shared;
        let settings = Settings { samples: 1, photons: 2000, seed, eye_seed: Some(0), policy, ..settings };
        let mut passes = IndependentPasses::new(&scene, settings).unwrap();
        let mut sums = Sums::new(24, 20);
        (0..PASSES).for_each(|k| sums.add(&passes.pass(k).0));
        (sums.mean(PASSES), sums.standard_error(PASSES))
    };
    let renders: Vec<(Image, Image)> = (0..SEEDS).map(render).collect();
    let mut across = Sums::new(24, 20);
    renders.iter().for_each(|(mean, _)| across.add(mean));
    let square =
        |image: &Image| image.pixels().iter().map(|x| f64::from((*x * *x).element_sum())).sum::<f64>();
    // The variance of one of them, not of their mean.
    let spread = square(&across.standard_error(SEEDS as u32)) * SEEDS as f64;
    let claimed = renders.iter().map(|(_, error)| square(error)).sum::<f64>() / SEEDS as f64;
    eprintln!("claimed {claimed:e}, found {spread:e}: {}", claimed / spread);
    assert!((claimed / spread - 1.0).abs() < 0.15, "{claimed} {spread}");
}

#[test]
fn errors_have_their_layer() {
    let bench = Bench::new();
    bench.merged(&bench.render("cornell_b", "a", &[0, 3]));
    let error = read_exr_layer(&bench.path("merged.exr"), "stderr").unwrap();
    let positive = error.pixels().iter().filter(|pixel| pixel.min_element() > 0.0).count();
    assert!(positive > 200 && error.count_non_finite() == 0, "{positive}");
    bench.merged(&bench.render("cornell_b", "a", &[0, 1]));
    let error = read_exr_layer(&bench.path("merged.exr"), "stderr").unwrap();
    assert!(error.pixels().iter().all(|pixel| pixel.is_nan()), "one pass tells nothing of its error");
}

fn wait_for(path: &Path) {
    while !path.exists() {
        thread::sleep(Duration::from_millis(2));
    }
}

/// When a file was written last.
fn written(path: &Path) -> Option<SystemTime> {
    fs::metadata(path).and_then(|file| file.modified()).ok()
}

/// Passes of a shard, by what `merge` tells.
fn passes_in(bench: &Bench, shard: &str) -> u64 {
    let done = bench.run(&format!("merge {shard} -o told.shard --json"));
    let json: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
    json["passes"].as_u64().unwrap()
}

/// INT, TERM, HUP and USR1 finish the pass under way; what is on disk then is that of so many passes.
#[test]
fn signals_leave_a_shard_that_is_as_good_as_any() {
    for signal in ["-INT", "-TERM", "-HUP", "-USR1"] {
        let bench = Bench::new();
        let scene = scene_file("cornell_b");
        let endless =
            format!("render {scene} {TINY} --partial --checkpoint-every 0 --passes 0..1000000 -o a.shard");
        let child = bench.start(&endless);
        wait_for(&bench.path("a.shard"));
        let sent = Command::new("kill").args([signal, &child.id().to_string()]).status();
        assert!(sent.unwrap().success());
        let ended = child.wait_with_output().unwrap();
        assert_eq!(ended.status.code(), Some(130), "{signal}: {}", told(&ended));
        let passes = passes_in(&bench, "a.shard");
        let whole = bench.render("cornell_b", "whole", &[0, passes as u32]);
        assert!(bench.merged(&["a.shard".into()]) == bench.merged(&whole), "{signal}: {passes} passes");
    }
}

/// Batch systems that send USR1 send TERM later: a pass under way is finished even then.
#[test]
fn usr1_does_not_make_the_next_signal_an_urgent_one() {
    let bench = Bench::new();
    let scene = scene_file("cornell_b");
    let slow =
        format!("render {scene} --size 64x64 --photons 2e6 --partial --passes 0..100 --checkpoint-every 0");
    let child = bench.start(&format!("{slow} -o a.shard"));
    wait_for(&bench.path("a.shard"));
    let before = passes_in(&bench, "a.shard");
    for signal in ["-USR1", "-USR1", "-TERM"] {
        Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
        thread::sleep(Duration::from_millis(5));
    }
    let ended = child.wait_with_output().unwrap();
    assert_eq!(ended.status.code(), Some(130));
    assert!(
        told(&ended).contains("a.shard: passes 0.."),
        "it ended in the midst of a pass: {}",
        told(&ended)
    );
    assert!(passes_in(&bench, "a.shard") >= before);
}

/// Killed at any moment and given again, with other threads.
#[test]
fn a_killed_shard_goes_on_to_the_same_bytes() {
    let bench = Bench::new();
    let whole = bench.render("depth_of_field", "whole", &[5, 25]);
    let render = format!("render {} {TINY} --partial --passes 5..25", scene_file("depth_of_field"));
    let mut resumed = 0;
    for kills in 0..4 {
        let before = written(&bench.path("a.shard"));
        let threads = kills % 2 + 1;
        let mut child = bench.start(&format!("{render} -o a.shard --checkpoint-every 0 --threads {threads}"));
        while written(&bench.path("a.shard")) == before && child.try_wait().unwrap().is_none() {
            thread::sleep(Duration::from_millis(2));
        }
        child.kill().unwrap();
        let ended = child.wait_with_output().unwrap();
        resumed += usize::from(told(&ended).contains("going on from a.shard: passes 5.."));
    }
    bench.succeed(&format!("{render} -o a.shard"));
    assert!(bench.run("merge a.shard -o a.exr --passes 5..25").status.success());
    bench.succeed(&format!("merge {} -o whole.exr --passes 5..25", whole[0]));
    let [a, b] = ["a.exr", "whole.exr"].map(|name| fs::read(bench.path(name)).unwrap());
    assert!(a == b && resumed > 0, "resumed {resumed} times");
}

#[test]
fn a_shard_that_is_there_goes_on_or_is_left_alone() {
    let bench = Bench::new();
    let scene = scene_file("cornell_b");
    let render = |passes: &str| format!("render {scene} {TINY} --partial --passes {passes} -o a.shard");
    bench.succeed(&render("4..6"));
    let bytes = fs::read(bench.path("a.shard")).unwrap();
    assert!(bench.succeed(&render("4..6")).contains("a.shard: its passes 4..6 are there already"));
    assert!(fs::read(bench.path("a.shard")).unwrap() == bytes);
    let went_on = bench.succeed(&render("4..9"));
    assert!(went_on.contains("going on from a.shard: passes 4..6 in "), "{went_on}");
    assert_eq!(passes_in(&bench, "a.shard"), 5);
    let not_its = "a.shard: there is a shard already with the passes 4..9, which are not the beginning of ";
    for passes in ["4..8", "0..9", "5..12"] {
        bench.fails(&render(passes), 2, &[&format!("{not_its}{passes}; name another file, or remove it")]);
    }
    let other =
        "a.shard: there is a shard of another picture already:\n  seed: the shard has 0, this render 1";
    bench.fails(&format!("{} --seed 1 --eye-seed 0", render("4..9")), 2, &[other]);
    fs::write(bench.path("a.shard"), b"a picture, say").unwrap();
    bench.fails(&render("4..9"), 2, &["a.shard: not a shard; remove it"]);
}

#[test]
fn wrong_shards_are_refused_by_name() {
    let bench = Bench::new();
    let shards = bench.render("cornell_b", "a", &[0, 2, 4]).join(" ");
    let render = format!("render {} {TINY} --partial", scene_file("cornell_b"));
    bench.succeed(&format!("{render} --passes 3..5 -o over.shard"));
    let words = ["over.shard: the passes 3..4 are in a.2-4.shard, too"];
    bench.fails(&format!("merge {shards} over.shard -o b.exr"), 2, &words);
    bench.fails(
        "merge over.shard over.shard -o b.exr",
        2,
        &["over.shard: the passes 3..5 are in over.shard, too"],
    );
    bench.succeed(&format!("{render} --passes 4..5 --alpha 0.5 --depth 3 -o foreign.shard"));
    let words =
        ["foreign.shard: this shard belongs to another picture than a.0-2.shard", "alpha: ", "depth: "];
    bench.fails(&format!("merge {shards} foreign.shard -o b.exr"), 2, &words);
    let mut bytes = fs::read(bench.path("over.shard")).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(bench.path("damaged.shard"), &bytes).unwrap();
    fs::write(bench.path("cut.shard"), &bytes[..middle]).unwrap();
    for name in ["damaged", "cut"] {
        let words = [&*format!("{name}.shard: damaged"), "render its passes again"];
        bench.fails(&format!("merge {shards} {name}.shard -o b.exr"), 2, &words);
    }
    bench.fails("merge nowhere.shard -o b.exr", 2, &["nowhere.shard: the shard cannot be read"]);
    fs::create_dir(bench.path("empty")).unwrap();
    bench.fails("merge empty -o b.exr", 2, &["empty: there is no file in it that ends in .shard"]);
    bench.fails(
        &format!("merge {shards} -o b.exr --passes 1..4"),
        2,
        &["passes 0..1 are in the shards, but not among 1..4"],
    );
    bench.fails(&format!("merge {shards} -o b.png"), 2, &["b.png: a picture is written as EXR"]);
    assert!(!bench.path("b.exr").exists() && !bench.path("b.png").exists());
}

#[test]
fn gaps_are_printed_for_batch_systems() {
    let bench = Bench::new();
    fs::create_dir(bench.path("shards")).unwrap();
    bench.render("cornell_b", "shards/a", &[2, 4, 5]);
    bench.render("cornell_b", "shards/a", &[8, 9]);
    let merge = |flags: &str| bench.run(&format!("merge shards -o b.exr {flags}"));
    for (flags, printed) in [
        ("", "0..2,5..8\n"),
        ("--passes 0..14", "0..2,5..8,9..14\n"),
        ("--passes 0..14 --shard-passes 2", "--array=0,2-6\n"),
        ("--shard-passes 4", "--array=0-1\n"),
    ] {
        let done = merge(flags);
        assert_eq!((done.status.code(), &*out(&done)), (Some(1), printed), "{flags}: {}", told(&done));
    }
    assert!(told(&merge("")).contains("no picture is written: 5 passes are missing, 0..2,5..8"));
    let json: serde_json::Value = serde_json::from_slice(&merge("--json --shard-passes 4").stdout).unwrap();
    assert_eq!(
        (&json["array"], &json["missing"], &json["written"]),
        (&"0-1".into(), &5.into(), &serde_json::Value::Null)
    );
    assert!(!bench.path("b.exr").exists());
    let done = merge("--allow-gaps");
    assert!(done.status.success() && bench.path("b.exr").exists() && bench.path("b.png").exists());
    assert_eq!(out(&done), "0..2,5..8\n");
    let header = String::from_utf8_lossy(&fs::read(bench.path("b.exr")).unwrap()).into_owned();
    assert!(header.contains("2..5,8..9") && header.contains("caustica:passes\0int\0\u{4}\0\0\0\u{4}"));
    assert!(
        !header.contains("shards/")
            && !header.contains("caustica:command")
            && !header.contains("caustica:seconds")
    );
    assert_eq!(out(&merge("--passes 2..5 --allow-gaps")), "", "what is beyond is refused");
}

#[test]
fn what_makes_no_sense_in_parts_is_refused_with_the_reason() {
    let bench = Bench::new();
    let render = |flags: &str| format!("render {} {TINY} {flags}", scene_file("cornell_b"));
    bench.fails(
        &render("--passes 0..4"),
        2,
        &["--passes 0..4 are some of the passes", "give --partial, or --passes 4"],
    );
    for flags in ["--partial", "--partial --passes 4"] {
        bench.fails(&render(flags), 2, &["give them as --passes A..B"]);
    }
    bench.fails(&render("--passes 4..4 --partial"), 2, &["`4..4` holds no pass"]);
    for flags in [
        "--time 3",
        "--target-error 5%",
        "--layers",
        "--apart",
        "--features",
        "--direct d.exr",
        "--every-pass e",
        "--display-server 1",
        "--json -",
        "--checkpoint c",
        "--resume",
    ] {
        let flag = flags.split(' ').next().unwrap();
        bench.fails(
            &render(&format!("--passes 0..2 --partial {flags}")),
            2,
            &[&format!("--partial does not go with {flag}: ")],
        );
    }
    for policy in ["hit-point", "tested"] {
        let words = [&*format!(
            "by the radius policy `{policy}` the discs of a pass depend on what passes before it found"
        )];
        bench.fails(&render(&format!("--passes 0..2 --partial --radius-policy {policy}")), 2, &words);
    }
    bench.fails(
        &render("--passes 0..2 --partial -o a.exr"),
        2,
        &["a.exr: a shard is a file that ends in .shard"],
    );
    bench.succeed(&render("--passes 0..2 --partial --radius-policy fixed"));
    assert!(bench.path("out/cornell_b.0-2.shard").exists());
}
