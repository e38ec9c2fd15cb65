//! An installed tree, `bin` beside `lib`, runs wherever it is moved.

#![allow(clippy::unwrap_used)]

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use caustica::embree::Device;

/// The Embree library that this process has loaded, as its memory map tells.
fn loaded_embree() -> PathBuf {
    Device::new().unwrap();
    let maps = fs::read_to_string("/proc/self/maps").unwrap();
    let path = maps.lines().filter_map(|line| line.find('/').map(|at| &line[at..]));
    PathBuf::from(path.into_iter().find(|path| path.contains("/libembree4")).unwrap())
}

/// What the copy of this program in `tree` says about the library it loads.
fn embree_of(tree: &Path) -> String {
    let mut program = Command::new(tree.join("bin/program"));
    program.args(["--ignored", "--exact", "tells_which_embree_is_loaded", "--nocapture"]);
    let output = program.env_remove("LD_LIBRARY_PATH").output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn install_into(tree: &Path, libraries: &Path) {
    fs::create_dir_all(tree.join("bin")).unwrap();
    fs::create_dir_all(tree.join("lib")).unwrap();
    fs::copy(env::current_exe().unwrap(), tree.join("bin/program")).unwrap();
    for library in fs::read_dir(libraries).unwrap().map(|entry| entry.unwrap()) {
        if library.file_name().to_string_lossy().contains(".so.") {
            fs::copy(library.path(), tree.join("lib").join(library.file_name())).unwrap();
        }
    }
}

#[test]
#[ignore = "the other test runs it from a tree of its own"]
fn tells_which_embree_is_loaded() {
    println!("loaded {}", loaded_embree().display());
}

#[test]
fn an_installed_tree_runs_where_it_is_moved() {
    let embree = loaded_embree();
    if embree.starts_with("/usr") {
        eprintln!("skipped: the system's Embree is not installed along");
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    let (tree, moved) = (dir.path().join("tree"), dir.path().join("moved"));
    install_into(&tree, embree.parent().unwrap());
    assert!(embree_of(&tree).contains(&format!("loaded {}/lib/libembree4", tree.display())));
    fs::rename(&tree, &moved).unwrap();
    assert!(embree_of(&moved).contains(&format!("loaded {}/lib/libembree4", moved.display())));
}
