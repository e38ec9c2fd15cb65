//! Scenes as TOML.

use std::fmt::{Display, Write};

use super::super::{CameraDesc, FilmDesc, LightDesc, Material, RenderDesc, SceneDesc, Textures};
use super::degrees::degrees;
use super::pictures::Pictures;
use super::ply::mesh_file;
use super::quads::quad_corners;
use super::{SaveError, SavedScene, ply};
use crate::bsdf::{Bsdf, Interface, Plastic, RoughSurface};
use crate::math::{Rgb, Vec3};
use crate::texture::Encoding;

/// A scene in normal form; its meshes go into `folder`.
pub(super) fn write(desc: &SceneDesc, folder: &str, mut pictures: Pictures) -> Result<SavedScene, SaveError> {
    let mut text = Text(String::new());
    text.film(&desc.film);
    text.camera(&desc.camera);
    text.render(&desc.render);
    desc.materials.iter().try_for_each(|material| text.material(material, &mut pictures))?;
    for light in &desc.point_lights {
        text.table("[point_light]");
        text.field("position", vector(light.position));
        text.field("intensity", vector(light.intensity));
    }
    desc.further_lights.iter().try_for_each(|light| text.further_light(light, &mut pictures))?;
    let name = |material: u32| quoted(&desc.materials[material as usize].name);
    for sphere in &desc.spheres {
        text.table("[sphere]");
        text.field("center", vector(sphere.center));
        text.field("radius", number(sphere.radius));
        text.field("material", name(sphere.material));
    }
    let mut meshes = Vec::new();
    for mesh in &desc.meshes {
        let material = name(mesh.materials.first().copied().unwrap_or(0));
        match quad_corners(mesh) {
            Some(corners) => {
                text.table("[quad]");
                text.field("corners", format!("[{}]", corners.map(vector).join(", ")));
            }
            None => {
                let file = mesh_file(folder, meshes.len() + 1);
                text.table("[mesh]");
                text.field("file", quoted(&file.to_string_lossy()));
                text.field("normals", quoted(if mesh.normals.is_some() { "file" } else { "flat" }));
                meshes.push((file, ply::write(mesh)));
            }
        }
        text.field("material", material);
    }
    Ok(SavedScene { text: text.0, meshes, pictures: pictures.into_files(), warnings: Vec::new() })
}

struct Text(String);

impl Text {
    fn table(&mut self, name: &str) {
        let blank = if self.0.is_empty() { "" } else { "\n" };
        self.line(format_args!("{blank}[{name}]"));
    }

    fn field(&mut self, name: &str, value: impl Display) {
        self.line(format_args!("{name} = {value}"));
    }

    fn line(&mut self, line: impl Display) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.0, "{line}");
    }

    fn film(&mut self, film: &FilmDesc) {
        self.table("film");
        self.field("width", film.width);
        self.field("height", film.height);
        self.field("filter", quoted(film.filter.name()));
    }

    fn camera(&mut self, camera: &CameraDesc) {
        self.table("camera");
        self.field("position", vector(camera.position));
        self.field("look_at", vector(camera.look_at));
        self.field("up", vector(camera.up));
        self.field("fov", number(camera.fov_degrees));
        if camera.lens_radius > 0.0 {
            self.field("lens_radius", number(camera.lens_radius));
            self.field("focus_distance", number(camera.focus_distance));
        }
    }

    fn render(&mut self, render: &RenderDesc) {
        self.table("render");
        self.field("passes", render.passes);
        self.field("photons", render.photons);
        self.field("samples", render.samples);
        self.field("alpha", format_args!("{:?}", render.alpha));
        if let Some(radius) = render.radius {
            self.field("radius", format_args!("{radius:?}"));
        }
        self.field("depth", render.depth);
    }

    fn further_light(&mut self, light: &LightDesc, pictures: &mut Pictures) -> Result<(), SaveError> {
        match light {
            LightDesc::Spot(spot) => {
                self.table("[spot_light]");
                self.field("position", vector(spot.position));
                self.field("direction", vector(spot.axis));
                self.field("intensity", vector(spot.intensity));
                self.field("inner", number(degrees(spot.inner)));
                self.field("outer", number(degrees(spot.outer)));
            }
            LightDesc::Distant { direction, irradiance } => {
                self.table("[distant_light]");
                self.field("direction", vector(*direction));
                self.field("irradiance", vector(*irradiance));
            }
            LightDesc::Sky(radiance) => {
                self.table("environment");
                self.field("radiance", vector(*radiance));
            }
            LightDesc::Panorama { file, panorama } => {
                self.table("environment");
                self.field("file", quoted(&pictures.copy(file)?));
                self.field("scale", number(panorama.scale()));
                self.field("turn", number(degrees(panorama.turn())));
            }
        }
        Ok(())
    }

    fn material(&mut self, material: &Material, pictures: &mut Pictures) -> Result<(), SaveError> {
        self.table(&format!("material.{}", quoted(&material.name)));
        let (kind, mut values) = bsdf(&material.bsdf);
        put_pictures(&material.textures, &mut values, pictures)?;
        self.field(kind, format_args!("{{ {values} }}"));
        if material.emission != Rgb::ZERO {
            self.field("emission", vector(material.emission));
        }
        if material.absorption != Rgb::ZERO {
            self.field("absorption", vector(material.absorption));
        }
        match &material.textures.opacity {
            Some(texture) => self.field("opacity", quoted(&pictures.texture(texture, Encoding::Opacity)?)),
            None if material.opacity < 1.0 => self.field("opacity", number(material.opacity)),
            None => (),
        }
        Ok(())
    }
}

