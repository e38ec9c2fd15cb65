//! Scenes of any number of triangles, and the rays of real renders through them.

use super::BenchError;
use crate::bsdf::Bsdf;
use crate::math::{Ray, Rgb, Vec3};
use crate::ppm::{DirectPass, Render, Settings, camera_pass, photon_pass};
use crate::scene::{CameraDesc, FilmDesc, Material, Mesh, RenderDesc, Scene, SceneDesc, water};

/// Triangles of the room without water.
pub const ROOM_TRIANGLES: usize = 36;

/// What rays are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayKind {
    /// From the camera, and on from mirrors and water.
    Eye,
    /// From hit points to the lamp.
    Shadow,
    /// From the lamp, and on from whatever a photon meets.
    Photon,
}

impl RayKind {
    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            RayKind::Eye => "eye",
            RayKind::Shadow => "shadow",
            RayKind::Photon => "photon",
        }
    }
}

/// Rays of one kind.
#[derive(Clone, Debug)]
pub struct RaySet {
    /// What they are for.
    pub kind: RayKind,
    /// In the order in which the render asks.
    pub as_traced: Vec<Ray>,
    /// The same, in blocks of [`SORTED_BLOCK`] sorted by the octant of their direction.
    pub sorted: Vec<Ray>,
}

/// Rays that are sorted together.
pub const SORTED_BLOCK: usize = 4096;

impl RaySet {
    /// Keeps `rays` in both orders.
    pub fn new(kind: RayKind, rays: Vec<Ray>) -> RaySet {
        let mut sorted = rays.clone();
        sorted.chunks_mut(SORTED_BLOCK).for_each(|block| block.sort_by_key(octant));
        RaySet { kind, as_traced: rays, sorted }
    }
}

fn octant(ray: &Ray) -> u32 {
    ray.dir.cmplt(Vec3::ZERO).bitmask()
}

/// The rays of a render of `desc` with one eye path a pixel and one pass of its photons.
///
/// # Errors
/// If Embree refuses the scene.
pub fn record(desc: SceneDesc) -> Result<[RaySet; 3], BenchError> {
    let scene = Scene::new(desc)?;
    let settings = Settings::of_scene(scene.render());
    let eye = camera_pass::record_rays(&scene, &settings);
    let render = Render::new(&scene, settings);
    let shadow = DirectPass::record_rays(&scene, render.hit_points(), settings.seed);
    let photon = photon_pass::record_rays(&scene, &settings, 0);
    Ok([
        RaySet::new(RayKind::Eye, eye),
        RaySet::new(RayKind::Shadow, shadow),
        RaySet::new(RayKind::Photon, photon),
    ])
}

/// An open room with two blocks, the higher one a mirror, under a square lamp: [`ROOM_TRIANGLES`]. Where more are asked
/// for, water stands in it, as fine as it takes to have no less than `triangles`.
///
/// A picture of it has about as many pixels as a pass has `photons`.
pub fn room(triangles: usize, photons: u64) -> SceneDesc {
    let side = (photons.isqrt() as u32).clamp(1, 16384);
    let water_triangles = triangles.saturating_sub(ROOM_TRIANGLES);
    let cells = water_triangles.div_ceil(2).isqrt();
    let cells = if 2 * cells * cells < water_triangles { cells + 1 } else { cells };
    let mut meshes = vec![walls_and_blocks()];
    meshes.extend((cells > 0).then(|| water_of(cells)));
    SceneDesc {
        name: "room".into(),
        path: "room".into(),
        film: FilmDesc::new(side, side),
        render: RenderDesc { passes: 1, photons, samples: 1, alpha: 0.7, radius: None, depth: 8 },
        materials: materials(),
        meshes,
        ..SceneDesc::new(CameraDesc::pinhole(Vec3::new(0.0, 1.9, 4.0), Vec3::new(0.0, 0.9, 0.0), 36.0))
    }
}

const WHITE: u32 = 0;
const RED: u32 = 1;
const GREEN: u32 = 2;
const MIRROR: u32 = 3;
const LAMP: u32 = 4;
const WATER: u32 = 5;

/// By number.
fn materials() -> Vec<Material> {
    let diffuse = |r, g, b| Bsdf::Diffuse { albedo: Rgb::new(r, g, b) };
    let material = |name: &str, bsdf, radiance| Material::plain(name, bsdf, Rgb::splat(radiance));
    vec![
        material("white", diffuse(0.7, 0.7, 0.7), 0.0),
        material("red", diffuse(0.6, 0.1, 0.1), 0.0),
        material("green", diffuse(0.1, 0.5, 0.1), 0.0),
        material("mirror", Bsdf::Mirror { reflectance: Rgb::splat(0.9) }, 0.0),
        material("lamp", diffuse(0.0, 0.0, 0.0), 20.0),
        material("water", Bsdf::Dielectric { ior: 1.33 }, 0.0),
    ]
}

type Quad = [Vec3; 4];

fn walls_and_blocks() -> Mesh {
    let inward = |[a, b, c, d]: Quad| [d, c, b, a];
    let [left, right, floor, ceiling, back, _] = cuboid(Vec3::Y, Vec3::ONE, 0.0).map(inward);
    let walls = [(left, RED), (right, GREEN), (floor, WHITE), (ceiling, WHITE), (back, WHITE)];
    let [_, _, lamp, ..] = cuboid(Vec3::new(0.0, 1.999, 0.0), Vec3::new(0.2, 0.0005, 0.2), 0.0);
    let high = cuboid(Vec3::new(-0.35, 0.6, -0.35), Vec3::new(0.28, 0.6, 0.28), 0.3);
    let low = cuboid(Vec3::new(0.4, 0.25, 0.3), Vec3::new(0.25, 0.25, 0.25), -0.3);
    let faces = walls.into_iter().chain([(lamp, LAMP)]);
    mesh(faces.chain(high.map(|face| (face, MIRROR))).chain(low.map(|face| (face, WHITE))))
}

