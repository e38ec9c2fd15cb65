//! Closed meshes seen from inside, for [`super::leaks`].

use std::f32::consts::{PI, TAU};
use std::sync::OnceLock;

use crate::bsdf::Bsdf;
use crate::math::{Ray, Rgb, Rng, Vec3};
use crate::scene::{CameraDesc, FilmDesc, Material, Mesh, RenderDesc, SceneDesc};

/// A closed mesh that holds the ball of radius [`HELD`], stretched by [`ClosedMesh::stretch`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClosedMesh {
    /// A cube: few triangles, right angles.
    Room,
    /// A ball of many triangles, the thinnest at its poles.
    Ball,
    /// The ball, a thousand times as long as it is wide: triangles like needles.
    Needle,
    /// The ball, far from the origin.
    FarBall,
}

/// All of them.
pub const MESHES: [ClosedMesh; 4] =
    [ClosedMesh::Room, ClosedMesh::Ball, ClosedMesh::Needle, ClosedMesh::FarBall];

/// All meshes reach beyond this before they are stretched.
const HELD: f32 = 0.9;
const RINGS: u32 = 64;
const SEGMENTS: u32 = 128;

/// Where the triangles are.
#[derive(Clone, Debug)]
pub(super) struct Shape {
    vertices: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    stretch: Vec3,
    middle: Vec3,
}

impl ClosedMesh {
    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            ClosedMesh::Room => "room",
            ClosedMesh::Ball => "ball",
            ClosedMesh::Needle => "needle",
            ClosedMesh::FarBall => "far ball",
        }
    }

    fn stretch(self) -> Vec3 {
        match self {
            ClosedMesh::Needle => Vec3::new(1.0, 1e3, 1.0),
            ClosedMesh::Room | ClosedMesh::Ball | ClosedMesh::FarBall => Vec3::ONE,
        }
    }

    fn middle(self) -> Vec3 {
        match self {
            ClosedMesh::FarBall => Vec3::new(1000.0, -700.0, 300.0),
            ClosedMesh::Room | ClosedMesh::Ball | ClosedMesh::Needle => Vec3::ZERO,
        }
    }

    /// Made once.
    pub(super) fn shape(self) -> &'static Shape {
        static SHAPES: [OnceLock<Shape>; MESHES.len()] = [const { OnceLock::new() }; MESHES.len()];
        SHAPES[self as usize].get_or_init(|| {
            let (mut vertices, triangles) = if self == ClosedMesh::Room { cube() } else { ball() };
            vertices.iter_mut().for_each(|p| *p = *p * self.stretch() + self.middle());
            Shape { vertices, triangles, stretch: self.stretch(), middle: self.middle() }
        })
    }

    /// A scene of the mesh alone; its triangles look inward.
    pub(super) fn scene(self) -> SceneDesc {
        let Shape { vertices, triangles, stretch, middle } = self.shape().clone();
        let grey = Bsdf::Diffuse { albedo: Rgb::splat(0.5) };
        SceneDesc {
            name: self.name().into(),
            path: self.name().into(),
            film: FilmDesc::new(1, 1),
            render: RenderDesc { passes: 1, photons: 1, samples: 1, alpha: 0.7, radius: None, depth: 1 },
            materials: vec![Material::plain("grey", grey, Rgb::ZERO)],
            meshes: vec![Mesh::new(self.name(), vertices, triangles, 0)],
            ..SceneDesc::new(CameraDesc::pinhole(middle, middle + stretch, 90.0))
        }
    }
}

impl Shape {
    /// A ray from a point inside to a vertex.
    pub(super) fn ray_to_a_vertex(&self, rng: &mut Rng) -> Ray {
        let [vertex, _] = self.edge(rng);
        self.ray_to(vertex, rng)
    }

    /// A ray from a point inside to a point on an edge.
    pub(super) fn ray_to_an_edge(&self, rng: &mut Rng) -> Ray {
        let [a, b] = self.edge(rng);
        let target = a.lerp(b, rng.next_f32());
        self.ray_to(target, rng)
    }

    fn edge(&self, rng: &mut Rng) -> [Vec3; 2] {
        let pick = (rng.next_f32() * self.triangles.len() as f32) as usize;
        let triangle = self.triangles[pick.min(self.triangles.len() - 1)];
        [0, 1].map(|k| self.vertices[triangle[k] as usize])
    }

    fn ray_to(&self, target: Vec3, rng: &mut Rng) -> Ray {
        let in_cube = 2.0 * Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32()) - 1.0;
        let origin = self.middle + HELD / 3f32.sqrt() * in_cube * self.stretch;
        Ray::new(origin, target - origin)
    }
}

type Triangles = (Vec<Vec3>, Vec<[u32; 3]>);

fn cube() -> Triangles {
    let Mesh { vertices, triangles, .. } = Mesh::inward_cube("room", 0);
    (vertices, triangles)
}

fn ball() -> Triangles {
    let on_ball = |ring: u32, segment: u32| {
        let (theta, phi) = (PI * ring as f32 / RINGS as f32, TAU * segment as f32 / SEGMENTS as f32);
        Vec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin())
    };
    let rings = (1..RINGS).flat_map(|ring| (0..SEGMENTS).map(move |segment| on_ball(ring, segment)));
    let vertices: Vec<Vec3> = rings.chain([Vec3::Y, Vec3::NEG_Y]).collect();
    let (north, south) = (vertices.len() as u32 - 2, vertices.len() as u32 - 1);
    let at = |ring: u32, segment: u32| (ring - 1) * SEGMENTS + segment % SEGMENTS;
    let mut triangles = Vec::new();
    for s in 0..SEGMENTS {
        triangles.push([north, at(1, s), at(1, s + 1)]);
        triangles.push([south, at(RINGS - 1, s + 1), at(RINGS - 1, s)]);
        for r in 1..RINGS - 1 {
            triangles.extend(halves([at(r, s), at(r + 1, s), at(r + 1, s + 1), at(r, s + 1)]));
        }
    }
    (vertices, triangles)
}

fn halves([a, b, c, d]: [u32; 4]) -> [[u32; 3]; 2] {
    [[a, b, c], [a, c, d]]
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::scene::Scene;

    /// Every edge has one triangle on either side, which run along it in opposite directions.
    #[test]
    fn the_meshes_are_closed_and_look_inward() {
        for mesh in MESHES {
            let mut edges: BTreeMap<(u32, u32), u32> = BTreeMap::new();
            for t in &mesh.shape().triangles {
                (0..3).for_each(|k| *edges.entry((t[k], t[(k + 1) % 3])).or_default() += 1);
            }
            for (&(a, b), &count) in &edges {
                assert_eq!((count, edges.get(&(b, a))), (1, Some(&1)), "{mesh:?}: {a} {b}");
            }
            let scene = Scene::new(mesh.scene()).unwrap();
            let middle = mesh.middle() + 1e-3 * mesh.stretch();
            for dir in [Vec3::X, Vec3::NEG_Y, Vec3::new(-0.3, 0.2, 0.9)] {
                assert!(scene.intersect(&Ray::new(middle, dir)).unwrap().is_front(), "{mesh:?} {dir}");
            }
        }
    }
}