/// Puts the names of pictures in the place of the constants that stand for them.
fn put_pictures(textures: &Textures, values: &mut String, pictures: &mut Pictures) -> Result<(), SaveError> {
    let colors = ["albedo", "reflectance", "base", "color"];
    let put = |values: &mut String, name: &str, picture: &str| {
        let start = values.find(&format!("{name} = "));
        let Some(at) = start.map(|start| start + name.len() + 3) else { return };
        let rest = &values[at..];
        let end = if rest.starts_with('[') { rest.find(']').map(|end| end + 1) } else { rest.find(',') };
        let end = at + end.unwrap_or(rest.len());
        values.replace_range(at..end, &quoted(picture));
    };
    if let Some(texture) = &textures.color {
        let picture = pictures.texture(texture, Encoding::Colour)?;
        colors.iter().for_each(|name| put(values, name, &picture));
    }
    if let Some(texture) = &textures.roughness {
        put(values, "roughness", &pictures.texture(texture, Encoding::Plain)?);
    }
    Ok(())
}

/// The kind of a surface and its fields.
fn bsdf(bsdf: &Bsdf) -> (&'static str, String) {
    match *bsdf {
        Bsdf::Diffuse { albedo } => ("diffuse", format!("albedo = {}", vector(albedo))),
        Bsdf::Mirror { reflectance } => ("mirror", format!("reflectance = {}", vector(reflectance))),
        Bsdf::Dielectric { ior } => ("dielectric", format!("ior = {}", number(ior))),
        Bsdf::ThinDielectric { ior } => ("thin_dielectric", format!("ior = {}", number(ior))),
        Bsdf::Conductor { eta, k, reflectance } => ("conductor", metal(eta, k, reflectance)),
        Bsdf::Rough(RoughSurface { facets, interface }) => {
            let roughness = format!("roughness = {}", number(facets.alpha));
            match interface {
                Interface::Conductor { eta, k, reflectance } => {
                    ("rough_conductor", format!("{roughness}, {}", metal(eta, k, reflectance)))
                }
                Interface::Dielectric { ior } => {
                    ("rough_dielectric", format!("{roughness}, ior = {}", number(ior)))
                }
            }
        }
        Bsdf::Plastic(Plastic { base, ior, nonlinear, .. }) => {
            ("plastic", format!("base = {}, ior = {}, nonlinear = {nonlinear}", vector(base), number(ior)))
        }
        Bsdf::FixedWeight { color, reflectivity, transparency, ior } => (
            "fixed_weight",
            format!(
                "color = {}, reflectivity = {}, transparency = {}, ior = {}",
                vector(color),
                number(reflectivity),
                number(transparency),
                number(ior)
            ),
        ),
    }
}

fn metal(eta: Rgb, k: Rgb, reflectance: Rgb) -> String {
    format!("eta = {}, k = {}, reflectance = {}", vector(eta), vector(k), vector(reflectance))
}

/// The shortest decimal that comes back as the same f32.
fn number(x: f32) -> String {
    format!("{x:?}")
}

fn vector(v: Vec3) -> String {
    format!("[{}]", v.to_array().map(number).join(", "))
}

/// As JSON writes it, which is one of the ways of TOML but for DEL.
fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string().replace('\u{7f}', "\\u007F")
}
