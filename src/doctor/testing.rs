//! A sound scene for the tests of this module to break.

use super::specimens::bare;
use super::subject::Subject;
use super::{Check, Finding, Severity};
use crate::bsdf::Bsdf;
use crate::math::{Rgb, Vec3};
use crate::ppm::Settings;
use crate::scene::{Material, Mesh, RenderDesc, SceneDesc, SphereDesc, Traversal};

pub const WALL: u32 = 0;
pub const GLASS: u32 = 1;
pub const LAMP: u32 = 2;
pub const WHITE: u32 = 3;

/// A grey room from -1 to 1 with a glass ball and a point light, without anything to note; every material but those of
/// lamp and whitewash is in use.
pub fn room() -> SceneDesc {
    let grey = Bsdf::Diffuse { albedo: Rgb::splat(0.5) };
    let black = Bsdf::Diffuse { albedo: Rgb::ZERO };
    let white = Bsdf::Diffuse { albedo: Rgb::ONE };
    let material = |name: &str, bsdf, light| Material::plain(name, bsdf, Rgb::splat(light));
    let mut walls = cube("room", Vec3::ZERO, 1.0, WALL);
    walls.triangles.iter_mut().for_each(|corners| corners.reverse());
    SceneDesc {
        name: "room".into(),
        path: "room.toml".into(),
        render: RenderDesc {
            passes: 4,
            photons: 20_000,
            samples: 1,
            alpha: 0.7,
            radius: Some(0.05),
            depth: 16,
        },
        materials: vec![
            material("wall", grey, 0.0),
            material("glass", Bsdf::Dielectric { ior: 1.5 }, 0.0),
            material("lamp", black, 2.0),
            material("white", white, 0.0),
        ],
        spheres: vec![SphereDesc { center: Vec3::new(-0.4, -0.6, -0.3), radius: 0.3, material: GLASS }],
        meshes: vec![walls],
        ..bare()
    }
}

/// A cube whose normals point outward.
pub fn cube(name: &str, middle: Vec3, half: f32, material: u32) -> Mesh {
    let corner = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 2.0 - 1.0;
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
    Mesh::new(name, (0..8).map(|i| middle + half * corner(i)).collect(), triangles, material)
}

pub fn triangle(name: &str, corners: [Vec3; 3]) -> Mesh {
    Mesh::new(name, corners.to_vec(), vec![[0, 1, 2]], WALL)
}

/// Horizontal, from `x` to `x + side` and likewise in z; its normal points down.
pub fn ceiling(name: &str, corner: Vec3, side: f32, material: u32) -> Mesh {
    let [x, z] = [side * Vec3::X, side * Vec3::Z];
    let corners = vec![corner, corner + x, corner + x + z, corner + z];
    Mesh::new(name, corners, vec![[0, 1, 2], [0, 2, 3]], material)
}

pub fn with_material(mut mesh: Mesh, material: u32) -> Mesh {
    mesh.materials.fill(material);
    mesh
}

/// `scale` times as large, then moved by `shift`.
pub fn moved(mut desc: SceneDesc, scale: f32, shift: Vec3) -> SceneDesc {
    desc.place(scale, shift);
    desc
}

pub fn subject(desc: &SceneDesc) -> Subject<'_> {
    Subject::new(desc, Settings::of_scene(&desc.render), Traversal::Custom).unwrap()
}

/// The first finding of a check.
pub fn of(findings: &[Finding], check: Check) -> &Finding {
    findings.iter().find(|finding| finding.check == check).unwrap()
}

pub fn severity(findings: &[Finding], check: Check) -> Severity {
    of(findings, check).severity
}
