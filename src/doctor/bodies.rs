//! Triangles that hang together, and what they enclose.

use rayon::prelude::*;

use super::duplicates::has_an_inside;
use super::places::{self, Place};
use crate::math::{Aabb, DVec3, Vec3, solid_angle};
use crate::scene::SceneDesc;

/// What a surface is made of, as far as light inside is concerned: bodies of different kinds do not hang together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Kind {
    /// Of any materials that no light passes.
    Opaque,
    /// Of the material with this number, which light passes.
    Glass(u32),
}

/// Triangles of a kind that share edges, whatever mesh they are in.
#[derive(Clone, Debug)]
pub(super) struct Body {
    pub kind: Kind,
    /// In the order of the meshes.
    pub triangles: Vec<Place>,
    /// Edges where a neighbour is missing.
    pub borders: usize,
    /// Edges of two triangles that face opposite ways.
    pub flips: usize,
    /// The volume within, negative where normals point inward (scene units³).
    pub volume: f64,
    pub bounds: Aabb,
}

impl Body {
    pub fn is_closed(&self) -> bool {
        self.borders == 0 && self.flips == 0
    }

    /// Whether `p` is inside a closed body.
    ///
    /// By the sum of the solid angles of its triangles, which is 4π inside, up to its sign, and 0 outside.
    pub fn contains(&self, desc: &SceneDesc, p: Vec3) -> bool {
        if !self.is_closed() || !self.bounds.contains(p) {
            return false;
        }
        const HALF: f64 = 2.0 * std::f64::consts::PI;
        let angles: Vec<f64> =
            self.triangles.par_iter().map(|place| solid_angle(place.corners(desc), p)).collect();
        angles.iter().sum::<f64>().abs() > HALF
    }
}

/// All bodies, ordered by their first triangles.
pub(super) fn bodies(desc: &SceneDesc) -> Vec<Body> {
    let (places, corners) = faces(desc);
    let edges = edges(&corners);
    let mut groups = Groups::singles(places.len());
    for edge in edges.chunk_by(|a, b| a.ends == b.ends) {
        edge[1..].iter().for_each(|other| groups.join(edge[0].triangle, other.triangle));
    }
    let roots: Vec<u32> = (0..places.len() as u32).map(|triangle| groups.root(triangle)).collect();
    let mut order: Vec<u32> = (0..places.len() as u32).collect();
    order.par_sort_by_key(|&triangle| roots[triangle as usize]);
    let mut faults = vec![[0; 2]; places.len()];
    for edge in edges.chunk_by(|a, b| a.ends == b.ends) {
        let [borders, flips] = &mut faults[roots[edge[0].triangle as usize] as usize];
        match edge_fault(edge) {
            None => (),
            Some(EdgeFault::Border) => *borders += 1,
            Some(EdgeFault::Flip) => *flips += 1,
        }
    }
    order
        .chunk_by(|&a, &b| roots[a as usize] == roots[b as usize])
        .map(|group| {
            let triangles: Vec<Place> = group.iter().map(|&triangle| places[triangle as usize]).collect();
            body(desc, triangles, faults[roots[group[0] as usize] as usize])
        })
        .collect()
}

fn body(desc: &SceneDesc, triangles: Vec<Place>, [borders, flips]: [usize; 2]) -> Body {
    let bounds = Aabb::of_points(triangles.iter().flat_map(|place| place.corners(desc)));
    let middle = bounds.center().as_dvec3();
    let volume = triangles.iter().map(|place| volume(place.corners(desc), middle)).sum();
    Body { kind: kind(desc, triangles[0]), triangles, borders, flips, volume, bounds }
}

/// Of the tetrahedron with its apex at `middle`.
fn volume(corners: [Vec3; 3], middle: DVec3) -> f64 {
    let [a, b, c] = corners.map(|corner| corner.as_dvec3() - middle);
    a.dot(b.cross(c)) / 6.0
}

fn kind(desc: &SceneDesc, place: Place) -> Kind {
    if has_an_inside(&place.material(desc).bsdf) {
        Kind::Glass(place.material_number(desc))
    } else {
        Kind::Opaque
    }
}

