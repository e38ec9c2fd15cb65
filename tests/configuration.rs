//! Variables in the place of flags, colours on terminals and elsewhere, completions and manual pages.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a panic is how a test fails")]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use assert_cmd::cargo::CommandCargoExt;

mod common;

fn caustica() -> Command {
    let mut command = Command::cargo_bin("caustica").unwrap();
    ["NO_COLOR", "CLICOLOR", "CLICOLOR_FORCE"].into_iter().for_each(|name| {
        command.env_remove(name);
    });
    command
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// A folder with a scene that asks for 3 passes.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let scene = format!("{}\n[render]\npasses = 3\nphotons = 2000\n", common::GLASS_AND_LAMPS);
    fs::write(folder.path().join("scene.toml"), scene).unwrap();
    folder
}

fn run(folder: &Path, command: &str, variables: &[(&str, &str)], flags: &[&str]) -> Output {
    let mut program = caustica();
    program.current_dir(folder).args([command, "scene.toml", "-o", "a.exr"]).args(flags);
    program.envs(variables.iter().copied()).output().unwrap()
}

/// What a render writes that is asked for like that.
fn rendered(folder: &Path, variables: &[(&str, &str)], flags: &[&str]) -> Vec<u8> {
    let done = run(folder, "render", variables, flags);
    assert!(done.status.success(), "{}", text(&done.stderr));
    fs::read(folder.join("a.exr")).unwrap()
}

#[test]
fn variables_stand_for_flags_below_them_and_above_the_scene() {
    let folder = folder();
    let rendered = |variables: &[(&str, &str)], flags: &[&str]| rendered(folder.path(), variables, flags);
    let flags = ["--reproducible", "--passes", "2", "--eye-seed", "5"];
    let by_flags = rendered(&[], &flags);
    assert_eq!(text(&by_flags).matches("caustica:passes\0int\0\u{4}\0\0\0\u{2}").count(), 1);
    let variables = [("CAUSTICA_REPRODUCIBLE", "yes"), ("CAUSTICA_PASSES", "2"), ("CAUSTICA_EYE_SEED", "5")];
    assert!(rendered(&variables, &[]) == by_flags, "as flags, above the scene");
    let others = [("CAUSTICA_PASSES", "7"), ("CAUSTICA_EYE_SEED", "6"), ("CAUSTICA_SEED", "")];
    assert!(rendered(&others, &flags) == by_flags, "below flags, and nothing where they are empty");
}

#[test]
fn flags_win_over_variables_that_they_exclude() {
    let folder = folder();
    let has_layers = |variables: &[(&str, &str)], flags: &[&str]| {
        text(&rendered(folder.path(), variables, &[&["--passes", "2"], flags].concat())).contains("stderr.R")
    };
    assert!(has_layers(&[("CAUSTICA_NO_ERROR_ESTIMATES", "1")], &["--layers"]));
    assert!(!has_layers(&[("CAUSTICA_LAYERS", "1")], &["--no-error-estimates"]));
    assert!(has_layers(&[("CAUSTICA_LAYERS", "1")], &[]));
    assert!(!has_layers(&[("CAUSTICA_LAYERS", "0")], &[]));
    assert!(has_layers(&[("CAUSTICA_LAYERS", "on"), ("CAUSTICA_NO_ERROR_ESTIMATES", "off")], &[]));
}

#[test]
fn wrong_values_tell_the_variable_and_exit_with_2() {
    let folder = folder();
    let variables = [("CAUSTICA_PASSES", "many"), ("CAUSTICA_THREADS", "1")];
    let done = run(folder.path(), "render", &variables, &[]);
    let told = text(&done.stderr);
    assert_eq!(done.status.code(), Some(2), "{told}");
    assert!(told.contains("invalid value 'many' for '--passes <N|A..B>'"), "{told}");
    assert!(
        told.ends_with("taken from the environment: CAUSTICA_PASSES=many CAUSTICA_THREADS=1\n"),
        "{told}"
    );
    assert!(!folder.path().join("a.exr").exists());
}

#[test]
fn variables_of_no_flag_are_told_and_other_commands_do_not_look() {
    let folder = folder();
    let variables = [("CAUSTICA_PASES", "2"), ("CAUSTICA_PASSES", "1")];
    let done = run(folder.path(), "reference", &variables, &["--spp", "1"]);
    let told = text(&done.stderr);
    assert!(done.status.success() && told.contains("CAUSTICA_PASES stands for no flag"), "{told}");
    assert!(!told.contains("CAUSTICA_PASSES stands"), "that is one of render: {told}");
    let info =
        caustica().current_dir(&folder).args(["info", "scene.toml"]).env("CAUSTICA_JSON", "1").output();
    let info = info.unwrap();
    assert!(text(&info.stdout).starts_with("scene        scene.toml") && info.stderr.is_empty());
}

