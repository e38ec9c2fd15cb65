//! Sheets above a floor: what goes through them is known in closed form.

use caustica::bsdf::Bsdf;
use caustica::math::{DVec3, Rgb, Vec2, Vec3};
use caustica::ppm::{Render, Settings};
use caustica::scene::{CameraDesc, FilmDesc, Material, Mesh, PointLightDesc, RenderDesc, Scene, SceneDesc};

pub const INTENSITY: f32 = 1000.0;
pub const LIGHT_HEIGHT: f64 = 10.0;
pub const BLACK: Bsdf = Bsdf::Diffuse { albedo: Rgb::ZERO };
/// Light that bounces off it does not count.
pub const NEARLY_BLACK: Bsdf = Bsdf::Diffuse { albedo: Rgb::splat(1e-3) };

/// A horizontal square at height `y` that faces up, or down.
pub fn sheet(y: f32, half: f32, up: bool, material: u32) -> Mesh {
    let corner = |x: f32, z: f32| Vec3::new(x * half, y, z * half);
    Mesh {
        name: "sheet".into(),
        vertices: vec![corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)],
        normals: None,
        uvs: Some(vec![Vec2::ZERO, Vec2::Y, Vec2::ONE, Vec2::X]),
        triangles: if up { vec![[0, 1, 2], [0, 2, 3]] } else { vec![[0, 2, 1], [0, 3, 2]] },
        materials: vec![material; 2],
    }
}

/// A floor of material 0 at y = 0 under a point light, and other meshes of the other materials. The camera looks at the floor below
/// the light, from just above it.
pub fn over_floor(others: Vec<Material>, meshes: Vec<Mesh>) -> SceneDesc {
    let floor = Material::plain("floor", NEARLY_BLACK, Rgb::ZERO);
    SceneDesc {
        name: "floor".into(),
        path: "floor.toml".into(),
        film: FilmDesc::new(8, 8),
        render: RenderDesc {
            passes: 1,
            photons: 1_000_000,
            samples: 4,
            alpha: 0.7,
            radius: Some(1.0),
            depth: 8,
        },
        materials: [vec![floor], others].concat(),
        meshes: [vec![sheet(0.0, 200.0, true, 0)], meshes].concat(),
        point_lights: vec![PointLightDesc {
            position: Vec3::new(0.0, LIGHT_HEIGHT as f32, 0.0),
            intensity: Rgb::splat(INTENSITY),
        }],
        ..SceneDesc::new(CameraDesc {
            up: Vec3::Z,
            ..CameraDesc::pinhole(Vec3::new(0.0, 0.5, 0.0), Vec3::ZERO, 60.0)
        })
    }
}

/// The same under a square lamp at the height of the light in its place.
pub fn under_lamp(mut desc: SceneDesc, half: f32) -> SceneDesc {
    desc.point_lights.clear();
    desc.materials.push(Material::plain("lamp", BLACK, Rgb::splat(50.0)));
    desc.meshes.push(sheet(LIGHT_HEIGHT as f32, half, false, desc.materials.len() as u32 - 1));
    desc
}

/// The mean irradiance from photons over all hit points; every pass balances its ledgers.
pub fn photon_irradiance(scene: &Scene, settings: Settings, passes: u32) -> DVec3 {
    let mut render = Render::new(scene, settings);
    for _ in 0..passes {
        let photons = render.pass().photons;
        assert!(photons.is_balanced(), "{photons:?}");
    }
    let sum: DVec3 = (0..render.hit_points().len()).map(|k| render.photon_irradiance(k)).sum();
    sum / render.hit_points().len() as f64
}

pub fn assert_close(found: f64, expected: f64, tolerance: f64) {
    assert!((found / expected - 1.0).abs() < tolerance, "{found} instead of {expected}");
}
