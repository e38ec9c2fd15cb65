//! Scenes whose renders are known well enough to tell a sound program from another.

use crate::bsdf::Bsdf;
use crate::math::{Rgb, Vec3};
use crate::scene::{CameraDesc, FilmDesc, Material, Mesh, PointLightDesc, RenderDesc, SceneDesc, SphereDesc};

/// A built-in scene, and what must hold of it.
pub(super) struct Specimen {
    pub name: &'static str,
    pub desc: SceneDesc,
    /// No photon can leave.
    pub is_closed: bool,
    /// Not every pixel is black.
    pub is_lit: bool,
    /// Paths are so long that the last bit of one hit decides where they end.
    pub is_chaotic: bool,
}

const WALL: u32 = 0;
const GLASS: u32 = 1;
const MIRROR: u32 = 2;
const LAMP: u32 = 3;

/// All of them.
pub(super) fn specimens() -> Vec<Specimen> {
    let lit = |name, desc| Specimen { name, desc, is_closed: true, is_lit: true, is_chaotic: false };
    let dark = |name, desc| Specimen { name, desc, is_closed: true, is_lit: false, is_chaotic: false };
    vec![
        lit("a furnished box", furnished()),
        lit("a box far from the origin", far_away()),
        lit("degenerate triangles", with_degenerate_triangles()),
        lit("glass in glass", with_nested_glass()),
        Specimen { is_chaotic: true, ..lit("a box that absorbs nothing", white()) },
        dark("a box without light", unlit()),
        dark("a camera that sees nothing", looking_away()),
    ]
}

fn materials() -> Vec<Material> {
    let material = |name: &str, bsdf, light| Material::plain(name, bsdf, Rgb::splat(light));
    vec![
        material("wall", Bsdf::Diffuse { albedo: Rgb::splat(0.5) }, 0.0),
        material("glass", Bsdf::Dielectric { ior: 1.5 }, 0.0),
        material("mirror", Bsdf::Mirror { reflectance: Rgb::splat(0.9) }, 0.0),
        material("lamp", Bsdf::Diffuse { albedo: Rgb::ZERO }, 2.0),
    ]
}

/// A grey box with a point light, seen from within.
pub(super) fn bare() -> SceneDesc {
    SceneDesc {
        name: "box".into(),
        path: "box".into(),
        film: FilmDesc::new(24, 24),
        render: RenderDesc {
            passes: 2,
            photons: 10_000,
            samples: 2,
            alpha: 0.7,
            radius: Some(0.1),
            depth: 16,
        },
        materials: materials(),
        meshes: vec![Mesh::inward_cube("box", WALL)],
        point_lights: vec![PointLightDesc { position: Vec3::new(0.15, 0.55, -0.1), intensity: Rgb::ONE }],
        ..SceneDesc::new(CameraDesc::pinhole(Vec3::new(0.1, 0.2, 0.9), Vec3::new(0.0, -0.4, -1.0), 70.0))
    }
}

/// With a glass ball, a mirror, and a lamp under the ceiling.
fn furnished() -> SceneDesc {
    let mut desc = bare();
    desc.spheres.push(SphereDesc { center: Vec3::new(-0.35, -0.6, -0.3), radius: 0.3, material: GLASS });
    let [a, b, up] = [Vec3::new(0.3, -0.9, -0.6), Vec3::new(0.8, -0.9, -0.2), 1.2 * Vec3::Y];
    let halves = || vec![[0, 1, 2], [0, 2, 3]];
    desc.meshes.push(Mesh::new("mirror", vec![a, b, b + up, a + up], halves(), MIRROR));
    let corner = |x: f32, z: f32| Vec3::new(x, 0.95, z);
    let lamp = vec![corner(-0.25, -0.25), corner(0.25, -0.25), corner(0.25, 0.25), corner(-0.25, 0.25)];
    desc.meshes.push(Mesh::new("lamp", lamp, halves(), LAMP));
    desc
}

fn far_away() -> SceneDesc {
    let mut desc = bare();
    desc.place(1.0, Vec3::new(1000.0, -700.0, 300.0));
    desc
}

/// A point, a line and a needle among sound triangles.
fn with_degenerate_triangles() -> SceneDesc {
    let mut desc = bare();
    let [a, b] = [Vec3::new(-0.5, -0.2, -0.5), Vec3::new(0.5, -0.2, -0.5)];
    let corners = vec![a, b, 0.5 * (a + b), a + 1e-7 * Vec3::Y];
    desc.meshes.push(Mesh::new("degenerate", corners, vec![[0, 0, 0], [0, 1, 2], [0, 1, 3]], WALL));
    desc
}

fn with_nested_glass() -> SceneDesc {
    let mut desc = bare();
    let ball = |radius| SphereDesc { center: Vec3::new(0.0, -0.4, -0.2), radius, material: GLASS };
    desc.spheres.extend([ball(0.5), ball(0.3)]);
    desc
}

/// Few photons, since all of them are followed to the longest path.
fn white() -> SceneDesc {
    let mut desc = bare();
    desc.materials[WALL as usize].bsdf = Bsdf::Diffuse { albedo: Rgb::ONE };
    desc.render.photons = 64;
    desc
}

fn unlit() -> SceneDesc {
    SceneDesc { point_lights: vec![], ..bare() }
}

fn looking_away() -> SceneDesc {
    let mut desc = bare();
    desc.camera.position = 3.0 * Vec3::Z;
    desc.camera.look_at = 4.0 * Vec3::Z;
    desc
}
