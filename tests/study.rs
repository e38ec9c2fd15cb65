//! `caustica study` as a user meets it: what it writes, and that it goes on where it was.
#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use std::fs;
use std::path::Path;
use std::process::Output;
use std::time::Duration;

use caustica::compare::Metrics;
use caustica::output::read_exr;
use caustica::report::Cell;
use serde_json::Value;

mod study_scene;

use study_scene::{Studio, caustica};

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

fn lines(path: &Path) -> Vec<String> {
    fs::read_to_string(path).unwrap().lines().map(str::to_owned).collect()
}

fn assert_success(output: &Output) {
    assert!(output.status.success(), "{}", text(&output.stderr));
}

#[test]
fn a_study_reports_the_same_numbers_in_all_forms() {
    let studio = Studio::new();
    studio.study_to_the_end(&["--axes", "alpha,method", "--repetitions", "2", "--budget", "6"]);
    let report = json(&studio.path("study/study.json"));
    let html = fs::read_to_string(studio.path("study/study.html")).unwrap();
    let text_of_page = html.replace("<span>", "").replace("</span>", "");
    let csv = lines(&studio.path("study/study.csv"));
    let curves = report["curves"].as_array().unwrap();
    assert_eq!(curves.len(), 7, "the baseline, four alphas, path tracing and light tracing");
    let points: Vec<&Value> = curves.iter().flat_map(|curve| curve["points"].as_array().unwrap()).collect();
    assert_eq!(csv.len(), 1 + points.len());
    for (point, line) in points.iter().zip(&csv[1..]) {
        assert_eq!(point["repetitions"], 2);
        for number in [&point["seconds"]["median"], &point["error_percent"]["mean"], &point["rel_mse"]] {
            let shown = Cell::Number(number.as_f64().unwrap()).to_string();
            assert!(html.contains(&format!("<td>{shown}</td>")), "the page lacks {shown}");
            assert!(line.split(',').any(|field| field == shown), "{line} lacks {shown}");
        }
        let command = point["command"].as_str().unwrap();
        assert!(text_of_page.contains(&format!("<code>{command}</code>")), "the page lacks {command}");
    }
    let duels = report["duels"].as_array().unwrap().len();
    // Whether two methods were measured at one time depends on the clock; `study::leader` has the tests of what they then are.
    assert_eq!(html.matches("<p class=\"duel\">Measured: at").count(), duels);
    let rest = html.replace("http://www.w3.org/2000/svg", "");
    assert!(!rest.contains("http") && !rest.contains("url(") && !rest.contains("src=\"/"));
    let plots = plots_of_parts(&curves[0]);
    assert_eq!(html.matches("<svg").count(), 3 + plots, "the front and two axes, and of variance and bias");
    assert_eq!(html.matches("data:image/png").count(), 1 + 2 * 7);
}

/// How many plots the baseline's variance and squared bias need: what is not told from 0 is not drawn.
fn plots_of_parts(baseline: &Value) -> usize {
    let points = baseline["points"].as_array().unwrap();
    let has_bias = |region: &str| {
        let told = |point: &Value| {
            let parts = &point["separation"][region];
            let of = |name: &str| parts[name].as_f64();
            of("bias2").is_some_and(|bias2| bias2 > 2.0 * of("bias2_error").unwrap())
        };
        usize::from(points.iter().any(told))
    };
    1 + has_bias("all") + has_bias("flat")
}

