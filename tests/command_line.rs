//! The program as a user meets it: exit codes, messages, files.
#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

mod common;

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use common::data;
use tempfile::TempDir;

fn caustica(arguments: &[&str]) -> std::process::Output {
    Command::cargo_bin("caustica").unwrap().args(arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// A folder with a small copy of a data scene in it.
struct Sandbox {
    folder: TempDir,
}

impl Sandbox {
    fn new() -> Sandbox {
        Sandbox { folder: tempfile::tempdir().unwrap() }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn name(&self, name: &str) -> String {
        self.path(name).to_str().unwrap().to_owned()
    }

    /// `data/course_diffuse.toml` at 32 x 32 pixels after `edit`.
    fn scene(&self, edit: impl Fn(String) -> String) -> String {
        let text = fs::read_to_string(data("course_diffuse.toml")).unwrap();
        fs::write(self.path("scene.toml"), edit(text.replace("= 512", "= 32"))).unwrap();
        self.name("scene.toml")
    }

    fn small_scene(&self) -> String {
        self.scene(|text| text)
    }
}

/// Exit code 2, a message with every one of `words`, and no file written.
fn assert_refused(sandbox: &Sandbox, arguments: &[&str], words: &[&str]) {
    let before = fs::read_dir(sandbox.folder.path()).unwrap().count();
    let output = caustica(arguments);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
    for word in words {
        assert!(message.contains(word), "`{word}` is not in: {message}");
    }
    assert!(!message.contains("panicked"), "{message}");
    assert_eq!(before, fs::read_dir(sandbox.folder.path()).unwrap().count(), "a file was written");
}

#[test]
fn help_shows_examples_and_every_command() {
    let help = text(&caustica(&["--help"]).stdout);
    for word in
        ["render", "reference", "compare", "info", "surface", "bench", "study", "Examples:", "Exit codes:"]
    {
        assert!(help.contains(word), "`{word}` is missing");
    }
    assert!(text(&caustica(&["render", "--help"]).stdout).contains("Examples:"));
}

/// The methods miss different things, and light tracing says how much of the picture that is.
#[test]
fn reference_tells_what_light_tracing_misses() {
    let sandbox = Sandbox::new();
    let scene = sandbox.scene(|text| text.replacen("\"white\"", "\"glass\"", 1) + GLASS);
    for (method, told) in [("path", false), ("light", true)] {
        let exr = sandbox.name(&format!("{method}.exr"));
        let output = caustica(&["reference", &scene, "--method", method, "--spp", "2", "-o", &exr]);
        let message = text(&output.stderr);
        assert!(output.status.success(), "{message}");
        assert_eq!(
            message.contains("% of the pixels show surfaces that mirror or refract"),
            told,
            "{message}"
        );
        for name in [".exr", ".png", "_stderr.exr"].map(|end| format!("{method}{end}")) {
            assert!(sandbox.path(&name).is_file(), "{name} is missing");
        }
    }
    let diffuse = sandbox.small_scene();
    let output =
        caustica(&["reference", &diffuse, "--method", "light", "--spp", "1", "-o", &sandbox.name("a.exr")]);
    assert!(!text(&output.stderr).contains("pixels show"), "nothing is missing");
}

/// Neither method overwrites the other's picture.
#[test]
fn reference_names_pictures_by_method() {
    let sandbox = Sandbox::new();
    let scene = sandbox.small_scene();
    for (method, name) in [("path", "out/scene_reference.exr"), ("light", "out/scene_reference_light.exr")] {
        let mut command = Command::cargo_bin("caustica").unwrap();
        command.current_dir(sandbox.folder.path()).args([
            "reference",
            &scene,
            "--method",
            method,
            "--spp",
            "1",
        ]);
        command.assert().success();
        assert!(sandbox.path(name).is_file(), "{name} is missing");
    }
}

const GLASS: &str = "\n[material.glass]\ndielectric = { ior = 1.5 }\n";

#[test]
fn render_writes_all_that_was_asked_for() {
    let sandbox = Sandbox::new();
    let scene = sandbox.small_scene();
    let (exr, direct, passes) = (sandbox.name("a.exr"), sandbox.name("direct.exr"), sandbox.name("passes"));
    #[rustfmt::skip]
    let output = caustica(&[
        "render", &scene, "-o", &exr, "--passes", "2", "--photons", "1e3", "--json", "-",
        "--direct", &direct, "--every-pass", &passes,
    ]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    for name in ["a.exr", "a.png", "direct.exr", "direct.png", "passes/pass_0001.exr", "passes/pass_0002.png"]
    {
        assert!(sandbox.path(name).is_file(), "{name} is missing");
    }
    assert_statistics(&text(&output.stdout));
    let again = caustica::output::read_exr(Path::new(&sandbox.name("passes/pass_0002.exr"))).unwrap();
    assert_eq!(again, caustica::output::read_exr(Path::new(&exr)).unwrap(), "the last pass is the picture");
}

fn assert_statistics(json: &str) {
    let lines: Vec<serde_json::Value> = json.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    assert_eq!(lines.len(), 2);
    for (index, line) in lines.iter().enumerate() {
        assert_eq!(line["pass"], index + 1);
        let photons = &line["photons"];
        assert_eq!(photons["emitted"], 1000);
        let ends = ["absorbed", "escaped", "terminated", "dropped"];
        let ended: u64 = ends.iter().map(|end| photons[end].as_u64().unwrap()).sum();
        assert_eq!(ended, 1000);
        let flux = |account: &&str| photons["flux"][account][1].as_f64().unwrap();
        let [came, went]: [f64; 2] = [["emitted", "roulette", "shading"].as_slice(), &ends]
            .map(|accounts| accounts.iter().map(flux).sum());
        assert!(flux(&"emitted") > 0.0 && (came / went - 1.0).abs() < 1e-12, "{came} and {went}");
        for phase in ["trace", "gather", "direct"] {
            assert!(line["phases"][phase].as_f64().unwrap() >= 0.0);
        }
        assert!(line["radius"]["min"].as_f64().unwrap() <= line["radius"]["max"].as_f64().unwrap());
        assert!(line["rejected_by_side"].is_u64() && line["rays"].as_u64().unwrap() >= 1000);
    }
    assert_eq!(lines[0]["setup"]["hit_points"], 32 * 32 * 4);
}

/// 1,048,576 hit points in less than 300 MB of memory in all.
#[test]
fn a_million_hit_points_fit_into_300_megabytes() {
    let sandbox = Sandbox::new();
    let scene = data("course_diffuse.toml");
    #[rustfmt::skip]
    let output = caustica(&[
        "render", scene.to_str().unwrap(), "-o", &sandbox.name("a.exr"), "--passes", "2", "--json", "-",
    ]);
    let json = text(&output.stdout);
    let lines: Vec<serde_json::Value> = json.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    assert_eq!(lines[0]["setup"]["hit_points"], 1_048_576);
    let peak = lines[1]["peak_memory_bytes"].as_u64().unwrap();
    assert!(peak < 300_000_000, "{peak} bytes");
}

#[test]
fn bad_scenes_are_refused_with_their_place() {
    let sandbox = Sandbox::new();
    let output = sandbox.name("out.exr");
    let cases: [(&str, &str, &[&str]); 6] = [
        ("fov = 52", "fov = \"wide\"", &["scene.toml:", "fov", "degrees above 0"]),
        ("fov = 52", "fov = nan", &["scene.toml:", "fov"]),
        ("fov = 52", "fov = 52\nzoom = 2", &["scene.toml:", "zoom"]),
        ("width = 32", "width = 0", &["scene.toml:", "width", "16384"]),
        ("alpha = 0.7", "alpha = 2", &["scene.toml:", "alpha"]),
        ("material = \"white\"", "material = \"whit\"", &["scene.toml:", "whit", "white"]),
    ];
    for (from, to, words) in cases {
        let scene = sandbox.scene(|text| text.replacen(from, to, 1));
        assert_refused(&sandbox, &["render", &scene, "-o", &output], words);
    }
}

#[test]
fn bad_files_are_refused() {
    let sandbox = Sandbox::new();
    let (scene, output) = (sandbox.small_scene(), sandbox.name("out.exr"));
    let missing = sandbox.name("missing.toml");
    assert_refused(&sandbox, &["render", &missing, "-o", &output], &["missing.toml"]);
    let folder = sandbox.name("");
    assert_refused(&sandbox, &["render", &folder, "-o", &output], &["folder"]);
    assert_refused(&sandbox, &["render", &scene, "-o", &folder], &["folder"]);
    assert_refused(&sandbox, &["render", &scene, "-o", &sandbox.name("a.jpg")], &["a.jpg", ".exr"]);
    assert_refused(&sandbox, &["render", &scene, "--json", &folder, "-o", &output], &["folder"]);
    assert_refused(&sandbox, &["compare", &scene, &output], &["scene.toml"]);
    fs::write(sandbox.path("empty.obj"), "# nothing\n").unwrap();
    let scene = sandbox.scene(|text| text + "\n[[mesh]]\nfile = \"empty.obj\"\nmaterial = \"white\"\n");
    assert_refused(&sandbox, &["render", &scene, "-o", &output], &["empty.obj"]);
}

#[test]
fn bad_arguments_are_refused() {
    let sandbox = Sandbox::new();
    let (scene, output) = (sandbox.small_scene(), sandbox.name("out.exr"));
    for (option, value) in [
        ("--alpha", "0"),
        ("--alpha", "1.5"),
        ("--radius", "-1"),
        ("--radius", "nan"),
        ("--photons", "0"),
        ("--photons", "1.5"),
        ("--samples", "0"),
        ("--threads", "0"),
        ("--sampling", "random"),
        ("--time", "-1"),
        ("--passes", "-3"),
        ("--gamma", "0"),
    ] {
        assert_refused(&sandbox, &["render", &scene, "-o", &output, option, value], &[option]);
    }
}

/// Whatever goes wrong, the former picture stays.
#[test]
fn a_failed_render_keeps_the_old_picture() {
    let sandbox = Sandbox::new();
    fs::write(sandbox.path("old.exr"), "precious").unwrap();
    let scene = sandbox.scene(|text| text.replacen("fov = 52", "fov = 500", 1));
    assert_refused(&sandbox, &["render", &scene, "-o", &sandbox.name("old.exr")], &["fov"]);
    assert_eq!(fs::read_to_string(sandbox.path("old.exr")).unwrap(), "precious");
}

#[test]
fn compare_judges_by_its_bounds() {
    let sandbox = Sandbox::new();
    let scene = sandbox.small_scene();
    for seed in ["1", "2"] {
        let output = sandbox.name(&format!("{seed}.exr"));
        #[rustfmt::skip]
        caustica(&["render", &scene, "-o", &output, "--passes", "1", "--photons", "1e4", "--seed", seed]);
    }
    let (a, b) = (sandbox.name("1.exr"), sandbox.name("2.exr"));
    let code = |arguments: &[&str]| caustica(arguments).status.code();
    assert_eq!(code(&["compare", &a, &a, "--fail-above", "mse=0"]), Some(0));
    assert_eq!(code(&["compare", &a, &b]), Some(0), "without a bound it reports");
    assert_eq!(code(&["compare", &a, &b, "--fail-above", "relmse=1e-9"]), Some(1));
    assert_eq!(code(&["compare", &a, &b, "--fail-above", "beauty=1"]), Some(2));
    let json = caustica(&["compare", &a, &b, "--json"]);
    let metrics: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    assert!(metrics["rel_mse"].as_f64().unwrap() > 0.0);
}

#[test]
fn info_tells_what_the_depth_limit_loses() {
    let scene = data("course_balls.toml");
    let output = caustica(&["info", scene.to_str().unwrap(), "--json"]);
    let info: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let cuts = info["cuts"].as_array().unwrap();
    let lost = |index: usize| cuts[index]["lost_share"].as_f64().unwrap();
    assert!(lost(0) > 0.01, "without a single bounce the balls lose their specular share");
    assert!(lost(cuts.len() - 1) < 1e-6, "the default depth loses next to nothing");
    assert!(text(&caustica(&["info", scene.to_str().unwrap()]).stdout).contains("loses"));
}

#[test]
fn a_time_limit_ends_the_render() {
    let sandbox = Sandbox::new();
    let (scene, output) = (sandbox.small_scene(), sandbox.name("a.exr"));
    let run = caustica(&["render", &scene, "-o", &output, "--time", "0.2", "--photons", "1e4"]);
    assert!(run.status.success() && sandbox.path("a.exr").is_file());
    assert!(run.stdout.is_empty(), "quiet in a pipe");
}

/// Ctrl-C: the pass under way is finished, the picture written, and the exit code says so.
#[cfg(unix)]
#[test]
fn an_interrupted_render_writes_the_picture_it_has() {
    use std::io::{BufRead, BufReader};
    let sandbox = Sandbox::new();
    let (scene, output) = (sandbox.small_scene(), sandbox.name("a.exr"));
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_caustica"))
        .args(["render", &scene, "-o", &output, "--passes", "100000000", "--json", "-"])
        .stdout(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    lines.next().unwrap().unwrap();
    let killed = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(killed.unwrap().success());
    lines.for_each(|line| drop(line.unwrap()));
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(caustica::output::read_exr(Path::new(&output)).is_ok());
}

#[test]
fn the_surface_is_written_whole() {
    let sandbox = Sandbox::new();
    let output = sandbox.name("surface.obj");
    assert!(caustica(&["surface", &output, "--cells", "8"]).status.success());
    let obj = fs::read_to_string(output).unwrap();
    let count = |start: &str| obj.lines().filter(|l| l.starts_with(start)).count();
    assert_eq!((count("v "), count("f ")), (81, 128));
}

#[test]
fn bench_reports_a_pass_in_all_forms() {
    let sandbox = Sandbox::new();
    let scene = sandbox.small_scene();
    let (csv, html) = (sandbox.name("a.csv"), sandbox.name("a.html"));
    #[rustfmt::skip]
    let output = caustica(&[
        "bench", "--pass", &scene, "--photons", "1e3", "--samples", "1", "--radius", "2", "--repetitions", "2",
        "--json", "-", "--csv", &csv, "--html", &html,
    ]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&report["hit_points"], &report["scene"]), (&1024.into(), &scene.as_str().into()));
    assert!(report["ratio_to_bare"].as_f64().unwrap() > 0.0);
    let (csv, html) = (fs::read_to_string(csv).unwrap(), fs::read_to_string(html).unwrap());
    let mut numbers: Vec<&str> = csv.lines().skip(1).map(|line| line.split(',').nth(1).unwrap()).collect();
    numbers.retain(|number| !number.is_empty());
    assert!(numbers.len() > 10);
    for number in numbers {
        assert!(html.contains(&format!("<td>{number}</td>")), "the page lacks {number}");
        assert!(text(&output.stderr).contains(number), "the table lacks {number}");
    }
    assert!(!html.replace("http://www.w3.org/2000/svg", "").contains("http"));
}

#[test]
fn bench_holds_the_rivals_against_each_other() {
    #[rustfmt::skip]
    let output = caustica(&[
        "bench", "--gather", "--points", "2e3", "--overlaps", "5", "--photons", "1e3", "--repetitions", "1",
        "--threads", "2", "--variants", "--csv", "-",
    ]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let csv = text(&output.stdout);
    let overlaps: Vec<&str> = csv.lines().skip(1).map(|line| line.rsplit(',').nth(9).unwrap()).collect();
    // Ten structures, and the tree once more by each set of instructions that the machine has.
    assert!((11..=13).contains(&overlaps.len()) && csv.contains(",portable lanes,"), "{csv}");
    assert!(overlaps.iter().all(|count| *count == overlaps[0] && count.parse::<u64>().unwrap() > 1000));
}

#[test]
fn bench_gathers_the_photons_of_a_scene() {
    let sandbox = Sandbox::new();
    let (scene, html) = (sandbox.small_scene(), sandbox.name("a.html"));
    #[rustfmt::skip]
    let output = caustica(&[
        "bench", "--gather", "--scene", &scene, "--points", "500,3e3", "--radii", "0.5,1", "--photons", "1e3",
        "--repetitions", "1", "--json", "-", "--html", &html,
    ]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&report["scene"], &report["emitted"]), (&scene.as_str().into(), &1000.into()));
    assert_eq!(report["extent"], 750.0);
    let rows = report["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 2 * 2 * 6);
    for rows in rows.chunks(6) {
        assert!(rows.iter().all(|row| row["overlaps"] == rows[0]["overlaps"]), "{rows:?}");
        assert!(rows[0]["overlaps"].as_u64().unwrap() > 0);
        for key in ["build_ms", "ns_per_photon"] {
            assert!(rows.iter().all(|row| row[key]["median"].as_f64().unwrap() > 0.0), "{key}");
        }
        for key in ["bytes_per_point", "ns_per_overlap"] {
            assert!(rows.iter().all(|row| row[key].as_f64().unwrap() > 0.0), "{key}");
        }
    }
    assert!(fs::read_to_string(html).unwrap().contains(&scene));
}

#[test]
fn bench_asks_every_engine_about_every_ray() {
    let sandbox = Sandbox::new();
    let html = sandbox.name("a.html");
    #[rustfmt::skip]
    let output = caustica(&[
        "bench", "--rays", "--triangles", "36,500", "--photons", "1e3", "--repetitions", "1", "--threads", "2",
        "--json", "-", "--html", &html,
    ]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let rows = report["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 2 * (11 + 18 + 11));
    assert_eq!((&rows[0]["triangles"], &rows[79]["triangles"]), (&36.into(), &548.into()));
    assert!(rows.iter().all(|row| row["all_threads"]["median"].as_f64().unwrap() > 0.0));
    let html = fs::read_to_string(html).unwrap();
    assert!(html.contains("<td class=\"words\">rtcOccluded1</td>") && html.matches("<svg").count() == 8);
}

#[test]
fn bench_needs_one_question_with_its_own_options() {
    let sandbox = Sandbox::new();
    let scene = sandbox.small_scene();
    assert_refused(&sandbox, &["bench"], &["--pass", "--gather", "--rays"]);
    assert_refused(&sandbox, &["bench", "--gather", "--rays"], &["--gather", "--rays"]);
    assert_refused(&sandbox, &["bench", "--pass", &scene, "--rays"], &["--rays"]);
    assert_refused(&sandbox, &["bench", "--rays", "--retrace"], &["--retrace"]);
    assert_refused(&sandbox, &["bench", "--rays", "--points", "10"], &["--points"]);
    assert_refused(&sandbox, &["bench", "--gather", "--triangles", "36"], &["--triangles"]);
    assert_refused(&sandbox, &["bench", "--rays", "--triangles", "1e9"], &["--triangles"]);
    assert_refused(&sandbox, &["bench", "--gather", "--pass", &scene], &["--gather"]);
    assert_refused(&sandbox, &["bench", "--scene", &scene], &["--gather"]);
    assert_refused(&sandbox, &["bench", "--rays", "--scene", &scene], &["--scene"]);
    assert_refused(&sandbox, &["bench", "--pass", &scene, "--scene", &scene], &["--scene"]);
    let gather_scene = ["bench", "--gather", "--scene", &scene];
    assert_refused(&sandbox, &[&gather_scene[..], &["--overlaps", "5"]].concat(), &["--overlaps", "--scene"]);
    let too_many = [&gather_scene[..], &["--points", "1e8", "--photons", "10"]].concat();
    assert_refused(&sandbox, &too_many, &["scene.toml", "4096 eye samples", "100000000 hit points"]);
    assert_refused(&sandbox, &["bench", "--gather", "--scene", &sandbox.name("none.toml")], &["none.toml"]);
    assert_refused(&sandbox, &["bench", "--gather", "--radius", "1"], &["--radius"]);
    assert_refused(&sandbox, &["bench", "--pass", &scene, "--points", "10"], &["--points"]);
    assert_refused(&sandbox, &["bench", "--gather", "--radii", "0"], &["--radii"]);
    assert_refused(&sandbox, &["bench", "--gather", "--points", "1e9"], &["--points"]);
    assert_refused(&sandbox, &["bench", "--pass", &sandbox.name("none.toml")], &["none.toml"]);
    let folder = sandbox.name("");
    assert_refused(&sandbox, &["bench", "--pass", &scene, "--html", &folder], &["folder"]);
}

#[test]
fn bench_gathers_no_photons_in_the_dark() {
    let sandbox = Sandbox::new();
    let scene = sandbox.scene(|text| text.replace("intensity = [6000, 6000, 6000]", "intensity = [0, 0, 0]"));
    assert_refused(
        &sandbox,
        &["bench", "--gather", "--scene", &scene],
        &["scene.toml", "no photon", "light"],
    );
}

/// A black picture, a warning, and exit code 0.
#[test]
fn a_scene_without_light_is_black() {
    let sandbox = Sandbox::new();
    let scene = sandbox.scene(|text| text.replace("intensity = [6000, 6000, 6000]", "intensity = [0, 0, 0]"));
    let output = caustica(&["render", &scene, "-o", &sandbox.name("a.exr"), "--passes", "1"]);
    assert!(output.status.success() && text(&output.stderr).contains("warning"));
    let image = caustica::output::read_exr(&sandbox.path("a.exr")).unwrap();
    assert!(image.pixels().iter().all(|p| *p == caustica::math::Rgb::ZERO));
}

/// A target ends the render, the last words tell of the error, and the statistics foretell.
#[test]
fn target_error_ends_the_render() {
    let sandbox = Sandbox::new();
    let (scene, picture, json) = (sandbox.small_scene(), sandbox.name("a.exr"), sandbox.name("a.jsonl"));
    let base = ["render", &scene, "-o", &picture, "--radius", "8", "--photons", "5000", "--json", &json];
    let output = caustica(&[&base[..], &["--target-error", "4%", "--confidence", "90%"]].concat());
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{message}");
    for word in
        ["target: relative error", "at most 4.00 % with 90.0 % confidence", "error after", "noise", "bias"]
    {
        assert!(message.contains(word), "`{word}` is not in: {message}");
    }
    assert!(!message.contains("is not reached"), "{message}");
    let lines = fs::read_to_string(sandbox.path("a.jsonl")).unwrap();
    let looks: Vec<serde_json::Value> = lines
        .lines()
        .map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap()["error"].clone())
        .filter(|error| !error.is_null())
        .collect();
    let last = looks.last().unwrap();
    assert!(last["upper"].as_f64().unwrap() <= 0.04 && looks.len() > 3, "{looks:?}");
    assert!(looks[looks.len() - 2]["outlook"]["passes"].is_f64(), "{looks:?}");
    assert!(looks[..looks.len() - 1].iter().all(|look| look["upper"].as_f64().unwrap() > 0.04));
}

#[test]
fn a_target_that_is_missed_is_told() {
    let sandbox = Sandbox::new();
    let (scene, picture) = (sandbox.small_scene(), sandbox.name("a.exr"));
    let options = ["--radius", "8", "--photons", "5000", "--passes", "8", "--target-error", "0.1%"];
    let output = caustica(&[&["render", &scene, "-o", &picture][..], &options].concat());
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{message}");
    assert!(message.contains("the target of 0.100 % is not reached, it would be after about"), "{message}");
}

#[test]
fn a_target_out_of_reach_is_refused() {
    let sandbox = Sandbox::new();
    let (scene, picture) = (sandbox.small_scene(), sandbox.name("a.exr"));
    for hopeless in [["--alpha", "1"], ["--radius-policy", "fixed"]] {
        let arguments = [&["render", &scene, "-o", &picture, "--target-error", "2%"][..], &hopeless].concat();
        assert_refused(
            &sandbox,
            &arguments,
            &["2.00 %", "out of reach", "radii do not shrink", "--alpha below 1"],
        );
    }
    let arguments = ["render", &scene, "-o", &picture, "--target-error", "2%", "--no-error-estimates"];
    assert_refused(&sandbox, &arguments, &["--target-error", "--no-error-estimates"]);
}

/// Layers hold the bounds, `compare` reads them, and the picture is the same as without.
#[test]
fn layers_are_read_by_compare() {
    let sandbox = Sandbox::new();
    let (scene, plain, layered) = (sandbox.small_scene(), sandbox.name("a.exr"), sandbox.name("b.exr"));
    let base =
        |output| ["render", &scene, "-o", output, "--passes", "4", "--radius", "8", "--photons", "5000"];
    assert!(caustica(&base(&plain)).status.success());
    assert!(caustica(&[&base(&layered)[..], &["--layers"]].concat()).status.success());
    let bound = format!("{layered}:bound");
    let output = caustica(&["compare", &layered, &plain, "--bound", &bound, "--fail-above", "mse=0"]);
    let message = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{message}{}", text(&output.stderr));
    assert!(message.contains("coverage    1.000000"), "{message}");
    for layer in ["stderr", "bias", "photons", "radius"] {
        let name = format!("{layered}:{layer}");
        assert_eq!(caustica(&["compare", &name, &name]).status.code(), Some(0), "{layer}");
    }
}
