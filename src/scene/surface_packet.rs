use super::gist::Gist;
use super::surface::Geometry;
use super::{HitPacket, RayPacket, Row, Scene};
use crate::bsdf::Bsdf;
use crate::embree::PACKET;
use crate::math::{Ray, Rgb, Vec3};

/// The surfaces that a packet of rays meets, in columns; anything where it meets nothing.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct SurfacePacket {
    /// The points: all x, all y, all z.
    pub p: [Row; 3],
    /// Their absolute error, in scene units.
    pub p_error: Row,
    /// Geometric normals, unit, outward.
    pub ng: [Row; 3],
    /// The diffuse share of each surface.
    pub albedo: [Row; 3],
    /// One bit a lane: something is met.
    pub found: u16,
    /// One bit a lane: what is met has no other lobe than the Lambertian one, no other normal than the geometric one, and is no
    /// mask.
    pub lambertian: u16,
}

impl SurfacePacket {
    /// Nothing is met.
    pub const NONE: SurfacePacket = SurfacePacket {
        p: [[0.0; PACKET]; 3],
        p_error: [0.0; PACKET],
        ng: [[0.0; PACKET]; 3],
        albedo: [[0.0; PACKET]; 3],
        found: 0,
        lambertian: 0,
    };

    #[inline(always)]
    fn set(&mut self, lane: usize, surface: &Geometry, albedo: Rgb) {
        for axis in 0..3 {
            self.p[axis][lane] = surface.p[axis];
            self.ng[axis][lane] = surface.ng[axis];
            self.albedo[axis][lane] = albedo[axis];
        }
        self.p_error[lane] = surface.p_error;
    }
}

impl Scene {
    /// Leaves in `surfaces` what a packet of rays meets.
    pub(crate) fn surfaces(&self, rays: &RayPacket, hits: &HitPacket, surfaces: &mut SurfacePacket) {
        let (mut found, mut lambertian) = (0, 0);
        for lane in 0..rays.len.min(PACKET) {
            let Some(hit) = hits.hit(lane) else { continue };
            let surface = self.surfaces[hit.geometry as usize].at(&rays.ray(lane), &hit);
            let (albedo, is_diffuse) = match self.gists[surface.material as usize] {
                Gist::Lambertian(albedo) => (albedo, true),
                Gist::Uniform(share) => (share, false),
                Gist::Rough => (Rgb::ZERO, false),
                Gist::Varying => self.diffuse_share(&rays.ray(lane), surface),
            };
            surfaces.set(lane, &surface, albedo);
            found |= 1 << lane;
            lambertian |= u16::from(is_diffuse && surface.ns == surface.ng) << lane;
        }
        (surfaces.found, surfaces.lambertian) = (found, lambertian);
    }

    /// The diffuse share of what is not the same everywhere, and whether it is Lambertian.
    // The surface by value: a reference would keep that of every lane in memory.
    #[inline(never)]
    fn diffuse_share(&self, ray: &Ray, surface: Geometry) -> (Rgb, bool) {
        let material = &self.materials[surface.material as usize];
        material.look(
            || surface.texture_coordinates(),
            |bsdf| match bsdf {
                Bsdf::Diffuse { albedo } => (*albedo, !material.is_mask()),
                bsdf => (bsdf.diffuse_share(cosine(ray, surface.ns)), false),
            },
        )
    }
}

/// Of the angle between a ray and a normal.
fn cosine(ray: &Ray, normal: Vec3) -> f32 {
    ray.dir.dot(normal).abs() / ray.dir.length()
}
