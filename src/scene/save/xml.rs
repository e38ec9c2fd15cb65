//! Scenes as Mitsuba 3's XML. What Mitsuba has no word for stands in processing instructions, which it skips.

use std::collections::BTreeSet;
use std::fmt::{Display, Write};

use glam::DAffine3;

use super::super::{
    CameraDesc, FilmDesc, LightDesc, Material, Mesh, PixelFilter, RenderDesc, SceneDesc, Textures,
};
use super::normal_form::unique;
use super::{SaveError, SavedScene, degrees, mesh_file, ply, quad_corners, whole_path};
use crate::bsdf::{Bsdf, Interface, Plastic, RoughSurface};
use crate::math::{DVec3, Rgb, Vec3};

/// A scene in normal form; its meshes go into `folder`.
pub(super) fn write(desc: &SceneDesc, folder: &str, lenient: bool) -> Result<SavedScene, SaveError> {
    let mut writer =
        Writer { text: String::new(), ids: Vec::new(), meshes: Vec::new(), warnings: Vec::new(), lenient };
    writer.line("<scene version=\"3.0.0\">");
    writer.render(&desc.render);
    let absorbs = desc.materials.iter().any(|material| material.absorption != Rgb::ZERO);
    writer.line(format_args!("<integrator type=\"{}\"/>", if absorbs { "volpath" } else { "path" }));
    writer.sensor(&desc.camera, &desc.film);
    writer.materials(desc)?;
    for light in &desc.point_lights {
        writer.line("<emitter type=\"point\">");
        writer.line(format_args!("    <point name=\"position\" value=\"{}\"/>", vector(light.position)));
        writer.line(format_args!("    <rgb name=\"intensity\" value=\"{}\"/>", vector(light.intensity)));
        writer.line("</emitter>");
    }
    desc.further_lights.iter().for_each(|light| writer.further_light(light));
    for sphere in &desc.spheres {
        writer.line("<shape type=\"sphere\">");
        writer.line(format_args!("    <point name=\"center\" value=\"{}\"/>", vector(sphere.center)));
        writer.line(format_args!("    <float name=\"radius\" value=\"{:?}\"/>", sphere.radius));
        writer.shape_end(sphere.material, &desc.materials);
    }
    desc.meshes.iter().for_each(|mesh| writer.mesh(mesh, folder, &desc.materials));
    writer.line("</scene>");
    Ok(SavedScene { text: writer.text, meshes: writer.meshes, warnings: writer.warnings })
}

struct Writer {
    text: String,
    /// Of each material.
    ids: Vec<String>,
    meshes: Vec<(std::path::PathBuf, Vec<u8>)>,
    warnings: Vec<String>,
    lenient: bool,
}

