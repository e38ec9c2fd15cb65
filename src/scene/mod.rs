//! What a scene is made of, and how it is read: TOML scene files, OBJ meshes with their MTL materials.
//!
//! [`load`] turns a scene file into a [`SceneDesc`]: plain data, fully checked and resolved, in scene units.
//! Whatever a file gets wrong comes back as a [`SceneError`] that names the place and what is allowed there;
//! whatever is repaired leaves a line in [`SceneDesc::warnings`]. [`Scene::new`] makes it traceable.
//!
//! # Scene files
//! TOML, with every key checked; whole numbers are welcome where floats are expected. Lengths are in scene units
//! of the user's choice, y is up by default, and hands are right.
//!
//! ```toml
//! [film]                     # optional
//! width = 512                # 1 to 16384, default 512
//! height = 512
//!
//! [camera]
//! position = [0, 60, 180]
//! look_at = [0, 60, 0]
//! up = [0, 1, 0]             # the default
//! fov = 52                   # degrees, horizontal, full angle
//!
//! [render]                   # optional; defaults:
//! passes = 64
//! photons = 100000           # a pass
//! samples = 4                # eye paths a pixel
//! alpha = 0.7                # share of photons kept, above 0, up to 1
//! radius = 0.5               # no default: without it, it follows from the scene
//! depth = 12                 # longest chain of specular events on an eye path
//!
//! [material.water]           # exactly one of diffuse, mirror, dielectric, fixed_weight
//! # diffuse = { albedo = [0.7, 0.7, 0.7] }
//! # mirror = { reflectance = [0.9, 0.9, 0.9] }
//! # dielectric = { ior = 1.5 }
//! fixed_weight = { color = [0.6, 0.6, 0.7], reflectivity = 0.2, transparency = 0.7, ior = 1.33 }
//! emission = [0, 0, 0]       # optional, W/m²/sr, on the geometric normal's side; not for spheres
//!
//! [[point_light]]
//! position = [0, 108, 0]
//! intensity = [6000, 6000, 6000] # W/sr
//!
//! [[sphere]]
//! center = [23.5, 16.5, 31]
//! radius = 16.5
//! material = "water"
//!
//! [[quad]]                   # two triangles, corners 0 1 2 and 0 2 3
//! corners = [[0, 0, 0], [0, 0, 9], [9, 0, 9], [9, 0, 0]] # in order; normal by the right hand
//! material = "water"
//!
//! [[mesh]]
//! file = "surface.obj"       # relative to the scene file
//! scale = 120                # or [x, y, z]; first scale, then rotate, then translate
//! rotate = { axis = [0, 1, 0], degrees = 30 } # counter-clockwise when the axis points at the viewer
//! translate = [0, 50, 0]
//! normals = "smooth"         # or "flat" or "file"; default "file" if the file has any, else "flat"
//! material = "water"         # without it, the file's own materials count
//! ```
//!
//! # Meshes
//! An OBJ file is read for its vertices, normals, faces and materials. A byte order mark, CRLF, a missing last
//! newline, a `\` that continues a line, negative indices and comments behind values are all in order.
//!
//! | in the file | what happens |
//! |---|---|
//! | texture coordinates, vertex colours, groups, smoothing groups | not used |
//! | a vertex with a weight `w` | divided by it; `w = 0` is refused with its line |
//! | a coordinate that is no number, not finite or beyond ±1.8e18 | refused with its line |
//! | an index that is 0, no whole number or out of range | refused with its line |
//! | points, lines, faces of 1 or 2 vertices | ignored, with a warning and their count |
//! | a face of 4 or more vertices | a fan from its first vertex if convex, else ears are clipped |
//! | a concave face of more than 1024 vertices | refused with its line |
//! | triangles without area | dropped, with a warning and their count |
//! | no triangle left | refused |
//! | UTF-16, NUL bytes | refused |
//! | bytes that are not UTF-8, as in old comments | replaced by U+FFFD |
//! | vertex normals that are zero or not finite, corners without one | the smooth normal of the faces around |
//!
//! A scale with a negative determinant mirrors the mesh; the winding is flipped with it, so that normals that
//! pointed outward still do.
//!
//! # Materials of MTL files
//! They count where the scene file gives a mesh no material of its own. The first row that fits decides:
//!
//! | MTL | surface |
//! |---|---|
//! | `illum` 4, 6, 7 or 9 | dielectric, `ior = Ni`; 1.5 with a warning where `Ni` is missing or not above 0 |
//! | `illum` 3, or `illum` 5 with `Kd` 0 and `Ks` above 0 | mirror of reflectance `Ks` |
//! | `Kd` | diffuse of albedo `Kd` |
//! | nothing of these | diffuse grey of albedo 0.5, with a warning |
//! | missing or unreadable file, unknown material, no `usemtl` | diffuse grey of albedo 0.5, with a warning |
//! | `Ke` | emission, beside any of the above |
//! | `Kd` or `Ks` outside 0 to 1, `Ke` below 0 | clamped, with a warning |
//! | `map_Kd` | not read, with a warning |
//! | a line whose numbers cannot be read | ignored, with a warning |

mod compile;
mod desc;
mod direct;
mod error;
mod load;
mod mesh;
mod surface;
pub mod water;

pub use desc::{CameraDesc, FilmDesc, Material, PointLightDesc, RenderDesc, SceneDesc, SphereDesc};
pub use direct::DirectLight;
pub use error::SceneError;
pub use load::load;
pub use mesh::Mesh;
pub use surface::{Receiver, SurfaceHit};

use surface::Surface;

use crate::bsdf::{Scattering, Transport};
use crate::camera::Camera;
use crate::embree;
use crate::light::Lights;
use crate::math::{Aabb, Ray, Rgb};

/// A traceable scene: immutable, so that any number of threads may query it.
#[derive(Debug)]
pub struct Scene {
    rays: embree::Scene,
    surfaces: Vec<Surface>,
    materials: Vec<Material>,
    lights: Lights,
    camera: Camera,
    film: FilmDesc,
    render: RenderDesc,
    bounds: Aabb,
}

impl Scene {
    /// The nearest surface along `ray`.
    pub fn intersect(&self, ray: &Ray) -> Option<SurfaceHit> {
        let hit = self.rays.intersect(ray)?;
        let surface = self.surfaces[hit.geometry as usize].at(ray, &hit);
        Some(SurfaceHit::new(ray, hit.t, surface))
    }

    /// Whether anything lies on `ray`; shadow rays take water and glass for opaque.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.rays.occluded(ray)
    }

    /// All lobes of the surface at `hit` for a path that arrives there.
    pub fn scatter(&self, hit: &SurfaceHit, transport: Transport) -> Scattering {
        self.materials[hit.material as usize].bsdf.scatter(hit.wo_local(), transport)
    }

    /// The radiance that the surface itself sends along `wo`: one-sided.
    pub fn emission(&self, hit: &SurfaceHit) -> Rgb {
        if hit.is_front() { self.materials[hit.material as usize].emission } else { Rgb::ZERO }
    }

    /// The materials, by number.
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// The lights with power.
    pub fn lights(&self) -> &Lights {
        &self.lights
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
