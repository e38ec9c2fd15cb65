//! Where rays meet surfaces, and how light arrives and goes on there.

use super::surface::{Geometry, texture_coordinates};
use crate::bsdf::{Coat, Event};
use crate::math::{Frame, Ray, Vec2, Vec3, offset_origin};

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
    /// Texture coordinates on a mesh that has some.
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
    pub(super) fn texture_coordinates(&self) -> Vec2 {
        texture_coordinates(self.sphere_radius, self.ng, self.uv)
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
