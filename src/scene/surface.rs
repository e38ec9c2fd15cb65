use std::f32::consts::FRAC_1_PI;
use std::ops::{Add, Mul};

use rayon::prelude::*;

use super::mesh::{geometric_normal, least_altitude};
use super::tracer::Hit;
use super::{Mesh, SphereDesc};
use crate::math::{Aabb, RELATIVE_POSITION_ERROR, Ray, Vec2, Vec3};

/// The triangles or spheres behind one geometry of the ray tracer.
#[derive(Debug)]
pub(super) enum Surface {
    Mesh(Mesh, Vec<Facet>),
    Spheres(Vec<SphereDesc>),
}

/// What of a triangle is the same wherever it is hit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facet {
    ng: Vec3,
    p_error: f32,
    /// The least barycentric weight of a point.
    margin: f32,
}

/// How far points stay from the edges of their triangle, in errors of a point: nearer, the next ray could start behind
/// the wall on the other side of the edge. Enough where walls meet at 45 degrees or more.
const EDGE_ERRORS: f32 = 1.0;

/// The largest margin, so that points far from the origin, whose errors are large, stay about where they are.
const MAX_MARGIN: f32 = 1.0 / 32.0;

impl Facet {
    fn of(corners: [Vec3; 3]) -> Facet {
        let largest = corners.iter().fold(0.0, |m: f32, c| m.max(c.abs().max_element()));
        let ng = geometric_normal(corners).unwrap_or(Vec3::Y);
        let p_error = RELATIVE_POSITION_ERROR * largest;
        Facet { ng, p_error, margin: (EDGE_ERRORS * p_error / least_altitude(corners)).min(MAX_MARGIN) }
    }

    /// The weights of the second and third corner, moved where they do not keep the margin.
    #[inline(always)]
    fn keep_margin(&self, u: f32, v: f32) -> (f32, f32) {
        let least = u.min(v).min(1.0 - u - v);
        if least >= self.margin { (u, v) } else { towards_centroid(u, v, least, self.margin) }
    }
}

/// Whether all points of the triangle that rays go on from keep their distance from its edges; they cannot where it is
/// thinner than 32 times their error.
pub fn keeps_clear_of_edges(corners: [Vec3; 3]) -> bool {
    Facet::of(corners).margin < MAX_MARGIN
}

/// Moves a point whose least weight is `least` towards the centroid until that is `margin`.
#[cold]
fn towards_centroid(u: f32, v: f32, least: f32, margin: f32) -> (f32, f32) {
    const CENTRE: f32 = 1.0 / 3.0;
    let share = ((margin - least) / (CENTRE - least)).clamp(0.0, 1.0);
    (u + share * (CENTRE - u), v + share * (CENTRE - v))
}

/// Where and how a surface was hit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Geometry {
    pub p: Vec3,
    pub p_error: f32,
    pub ng: Vec3,
    pub ns: Vec3,
    /// Texture coordinates on a mesh that has some.
    pub uv: Vec2,
    /// 0 of a triangle.
    pub sphere_radius: f32,
    pub material: u32,
}

impl Surface {
    pub fn of_mesh(mesh: Mesh) -> Surface {
        let facets = (0..mesh.triangles.len()).into_par_iter().map(|k| Facet::of(mesh.corners(k))).collect();
        Surface::Mesh(mesh, facets)
    }

    /// The surface at a hit of the ray tracer.
    // Inlined, since handing such records over through memory stalls on their parts of odd size.
    #[inline(always)]
    pub fn at(&self, ray: &Ray, hit: &Hit) -> Geometry {
        match self {
            Surface::Mesh(mesh, facets) => on_triangle(mesh, &facets[hit.primitive as usize], hit),
            Surface::Spheres(spheres) => on_sphere(&spheres[hit.primitive as usize], ray.at(hit.t)),
        }
    }

    /// Whether rays meet both at the same places, bit by bit.
    pub fn lies_as(&self, other: &Surface) -> bool {
        match (self, other) {
            (Surface::Mesh(a, _), Surface::Mesh(b, _)) => {
                a.triangles == b.triangles && bits(&a.vertices).eq(bits(&b.vertices))
            }
            (Surface::Spheres(a), Surface::Spheres(b)) => {
                let ball = |s: &SphereDesc| s.center.extend(s.radius).to_array().map(f32::to_bits);
                a.iter().map(ball).eq(b.iter().map(ball))
            }
            (Surface::Mesh(..), Surface::Spheres(_)) | (Surface::Spheres(_), Surface::Mesh(..)) => false,
        }
    }