impl Writer {
    fn line(&mut self, line: impl Display) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.text, "{line}");
    }

    fn render(&mut self, render: &RenderDesc) {
        let RenderDesc { passes, photons, samples, alpha, radius, depth } = render;
        let radius = radius.map_or(String::new(), |radius| format!(" radius=\"{radius:?}\""));
        self.line(format_args!(
            "<?caustica passes=\"{passes}\" photons=\"{photons}\" samples=\"{samples}\" alpha=\"{alpha:?}\"{radius} depth=\"{depth}\"?>"
        ));
    }

    fn sensor(&mut self, camera: &CameraDesc, film: &FilmDesc) {
        let has_lens = camera.lens_radius > 0.0;
        let kind = if has_lens { "thinlens" } else { "perspective" };
        self.line(format_args!("<sensor type=\"{kind}\">"));
        self.line("    <string name=\"fov_axis\" value=\"x\"/>");
        self.line(format_args!("    <float name=\"fov\" value=\"{:?}\"/>", camera.fov_degrees));
        if has_lens {
            self.line(format_args!(
                "    <float name=\"aperture_radius\" value=\"{:?}\"/>",
                camera.lens_radius
            ));
            self.line(format_args!(
                "    <float name=\"focus_distance\" value=\"{:?}\"/>",
                camera.focus_distance
            ));
        }
        let [origin, target, up] = [camera.position, camera.look_at, camera.up].map(vector);
        self.line("    <transform name=\"to_world\">");
        self.line(format_args!("        <lookat origin=\"{origin}\" target=\"{target}\" up=\"{up}\"/>"));
        self.line("    </transform>");
        self.line("    <film type=\"hdrfilm\">");
        self.line(format_args!("        <integer name=\"width\" value=\"{}\"/>", film.width));
        self.line(format_args!("        <integer name=\"height\" value=\"{}\"/>", film.height));
        if film.filter == PixelFilter::Points {
            self.line("        <?caustica filter=\"points\"?>");
        }
        let filter = if film.filter == PixelFilter::Points { PixelFilter::Box } else { film.filter };
        self.line(format_args!("        <rfilter type=\"{}\"/>", filter.name()));
        self.line("    </film>");
        self.line("</sensor>");
    }

    fn further_light(&mut self, light: &LightDesc) {
        let (kind, properties) = match light {
            LightDesc::Spot(spot) => {
                let (origin, axis) = (spot.position.as_dvec3(), spot.axis.as_dvec3());
                let [origin, target, up] = [origin, origin + axis, axis.any_orthonormal_vector()].map(exact);
                let place = format!("<lookat origin=\"{origin}\" target=\"{target}\" up=\"{up}\"/>");
                let angles =
                    float("beam_width", degrees(spot.inner)) + &float("cutoff_angle", degrees(spot.outer));
                ("spot", rgb("intensity", spot.intensity) + &angles + &to_world(&place))
            }
            LightDesc::Distant { direction, irradiance } => {
                let along = format!("<vector name=\"direction\" value=\"{}\"/>", vector(*direction));
                ("directional", along + &rgb("irradiance", *irradiance))
            }
            LightDesc::Sky(radiance) => ("constant", rgb("radiance", *radiance)),
            LightDesc::Panorama { file, panorama } => {
                // The middle of the picture lies along +z for Mitsuba, and along -z here.
                let turn = format!("<rotate y=\"1\" angle=\"{:?}\"/>", degrees(panorama.turn()) - 180.0);
                let file = string("filename", &escaped(&whole_path(file)));
                ("envmap", file + &float("scale", panorama.scale()) + &to_world(&turn))
            }
        };
        self.line(format_args!("<emitter type=\"{kind}\">{properties}</emitter>"));
    }

    fn materials(&mut self, desc: &SceneDesc) -> Result<(), SaveError> {
        let mut taken = BTreeSet::new();
        let in_meshes = desc.meshes.iter().flat_map(|mesh| &mesh.materials).copied();
        let used: BTreeSet<u32> =
            in_meshes.chain(desc.spheres.iter().map(|sphere| sphere.material)).collect();
        for (material, number) in desc.materials.iter().zip(0..) {
            let id = unique(&plain_id(&material.name), &mut taken);
            self.material(material, &id)?;
            self.ids.push(id);
            if material.emission != Rgb::ZERO && !used.contains(&number) {
                let lost = "no shape has it, so its emission is not written";
                self.warnings.push(format!("material `{}`: {lost}", material.name));
            }
            if material.absorption != Rgb::ZERO && !used.contains(&number) {
                let lost = "no shape has it, so its absorption is not written";
                self.warnings.push(format!("material `{}`: {lost}", material.name));
            }
        }
        Ok(())
    }

    fn material(&mut self, material: &Material, id: &str) -> Result<(), SaveError> {
        if material.textures != Textures::NONE {
            let what = format!("material `{}` with a picture", material.name);
            self.lacks(
                what,
                "constants; or --lenient, which keeps the largest value of the picture",
                "the file has its largest value",
            )?;
        }
        let (kind, properties) = self.bsdf(material)?;
        let note = if id == material.name {
            String::new()
        } else {
            format!("<?caustica name=\"{}\"?>", escaped(&material.name))
        };
        let id = escaped(id);
        let inner = format!("<bsdf type=\"{kind}\">{properties}</bsdf>");
        if material.opacity < 1.0 {
            let both_sides = format!("<bsdf type=\"twosided\">{inner}</bsdf>");
            let inner = if material.bsdf.transmits() { inner } else { both_sides };
            let opacity = float("opacity", material.opacity);
            self.line(format_args!("<bsdf type=\"mask\" id=\"{id}\">{note}{opacity}"));
            self.line(format_args!("    {inner}"));
            self.line("</bsdf>");
        } else if material.bsdf.transmits() {
            self.line(format_args!("<bsdf type=\"{kind}\" id=\"{id}\">{note}{properties}</bsdf>"));
        } else {
            self.line(format_args!("<bsdf type=\"twosided\" id=\"{id}\">{note}"));
            self.line(format_args!("    {inner}"));
            self.line("</bsdf>");
        }
        Ok(())
    }

    /// Its type and its properties.
    fn bsdf(&mut self, material: &Material) -> Result<(&'static str, String), SaveError> {
        Ok(match material.bsdf {
            Bsdf::Diffuse { albedo } => ("diffuse", rgb("reflectance", albedo)),
            Bsdf::Mirror { reflectance } => {
                ("conductor", string("material", "none") + &rgb("specular_reflectance", reflectance))
            }
            Bsdf::Dielectric { ior } => ("dielectric", indices(ior)),
            Bsdf::ThinDielectric { ior } => ("thindielectric", indices(ior)),
            Bsdf::Conductor { eta, k, reflectance } => ("conductor", metal(eta, k, reflectance)),
            Bsdf::Rough(RoughSurface { facets, interface }) => {
                let facets = string("distribution", "ggx") + &float("alpha", facets.alpha);
                match interface {
                    Interface::Conductor { eta, k, reflectance } => {
                        ("roughconductor", facets + &metal(eta, k, reflectance))
                    }
                    Interface::Dielectric { ior } => ("roughdielectric", facets + &indices(ior)),
                }
            }
            Bsdf::Plastic(Plastic { base, ior, nonlinear, .. }) => {
                let nonlinear = format!("<boolean name=\"nonlinear\" value=\"{nonlinear}\"/>");
                ("plastic", rgb("diffuse_reflectance", base) + &indices(ior) + &nonlinear)
            }
            Bsdf::FixedWeight { .. } => ("diffuse", rgb("reflectance", self.diffuse_share(material)?)),
        })
    }

    /// Refuses what is not written, or says what stands in its place.
    fn lacks(&mut self, what: String, allowed: &str, instead: &str) -> Result<(), SaveError> {
        if !self.lenient {
            return Err(SaveError::NoCounterpart { what, allowed: allowed.to_owned() });
        }
        self.warnings.push(format!("{what}: not written; {instead}"));
        Ok(())
    }

    /// What Mitsuba can show of fixed weights.
    fn diffuse_share(&mut self, material: &Material) -> Result<Rgb, SaveError> {
        let what = format!("material `{}` of fixed weights", material.name);
        let allowed =
            "diffuse, mirror, dielectric and the like; or --lenient, which keeps its diffuse share alone";
        self.lacks(what, allowed, "the file has its diffuse share alone, without mirror and glass")?;
        Ok(material.bsdf.albedo(1.0))
    }

    fn mesh(&mut self, mesh: &Mesh, folder: &str, materials: &[Material]) {
        let material = mesh.materials.first().copied().unwrap_or(0);
        match quad_corners(mesh).and_then(parallelogram) {
            Some(matrix) => {
                self.line("<shape type=\"rectangle\">");
                self.line(format_args!(
                    "    <transform name=\"to_world\"><matrix value=\"{matrix}\"/></transform>"
                ));
            }
            None => {
                let file = mesh_file(folder, self.meshes.len() + 1);
                self.line("<shape type=\"ply\">");
                self.line(format_args!(
                    "    <string name=\"filename\" value=\"{}\"/>",
                    escaped(&file.to_string_lossy())
                ));
                if mesh.normals.is_none() {
                    self.line("    <boolean name=\"face_normals\" value=\"true\"/>");
                }
                self.meshes.push((file, ply::write(mesh)));
            }
        }
        self.shape_end(material, materials);
    }

    fn shape_end(&mut self, material: u32, materials: &[Material]) {
        let id = escaped(&self.ids[material as usize]);
        self.line(format_args!("    <ref id=\"{id}\"/>"));
        let emission = materials[material as usize].emission;
        if emission != Rgb::ZERO {
            let radiance = format!("<rgb name=\"radiance\" value=\"{}\"/>", vector(emission));
            self.line(format_args!("    <emitter type=\"area\">{radiance}</emitter>"));
        }
        let absorption = materials[material as usize].absorption;
        if absorption != Rgb::ZERO {
            let properties = float("albedo", 0.0) + &extinction(absorption);
            self.line(format_args!(
                "    <medium type=\"homogeneous\" name=\"interior\">{properties}</medium>"
            ));
        }
        self.line("</shape>");
    }
}

