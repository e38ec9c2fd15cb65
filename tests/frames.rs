//! Scenes that follow each other: what they share is parsed and built once, and no bit tells.

// Clippy takes helpers outside `#[test]` functions for ordinary code.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::Path;
use std::sync::Arc;

use caustica::film::Image;
use caustica::math::{Rgb, Vec3};
use caustica::ppm::{Render, Settings};
use caustica::scene::{Access, MeshMemory, Scene, SceneDesc, Traversal, load_with, water};

fn frame(folder: &Path, x: f32, albedo: f32) -> SceneDesc {
    let text = format!(
        "[film]\nwidth = 24\nheight = 16\n[camera]\nposition = [{x}, 3, 2]\nlook_at = [0, 0, 0]\nfov = 40\n\
         [render]\nphotons = 2000\n[material.a]\ndiffuse = {{ albedo = [{albedo}, 0.5, 0.5] }}\n\
         [material.w]\ndielectric = {{ ior = 1.33 }}\n\
         [[mesh]]\nfile = \"water.obj\"\nmaterial = \"w\"\n[[sphere]]\ncenter = [0, -1, 0]\nradius = 0.5\nmaterial = \"a\"\n\
         [[point_light]]\nposition = [0, 3, 0]\nintensity = [1, 1, 1]\n"
    );
    let path = folder.join("frame.toml");
    fs::write(&path, text).unwrap();
    load_with(&path, &Access::any()).unwrap()
}

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut surface = Vec::new();
    water::write_obj(&mut surface, 8).unwrap();
    fs::write(folder.path().join("water.obj"), surface).unwrap();
    folder
}

fn picture(scene: &Scene) -> Image {
    let mut render = Render::new(scene, Settings::of_scene(scene.render()));
    render.pass();
    render.pass();
    render.picture()
}

#[test]
fn frames_of_the_same_surfaces_share_a_tree_and_lose_no_bit() {
    let folder = folder();
    for traversal in [Traversal::Embree, Traversal::EmbreeFast, Traversal::Custom] {
        let first = Scene::with_traversal(frame(folder.path(), 0.0, 0.5), traversal).unwrap();
        let second = first.successor(frame(folder.path(), 0.5, 0.8)).unwrap();
        let alone = Scene::with_traversal(frame(folder.path(), 0.5, 0.8), traversal).unwrap();
        assert!(second.shares_tree(&first) && !alone.shares_tree(&first));
        assert!(picture(&second) == picture(&alone), "{traversal}");
        assert!(picture(&second) != picture(&first), "{traversal}: the test sees nothing");
        assert_ne!(picture(&second).get(12, 8), Rgb::ZERO);
    }
}

#[test]
fn surfaces_that_moved_get_a_tree_of_their_own() {
    let folder = folder();
    let first = Scene::new(frame(folder.path(), 0.0, 0.5)).unwrap();
    let changes: [fn(&mut SceneDesc); 5] = [
        |desc| desc.meshes[0].vertices[3].y += 1e-6,
        |desc| desc.meshes[0].triangles[0].swap(0, 1),
        |desc| desc.spheres[0].radius *= 1.5,
        |desc| desc.spheres[0].center += Vec3::X,
        |desc| drop(desc.meshes.pop()),
    ];
    for (number, change) in changes.iter().enumerate() {
        let mut desc = frame(folder.path(), 0.5, 0.8);
        change(&mut desc);
        let scene = first.successor(desc.clone()).unwrap();
        assert!(!scene.shares_tree(&first), "change {number}");
        assert!(picture(&scene) == picture(&Scene::new(desc).unwrap()), "change {number}");
    }
}

#[test]
fn meshes_from_memory_are_those_of_the_file() {
    let folder = folder();
    let memory = Arc::new(MeshMemory::default());
    let path = folder.path().join("frame.toml");
    let remembered = || load_with(&path, &Access::any().remembering(Arc::clone(&memory))).unwrap();
    for x in [0.0, 0.5] {
        let alone = frame(folder.path(), x, 0.5);
        assert!(remembered() == alone, "frame at {x}");
    }
    let mut other = Vec::new();
    water::write_obj(&mut other, 4).unwrap();
    fs::write(folder.path().join("water.obj"), other).unwrap();
    let alone = frame(folder.path(), 0.0, 0.5);
    assert!(remembered() == alone, "another file of the same name");
}