/// At every point, variance, squared bias and the reference's own variance are the whole error; the page and the list have both.
#[test]
fn variance_and_bias_are_the_whole_error() {
    let studio = Studio::new();
    studio.study_to_the_end(&["--axes", "convergence", "--repetitions", "3", "--budget", "8"]);
    let report = json(&studio.path("study/study.json"));
    let html = fs::read_to_string(studio.path("study/study.html")).unwrap();
    let csv = fs::read_to_string(studio.path("study/study.csv")).unwrap();
    assert!(html.contains("<h2>Variance and bias</h2>") && html.contains("squared bias, flat"));
    assert!(html.contains("theory, shared, alpha 2/3: -0.67"), "theory is drawn");
    let mut noises = Vec::new();
    for curve in report["curves"].as_array().unwrap() {
        assert!(curve["convergence"]["variance"]["theory"].is_f64(), "{}", curve["name"]);
        for point in curve["points"].as_array().unwrap() {
            let parts = &point["separation"]["all"];
            let [variance, bias2] = ["variance", "bias2"].map(|name| parts[name].as_f64().unwrap());
            noises.push(point["rel_mse"].as_f64().unwrap() - variance - bias2);
            for number in [variance, bias2] {
                assert!(csv.contains(&format!(",{},", Cell::Number(number))), "the list lacks {number}");
            }
        }
    }
    let told = report["reference_made"]["error_percent"].as_f64().unwrap();
    assert!((100.0 * noises[0].sqrt() / told - 1.0).abs() < 0.1, "{told} %, but {}", noises[0]);
    assert!(noises.iter().all(|noise| (noise / noises[0] - 1.0).abs() < 1e-6), "{noises:?}");
    assert!(!studio.path("study/pictures/looks").exists());
}

/// The picture of the command has the very error that the study notes.
#[test]
fn every_number_is_made_by_its_command() {
    let studio = Studio::new();
    let axes = "method,traversal,sampling,policy,convergence,precision";
    studio.study_to_the_end(&["--axes", axes, "--repetitions", "1", "--budget", "6"]);
    let report = json(&studio.path("study/study.json"));
    let reference = read_exr(&studio.path("study/reference.exr")).unwrap();
    let curves = report["curves"].as_array().unwrap();
    assert_eq!(curves.len(), 13);
    for curve in curves {
        // Where discs are large, a share of time may hold less than three looks.
        let points = curve["points"].as_array().unwrap();
        let point = &points[points.len().min(3) - 1];
        let command = point["command"].as_str().unwrap();
        let picture = studio.name("picture.exr");
        let mut words: Vec<&str> = command.split(' ').skip(1).collect();
        words.extend(["-o", &picture]);
        assert_success(&caustica(&words));
        let metrics = Metrics::between(&read_exr(Path::new(&picture)).unwrap(), &reference).unwrap();
        let noted = point["rel_mse"].as_f64().unwrap();
        assert!(
            (metrics.rel_mse / noted - 1.0).abs() < 1e-12,
            "{command}: {} is noted as {noted}",
            metrics.rel_mse
        );
    }
}

#[test]
fn a_finished_study_measures_nothing_again() {
    let studio = Studio::new();
    let arguments = ["--axes", "effects", "--repetitions", "2", "--budget", "2"];
    studio.study_to_the_end(&arguments);
    let measured = fs::read(studio.path("study/measurements.jsonl")).unwrap();
    let (page, reference) =
        (fs::read(studio.path("study/study.html")).unwrap(), studio.path("study/reference.exr"));
    let made = fs::metadata(&reference).unwrap().modified().unwrap();
    let again = studio.study(&arguments);
    assert_success(&again);
    assert!(text(&again.stderr).contains("0 runs measured now"), "{}", text(&again.stderr));
    assert_eq!(fs::read(studio.path("study/measurements.jsonl")).unwrap(), measured);
    assert_eq!(
        fs::read(studio.path("study/study.html")).unwrap(),
        page,
        "the same numbers make the same page"
    );
    assert_eq!(fs::metadata(&reference).unwrap().modified().unwrap(), made);
    let longer = studio.study(&["--axes", "effects", "--repetitions", "2", "--budget", "2.5"]);
    assert!(!text(&longer.stderr).contains("0 runs measured now"), "other settings are measured");
}

