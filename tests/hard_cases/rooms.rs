//! Small scenes that hard cases are built into.
#![allow(dead_code, reason = "every case uses another part")]

use caustica::bsdf::Bsdf;
use caustica::math::{Rgb, Vec3};
use caustica::ppm::{PassStatistics, Render, Settings};
use caustica::scene::{
    CameraDesc, FilmDesc, Material, Mesh, PointLightDesc, RenderDesc, Scene, SceneDesc, SphereDesc, Traversal,
};

/// Both ways of tracing rays: a case must hold with either.
pub const TRAVERSALS: [Traversal; 2] = [Traversal::Embree, Traversal::Custom];

pub const GREY: Bsdf = Bsdf::Diffuse { albedo: Rgb::splat(0.5) };
pub const GLASS: Bsdf = Bsdf::Dielectric { ior: 1.5 };
pub const MIRROR: Bsdf = Bsdf::Mirror { reflectance: Rgb::ONE };

pub fn dark(name: &str, bsdf: Bsdf) -> Material {
    Material::plain(name, bsdf, Rgb::ZERO)
}

/// A mesh of one material whose triangles are counterclockwise from the side that their normals point to.
pub fn mesh(vertices: Vec<Vec3>, triangles: Vec<[u32; 3]>, material: u32) -> Mesh {
    Mesh::new("mesh", vertices, triangles, material)
}

/// The quad `a b c d`, whose normal is that of `a b c`.
pub fn quad(corners: [Vec3; 4], material: u32) -> Mesh {
    mesh(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]], material)
}

/// A horizontal square at height `y`, `2 half` wide, whose normal points up.
pub fn floor(y: f32, half: f32, material: u32) -> Mesh {
    let corner = |x: f32, z: f32| Vec3::new(x * half, y, z * half);
    quad([corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)], material)
}

/// The same with its normal down.
pub fn ceiling(y: f32, half: f32, material: u32) -> Mesh {
    let mut mesh = floor(y, half, material);
    mesh.triangles.iter_mut().for_each(|corners| corners.reverse());
    mesh
}

/// The cube from -1 to 1 with its faces turned inward.
pub fn inward_cube(material: u32) -> Mesh {
    Mesh::inward_cube("mesh", material)
}

/// A grey box from -1 to 1 with a point light off its middle, seen from within: material 0 is its walls'.
pub fn lit_box() -> SceneDesc {
    SceneDesc {
        name: "box".into(),
        path: "box.toml".into(),
        film: FilmDesc::new(24, 24),
        render: RenderDesc {
            passes: 2,
            photons: 20_000,
            samples: 2,
            alpha: 0.7,
            radius: Some(0.05),
            depth: 16,
        },
        materials: vec![dark("wall", GREY)],
        meshes: vec![inward_cube(0)],
        point_lights: vec![PointLightDesc {
            position: Vec3::new(0.15, 0.55, -0.1),
            intensity: Rgb::splat(1.0),
        }],
        ..SceneDesc::new(CameraDesc::pinhole(Vec3::new(0.1, 0.2, 0.9), Vec3::new(0.0, -0.4, -1.0), 70.0))
    }
}

/// The scene by each of the two ways of tracing rays.
pub fn by_both_traversals(desc: &SceneDesc) -> [Scene; 2] {
    TRAVERSALS.map(|traversal| Scene::with_traversal(desc.clone(), traversal).unwrap())
}

/// Renders the passes that the scene asks for; every photon is accounted for.
pub fn rendered<'s>(scene: &'s Scene, settings: Settings) -> (Render<'s>, Vec<PassStatistics>) {
    let mut render = Render::new(scene, settings);
    let passes = (0..scene.render().passes).map(|_| render.pass()).collect::<Vec<_>>();
    for pass in &passes {
        assert!(pass.photons.is_balanced(), "photons unaccounted for: {:?}", pass.photons);
    }
    (render, passes)
}

/// The scene, `scale` times as large and then moved by `shift`.
pub fn moved(mut desc: SceneDesc, scale: f32, shift: Vec3) -> SceneDesc {
    desc.place(scale, shift);
    desc
}

/// [`lit_box`] with a glass ball, a mirror, a lamp of some size and a surface whose normals are smoothed.
pub fn furnished_box() -> SceneDesc {
    let mut desc = lit_box();
    desc.materials.extend([dark("glass", GLASS), dark("mirror", MIRROR)]);
    desc.materials.push(Material::plain("lamp", Bsdf::Diffuse { albedo: Rgb::ZERO }, Rgb::splat(2.0)));
    desc.spheres.push(SphereDesc { center: Vec3::new(-0.35, -0.6, -0.3), radius: 0.3, material: 1 });
    let [a, b] = [Vec3::new(0.3, -0.9, -0.6), Vec3::new(0.8, -0.9, -0.2)];
    desc.meshes.push(quad([a, b, b + 1.2 * Vec3::Y, a + 1.2 * Vec3::Y], 2));
    desc.meshes.push(ceiling(0.95, 0.25, 3));
    let ridge = [Vec3::new(-0.9, -0.8, 0.4), Vec3::new(-0.3, -0.5, 0.4), Vec3::new(0.3, -0.8, 0.4)];
    let ends = ridge.iter().flat_map(|&p| [p, p - 0.5 * Vec3::Z]).collect();
    let mut tent = mesh(ends, vec![[0, 2, 1], [2, 3, 1], [2, 4, 3], [4, 5, 3]], 0);
    let leaning = |x: f32| Vec3::new(x, 1.0, 0.0).normalize();
    tent.normals = Some([-0.5, -0.5, 0.0, 0.0, 0.5, 0.5].map(leaning).to_vec());
    desc.meshes.push(tent);
    desc
}
