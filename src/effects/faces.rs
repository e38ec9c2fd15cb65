//! Triangles by number, and which of them hang together.

use std::ops::Range;

use rayon::prelude::*;

use crate::math::{Aabb, RELATIVE_POSITION_ERROR, Vec3};
use crate::scene::{Material, Mesh, Scene};

/// A triangle of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Face {
    pub mesh: u32,
    pub triangle: u32,
}

/// The triangles of a scene.
pub(super) struct Triangles<'s> {
    meshes: Vec<&'s Mesh>,
    materials: &'s [Material],
}

impl<'s> Triangles<'s> {
    pub fn of(scene: &'s Scene) -> Triangles<'s> {
        Triangles { meshes: scene.meshes().collect(), materials: scene.materials() }
    }

    pub fn corners(&self, face: Face) -> [Vec3; 3] {
        self.meshes[face.mesh as usize].corners(face.triangle as usize)
    }

    pub fn material_number(&self, face: Face) -> u32 {
        self.meshes[face.mesh as usize].materials[face.triangle as usize]
    }

    pub fn material(&self, face: Face) -> &'s Material {
        &self.materials[self.material_number(face) as usize]
    }

    /// The box around a triangle and the errors of its points.
    pub fn bounds(&self, face: Face) -> Aabb {
        grown(Aabb::of_points(self.corners(face)))
    }

    pub fn materials(&self) -> &'s [Material] {
        self.materials
    }

    /// The box around several of them.
    pub fn bounds_of(&self, faces: &[Face]) -> Aabb {
        faces.iter().map(|face| self.bounds(*face)).fold(Aabb::EMPTY, Aabb::union)
    }

    /// Those that have an area, mesh by mesh: rays meet no others.
    pub fn faces(&self) -> impl Iterator<Item = Face> {
        let all = self.meshes.iter().zip(0..).flat_map(|(mesh, number)| {
            (0..mesh.triangles.len() as u32).map(move |triangle| Face { mesh: number, triangle })
        });
        all.filter(|face| has_area(self.corners(*face)))
    }

    /// The faces of each mesh as one part.
    pub fn by_mesh(&self) -> Parts {
        let faces: Vec<Face> = self.faces().collect();
        let mut parts = Parts { turned: vec![false; faces.len()], faces, parts: Vec::new() };
        let mut start = 0;
        for group in parts.faces.chunk_by(|a, b| a.mesh == b.mesh) {
            parts.parts.push(Part { faces: start..start + group.len(), is_closed: false });
            start += group.len();
        }
        parts
    }

    /// The faces that share edges, whatever mesh they are in: positions are the same where their bits are.
    ///
    /// `O(n log n)` for `n` triangles.
    pub fn by_edges(&self, faces: Vec<Face>, vertices: &Vertices) -> Parts {
        let edges = edges(self, &faces, vertices);
        let mut groups = Groups::singles(faces.len());
        let mut open = Vec::new();
        for edge in edges.chunk_by(|a, b| a.ends == b.ends) {
            if !groups.join_along(edge) {
                open.push(edge[0].face);
            }
        }
        parts(faces, &mut groups, &open)
    }
}

/// Exactly, however small: the products of f32 do not vanish in f64.
fn has_area(corners: [Vec3; 3]) -> bool {
    let [a, b, c] = corners.map(|corner| corner.as_dvec3());
    (b - a).cross(c - a).length_squared() > 0.0
}

/// A box with room for the errors of points on surfaces within.
pub(super) fn grown(bounds: Aabb) -> Aabb {
    let error = RELATIVE_POSITION_ERROR * bounds.min.abs().max(bounds.max.abs()).max_element();
    Aabb { min: bounds.min - error, max: bounds.max + error }
}

/// Faces that hang together.
#[derive(Clone, Debug)]
pub(super) struct Part {
    /// In [`Parts::faces`].
    pub faces: Range<usize>,
    /// Whether each edge belongs to two of them, and all can be turned to face the same side.
    pub is_closed: bool,
}

/// All faces of a kind, part by part, in the order of the parts' first faces.
#[derive(Debug, Default)]
pub(super) struct Parts {
    pub faces: Vec<Face>,
    /// Of a closed part, whether a face has to be turned over to face the side of the part's first.
    pub turned: Vec<bool>,
    pub parts: Vec<Part>,
}