/// Colours end at 1 in Mitsuba; a power of two as the factor leaves their digits as they are.
fn extinction(sigma: Rgb) -> String {
    let scale = (1..=127).map(|k| 2f32.powi(k)).find(|scale| sigma.max_element() <= *scale);
    match scale.filter(|_| sigma.max_element() > 1.0) {
        Some(scale) => rgb("sigma_t", sigma / scale) + &float("scale", scale),
        None => rgb("sigma_t", sigma),
    }
}

fn to_world(step: &str) -> String {
    format!("<transform name=\"to_world\">{step}</transform>")
}

fn exact(v: DVec3) -> String {
    v.to_array().map(|x| format!("{x:?}")).join(", ")
}

fn rgb(name: &str, color: Rgb) -> String {
    format!("<rgb name=\"{name}\" value=\"{}\"/>", vector(color))
}

fn float(name: &str, x: f32) -> String {
    format!("<float name=\"{name}\" value=\"{x:?}\"/>")
}

fn string(name: &str, value: &str) -> String {
    format!("<string name=\"{name}\" value=\"{value}\"/>")
}

fn indices(ior: f32) -> String {
    float("int_ior", ior) + &float("ext_ior", 1.0)
}

fn metal(eta: Rgb, k: Rgb, reflectance: Rgb) -> String {
    rgb("eta", eta) + &rgb("k", k) + &rgb("specular_reflectance", reflectance)
}

