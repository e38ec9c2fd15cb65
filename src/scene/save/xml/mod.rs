//! Scenes as Mitsuba 3's XML. What Mitsuba has no word for stands in processing instructions, which it skips.

mod materials;
mod values;

use std::collections::BTreeSet;
use std::fmt::{Display, Write};

use glam::DAffine3;

use self::values::{escaped, exact, float, rgb, string, to_world, vector};
use super::super::{
    CameraDesc, FilmDesc, LightDesc, Material, Mesh, PixelFilter, RenderDesc, SceneDesc, SphereDesc, Textures,
};
use super::degrees::degrees;
use super::pictures::Pictures;
use super::ply::mesh_file;
use super::quads::quad_corners;
use super::{SaveError, SavedScene, ply};
use crate::math::{DVec3, Rgb, Vec2, Vec3};

/// A scene in normal form; its meshes go into `folder`.
pub(super) fn write(
    desc: &SceneDesc,
    folder: &str,
    pictures: Pictures,
    lenient: bool,
) -> Result<SavedScene, SaveError> {
    let mut writer = Writer {
        text: String::new(),
        ids: Vec::new(),
        meshes: Vec::new(),
        pictures,
        round: round_pictures(desc),
        warnings: Vec::new(),
        lenient,
    };
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
    desc.further_lights.iter().try_for_each(|light| writer.further_light(light))?;
    desc.spheres.iter().for_each(|sphere| writer.sphere(sphere, &desc.materials));
    desc.meshes.iter().for_each(|mesh| writer.mesh(mesh, folder, &desc.materials));
    writer.line("</scene>");
    let Writer { text, meshes, pictures, warnings, .. } = writer;
    Ok(SavedScene { text, meshes, pictures: pictures.into_files(), warnings })
}

/// The materials whose pictures are on spheres.
fn round_pictures(desc: &SceneDesc) -> BTreeSet<u32> {
    let pictured = |material: &u32| desc.materials[*material as usize].textures != Textures::NONE;
    desc.spheres.iter().map(|sphere| sphere.material).filter(pictured).collect()
}

struct Writer {
    text: String,
    /// Of each material.
    ids: Vec<String>,
    meshes: Vec<(std::path::PathBuf, Vec<u8>)>,
    pictures: Pictures,
    /// Mitsuba mirrors pictures on rectangles and does not on spheres, so the maps of texture coordinates differ: these materials have
    /// that of spheres, which turns pictures by half a turn.
    round: BTreeSet<u32>,
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

    fn sphere(&mut self, sphere: &SphereDesc, materials: &[Material]) {
        self.line("<shape type=\"sphere\">");
        let SphereDesc { center, radius, material } = *sphere;
        if self.round.contains(&material) {
            let [x, y, z] = center.to_array();
            self.line(format_args!(
                "    <transform name=\"to_world\"><matrix value=\"-{radius:?} 0 0 {x:?} 0 0 -{radius:?} {y:?} 0 -{radius:?} 0 {z:?} 0 0 0 1\"/></transform>"
            ));
        } else {
            self.line(format_args!("    <point name=\"center\" value=\"{}\"/>", vector(center)));
            self.line(format_args!("    <float name=\"radius\" value=\"{radius:?}\"/>"));
        }
        self.shape_end(material, materials);
    }

    fn further_light(&mut self, light: &LightDesc) -> Result<(), SaveError> {
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
                let file = string("filename", &escaped(&self.pictures.copy(file)?));
                ("envmap", file + &float("scale", panorama.scale()) + &to_world(&turn))
            }
        };
        self.line(format_args!("<emitter type=\"{kind}\">{properties}</emitter>"));
        Ok(())
    }

    fn mesh(&mut self, mesh: &Mesh, folder: &str, materials: &[Material]) {
        let material = mesh.materials.first().copied().unwrap_or(0);
        let turned = self.round.contains(&material);
        let corners = if turned { None } else { quad_corners(mesh) };
        match corners.and_then(parallelogram) {
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
                let bytes = if turned { ply::write(&mirrored(mesh)) } else { ply::write(mesh) };
                self.meshes.push((file, bytes));
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

/// With mirrored texture coordinates, for pictures that are turned.
fn mirrored(mesh: &Mesh) -> Mesh {
    let mirror = |uv: &Vec2| Vec2::new(-uv.x, uv.y);
    Mesh { uvs: mesh.uvs.as_ref().map(|uvs| uvs.iter().map(mirror).collect()), ..mesh.clone() }
}

/// Colours end at 1 in Mitsuba; a power of two as the factor leaves their digits as they are.
fn extinction(sigma: Rgb) -> String {
    let scale = (1..=127).map(|k| 2f32.powi(k)).find(|scale| sigma.max_element() <= *scale);
    match scale.filter(|_| sigma.max_element() > 1.0) {
        Some(scale) => rgb("sigma_t", sigma / scale) + &float("scale", scale),
        None => rgb("sigma_t", sigma),
    }
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
