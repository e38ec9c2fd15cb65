//! `caustica convert`: what stands on the disk afterwards.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a panic is how a test fails")]

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use caustica::scene::{SceneDesc, load};

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name)
}

fn convert(from: &Path, to: &Path) -> Result<(), String> {
    let mut program = Command::new(env!("CARGO_BIN_EXE_caustica"));
    let output = program.arg("convert").args([from, to]).output().unwrap();
    let told = String::from_utf8(output.stderr).unwrap();
    if output.status.success() { Ok(()) } else { Err(format!("{}: {told}", output.status)) }
}

/// Textures' largest values stand for them here: what they show is compared where they are written.
fn looks(desc: &SceneDesc) -> Vec<(String, String)> {
    let look = |m: &caustica::scene::Material| (m.name.clone(), format!("{:?} {:?}", m.bsdf, m.emission));
    desc.materials.iter().map(look).collect()
}

/// A scene with pictures on surfaces, on a sphere and all around can be moved away with its folders, and goes back to TOML.
#[test]
fn a_converted_scene_holds_its_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let (first, moved) = (folder.path().join("first"), folder.path().join("moved"));
    fs::create_dir(&first).unwrap();
    convert(&data("evening.toml"), &first.join("evening.xml")).unwrap();
    fs::rename(&first, &moved).unwrap();
    let mut names: Vec<_> = fs::read_dir(moved.join("evening_pictures"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name())
        .collect();
    names.sort();
    assert_eq!(names, ["brushed.png", "evening.png", "tiles.png"]);
    convert(&moved.join("evening.xml"), &moved.join("back.toml")).unwrap();
    let [ours, theirs] = [data("evening.toml"), moved.join("back.toml")].map(|path| load(&path).unwrap());
    assert_eq!(looks(&ours), looks(&theirs));
    assert_eq!(ours.spheres, theirs.spheres);
    for name in names {
        let bytes = fs::read(data(name.to_str().unwrap())).unwrap();
        assert!(bytes == fs::read(moved.join("back_pictures").join(name)).unwrap());
    }
}

#[test]
fn no_picture_takes_the_place_of_another() {
    let folder = tempfile::tempdir().unwrap();
    let (xml, picture) = (folder.path().join("w.xml"), folder.path().join("w_pictures/boards.png"));
    convert(&data("window.toml"), &xml).unwrap();
    convert(&data("window.toml"), &xml).expect("the same picture may stay");
    fs::write(&picture, "another").unwrap();
    fs::remove_file(&xml).unwrap();
    let told = convert(&data("window.toml"), &xml).unwrap_err();
    assert!(
        told.contains("exit status: 2") && told.contains("w_pictures/boards.png: there is another file"),
        "{told}"
    );
    assert_eq!(fs::read(&picture).unwrap(), b"another");
    assert!(!xml.exists(), "nothing is written");
}
