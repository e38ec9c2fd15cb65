//! What a scene is made of, and how it is read and written: scene files in TOML or the XML of Mitsuba 3, OBJ meshes with their
//! MTL materials, PLY meshes.
//!
//! [`load`] turns a scene file into a [`SceneDesc`]: plain data, fully checked and resolved, in scene units.
//! Whatever a file gets wrong comes back as a [`SceneError`] that names the place and what is allowed there;
//! whatever is repaired leaves a line in [`SceneDesc::warnings`]. [`Scene::new`] makes it traceable.
//!
#![doc = include_str!("../../docs/scenes.md")]
#![doc = include_str!("../../docs/formats.md")]

mod bodies;
mod casters;
mod compile;
mod desc;
mod direct;
mod error;
mod gist;
mod load;
mod media;
mod mesh;
mod names;
mod places;
mod save;
mod surface;
mod surface_hit;
mod surface_packet;
mod tracer;
pub mod water;

pub use crate::camera::PixelFilter;
pub use crate::embree::{Coherence, EmbreeError};
pub(crate) use crate::embree::{HitPacket, RayPacket, Row};
pub use desc::{
    CameraDesc, FilmDesc, LightDesc, Material, PointLightDesc, RenderDesc, SceneDesc, SphereDesc, Textures,
};
pub use direct::DirectIrradiance;
pub use error::SceneError;
pub use load::{Access, FilesRead, Limits, MeshMemory, load, load_with};
pub use media::Media;
pub use mesh::{Mesh, least_altitude};
pub use places::{Item, Places};
pub use save::{SaveError, SavedScene, normal_form, save};
pub use surface::keeps_clear_of_edges;
pub use surface_hit::{Receiver, SurfaceHit};
pub(crate) use surface_packet::SurfacePacket;
pub use tracer::{Traversal, TraversalError};

use std::sync::Arc;

use gist::Gist;
use media::Absorbers;
use surface::Surface;
use tracer::Tracer;

use crate::bsdf::{Bsdf, GlossyLobe, SPECULAR, Scattering, Transport};
use crate::camera::Camera;
use crate::embree::PACKET;
use crate::light::{Light, Lights};
use crate::math::{Aabb, BoundingSphere, Ray, Rgb, Rng, Vec2, Vec3};

/// A traceable scene: immutable, so that any number of threads may query it.
#[derive(Debug)]
pub struct Scene {
    /// Scenes of the same surfaces share it.
    rays: Arc<Tracer>,
    traversal: Traversal,
    surfaces: Vec<Surface>,
    materials: Vec<Material>,
    /// Of each material, what most paths need alone.
    gists: Vec<Gist>,
    /// Whether any material is a mask.
    has_masks: bool,
    absorbers: Absorbers,
    lights: Lights,
    camera: Camera,
    /// As the scene describes them, those without power, too.
    point_lights: Vec<PointLightDesc>,
    further_lights: Vec<LightDesc>,
    view: CameraDesc,
    film: FilmDesc,
    render: RenderDesc,
    bounds: Aabb,
    places: Places,
}

impl Scene {
    /// The nearest surface along `ray`.
    pub fn intersect(&self, ray: &Ray) -> Option<SurfaceHit> {
        let hit = self.rays.intersect(ray)?;
        let surface = self.surfaces[hit.geometry as usize].at(ray, &hit);
        Some(SurfaceHit::new(ray, hit.t, surface))
    }

    /// Calls `visit(k, hit)` with the nearest surface along `rays[k]`, in increasing order of those `k` that meet one.
    ///
    /// Faster than asking ray by ray, most of all where neighbours in `rays` start and point alike
    /// ([`Coherence::Coherent`]). The hits are those of [`Scene::intersect`] up to ties and rounding, and the same
    /// whenever the same rays come in the same order.
    pub fn intersect_all(
        &self,
        rays: &[Ray],
        coherence: Coherence,
        mut visit: impl FnMut(usize, &SurfaceHit),
    ) {
        let mut hits = HitPacket::none();
        for (packet, rays) in rays.chunks(PACKET).enumerate() {
            let rays = RayPacket::of(rays);
            self.intersect_packet(&rays, &mut hits, coherence);
            for lane in 0..rays.len {
                if let Some(hit) = self.surface_hit(&rays, &hits, lane) {
                    visit(packet * PACKET + lane, &hit);
                }
            }
        }
    }

