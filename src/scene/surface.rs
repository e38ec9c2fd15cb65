use std::f32::consts::FRAC_1_PI;

use rayon::prelude::*;

use super::mesh::{geometric_normal, least_altitude};
use super::tracer::Hit;
use super::{Mesh, SphereDesc};
use crate::bsdf::{Coat, Event};
use crate::math::{Aabb, Frame, RELATIVE_POSITION_ERROR, Ray, Vec2, Vec3, offset_origin};

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
    let weigh = |of: &[Vec3]| {
        let [a, b, c] = triangle.map(|i| of[i as usize]);
        (1.0 - u - v) * a + u * b + v * c
    };
    let texture = |of: &[Vec2]| {
        let [a, b, c] = triangle.map(|i| of[i as usize]);
        (1.0 - u - v) * a + u * b + v * c
    };
    let Facet { ng, p_error, .. } = *facet;
    let ns = mesh.normals.as_ref().and_then(|normals| weigh(normals).try_normalize());
    Geometry {
        p: weigh(&mesh.vertices),
        p_error,
        ng,
        ns: ns.unwrap_or(ng),
        uv: mesh.uvs.as_deref().map_or(Vec2::ZERO, texture),
        sphere_radius: 0.0,
        material: mesh.materials[hit.primitive as usize],
    }
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
        if self.sphere_radius > 0.0 { geographic(self.ng) } else { self.uv }
    }
}

/// Longitude and latitude of a place on a sphere, from 0 to 1: to the east from `-x`, and up.
pub(super) fn geographic(ng: Vec3) -> Vec2 {
    Vec2::new(0.5 + (-ng.z).atan2(ng.x) * (0.5 * FRAC_1_PI), 0.5 + ng.y.asin() * FRAC_1_PI)
}

/// A point of a surface that light or photons arrive at, seen from one side.
#[derive(Clone, Copy, Debug)]
pub struct Receiver {
    /// The point.
    pub p: Vec3,
    /// Its absolute error, in scene units.
    pub p_error: f32,
    /// Geometric normal, unit, on the side that is seen.
    pub ng: Vec3,
    /// Shading normal, unit, on the side that is seen.
    pub ns: Vec3,
    /// What light passes before it is received.
    pub coat: Coat,
}

impl Receiver {
    /// The same under a coat.
    #[must_use]
    pub fn under(self, coat: Coat) -> Receiver {
        Receiver { coat, ..self }
    }

    /// What the surface makes of flux that arrives from `wi`: `ns·wi / ng·wi`, since flux counts by the true surface
    /// and irradiance by the shading normal. `None` where it does not see `wi`.
    pub fn response(&self, wi: Vec3) -> Option<f32> {
        let response = foreshortening(self.ns, self.ng, wi);
        (self.ng.dot(wi) > 0.0 && response > 0.0).then_some(response)
    }
}

/// The first surface along a ray.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceHit {
    /// The point.
    pub p: Vec3,
    /// Its absolute error, in scene units.
    pub p_error: f32,
    /// Distance along the ray, in lengths of its direction.
    pub t: f32,
    /// Geometric normal, unit, outward: by the winding of a triangle, away from a sphere's centre.
    pub ng: Vec3,
    /// The shading normal that is seen along `wo`; it lies on the side of `ng`.
    pub normal: Vec3,
    /// The shading normal as the mesh has it.
    ns: Vec3,
    /// Back along the ray, unit.
    pub wo: Vec3,
    /// Texture coordinates on a mesh that has some; see [`SurfaceHit::texture_coordinates`].
    uv: Vec2,
    /// The radius of the sphere that was hit; 0 of a triangle.
    pub sphere_radius: f32,
    /// Number of the material.
    pub material: u32,
}

