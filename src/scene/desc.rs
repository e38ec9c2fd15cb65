use std::path::PathBuf;
use std::sync::Arc;

use super::{Mesh, Places};
use crate::bsdf::Bsdf;
use crate::camera::PixelFilter;
use crate::light::{Distant, Environment, Light, Panorama, Spot};
use crate::math::{BoundingSphere, Rgb, Vec2, Vec3};
use crate::texture::Texture;

/// A scene as its files describe it: checked, resolved and in scene units, but not yet traceable.
///
/// Every number is finite and in the range that the file format allows, and every material index is valid.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneDesc {
    /// The stem of the file's name.
    pub name: String,
    /// The scene file, as it was asked for.
    pub path: PathBuf,
    /// The picture.
    pub film: FilmDesc,
    /// The point of view.
    pub camera: CameraDesc,
    /// How to render unless the command line says otherwise.
    pub render: RenderDesc,
    /// The scene file's materials in its order, then those that meshes took from their MTL files.
    pub materials: Vec<Material>,
    /// Exact spheres.
    pub spheres: Vec<SphereDesc>,
    /// The quads in the order of the file, then the meshes.
    pub meshes: Vec<Mesh>,
    /// Point lights.
    pub point_lights: Vec<PointLightDesc>,
    /// Lights of other kinds that belong to no surface.
    pub further_lights: Vec<LightDesc>,
    /// What was repaired or looks like a mistake; each entry names its file.
    pub warnings: Vec<String>,
    /// Where the file describes all that.
    pub places: Places,
}

impl SceneDesc {
    /// Nothing at all in front of `camera`, on a film of 512 x 512 pixels: to be filled field by field, and made traceable by
    /// [`Scene::new`](super::Scene::new).
    pub fn new(camera: CameraDesc) -> SceneDesc {
        SceneDesc {
            name: "scene".into(),
            path: PathBuf::new(),
            film: FilmDesc::new(512, 512),
            camera,
            render: RenderDesc::default(),
            materials: Vec::new(),
            spheres: Vec::new(),
            meshes: Vec::new(),
            point_lights: Vec::new(),
            further_lights: Vec::new(),
            warnings: Vec::new(),
            places: Places::default(),
        }
    }

    /// The same without a line of any item: for a description that is no file's any more.
    #[must_use]
    pub fn without_places(self) -> SceneDesc {
        SceneDesc { places: Places::default(), ..self }
    }

    /// Makes the scene `scale` times as large, then moves it by `shift`; lights and absorption change so that
    /// every radiance stays.
    pub fn place(&mut self, scale: f32, shift: Vec3) {
        let place = |p: &mut Vec3| *p = *p * scale + shift;
        self.meshes.iter_mut().flat_map(|mesh| &mut mesh.vertices).for_each(place);
        for sphere in &mut self.spheres {
            place(&mut sphere.center);
            sphere.radius *= scale;
        }
        for light in &mut self.point_lights {
            place(&mut light.position);
            light.intensity *= scale * scale;
        }
        for light in &mut self.further_lights {
            if let LightDesc::Spot(spot) = light {
                place(&mut spot.position);
                spot.intensity *= scale * scale;
            }
        }
        self.materials.iter_mut().for_each(|material| material.absorption /= scale);
        place(&mut self.camera.position);
        place(&mut self.camera.look_at);
        self.camera.lens_radius *= scale;
        self.camera.focus_distance *= scale;
        self.render.radius = self.render.radius.map(|radius| radius * f64::from(scale));
    }
}

/// The size of the picture, and how its pixels weigh light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FilmDesc {
    /// Pixels in a row, from 1 to 16384.
    pub width: u32,
    /// Rows, from 1 to 16384.
    pub height: u32,
    /// The filter of every pixel.
    pub filter: PixelFilter,
}

impl FilmDesc {
    /// A picture of `width` x `height` pixels, each the mean of points.
    pub fn new(width: u32, height: u32) -> FilmDesc {
        FilmDesc { width, height, filter: PixelFilter::Points }
    }