    pub fn mesh(&self) -> Option<&Mesh> {
        match self {
            Surface::Mesh(mesh, _) => Some(mesh),
            Surface::Spheres(_) => None,
        }
    }

    /// None of a mesh.
    pub fn spheres(&self) -> &[SphereDesc] {
        match self {
            Surface::Mesh(..) => &[],
            Surface::Spheres(spheres) => spheres,
        }
    }

    pub fn primitives(&self) -> usize {
        match self {
            Surface::Mesh(mesh, _) => mesh.triangles.len(),
            Surface::Spheres(spheres) => spheres.len(),
        }
    }

    pub fn bounds(&self) -> Aabb {
        match self {
            Surface::Mesh(mesh, _) => Aabb::of_points(mesh.vertices.iter().copied()),
            Surface::Spheres(spheres) => {
                spheres.iter().map(|s| Aabb::of_sphere(s.center, s.radius)).fold(Aabb::EMPTY, Aabb::union)
            }
        }
    }
}

fn bits(vertices: &[Vec3]) -> impl Iterator<Item = [u32; 3]> {
    vertices.iter().map(|p| p.to_array().map(f32::to_bits))
}

/// The point from its barycentric weights: its error does not grow with the length of the ray.
// Inlined for the same reason as `Surface::at`.
#[inline(always)]
fn on_triangle(mesh: &Mesh, facet: &Facet, hit: &Hit) -> Geometry {
    let triangle = mesh.triangles[hit.primitive as usize];
    let (u, v) = facet.keep_margin(hit.u, hit.v);
    let Facet { ng, p_error, .. } = *facet;
    let ns = mesh.normals.as_deref().and_then(|normals| weighed(normals, triangle, u, v).try_normalize());
    Geometry {
        p: weighed(&mesh.vertices, triangle, u, v),
        p_error,
        ng,
        ns: ns.unwrap_or(ng),
        uv: mesh.uvs.as_deref().map_or(Vec2::ZERO, |uvs| weighed(uvs, triangle, u, v)),
        sphere_radius: 0.0,
        material: mesh.materials[hit.primitive as usize],
    }
}

/// The mean of what the corners of a triangle have, by the weights of the second and the third.
// Inlined for the same reason as `Surface::at`.
#[inline(always)]
fn weighed<T>(of: &[T], triangle: [u32; 3], u: f32, v: f32) -> T
where
    T: Copy + Add<Output = T>,
    f32: Mul<T, Output = T>,
{
    let [a, b, c] = triangle.map(|corner| of[corner as usize]);
    (1.0 - u - v) * a + u * b + v * c
}

/// The point is moved onto the sphere: its error does not grow with the length of the ray.
fn on_sphere(sphere: &SphereDesc, p: Vec3) -> Geometry {
    let ng = (p - sphere.center).normalize_or(Vec3::Y);
    Geometry {
        p: sphere.center + sphere.radius * ng,
        p_error: RELATIVE_POSITION_ERROR * (sphere.center.abs().max_element() + sphere.radius),
        ng,
        ns: ng,
        uv: Vec2::ZERO,
        sphere_radius: sphere.radius,
        material: sphere.material,
    }
}

impl Geometry {
    pub fn texture_coordinates(&self) -> Vec2 {
        texture_coordinates(self.sphere_radius, self.ng, self.uv)
    }
}

/// Those of a mesh, or the place on a sphere.
pub(super) fn texture_coordinates(sphere_radius: f32, ng: Vec3, uv: Vec2) -> Vec2 {
    if sphere_radius > 0.0 { geographic(ng) } else { uv }
}

/// Longitude and latitude of a place on a sphere, from 0 to 1: to the east from `-x`, and up.
pub(super) fn geographic(ng: Vec3) -> Vec2 {
    Vec2::new(0.5 + (-ng.z).atan2(ng.x) * (0.5 * FRAC_1_PI), 0.5 + ng.y.asin() * FRAC_1_PI)
}