impl SurfaceHit {
    // Inlined for the same reason as `Surface::at`.
    #[inline(always)]
    pub(super) fn new(ray: &Ray, t: f32, surface: Geometry) -> SurfaceHit {
        let Geometry { p, p_error, ng, ns, uv, sphere_radius, material } = surface;
        let wo = -ray.dir.normalize();
        SurfaceHit { p, p_error, t, ng, normal: seen_normal(ns, ng, wo), ns, wo, uv, sphere_radius, material }
    }

    /// The frame around [`SurfaceHit::normal`].
    pub fn frame(&self) -> Frame {
        Frame::around(self.normal)
    }

    /// `wo` in the shading frame.
    pub fn wo_local(&self) -> Vec3 {
        self.frame().to_local(self.wo)
    }

    /// Whether the ray came from the outer side, that of `ng`.
    pub fn is_front(&self) -> bool {
        self.ng.dot(self.wo) > 0.0
    }

    /// Where pictures on the surface are looked up.
    pub fn texture_coordinates(&self) -> Vec2 {
        if self.sphere_radius > 0.0 { geographic(self.ng) } else { self.uv }
    }

    /// The surface as it is seen along `wo`, but for its coat: see [`super::Scene::receiver`].
    pub fn receiver(&self) -> Receiver {
        let side = if self.is_front() { 1.0 } else { -1.0 };
        let (p, p_error) = (self.p, self.p_error);
        Receiver { p, p_error, ng: side * self.ng, ns: side * self.normal, coat: Coat::NONE }
    }

    /// The ray that goes on in the world direction `dir` after `event`.
    ///
    /// `None` where the shading normal bends it to the wrong side of the true surface: such light is absorbed.
    pub fn continue_along(&self, event: Event, dir: Vec3) -> Option<Ray> {
        let crosses = (self.ng.dot(dir) > 0.0) != self.is_front();
        (crosses == event.crosses()).then(|| Ray::new(offset_origin(self.p, self.p_error, self.ng, dir), dir))
    }

    /// The ray that goes straight on, as if there were no surface.
    pub fn pass(&self) -> Ray {
        Ray::new(offset_origin(self.p, self.p_error, self.ng, -self.wo), -self.wo)
    }

    /// The factor on the power of a photon that came along `wo` and goes on along `dir`, so that it carries as much
    /// as a path from the camera would the other way; 1 where shading and geometric normal agree.
    ///
    /// After a mirror, an interface or a facet `|ns·wo| |ng·dir| / (|ng·wo| |ns·dir|)`. After a diffuse bounce, whose
    /// direction is to be drawn around `ng`, `ns·wo / ng·wo` with the normal that is seen from `dir`, and 0 where
    /// that one faces away from `wo`.
    ///
    /// # Source
    /// Veach, "Robust Monte Carlo Methods for Light Transport Simulation", 1997, section 5.3.
    pub fn adjoint_correction(&self, event: Event, dir: Vec3) -> f32 {
        if self.ns == self.ng {
            return 1.0;
        }
        match event {
            Event::Diffuse => foreshortening(seen_normal(self.ns, self.ng, dir), self.ng, self.wo),
            Event::Reflection | Event::Transmission | Event::GlossyReflection | Event::GlossyTransmission => {
                let ns = self.normal;
                foreshortening(ns, self.ng, self.wo) / foreshortening(ns, self.ng, dir)
            }
        }
    }
}

/// The shading normal, unless it sees `w` from the other side than the geometric one: then the latter stands in,
/// so that no cosine turns negative and no light leaks through.
fn seen_normal(ns: Vec3, ng: Vec3, w: Vec3) -> Vec3 {
    if ns.dot(w) * ng.dot(w) > 0.0 { ns } else { ng }
}

/// `ns·w / ng·w`: how much more light from `w` the shading normal promises than the true surface receives.
/// 0 where both see `w` from different sides, or edge on.
fn foreshortening(ns: Vec3, ng: Vec3, w: Vec3) -> f32 {
    let ratio = ns.dot(w) / ng.dot(w);
    if ratio.is_finite() { ratio.max(0.0) } else { 0.0 }
}