/// All triangles and the numbers of their corners; of several in the same place that face alike, the first.
fn faces(desc: &SceneDesc) -> (Vec<Place>, Vec<[u32; 3]>) {
    let places: Vec<Place> = places::all(desc).collect();
    let corners = welded_corners(desc, &places).into_iter().map(smallest_first);
    let mut faces: Vec<([u32; 3], Place)> = corners.zip(places).collect();
    faces.par_sort_unstable();
    faces.dedup_by_key(|(corners, _)| *corners);
    faces.par_sort_unstable_by_key(|(_, place)| *place);
    faces.into_iter().map(|(corners, place)| (place, corners)).unzip()
}

/// The same corners in the same sense of rotation.
fn smallest_first([a, b, c]: [u32; 3]) -> [u32; 3] {
    match a.min(b).min(c) {
        first if first == a => [a, b, c],
        first if first == b => [b, c, a],
        _ => [c, a, b],
    }
}

/// Numbers for the corners of every triangle: equal for equal positions and kinds.
fn welded_corners(desc: &SceneDesc, places: &[Place]) -> Vec<[u32; 3]> {
    let mut keyed: Vec<(Kind, [u32; 3], u32)> = Vec::with_capacity(3 * places.len());
    for (place, triangle) in places.iter().zip(0..) {
        let kind = kind(desc, *place);
        for (corner, k) in place.corners(desc).into_iter().zip(0..) {
            keyed.push((kind, (corner + 0.0).to_array().map(f32::to_bits), 3 * triangle + k));
        }
    }
    keyed.par_sort_unstable();
    let mut welded = vec![[0; 3]; places.len()];
    let groups = keyed.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1));
    for (group, number) in groups.zip(0..) {
        for (_, _, corner) in group {
            welded[*corner as usize / 3][*corner as usize % 3] = number;
        }
    }
    welded
}

/// One side of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Edge {
    /// The smaller one first.
    ends: [u32; 2],
    triangle: u32,
    /// Whether the triangle runs from the first to the second.
    is_forward: bool,
}

fn edges(corners: &[[u32; 3]]) -> Vec<Edge> {
    let mut edges: Vec<Edge> = Vec::with_capacity(3 * corners.len());
    for (corners, triangle) in corners.iter().zip(0..) {
        for k in 0..3 {
            let [from, to] = [corners[k], corners[(k + 1) % 3]];
            if from != to {
                edges.push(Edge { ends: [from.min(to), from.max(to)], triangle, is_forward: from < to });
            }
        }
    }
    edges.par_sort_unstable();
    edges
}

enum EdgeFault {
    Border,
    Flip,
}

/// A closed surface runs along each edge as often forward as back.
fn edge_fault(edge: &[Edge]) -> Option<EdgeFault> {
    let forward = edge.iter().filter(|edge| edge.is_forward).count();
    match edge.len() {
        n if 2 * forward == n => None,
        2 => Some(EdgeFault::Flip),
        _ => Some(EdgeFault::Border),
    }
}

/// Disjoint sets of triangles, each known by its smallest member.
struct Groups {
    parents: Vec<u32>,
}

impl Groups {
    fn singles(n: usize) -> Groups {
        Groups { parents: (0..n as u32).collect() }
    }

    fn root(&mut self, mut member: u32) -> u32 {
        while self.parents[member as usize] != member {
            let parent = self.parents[member as usize];
            self.parents[member as usize] = self.parents[parent as usize];
            member = parent;
        }
        member
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parents[a.max(b) as usize] = a.min(b);
    }
}

/// The numbers of things inside which `p` lies.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Enclosures {
    /// Indices of bodies.
    pub bodies: Vec<usize>,
    /// Indices of spheres.
    pub spheres: Vec<usize>,
}

impl Enclosures {
    pub fn of(desc: &SceneDesc, bodies: &[Body], p: Vec3) -> Enclosures {
        Enclosures {
            bodies: (0..bodies.len()).filter(|&k| bodies[k].contains(desc, p)).collect(),
            spheres: (0..desc.spheres.len())
                .filter(|&k| desc.spheres[k].center.distance(p) < desc.spheres[k].radius)
                .collect(),
        }
    }

    /// Those that are not around another point, too.
    pub fn without(mut self, other: &Enclosures) -> Enclosures {
        self.bodies.retain(|body| !other.bodies.contains(body));
        self.spheres.retain(|sphere| !other.spheres.contains(sphere));
        self
    }