fn parts(faces: Vec<Face>, groups: &mut Groups, open: &[u32]) -> Parts {
    let n = faces.len() as u32;
    let roots: Vec<(u32, bool)> = (0..n).map(|face| groups.root(face)).collect();
    let mut is_closed = vec![true; faces.len()];
    open.iter().for_each(|&face| is_closed[roots[face as usize].0 as usize] = false);
    let mut order: Vec<u32> = (0..n).collect();
    order.par_sort_by_key(|&face| roots[face as usize].0);
    let mut sorted = Parts {
        faces: order.iter().map(|&face| faces[face as usize]).collect(),
        turned: order.iter().map(|&face| roots[face as usize].1).collect(),
        parts: Vec::new(),
    };
    let mut start = 0;
    for group in order.chunk_by(|&a, &b| roots[a as usize].0 == roots[b as usize].0) {
        let is_closed = is_closed[roots[group[0] as usize].0 as usize];
        sorted.parts.push(Part { faces: start..start + group.len(), is_closed });
        start += group.len();
    }
    sorted
}

/// Numbers for the vertices of every mesh: equal for equal positions.
pub(super) struct Vertices(Vec<Vec<u32>>);

impl Vertices {
    pub fn weld(triangles: &Triangles) -> Vertices {
        let all = triangles.meshes.iter().flat_map(|mesh| &mesh.vertices);
        // Both zeros are the same place.
        let bits = |vertex: &Vec3| (*vertex + 0.0).to_array().map(f32::to_bits);
        let mut keyed: Vec<([u32; 3], u32)> = all.zip(0..).map(|(vertex, k)| (bits(vertex), k)).collect();
        keyed.par_sort_unstable();
        let mut numbers = vec![0; keyed.len()];
        for (group, number) in keyed.chunk_by(|a, b| a.0 == b.0).zip(0..) {
            group.iter().for_each(|(_, vertex)| numbers[*vertex as usize] = number);
        }
        let mut rest = numbers.into_iter();
        let of_mesh = |mesh: &&Mesh| rest.by_ref().take(mesh.vertices.len()).collect();
        Vertices(triangles.meshes.iter().map(of_mesh).collect())
    }

    fn of(&self, triangles: &Triangles, face: Face) -> [u32; 3] {
        let mesh = face.mesh as usize;
        let corners = triangles.meshes[mesh].triangles[face.triangle as usize];
        corners.map(|corner| self.0[mesh][corner as usize])
    }
}

/// One side of a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Edge {
    /// The smaller one first.
    ends: [u32; 2],
    face: u32,
    /// Whether the face runs from the first to the second.
    is_forward: bool,
}

fn edges(triangles: &Triangles, faces: &[Face], vertices: &Vertices) -> Vec<Edge> {
    let of_face = |face: u32| {
        let corners = vertices.of(triangles, faces[face as usize]);
        [0, 1, 2].map(|k| {
            let [from, to] = [corners[k], corners[(k + 1) % 3]];
            Edge { ends: [from.min(to), from.max(to)], face, is_forward: from < to }
        })
    };
    let mut edges: Vec<Edge> = (0..faces.len() as u32).flat_map(of_face).collect();
    edges.par_sort_unstable();
    edges
}

/// Disjoint sets of faces, each known by its smallest member, and which way round each face is in its set.
struct Groups {
    parents: Vec<u32>,
    /// Whether a face is turned over against its parent.
    turned: Vec<bool>,
}

impl Groups {
    fn singles(n: usize) -> Groups {
        Groups { parents: (0..n as u32).collect(), turned: vec![false; n] }
    }

    /// The smallest member, and whether `member` is turned over against it.
    fn root(&mut self, member: u32) -> (u32, bool) {
        let (mut at, mut turned) = (member as usize, false);
        while self.parents[at] as usize != at {
            let parent = self.parents[at] as usize;
            self.turned[at] ^= self.turned[parent];
            self.parents[at] = self.parents[parent];
            turned ^= self.turned[at];
            at = self.parents[at] as usize;
        }
        (at as u32, turned)
    }

    /// Joins two sets, so that `a` and `b` face the same way, or not; false if they already do otherwise.
    fn join(&mut self, a: u32, b: u32, turned: bool) -> bool {
        let ((a, a_turned), (b, b_turned)) = (self.root(a), self.root(b));
        let turned = turned ^ a_turned ^ b_turned;
        if a == b {
            return !turned;
        }
        self.parents[a.max(b) as usize] = a.min(b);
        self.turned[a.max(b) as usize] = turned;
        true
    }