    /// Leaves in `hits` what a packet of rays meets: as [`Scene::intersect_all`], for [`Scene::surfaces`] or
    /// [`Scene::surface_hit`] to look at.
    pub(crate) fn intersect_packet(&self, rays: &RayPacket, hits: &mut HitPacket, coherence: Coherence) {
        self.rays.intersect_packet(rays, hits, coherence);
    }

    /// The surface that one ray of a packet meets.
    // Inlined for the same reason as `Surface::at`.
    #[inline(always)]
    pub(crate) fn surface_hit(&self, rays: &RayPacket, hits: &HitPacket, lane: usize) -> Option<SurfaceHit> {
        let (hit, ray) = (hits.hit(lane)?, rays.ray(lane));
        let surface = self.surfaces[hit.geometry as usize].at(&ray, &hit);
        Some(SurfaceHit::new(&ray, hit.t, surface))
    }

    /// Whether anything lies on `ray`; shadow rays take water and glass for opaque.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.rays.occluded(ray)
    }

    /// Who answers [`Scene::intersect`] and [`Scene::occluded`].
    pub fn traversal(&self) -> Traversal {
        self.traversal
    }

    /// How far the nearest surface along `ray` is, in lengths of its direction: the bare query, without what is there.
    pub fn distance(&self, ray: &Ray) -> Option<f32> {
        self.rays.intersect(ray).map(|hit| hit.t)
    }

    /// What `of` says of how the surface at `hit` scatters.
    #[inline(always)]
    fn look<R>(&self, hit: &SurfaceHit, of: impl FnOnce(&Bsdf) -> R) -> R {
        self.materials[hit.material as usize].look(|| hit.texture_coordinates(), of)
    }

    /// The diffuse share of the surface at `hit` as it is seen: see [`Bsdf::albedo`].
    pub fn albedo(&self, hit: &SurfaceHit) -> Rgb {
        match self.gists[hit.material as usize] {
            Gist::Lambertian(albedo) | Gist::Uniform(albedo) => albedo,
            Gist::Rough => Rgb::ZERO,
            Gist::Varying => self.look(hit, |bsdf| bsdf.albedo(hit.normal.dot(hit.wo))),
        }
    }

    /// The surface at `hit` as light arrives there that is seen along `hit.wo`.
    pub fn receiver(&self, hit: &SurfaceHit) -> Receiver {
        match self.gists[hit.material as usize] {
            Gist::Lambertian(_) | Gist::Uniform(_) | Gist::Rough => hit.receiver(),
            Gist::Varying => hit.receiver().under(self.look(hit, Bsdf::coat)),
        }
    }

    /// All lobes of the surface at `hit` for a path that arrives there; none of a rough one ([`Scene::scatter_by`]).
    pub fn scatter(&self, hit: &SurfaceHit, transport: Transport) -> Scattering {
        // The frame is the dearest part, and a diffuse surface has no use for it.
        if let Gist::Lambertian(albedo) = self.gists[hit.material as usize] {
            return Scattering::diffuse(albedo);
        }
        self.look(hit, |bsdf| match bsdf {
            bsdf if !SPECULAR => Scattering::diffuse(bsdf.albedo(1.0)),
            Bsdf::Diffuse { albedo } => Scattering::diffuse(*albedo),
            bsdf => bsdf.scatter(hit.wo_local(), transport),
        })
    }

    /// The same by a facet where the surface is rough, which `u` draws: two numbers of the unit square.
    // Inlined for the same reason as `Scene::glossy`.
    #[inline(always)]
    pub fn scatter_by(&self, hit: &SurfaceHit, transport: Transport, u: impl FnOnce() -> Vec2) -> Scattering {
        if self.is_rough(hit) {
            self.look(hit, |bsdf| bsdf.scatter_by(hit.wo_local(), transport, u))
        } else {
            self.scatter(hit, transport)
        }
    }

    /// The rough share of the surface at `hit`, for a path that arrives there.
    // Inlined, since most surfaces are smooth.
    #[inline(always)]
    pub fn glossy(&self, hit: &SurfaceHit, transport: Transport) -> Option<GlossyLobe> {
        if self.is_rough(hit) { self.rough_share(hit, transport) } else { None }
    }

    #[inline(never)]
    fn rough_share(&self, hit: &SurfaceHit, transport: Transport) -> Option<GlossyLobe> {
        self.look(hit, |bsdf| bsdf.glossy(hit.wo_local(), transport))
    }

    /// Whether the surface at `hit` is nothing but facets.
    pub fn is_rough(&self, hit: &SurfaceHit) -> bool {
        self.gists[hit.material as usize] == Gist::Rough
    }

    /// The radiance from where a ray points that meets nothing.
    pub fn sky(&self, ray: &Ray) -> Rgb {
        self.lights.environment().map_or(Rgb::ZERO, |around| around.radiance(ray.dir.normalize()))
    }

    /// The radiance that the surface itself sends along `wo`: one-sided.
    pub fn emission(&self, hit: &SurfaceHit) -> Rgb {
        if hit.is_front() { self.materials[hit.material as usize].emission } else { Rgb::ZERO }
    }

    /// How many triangles and spheres there are.
    pub fn primitives(&self) -> usize {
        self.surfaces.iter().map(Surface::primitives).sum()
    }

    /// The materials, by number.
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// Whether any surface is rough. Linear in the number of triangles where the scene has such a material.
    pub fn any_glossy(&self) -> bool {
        let rough = |material: u32| matches!(self.materials[material as usize].bsdf, Bsdf::Rough(_));
        (0..self.materials.len() as u32).any(rough)
            && (self.meshes().any(|mesh| mesh.materials.iter().any(|&material| rough(material)))
                || self.spheres().iter().any(|sphere| rough(sphere.material)))
    }

    /// Whether any surface mirrors, refracts, or is a mask.
    pub fn any_specular(&self) -> bool {
        self.has_masks || self.materials.iter().any(|material| material.bsdf.is_specular())
    }

    /// Whether any surface is a mask: has an opacity below 1.
    pub fn has_masks(&self) -> bool {
        self.has_masks
    }

    /// The share of light that meets the surface at `hit`; the rest goes straight on: see [`SurfaceHit::pass`].
    #[inline(always)]
    pub fn opacity(&self, hit: &SurfaceHit) -> f32 {
        if !self.has_masks {
            return 1.0;
        }
        self.materials[hit.material as usize].opacity_at(|| hit.texture_coordinates())
    }

    /// Whether a path goes straight through the surface at `hit`, by roulette. Nothing is drawn where the surface is opaque.
    #[inline(always)]
    pub fn passes(&self, hit: &SurfaceHit, rng: &mut Rng) -> bool {
        let opacity = self.opacity(hit);
        opacity < 1.0 && rng.next_f32() >= opacity
    }

    /// The lights with power.
    pub fn lights(&self) -> &Lights {
        &self.lights
    }

    /// The point lights by number, those without power, too.
    pub fn point_lights(&self) -> &[PointLightDesc] {
        &self.point_lights
    }

    /// The lights that belong to no surface, those without power, too, in the order of the description.
    pub fn free_lights(&self) -> Vec<(Item, Light)> {
        let ball = ball(self.bounds);
        let points = self.point_lights.iter().zip(0..).map(|(l, n)| (Item::PointLight(n), l.light()));
        let further =
            self.further_lights.iter().zip(0..).map(|(l, n)| (Item::FurtherLight(n), l.light(ball)));
        points.chain(further).collect()
    }

    /// The meshes, by number.
    pub fn meshes(&self) -> impl Iterator<Item = &Mesh> {
        self.surfaces.iter().filter_map(Surface::mesh)
    }

    /// The spheres, by number.
    pub fn spheres(&self) -> &[SphereDesc] {
        self.surfaces.last().map_or(&[], Surface::spheres)
    }

    /// The camera as the scene describes it.
    pub fn view(&self) -> &CameraDesc {
        &self.view
    }

    /// The camera.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// The size of the picture.
    pub fn film(&self) -> FilmDesc {
        self.film
    }

    /// The render settings that the scene file asks for.
    pub fn render(&self) -> &RenderDesc {
        &self.render
    }

    /// The box around all surfaces.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }
}

/// What light from afar enters by: around all surfaces, or any where there are none.
fn ball(bounds: Aabb) -> BoundingSphere {
    if bounds.is_empty() {
        return BoundingSphere { center: Vec3::ZERO, radius: 1.0 };
    }
    BoundingSphere::around([(bounds.min, 0.0), (bounds.max, 0.0)])
}