/// The faces of a block towards its own -x, +x, -y, +y, -z and +z; `angle` (radians) turns it about the vertical.
fn cuboid(middle: Vec3, half: Vec3, angle: f32) -> [Quad; 6] {
    let (sin, cos) = angle.sin_cos();
    let axes = [half.x * Vec3::new(cos, 0.0, -sin), half.y * Vec3::Y, half.z * Vec3::new(sin, 0.0, cos)];
    [0, 1, 2, 3, 4, 5].map(|face| {
        let [a, b, c] = [0, 1, 2].map(|k| axes[(face / 2 + k) % 3]);
        if face % 2 == 1 {
            [a - b - c, a + b - c, a + b + c, a - b + c].map(|corner| middle + corner)
        } else {
            [-a - b + c, -a + b + c, -a + b - c, -a - b - c].map(|corner| middle + corner)
        }
    })
}

fn mesh(faces: impl Iterator<Item = (Quad, u32)>) -> Mesh {
    let mut mesh = Mesh::new("room", vec![], vec![], 0);
    for (corners, material) in faces {
        let first = mesh.vertices.len() as u32;
        mesh.vertices.extend(corners);
        mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        mesh.materials.extend([material; 2]);
    }
    mesh
}

/// Fills the floor plan; the low block is below it, the high one stands out.
fn water_of(cells: usize) -> Mesh {
    let mut mesh = water::surface_mesh(cells);
    mesh.vertices.iter_mut().for_each(|vertex| *vertex = 2.0 * *vertex + 0.7 * Vec3::Y);
    mesh.materials.fill(WATER);
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count(desc: &SceneDesc) -> usize {
        desc.meshes.iter().map(|mesh| mesh.triangles.len()).sum()
    }

    #[test]
    fn there_are_no_less_triangles_than_asked_for_and_hardly_more() {
        for (asked, built) in [(1, 36), (36, 36), (37, 38), (38, 38), (39, 44), (20_000, 20_036)] {
            assert_eq!(count(&room(asked, 100)), built, "{asked}");
        }
        assert_eq!(count(&room(131_072, 100)), 36 + 2 * 256 * 256);
        assert!((1_000_000..1_003_000).contains(&count(&room(1_000_000, 100))));
    }

    #[test]
    fn the_room_is_seen_from_inside_and_the_blocks_from_outside() {
        let scene = Scene::new(room(36, 100)).unwrap();
        for dir in [Vec3::X, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z, Vec3::new(0.3, 1.0, 0.3)] {
            let hit = scene.intersect(&Ray::new(Vec3::new(0.1, 1.5, 0.3), dir)).unwrap();
            assert!(hit.is_front(), "{dir}");
        }
        assert!(scene.intersect(&Ray::new(Vec3::new(0.0, 1.5, 0.0), Vec3::Z)).is_none(), "it is open");
        for block in [Vec3::new(-0.35, 0.6, -0.35), Vec3::new(0.4, 0.25, 0.3)] {
            for dir in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::Z, Vec3::NEG_Z] {
                let hit = scene.intersect(&Ray::new(block, dir)).unwrap();
                assert!(!hit.is_front() && hit.ng.dot(dir) > 0.9, "{dir}");
            }
        }
    }

    #[test]
    fn the_lamp_shines_down() {
        let scene = Scene::new(room(36, 100)).unwrap();
        let up = scene.intersect(&Ray::new(Vec3::new(0.1, 1.8, 0.0), Vec3::Y)).unwrap();
        assert_eq!(scene.emission(&up), Rgb::splat(20.0));
        let flux = std::f32::consts::PI * 0.4 * 0.4 * 20.0;
        assert!((scene.lights().flux() - flux).abs().max_element() < 1e-3);
    }

    #[test]
    fn rays_are_those_of_a_render() {
        let sets = record(room(500, 400)).unwrap();
        let [eye, shadow, photon] = &sets;
        assert!(eye.as_traced.len() > 400, "some go on from mirror and water");
        assert!(eye.as_traced.iter().filter(|ray| ray.origin == Vec3::new(0.0, 1.9, 4.0)).count() == 400);
        assert!(shadow.as_traced.iter().all(|ray| ray.t_max < 1.0) && !shadow.as_traced.is_empty());
        assert!(photon.as_traced.iter().filter(|ray| ray.origin.y > 1.99).count() >= 400);
        assert_eq!(sets.each_ref().map(|set| set.kind), [RayKind::Eye, RayKind::Shadow, RayKind::Photon]);
    }

    #[test]
    fn sorting_moves_rays_within_blocks_only() {
        let dir = |k: usize| Vec3::new(1.0, 1.0, if k.is_multiple_of(2) { 1.0 } else { -1.0 });
        let rays: Vec<Ray> = (0..SORTED_BLOCK + 3).map(|k| Ray::new(Vec3::splat(k as f32), dir(k))).collect();
        let set = RaySet::new(RayKind::Eye, rays);
        let numbers: Vec<usize> = set.sorted.iter().map(|ray| ray.origin.x as usize).collect();
        assert_eq!(numbers[..3], [0, 2, 4]);
        assert_eq!(numbers[SORTED_BLOCK / 2..][..2], [1, 3]);
        assert_eq!(numbers[SORTED_BLOCK..], [SORTED_BLOCK, SORTED_BLOCK + 2, SORTED_BLOCK + 1]);
    }
}