#[cfg(unix)]
#[test]
fn an_interrupted_study_reports_and_goes_on() {
    let studio = Studio::new();
    let arguments = ["--axes", "alpha", "--repetitions", "2", "--budget", "8"];
    let journal = studio.path("study/measurements.jsonl");
    let mut child = studio.command(&arguments).spawn().unwrap();
    while fs::read(&journal).unwrap_or_default().is_empty() {
        assert!(child.try_wait().unwrap().is_none(), "it ended before it measured anything");
        std::thread::sleep(Duration::from_millis(20));
    }
    let killed = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(killed.unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let html = fs::read_to_string(studio.path("study/study.html")).unwrap();
    assert!(html.contains("the same command goes on"));
    let before = lines(&journal);
    assert!(before.len() < 10);
    fs::write(&journal, format!("{}\n{{\"key\": \"torn", before.join("\n"))).unwrap();
    let output = studio.study(&arguments);
    assert!(text(&output.stderr).contains("was torn"), "{}", text(&output.stderr));
    studio.study_to_the_end(&arguments);
    let after = lines(&journal);
    assert_eq!((after.len(), &after[..before.len()]), (10, &before[..]), "nothing is measured twice");
    assert!(
        !fs::read_to_string(studio.path("study/study.html")).unwrap().contains("the same command goes on")
    );
}

#[test]
fn the_list_says_what_would_be_measured() {
    let studio = Studio::new();
    let output = studio.bare(&["--list", "--axes", "radius,traversal"]);
    assert_success(&output);
    let list = text(&output.stdout);
    assert_eq!(list.lines().count(), 6, "{list}");
    for words in ["radius x4", "--radius 2", "--traversal embree-fast", "--size 192x192", "baseline"] {
        assert!(list.contains(words), "{words} is not in {list}");
    }
    assert!(!studio.path("study").exists());
}

#[test]
fn what_cannot_be_studied_is_refused() {
    let studio = Studio::new();
    let refused = |arguments: &[&str], words: &[&str]| {
        let output = studio.bare(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        for word in words {
            assert!(text(&output.stderr).contains(word), "{word} is not in {}", text(&output.stderr));
        }
    };
    refused(&[], &["--reference", "--make-reference"]);
    refused(&["--make-reference", "--axes", "beauty"], &["beauty", "alpha"]);
    refused(&["--make-reference", "--size", "0x3"], &["--size", "640x480"]);
    refused(&["--make-reference", "--quick", "--full"], &["--quick"]);
    refused(&["--make-reference", "--reference-stderr", "a.exr"], &["--reference"]);
    refused(&["--reference", &studio.name("missing.exr")], &["missing.exr"]);
    let picture = studio.name("small.exr");
    let scene = studio.scene();
    assert_success(&caustica(&["render", &scene, "--size", "8x8", "--passes", "1", "-o", &picture]));
    refused(&["--reference", &picture, "--size", "9x8"], &["8x8", "9x8"]);
}

/// A reference that is given sets the size.
#[test]
fn a_given_reference_is_used() {
    let studio = Studio::new();
    let picture = studio.name("reference.exr");
    let scene = studio.scene();
    assert_success(&caustica(&["render", &scene, "--size", "12x10", "--passes", "20", "-o", &picture]));
    let output =
        studio.bare(&["--reference", &picture, "--axes", "effects", "--repetitions", "1", "--budget", "1"]);
    assert_success(&output);
    let report = json(&studio.path("study/study.json"));
    assert_eq!((&report["size"][0], &report["size"][1]), (&12.into(), &10.into()));
    assert_eq!((&report["reference"], &report["reference_made"]), (&picture.as_str().into(), &Value::Null));
    assert_eq!(report["reference_noise_is_known"], false);
    let error = studio.name("small_stderr.exr");
    assert_success(&caustica(&[
        "reference",
        &scene,
        "--size",
        "9x8",
        "--spp",
        "2",
        "-o",
        &studio.name("small.exr"),
    ]));
    let refused = studio.bare(&["--reference", &picture, "--reference-stderr", &error]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(text(&refused.stderr).contains("9x8"), "{}", text(&refused.stderr));
}