/// The matrix that takes Mitsuba's rectangle to these corners, where one does so exactly.
fn parallelogram(corners: [Vec3; 4]) -> Option<String> {
    let [a, b, c, d] = corners.map(|corner| corner.as_dvec3());
    let (u, v, middle) = (0.5 * (b - a), 0.5 * (d - a), 0.5 * (a + c));
    let normal = u.cross(v).try_normalize()?;
    let map = DAffine3::from_cols(u, v, normal, middle);
    let signs = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let mapped = signs.map(|(x, y)| map.transform_point3(DVec3::new(x, y, 0.0)).as_vec3());
    let rows = [0, 1, 2].map(|i| [u[i], v[i], normal[i], middle[i]].map(|x| format!("{x:?}")).join(" "));
    (mapped == corners).then(|| format!("{} 0 0 0 1", rows.join(" ")))
}

/// An id that Mitsuba accepts: letters, digits and some signs, not an underscore in front.
fn plain_id(name: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || "-_ ()".contains(c) { c } else { '_' };
    let id: String = name.chars().map(plain).collect();
    if id.is_empty() || id.starts_with('_') { format!("m{id}") } else { id }
}

fn vector(v: Vec3) -> String {
    v.to_array().map(|x| format!("{x:?}")).join(", ")
}

/// As the value of an attribute; what XML cannot hold becomes U+FFFD.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\n' => escaped.push_str("&#10;"),
            '\t' => escaped.push_str("&#9;"),
            '\r' => escaped.push_str("&#13;"),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => escaped.push('\u{fffd}'),
            c => escaped.push(c),
        }
    }
    escaped
}