    /// Joins the faces at an edge; whether the surface goes on there as a closed one does.
    fn join_along(&mut self, edge: &[Edge]) -> bool {
        let faces_alike = |other: &Edge| other.is_forward != edge[0].is_forward;
        let mut is_consistent = true;
        for other in &edge[1..] {
            is_consistent &= self.join(edge[0].face, other.face, !faces_alike(other));
        }
        edge.len() == 2 && is_consistent
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{cube, scene_of};
    use super::*;
    use crate::scene::Mesh;

    /// How many faces each part has, and whether it is closed.
    fn parts_of(meshes: Vec<Mesh>) -> Vec<(usize, bool)> {
        let scene = scene_of(meshes);
        let triangles = Triangles::of(&scene);
        let vertices = Vertices::weld(&triangles);
        let parts = triangles.by_edges(triangles.faces().collect(), &vertices);
        parts.parts.iter().map(|part| (part.faces.len(), part.is_closed)).collect()
    }

    #[test]
    fn cubes_are_closed_however_their_faces_are_spread_over_meshes() {
        let whole = cube("cube", Vec3::ONE, 0.5, 0);
        let face = |k: usize| Mesh {
            triangles: whole.triangles[2 * k..2 * k + 2].to_vec(),
            materials: vec![0; 2],
            ..whole.clone()
        };
        assert_eq!(parts_of(vec![whole.clone()]), [(12, true)]);
        assert_eq!(parts_of((0..6).map(face).collect()), [(12, true)]);
        assert_eq!(parts_of((0..5).map(face).collect()), [(10, false)]);
    }

    /// Positions alone count; both zeros are one.
    #[test]
    fn vertices_are_welded_by_position() {
        let whole = cube("cube", Vec3::splat(0.5), 0.5, 0);
        let mut apart = whole.clone();
        apart.vertices = whole.triangles.iter().flatten().map(|&k| whole.vertices[k as usize]).collect();
        apart.triangles = (0..12).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        assert_eq!(parts_of(vec![apart.clone()]), [(12, true)]);
        let origin = apart.vertices.iter().position(|vertex| *vertex == Vec3::ZERO).unwrap();
        apart.vertices[origin] *= -1.0;
        assert_eq!(parts_of(vec![apart.clone()]), [(12, true)]);
        apart.vertices[origin].x = 1e-30;
        assert!(!parts_of(vec![apart])[0].1, "a hair's breadth is a gap");
    }

    #[test]
    fn every_missing_or_additional_triangle_opens_a_surface() {
        for k in 0..12 {
            let mut open = cube("cube", Vec3::ONE, 0.5, 0);
            open.triangles.remove(k);
            open.materials.remove(k);
            assert_eq!(parts_of(vec![open]), [(11, false)]);
            let mut double = cube("cube", Vec3::ONE, 0.5, 0);
            double.triangles.push(double.triangles[k]);
            double.materials.push(0);
            assert_eq!(parts_of(vec![double]), [(13, false)]);
        }
    }

    #[test]
    fn triangles_without_area_are_not_there() {
        let mut cube = cube("cube", Vec3::ONE, 0.5, 0);
        cube.triangles.push([0, 1, 1]);
        cube.materials.push(0);
        assert_eq!(parts_of(vec![cube]), [(12, true)]);
    }

    /// Triangles that face either way are turned; a surface of one side alone, as Möbius's, cannot be.
    #[test]
    fn faces_are_turned_alike_where_that_is_possible() {
        let mut mixed = cube("cube", Vec3::ONE, 0.5, 0);
        mixed.triangles[5].reverse();
        mixed.triangles[8].reverse();
        let scene = scene_of(vec![mixed]);
        let triangles = Triangles::of(&scene);
        let parts = triangles.by_edges(triangles.faces().collect(), &Vertices::weld(&triangles));
        let turned: Vec<usize> = (0..12).filter(|&k| parts.turned[k]).collect();
        assert!(parts.parts[0].is_closed && turned == [5, 8], "{turned:?}");
        // The real projective plane in six vertices: each edge belongs to two triangles.
        let plane = [
            [0, 1, 2],
            [0, 2, 3],
            [0, 3, 4],
            [0, 4, 5],
            [0, 5, 1],
            [1, 2, 4],
            [2, 3, 5],
            [3, 4, 1],
            [4, 5, 2],
            [5, 1, 3],
        ];
        let at = |k: u32| Vec3::new(k as f32, (k * k) as f32, (k * k * k) as f32);
        let mesh = Mesh::new("plane", (0..6).map(at).collect(), plane.to_vec(), 0);
        assert_eq!(parts_of(vec![mesh]), [(10, false)]);
    }
}
