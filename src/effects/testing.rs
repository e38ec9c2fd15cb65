//! Small scenes for the tests of this module.

use crate::bsdf::Bsdf;
use crate::math::{Rgb, Vec3};
use crate::scene::{
    CameraDesc, FilmDesc, Material, Mesh, PointLightDesc, RenderDesc, Scene, SceneDesc, SphereDesc, Traversal,
};

pub const WALL: u32 = 0;
pub const GLASS: u32 = 1;
pub const MIRROR: u32 = 2;
pub const LAMP: u32 = 3;
pub const BLACK: u32 = 4;

/// A grey room from -1 to 1, lit by a point light and seen from within.
pub fn room() -> SceneDesc {
    let material = |name: &str, bsdf, light| Material::plain(name, bsdf, Rgb::splat(light));
    let black = Bsdf::Diffuse { albedo: Rgb::ZERO };
    SceneDesc {
        name: "room".into(),
        path: "room.toml".into(),
        film: FilmDesc::new(16, 16),
        render: RenderDesc { passes: 2, photons: 2000, samples: 1, alpha: 0.7, radius: Some(0.1), depth: 16 },
        materials: vec![
            material("wall", Bsdf::Diffuse { albedo: Rgb::splat(0.5) }, 0.0),
            material("glass", Bsdf::Dielectric { ior: 1.5 }, 0.0),
            material("mirror", Bsdf::Mirror { reflectance: Rgb::splat(0.9) }, 0.0),
            material("lamp", black, 2.0),
            material("black", black, 0.0),
        ],
        meshes: vec![Mesh::inward_cube("room", WALL)],
        point_lights: vec![PointLightDesc { position: Vec3::new(0.15, 0.55, -0.1), intensity: Rgb::ONE }],
        ..SceneDesc::new(CameraDesc::pinhole(Vec3::new(0.1, 0.2, 0.9), Vec3::new(0.0, -0.4, -1.0), 70.0))
    }
}

pub fn scene(desc: SceneDesc) -> Scene {
    Scene::with_traversal(desc, Traversal::Custom).unwrap()
}

/// The room with these meshes alone.
pub fn scene_of(meshes: Vec<Mesh>) -> Scene {
    scene(SceneDesc { meshes, ..room() })
}

/// A cube whose normals point outward.
pub fn cube(name: &str, middle: Vec3, half: f32, material: u32) -> Mesh {
    let mut cube = Mesh::inward_cube(name, material);
    cube.vertices.iter_mut().for_each(|vertex| *vertex = middle + half * *vertex);
    cube.triangles.iter_mut().for_each(|corners| corners.reverse());
    cube
}

/// A square of `side` around `middle` that faces down.
pub fn ceiling(name: &str, middle: Vec3, side: f32, material: u32) -> Mesh {
    let corner = |x: f32, z: f32| middle + 0.5 * side * Vec3::new(x, 0.0, z);
    let corners = vec![corner(-1., -1.), corner(1., -1.), corner(1., 1.), corner(-1., 1.)];
    Mesh::new(name, corners, vec![[0, 1, 2], [0, 2, 3]], material)
}

pub fn ball(center: Vec3, radius: f32, material: u32) -> SphereDesc {
    SphereDesc { center, radius, material }
}

/// Takes one triangle out of a mesh.
pub fn without_triangle(mut mesh: Mesh, triangle: usize) -> Mesh {
    mesh.triangles.remove(triangle);
    mesh.materials.remove(triangle);
    mesh
}