    /// How many pixels the picture has.
    pub fn pixels(self) -> usize {
        self.width as usize * self.height as usize
    }

    /// The same film in another size: width and height.
    pub fn resized(self, (width, height): (u32, u32)) -> FilmDesc {
        FilmDesc { width, height, ..self }
    }
}

/// A camera. `position` differs from `look_at`, and `up` is not parallel to the view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraDesc {
    /// The pinhole, or the middle of the lens.
    pub position: Vec3,
    /// A point on the axis of view.
    pub look_at: Vec3,
    /// A direction that points up in the picture; not necessarily unit.
    pub up: Vec3,
    /// The horizontal full angle of view, above 0 and below 180.
    pub fov_degrees: f32,
    /// The radius of the lens in scene units; 0 is a pinhole.
    pub lens_radius: f32,
    /// How far from the lens the picture is sharp, along the axis of view, in scene units; above 0.
    pub focus_distance: f32,
}

impl CameraDesc {
    /// A pinhole at `position` that looks at `look_at`; y is up. A lens that it is given is sharp there.
    pub fn pinhole(position: Vec3, look_at: Vec3, fov_degrees: f32) -> CameraDesc {
        let focus_distance = (look_at.as_dvec3() - position.as_dvec3()).length() as f32;
        CameraDesc { position, look_at, up: Vec3::Y, fov_degrees, lens_radius: 0.0, focus_distance }
    }
}

/// The parameters of progressive photon mapping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderDesc {
    /// Photon passes.
    pub passes: u32,
    /// Photons emitted in a pass.
    pub photons: u64,
    /// Eye paths of a pixel, from 1 to 4096.
    pub samples: u32,
    /// The share of a pass's photons that is kept, above 0 and up to 1.
    pub alpha: f64,
    /// The first gather radius in scene units, where the file gives one.
    pub radius: Option<f64>,
    /// The longest chain of specular events on an eye path.
    pub depth: u32,
}

impl Default for RenderDesc {
    /// What scene files that say nothing else ask for: 64 passes of 100,000 photons, 4 samples, alpha 0.7, depth 12, and a
    /// radius that follows from what is seen.
    fn default() -> RenderDesc {
        RenderDesc { passes: 64, photons: 100_000, samples: 4, alpha: 0.7, radius: None, depth: 12 }
    }
}

/// A named surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The name in the scene file, or `MESH FILE:NAME` for a material of an MTL file.
    pub name: String,
    /// How it scatters.
    pub bsdf: Bsdf,
    /// Radiance (W/m²/sr) that leaves on the geometric normal's side.
    pub emission: Rgb,
    /// The share of light that meets the surface at all, from 0 to 1; the rest goes straight on as if nothing were there. What it
    /// emits is no less for that.
    pub opacity: f32,
    /// `σ` of what lies inside (1 / scene unit): the share `exp(-σ d)` of light is left after the distance `d`. Of materials that have an
    /// inside: see [`Bsdf::ior`].
    pub absorption: Rgb,
    /// Pictures that take the place of constants. Those are the largest values then, so that what a material can do at all is
    /// said by its constants.
    pub textures: Textures,
}

/// What of a material changes over a surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Textures {
    /// The colour: see [`Bsdf::with_color`].
    pub color: Option<Arc<Texture>>,
    /// The roughness, by the first channel: see [`Bsdf::with_roughness`].
    pub roughness: Option<Arc<Texture>>,
    /// The opacity, by the first channel.
    pub opacity: Option<Arc<Texture>>,
}

impl Textures {
    /// No pictures.
    pub const NONE: Textures = Textures { color: None, roughness: None, opacity: None };

    pub(super) fn is_none(&self) -> bool {
        self.are_plain() && self.opacity.is_none()
    }

    /// Whether the surface scatters alike everywhere.
    #[inline(always)]
    pub(super) fn are_plain(&self) -> bool {
        self.color.is_none() && self.roughness.is_none()
    }
}

impl Material {
    /// One that is the same everywhere.
    pub fn plain(name: impl Into<String>, bsdf: Bsdf, emission: Rgb) -> Material {
        Material {
            name: name.into(),
            bsdf,
            emission,
            opacity: 1.0,
            absorption: Rgb::ZERO,
            textures: Textures::NONE,
        }
    }