    /// The numbers of the materials around, of bodies by their first triangle.
    pub fn materials(&self, desc: &SceneDesc, bodies: &[Body]) -> Vec<u32> {
        let of_bodies = self.bodies.iter().map(|&k| bodies[k].triangles[0].material_number(desc));
        of_bodies.chain(self.spheres.iter().map(|&k| desc.spheres[k].material)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{GLASS, WALL, cube, room, with_material};
    use super::*;
    use crate::scene::Mesh;

    fn scene_of(meshes: Vec<Mesh>) -> SceneDesc {
        SceneDesc { meshes, ..room() }
    }

    fn only(meshes: Vec<Mesh>) -> (SceneDesc, Body) {
        let desc = scene_of(meshes);
        let mut bodies = bodies(&desc);
        assert_eq!(bodies.len(), 1, "{bodies:?}");
        (desc, bodies.remove(0))
    }

    #[test]
    fn a_cube_is_closed_and_has_its_volume() {
        let (_, body) = only(vec![cube("c", Vec3::ONE, 0.5, WALL)]);
        assert!(body.is_closed() && body.triangles.len() == 12);
        assert!((body.volume - 1.0).abs() < 1e-6, "{}", body.volume);
        let mut inward = cube("c", Vec3::ONE, 0.5, WALL);
        inward.triangles.iter_mut().for_each(|t| t.reverse());
        assert!((only(vec![inward]).1.volume + 1.0).abs() < 1e-6);
    }

    /// Quads are meshes of their own.
    #[test]
    fn faces_in_meshes_of_their_own_hang_together() {
        let whole = cube("c", Vec3::ZERO, 1.0, GLASS);
        let faces = (0..6).map(|face| Mesh {
            triangles: whole.triangles[2 * face..2 * face + 2].to_vec(),
            materials: vec![GLASS; 2],
            ..whole.clone()
        });
        let (_, body) = only(faces.collect());
        assert!(body.is_closed() && body.kind == Kind::Glass(GLASS));
    }

    #[test]
    fn holes_and_turned_triangles_are_counted() {
        let mut open = cube("c", Vec3::ZERO, 1.0, WALL);
        open.triangles.remove(3);
        open.materials.remove(3);
        let (_, body) = only(vec![open]);
        assert_eq!((body.borders, body.flips), (3, 0));
        let mut turned = cube("c", Vec3::ZERO, 1.0, WALL);
        turned.triangles[3].reverse();
        let (_, body) = only(vec![turned]);
        assert_eq!((body.borders, body.flips), (0, 3));
    }

    /// In any order that faces alike.
    #[test]
    fn faces_that_are_there_twice_count_once() {
        for turn in 0..3 {
            let mut mesh = cube("c", Vec3::ONE, 0.5, WALL);
            let mut again = mesh.triangles[3];
            again.rotate_left(turn);
            mesh.triangles.push(again);
            mesh.materials.push(WALL);
            let (_, body) = only(vec![mesh]);
            assert!(body.is_closed() && (body.volume - 1.0).abs() < 1e-6, "{body:?}");
        }
    }

    #[test]
    fn bodies_apart_and_of_other_kinds_are_other_bodies() {
        let two = vec![cube("a", Vec3::ZERO, 1.0, WALL), cube("b", 3.0 * Vec3::X, 1.0, WALL)];
        assert_eq!(bodies(&scene_of(two)).len(), 2);
        let mixed =
            vec![cube("a", Vec3::ZERO, 1.0, WALL), with_material(cube("b", Vec3::ZERO, 1.0, WALL), GLASS)];
        assert_eq!(bodies(&scene_of(mixed)).len(), 2);
    }

    #[test]
    fn inside_is_what_is_all_around() {
        let (desc, body) = only(vec![cube("c", Vec3::ONE, 0.5, WALL)]);
        for (p, inside) in [
            (Vec3::ONE, true),
            (Vec3::new(1.49, 0.51, 1.2), true),
            (Vec3::new(1.51, 1.0, 1.0), false),
            (Vec3::ZERO, false),
        ] {
            assert_eq!(body.contains(&desc, p), inside, "{p}");
        }
    }
}