#[test]
fn pictures_tell_the_command_and_the_variables_unless_they_are_reproducible() {
    let folder = folder();
    let variables = [("CAUSTICA_SEED", "5"), ("CAUSTICA_OUTPUT", "a b.exr")];
    let told = text(&rendered(folder.path(), &variables, &["--passes", "1"]));
    let start = told.find("CAUSTICA_OUTPUT='a b.exr' CAUSTICA_SEED=5 ").expect("variables");
    assert!(
        told[start..].contains("caustica render scene.toml -o a.exr --passes 1"),
        "{}",
        &told[start..][..200]
    );
    let told = text(&rendered(folder.path(), &variables, &["--passes", "1", "--reproducible"]));
    assert!(!told.contains("scene.toml -o") && !told.contains("CAUSTICA_SEED"));
}

const ESCAPE: char = '\u{1b}';

#[test]
fn help_is_coloured_only_where_that_is_wanted() {
    let help = |variables: &[(&str, &str)], argument: &str| {
        let mut command = caustica();
        let done = command.args(["render", argument]).envs(variables.iter().copied()).output().unwrap();
        text(&[done.stdout, done.stderr].concat())
    };
    for argument in ["--help", "--no-such-flag"] {
        assert!(!help(&[], argument).contains(ESCAPE), "no terminal: {argument}");
        assert!(help(&[("CLICOLOR_FORCE", "1")], argument).contains(ESCAPE), "{argument}");
        let both = [("CLICOLOR_FORCE", "1"), ("NO_COLOR", "1")];
        assert!(!help(&both, argument).contains(ESCAPE), "{argument}");
    }
}

/// Colours begin with an escape and end with an m; moves of the cursor end with other letters.
fn has_colours(told: &str) -> bool {
    let ends = told
        .split("\u{1b}[")
        .skip(1)
        .filter_map(|rest| rest.find(|c: char| c.is_ascii_alphabetic()).map(|end| rest.as_bytes()[end]));
    ends.into_iter().any(|end| end == b'm')
}

#[test]
fn terminals_without_colours_get_none() {
    let program = caustica().get_program().to_string_lossy().into_owned();
    let folder = folder();
    let on_terminal = |variables: &[(&str, &str)], arguments: &str| {
        let mut script = Command::new("script");
        script.args(["-qec", &format!("{program} {arguments}"), "/dev/null"]).current_dir(&folder);
        script.env_remove("NO_COLOR").env("TERM", "xterm-256color").envs(variables.iter().copied());
        script.output().map(|done| text(&done.stdout))
    };
    let Ok(help) = on_terminal(&[], "--help") else {
        eprintln!("skipped: there is no program `script` that makes a terminal");
        return;
    };
    assert!(has_colours(&help), "{help}");
    let render = "render scene.toml -o a.exr --passes 2";
    for variable in ["NO_COLOR", "CLICOLOR"] {
        let value = if variable == "NO_COLOR" { "1" } else { "0" };
        let told = on_terminal(&[(variable, value)], "--help").unwrap();
        assert!(told.contains("Usage: caustica") && !has_colours(&told), "{variable}: {told}");
        let told = on_terminal(&[(variable, value)], render).unwrap();
        assert!(told.contains("2 passes in") && !has_colours(&told), "{variable}: {told}");
    }
}

#[test]
fn completions_know_commands_and_flags() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let done = caustica().args(["completions", shell]).output().unwrap();
        let script = text(&done.stdout);
        assert!(done.status.success());
        for word in ["caustica", "render", "reference", "display-server", "completions"] {
            assert!(script.contains(word), "{shell}: {word}");
        }
    }
}

#[test]
fn bash_completes_by_them() {
    let script = caustica().args(["completions", "bash"]).output().unwrap().stdout;
    let folder = folder();
    fs::write(folder.path().join("caustica.bash"), script).unwrap();
    let complete = "source caustica.bash; COMP_WORDS=(caustica render --disp); COMP_CWORD=2; \
        _caustica caustica --disp render; echo ${COMPREPLY[@]}";
    let done = Command::new("bash").args(["--norc", "-c", complete]).current_dir(&folder).output().unwrap();
    assert_eq!(text(&done.stdout), "--display-server\n", "{}", text(&done.stderr));
}

#[test]
fn manual_pages_stand_for_the_program_and_every_command() {
    let folder = tempfile::tempdir().unwrap();
    let pages = folder.path().join("man/man1");
    let done = caustica().arg("man").arg(&pages).output().unwrap();
    assert!(done.status.success(), "{}", text(&done.stderr));
    let page = |name: &str| fs::read_to_string(pages.join(name)).unwrap();
    assert!(page("caustica.1").contains("caustica\\-compare(1)"));
    let render = page("caustica-render.1");
    assert!(render.starts_with(".ie") || render.starts_with(".TH"), "{render}");
    for part in [
        ".TH caustica-render 1  \"caustica 0.",
        "\\-\\-target\\-error",
        "Examples:",
        "\\-\\-display\\-server",
    ] {
        assert!(render.contains(part), "{part} in {render}");
    }
    assert_eq!(
        text(&done.stdout),
        format!("wrote {} pages into {}\n", fs::read_dir(&pages).unwrap().count(), pages.display())
    );
}