    /// What `of` says of how it scatters at a place, whose texture coordinates are asked for only if pictures need them.
    #[inline(always)]
    pub fn look<R>(&self, uv: impl FnOnce() -> Vec2, of: impl FnOnce(&Bsdf) -> R) -> R {
        if self.textures.are_plain() { of(&self.bsdf) } else { of(&self.textured(uv())) }
    }

    fn textured(&self, uv: Vec2) -> Bsdf {
        let Textures { color, roughness, opacity: _ } = &self.textures;
        let bsdf = color.as_ref().map_or(self.bsdf, |texture| self.bsdf.with_color(texture.at(uv)));
        roughness.as_ref().map_or(bsdf, |texture| bsdf.with_roughness(texture.at(uv).x))
    }

    /// The absorption of what lies behind the surface, where there is an inside.
    pub fn inside(&self) -> Option<Rgb> {
        self.bsdf.ior().map(|_| self.absorption)
    }

    /// Whether light may go through it as if nothing were there.
    pub fn is_mask(&self) -> bool {
        self.opacity < 1.0 || self.textures.opacity.is_some()
    }

    /// Whether light goes on behind it, refracted or as if nothing were there.
    pub fn transmits(&self) -> bool {
        self.is_mask() || self.bsdf.transmits()
    }

    /// The opacity at a place, whose texture coordinates are asked for only if a picture needs them.
    pub(super) fn opacity_at(&self, uv: impl FnOnce() -> Vec2) -> f32 {
        match &self.textures.opacity {
            Some(texture) => texture.at(uv()).x.clamp(0.0, 1.0),
            None => self.opacity,
        }
    }
}

/// A sphere whose normals point outward.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereDesc {
    /// Its middle.
    pub center: Vec3,
    /// Its radius, above 0.
    pub radius: f32,
    /// Index into [`SceneDesc::materials`].
    pub material: u32,
}

/// A light without extent that shines evenly in all directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLightDesc {
    /// Where it is.
    pub position: Vec3,
    /// Radiant intensity (W/sr).
    pub intensity: Rgb,
}

/// A light that belongs to no surface and is not a point that shines evenly.
#[derive(Clone, Debug, PartialEq)]
pub enum LightDesc {
    /// A point that shines into a cone.
    Spot(Spot),
    /// Light from so far away that its rays are parallel.
    Distant {
        /// Where the light goes, unit.
        direction: Vec3,
        /// Irradiance on a surface that faces it (W/m²).
        irradiance: Rgb,
    },
    /// The same radiance (W/m²/sr) from everywhere.
    Sky(Rgb),
    /// Radiance by a picture of all directions.
    Panorama {
        /// The file of the picture, as it was asked for.
        file: PathBuf,
        /// What it holds.
        panorama: Arc<Panorama>,
    },
}

impl LightDesc {
    /// What people call its kind: its table in a scene file.
    pub fn kind(&self) -> &'static str {
        match self {
            LightDesc::Spot(_) => "spot_light",
            LightDesc::Distant { .. } => "distant_light",
            LightDesc::Sky(_) | LightDesc::Panorama { .. } => "environment",
        }
    }

    /// The light around or into a scene that lies in `ball`.
    pub(super) fn light(&self, ball: BoundingSphere) -> Light {
        match self {
            LightDesc::Spot(spot) => Light::Spot(*spot),
            LightDesc::Distant { direction, irradiance } => {
                Light::Distant(Distant { direction: *direction, irradiance: *irradiance, ball })
            }
            LightDesc::Sky(radiance) => Light::Environment(Environment::constant(*radiance, ball).into()),
            LightDesc::Panorama { panorama, .. } => {
                Light::Environment(Environment::picture((**panorama).clone(), ball).into())
            }
        }
    }
}

impl PointLightDesc {
    pub(super) fn light(&self) -> Light {
        Light::Point { position: self.position, intensity: self.intensity }
    }
}
