//! What several test programs need.
#![allow(dead_code, reason = "every test program uses another part")]

use std::path::{Path, PathBuf};
use std::sync::Once;

use caustica::film::Image;
use caustica::ppm::{Render, Settings};
use caustica::reference::PathTracer;
use caustica::scene::{self, Scene, SceneDesc};

pub fn data(name: &str) -> PathBuf {
    write_water_surface();
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name)
}

/// The surface is generated, not kept: see `caustica surface`.
fn write_water_surface() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/surface.obj");
        if !path.exists() {
            caustica::output::write_atomically(&path, |mut out| scene::water::write_obj(&mut out, 256))
                .unwrap();
        }
    });
}

pub fn desc(name: &str) -> SceneDesc {
    scene::load(&data(name)).unwrap()
}

pub fn scene(name: &str) -> Scene {
    Scene::new(desc(name)).unwrap()
}

/// The scene with another resolution.
pub fn scene_at(name: &str, width: u32, height: u32) -> Scene {
    let mut desc = desc(name);
    (desc.film.width, desc.film.height) = (width, height);
    Scene::new(desc).unwrap()
}

pub fn settings(scene: &Scene) -> Settings {
    Settings::of_scene(scene.render())
}

pub fn photon_mapped(scene: &Scene, settings: Settings, passes: u32) -> Image {
    let mut render = Render::new(scene, settings);
    for _ in 0..passes {
        let pass = render.pass();
        assert!(pass.photons.is_balanced(), "photons unaccounted for: {:?}", pass.photons);
    }
    render.picture()
}

/// The picture and its standard error.
pub fn path_traced(scene: &Scene, samples: u32) -> (Image, Image) {
    let mut tracer = PathTracer::new(scene, 0);
    (0..samples).for_each(|_| tracer.add_sample());
    (tracer.picture(), tracer.standard_error())
}

/// A file of the comparison pictures, which stand beside a checkout where they are to be had at all.
pub fn comparison_picture(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/reference").join(name);
    if path.exists() {
        return Some(path);
    }
    eprintln!("skipped: the comparison picture {} is not there", path.display());
    None
}
