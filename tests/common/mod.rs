//! What several test programs need.
#![allow(dead_code, reason = "every test program uses another part")]

pub mod agree;
pub mod sheets;

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Once;

use caustica::bsdf::{Bsdf, Transport};
use caustica::compare::block_means;
use caustica::film::Image;
use caustica::math::{DVec3, Rgb, Vec2, Vec3};
use caustica::ppm::{Render, Settings};
use caustica::reference::{Estimator, Method};
use caustica::scene::{self, Material, Mesh, Scene, SceneDesc};

/// A scene file of area lights, a point light, and glass.
pub const GLASS_AND_LAMPS: &str = r#"
[film]
width = 48
height = 40
[camera]
position = [0, 60, 180]
look_at = [0, 60, 0]
fov = 52
[material.white]
diffuse = { albedo = [0.7, 0.7, 0.7] }
[material.glass]
dielectric = { ior = 1.5 }
[material.lamp]
diffuse = { albedo = [0, 0, 0] }
emission = [50, 50, 40]
[[point_light]]
position = [0, 100, 0]
intensity = [3000, 3000, 3000]
[[sphere]]
center = [0, 30, 0]
radius = 20
material = "glass"
[[quad]]
corners = [[-100, 0, -100], [-100, 0, 100], [100, 0, 100], [100, 0, -100]]
material = "white"
[[quad]]
corners = [[-100, 0, -60], [100, 0, -60], [100, 120, -60], [-100, 120, -60]]
material = "white"
[[quad]]
corners = [[-10, 110, -10], [10, 110, -10], [10, 110, 10], [-10, 110, 10]]
material = "lamp"
"#;

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

/// The scene that a text in TOML describes, which needs no other file.
pub fn desc_of(text: &str) -> SceneDesc {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.toml");
    fs::write(&path, text).unwrap();
    scene::load(&path).unwrap()
}

pub fn scene_of(text: &str) -> Scene {
    Scene::new(desc_of(text)).unwrap()
}

/// The scene under a lamp of the course's box in place of its point light: paths find that, too.
pub fn under_a_lamp(mut desc: SceneDesc) -> SceneDesc {
    desc.point_lights.clear();
    let black = Bsdf::Diffuse { albedo: Rgb::ZERO };
    desc.materials.push(Material::plain("lamp", black, Rgb::splat(6.0)));
    let corner = |x: f32, z: f32| Vec3::new(30.0 * x, 110.0, 30.0 * z);
    let corners = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let lamp = desc.materials.len() as u32 - 1;
    desc.meshes.push(Mesh::new("lamp", corners, vec![[0, 1, 2], [0, 2, 3]], lamp));
    desc
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

/// The mean and its standard error, of independent values.
pub fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (mean, (squares / (n * (n - 1.0))).sqrt())
}

/// The mean of every block of pixels and its standard error, over independent renders.
///
/// Errors of neighbouring pixels are correlated where they share photons or paths: only whole blocks of whole renders
/// are independent samples.
pub fn block_estimate(renders: &[Image], block: usize) -> (Image, Image) {
    let renders: Vec<Image> = renders.iter().map(|image| block_means(image, block)).collect();
    let n = renders.len() as f64;
    let over = |value: &dyn Fn(usize) -> DVec3| {
        let pixels = (0..renders[0].pixels().len()).map(|i| value(i).as_vec3()).collect();
        Image::from_pixels(renders[0].width(), renders[0].height(), pixels).unwrap()
    };
    let mean = |i: usize| renders.iter().map(|r| r.pixels()[i].as_dvec3()).sum::<DVec3>() / n;
    let stderr = |i: usize| {
        let squares = renders.iter().map(|r| (r.pixels()[i].as_dvec3() - mean(i)).powf(2.0));
        (squares.sum::<DVec3>() / (n * (n - 1.0))).map(f64::sqrt)
    };
    (over(&mean), over(&stderr))
}

/// True for the pixels of blocks in which, a pixel beyond the blocks included, only dark diffuse surfaces are seen: there
/// light tracing finds everything.
pub fn blocks_seen_diffuse(scene: &Scene, block: usize) -> Vec<bool> {
    let (width, height) = (scene.film().width as usize, scene.film().height as usize);
    let with_margin = |k: usize| (k / block * block).saturating_sub(1)..k / block * block + block + 1;
    let only_diffuse = |k: usize| {
        let (xs, ys) = (with_margin(k % width), with_margin(k / width));
        ys.into_iter()
            .all(|y| xs.clone().all(|x| is_seen_diffuse(scene, Vec2::new(x as f32, y as f32) + 0.5)))
    };
    (0..width * height).map(only_diffuse).collect()
}

fn is_seen_diffuse(scene: &Scene, raster: Vec2) -> bool {
    scene.intersect(&scene.camera().ray(raster)).is_none_or(|hit| {
        let scattering = scene.scatter(&hit, Transport::Camera);
        let is_dark = scene.emission(&hit) == Rgb::ZERO;
        scattering.specular().next().is_none() && is_dark && scene.opacity(&hit) == 1.0
    })
}

/// The path traced picture and its standard error.
pub fn path_traced(scene: &Scene, samples: u32) -> (Image, Image) {
    estimated(scene, Method::Path, samples, 0)
}

/// The light traced picture and its standard error.
pub fn light_traced(scene: &Scene, samples: u32) -> (Image, Image) {
    estimated(scene, Method::Light, samples, 0)
}

/// The picture and its standard error.
pub fn estimated(scene: &Scene, method: Method, samples: u32, seed: u64) -> (Image, Image) {
    let mut estimator = Estimator::new(scene, method, seed);
    (0..samples).for_each(|_| estimator.add_sample());
    (estimator.picture(), estimator.standard_error())
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
