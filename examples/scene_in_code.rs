//! A scene that no file describes: `cargo run --release --example scene_in_code OUTPUT.png`.
//!
//! A glass ball over a white table throws its caustic under a small lamp.

use std::error::Error;

use caustica::bsdf::Bsdf;
use caustica::math::{Rgb, Vec3};
use caustica::output::{Display, write_png};
use caustica::scene::{CameraDesc, FilmDesc, Material, Mesh, SphereDesc};
use caustica::{Render, Scene, SceneDesc, Settings};

const TABLE: u32 = 0;
const GLASS: u32 = 1;
const LAMP: u32 = 2;

fn main() -> Result<(), Box<dyn Error>> {
    let output = std::env::args().nth(1).ok_or("usage: scene_in_code OUTPUT.png")?;
    let desc = ball_on_a_table();
    let settings = Settings { photons: 50_000, ..Settings::of_scene(&desc.render) };
    let scene = Scene::new(desc)?;
    let mut render = Render::new(&scene, settings);
    for _ in 0..16 {
        render.pass();
    }
    write_png(output.as_ref(), &render.picture(), &Display::default())?;
    Ok(())
}

fn ball_on_a_table() -> SceneDesc {
    let camera = CameraDesc::pinhole(Vec3::new(0.0, 2.0, 3.0), Vec3::new(0.0, 0.2, 0.0), 40.0);
    let white = Bsdf::Diffuse { albedo: Rgb::splat(0.7) };
    let black = Bsdf::Diffuse { albedo: Rgb::ZERO };
    SceneDesc {
        film: FilmDesc::new(240, 180),
        materials: vec![
            Material::plain("table", white, Rgb::ZERO),
            Material::plain("glass", Bsdf::Dielectric { ior: 1.5 }, Rgb::ZERO),
            Material::plain("lamp", black, Rgb::splat(220.0)),
        ],
        meshes: vec![square("table", 0.0, 2.0, TABLE), square("lamp", 3.0, -0.1, LAMP)],
        spheres: vec![SphereDesc { center: Vec3::new(0.0, 0.6, 0.0), radius: 0.4, material: GLASS }],
        ..SceneDesc::new(camera)
    }
}

/// A horizontal square at height `y`; it faces up, or down where `half` its side is negative.
fn square(name: &str, y: f32, half: f32, material: u32) -> Mesh {
    let corner = |x: f32, z: f32| Vec3::new(x * half.abs(), y, z * half);
    let corners = vec![corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)];
    Mesh::new(name, corners, vec![[0, 1, 2], [0, 2, 3]], material)
}
