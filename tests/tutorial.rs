//! The tutorial's scene and its commands: what a stranger types first works as it stands there.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::Path;

use assert_cmd::Command;

/// What follows the line ` ```kind ` up to the next fence, block by block.
fn blocks<'a>(text: &'a str, kind: &str) -> Vec<&'a str> {
    let fence = format!("```{kind}\n");
    text.split(&fence).skip(1).map(|rest| rest.split("```").next().unwrap()).collect()
}

/// Commands that a test can do without: they measure for minutes, or hand work to a cluster.
fn is_left_out(line: &str) -> bool {
    line.contains(" study ") || line.contains("--slurm")
}

/// For a picture of 36 x 24 pixels that is wanted soon.
fn smaller(line: &str) -> String {
    line.replace("--time 120", "--time 1").replace("--spp 400", "--spp 4").replace("0,40,120,160", "0,3,9,12")
}

fn commands(text: &str) -> Vec<Vec<String>> {
    let lines = blocks(text, "sh").into_iter().flat_map(str::lines);
    let own = lines.filter(|line| line.starts_with("caustica ") && !is_left_out(line));
    own.map(|line| shlex::split(&smaller(line)).unwrap().split_off(1)).collect()
}

fn run(folder: &Path, arguments: &[String]) {
    let mut command = Command::cargo_bin("caustica").unwrap();
    let done = command.args(arguments).current_dir(folder).output().unwrap();
    // The farm is not rendered, which its status tells by 1.
    let expected = i32::from(arguments[0] == "status");
    assert_eq!(
        done.status.code(),
        Some(expected),
        "{arguments:?}: {}",
        String::from_utf8_lossy(&done.stderr)
    );
}

#[test]
fn the_tutorial_works_as_it_stands() {
    let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/tutorial.md")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let small = blocks(&text, "toml")[0].replace("width = 480\nheight = 320", "width = 36\nheight = 24");
    fs::create_dir(folder.path().join("out")).unwrap();
    fs::write(folder.path().join("out/marble.toml"), small).unwrap();
    let commands = commands(&text);
    assert!(commands.len() > 10, "{commands:?}");
    commands.iter().for_each(|command| run(folder.path(), command));
    for made in ["marble_error.png", "sweep/batch.html", "marble.farm/tasks.txt"] {
        assert!(folder.path().join("out").join(made).exists(), "{made}");
    }
}
