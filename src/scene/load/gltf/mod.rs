//! Scenes in glTF 2.0: geometry, materials, a camera and lights; what else a file holds is told and left out.

mod accessors;
mod buffers;
mod materials;
mod textures;

use std::collections::BTreeSet;
use std::path::Path;

use glam::{DAffine2, DAffine3, DMat4};
use gltf::camera::Projection;
use gltf::khr_lights_punctual::{Kind, Light};
use gltf::mesh::Mode;
use gltf::{Gltf, Mesh as Shape, Node, Primitive};

use self::buffers::Buffers;
use self::materials::Materials;
use self::textures::Pictures;
use super::super::{CameraDesc, FilmDesc, LightDesc, Mesh, Places, PointLightDesc, SceneDesc, SceneError};
use super::access::{Denial, Reader};
use super::affine::Affine;
use super::bare_mesh;
use super::geometry::{Geometry, Normals, Placement, is_traceable};
use super::source::file_error;
use crate::light::Spot;
use crate::math::{Aabb, DVec3, Rgb, Vec2, Vec3};

/// Nodes may be nested this deep.
const DEEPEST: usize = 256;

/// Reads a `.gltf` or `.glb` file and the buffers that it names.
pub(super) fn read(path: &Path, reader: &Reader) -> Result<SceneDesc, SceneError> {
    let denied = |denial: Denial| file_error(path, denial.reason());
    let bytes = reader.read(path, "a glTF scene").map_err(denied)?;
    let file = parsed(&bytes).map_err(|reason| file_error(path, reason))?;
    let version = &file.as_json().asset.version;
    if !version.starts_with("2.") {
        return Err(file_error(path, format!("is glTF {version}; allowed: 2.0")));
    }
    let buffers = Buffers::read(&file, path, reader)?;
    let mut parts = Parts::new(path, reader, &buffers);
    let scene = file.default_scene().or_else(|| file.scenes().next());
    let scene = scene.ok_or_else(|| file_error(path, "has no scene; at least one is needed"))?;
    parts.tell_of_the_rest(&file);
    for node in scene.nodes() {
        parts.node(&node, Affine::IDENTITY, 0)?;
    }
    parts.scene(path)
}

/// The file as data that is checked. The crate panics where positions are no accessor
/// and images have no source, so those are looked at first.
fn parsed(bytes: &[u8]) -> Result<Gltf, String> {
    let unsound = |e: gltf::Error| format!("is no glTF 2.0 that is sound: {e}");
    let Gltf { document, blob } = Gltf::from_slice_without_validation(bytes).map_err(unsound)?;
    let json = document.into_json();
    let positions = gltf::json::validation::Checked::Valid(gltf::Semantic::Positions);
    let primitives = json.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let given = primitives.filter_map(|primitive| primitive.attributes.get(&positions));
    let n = json.accessors.len();
    if let Some(index) = given.map(|index| index.value()).find(|&index| index >= n) {
        return Err(format!(
            "has positions in accessor {index}; allowed: less than {n}, as many as there are"
        ));
    }
    let sourceless = |image: &gltf::json::Image| match image.buffer_view {
        Some(_) => image.mime_type.is_none(),
        None => image.uri.is_none(),
    };
    if let Some(index) = json.images.iter().position(sourceless) {
        return Err(format!("has image {index} without a source; allowed: uri, or bufferView with mimeType"));
    }
    Ok(Gltf { document: gltf::Document::from_json(json).map_err(unsound)?, blob })
}

/// What a scene is put together from.
struct Parts<'a> {
    path: &'a Path,
    reader: &'a Reader<'a>,
    buffers: &'a Buffers,
    materials: Materials,
    meshes: Vec<Mesh>,
    point_lights: Vec<PointLightDesc>,
    spots: Vec<LightDesc>,
    distant: Vec<LightDesc>,
    camera: Option<(CameraDesc, FilmDesc)>,
    /// Nodes that were seen: they form a tree.
    seen: BTreeSet<usize>,
    triangles: u64,
    warnings: Vec<String>,
}

impl<'a> Parts<'a> {
    fn new(path: &'a Path, reader: &'a Reader<'a>, buffers: &'a Buffers) -> Parts<'a> {
        Parts {
            path,
            reader,
            buffers,
            materials: Materials::default(),
            meshes: Vec::new(),
            point_lights: Vec::new(),
            spots: Vec::new(),
            distant: Vec::new(),
            camera: None,
            seen: BTreeSet::new(),
            triangles: 0,
            warnings: Vec::new(),
        }
    }

    fn error(&self, reason: impl Into<String>) -> SceneError {
        file_error(self.path, reason)
    }

    fn tell(&mut self, what: &str) {
        self.warnings.push(format!("{}: {what}", self.path.display()));
    }

    fn tell_of_the_rest(&mut self, file: &Gltf) {
        let parts = [
            ("animations", file.animations().count(), "the picture shows the scene at rest"),
            ("skins", file.skins().count(), "the picture shows meshes as they are stored"),
            ("scenes beside the default one", file.scenes().count() - 1, "the picture lacks them"),
        ];
        for (what, n, lacks) in parts.into_iter().filter(|(_, n, _)| *n > 0) {
            self.tell(&format!("{n} {what} are not supported; {lacks}"));
        }
        let known = [
            "KHR_lights_punctual",
            "KHR_materials_ior",
            "KHR_materials_transmission",
            "KHR_materials_volume",
            "KHR_materials_emissive_strength",
            "KHR_texture_transform",
        ];
        let unknown: Vec<&str> = file.extensions_used().filter(|name| !known.contains(name)).collect();
        if !unknown.is_empty() {
            self.tell(&format!(
                "extensions that are not supported: {}; the picture lacks what they add",
                unknown.join(", ")
            ));
        }
    }

    fn node(&mut self, node: &Node, above: Affine, depth: usize) -> Result<(), SceneError> {
        if depth == DEEPEST || !self.seen.insert(node.index()) {
            return Err(self.error(format!(
                "node {} is nested in itself, in two nodes or too deep; allowed: a tree",
                node.index()
            )));
        }
        let local = DMat4::from_cols_array_2d(&node.transform().matrix().map(|column| column.map(f64::from)));
        let to_world = Affine(DAffine3::from_mat4(local)).then(above.0);
        if !to_world.0.is_finite() {
            return Err(self
                .error(format!("node {}: its place is not finite; allowed: finite numbers", node.index())));
        }
        if let Some(mesh) = node.mesh() {
            self.shape(&mesh, to_world)?;
        }
        if let Some(camera) = node.camera() {
            self.camera(&camera, to_world)?;
        }
        if let Some(light) = node.light() {
            self.light(&light, to_world)?;
        }
        node.children().try_for_each(|child| self.node(&child, to_world, depth + 1))
    }

    fn shape(&mut self, shape: &Shape, to_world: Affine) -> Result<(), SceneError> {
        if to_world.0.matrix3.determinant() == 0.0 {
            self.tell(&format!("mesh {} is flattened by its node; the picture lacks it", shape.index()));
            return Ok(());
        }
        for primitive in shape.primitives() {
            let name = format!("mesh {} `{}`", shape.index(), shape.name().unwrap_or_default());
            if primitive.morph_targets().next().is_some() {
                self.tell(&format!("{name}: morph targets are not supported; the picture shows it at rest"));
            }
            if matches!(primitive.mode(), Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
                self.tell(&format!("{name}: points and lines are not supported; the picture lacks them"));
                continue;
            }
            self.primitive(&primitive, &name, to_world)?;
        }
        Ok(())
    }

    fn primitive(&mut self, primitive: &Primitive, name: &str, to_world: Affine) -> Result<(), SceneError> {
        let told = |reason| file_error(self.path, format!("{name}: {reason}"));
        let mut geometry = self.geometry(primitive).map_err(told)?;
        let n_triangles = geometry.triangles.len();
        self.triangles += n_triangles as u64;
        self.reader.limits().check_triangles(self.triangles).map_err(told)?;
        if n_triangles == 0 {
            self.tell(&format!("{name}: has no triangles; the picture lacks it"));
            return Ok(());
        }
        let pictures = Pictures { path: self.path, reader: self.reader, buffers: self.buffers };
        let material = self.materials.number(&primitive.material(), pictures, &mut self.warnings);
        if let Some(to_uv) = self.materials.to_uv(material) {
            geometry.uvs = self.uvs(primitive, to_uv, geometry.vertices.len()).map_err(told)?;
            if geometry.uvs.is_none() {
                self.tell(&format!("{name}: has no TEXCOORD_0; one place of its pictures is all over it"));
            }
        }
        let (path, shown) = (self.path, format!("{name}: "));
        let placement = Placement {
            name,
            path,
            motion: &to_world,
            normals: Normals::FileOrFlat,
            flip: false,
            keeps_unit_normals: true,
            error: &|reason| file_error(path, format!("{shown}{reason}")),
        };
        let mesh = placement.mesh(geometry, vec![material; n_triangles], &mut self.warnings)?;
        self.meshes.push(mesh);
        Ok(())
    }

    fn geometry(&self, primitive: &Primitive) -> Result<Geometry, String> {
        let positions = primitive.get(&gltf::Semantic::Positions).ok_or("has no positions; allowed: some")?;
        let vertices = accessors::vectors(&positions, self.buffers)?;
        if let Some(outside) = vertices.iter().find(|p| !is_traceable(**p)) {
            return Err(format!("has a vertex at {outside}; allowed: coordinates from -1.8e18 to 1.8e18"));
        }
        let normals = primitive.get(&gltf::Semantic::Normals);
        let normals = normals.map(|normals| accessors::vectors(&normals, self.buffers)).transpose()?;
        if normals.as_ref().is_some_and(|normals| normals.len() != vertices.len()) {
            return Err(String::from("has not as many normals as positions; allowed: as many"));
        }
        let indices = match primitive.indices() {
            Some(indices) => accessors::indices(&indices, self.buffers)?,
            None => (0..vertices.len() as u32).collect(),
        };
        if let Some(index) = indices.iter().find(|&&index| index as usize >= vertices.len()) {
            return Err(format!(
                "vertex index {index} is out of range; allowed: less than {}",
                vertices.len()
            ));
        }
        Ok(Geometry {
            vertices,
            normals,
            uvs: None,
            triangles: triangles(primitive.mode(), &indices),
            ignored: 0,
        })
    }

    /// The texture coordinates of each vertex.
    fn uvs(&self, primitive: &Primitive, to_uv: DAffine2, n: usize) -> Result<Option<Vec<Vec2>>, String> {
        let Some(accessor) = primitive.get(&gltf::Semantic::TexCoords(0)) else { return Ok(None) };
        let uvs = accessors::pairs(&accessor, self.buffers)?;
        if uvs.len() != n {
            return Err(String::from("has not as many texture coordinates as positions; allowed: as many"));
        }
        let moved = |uv: Vec2| to_uv.transform_point2(uv.as_dvec2()).as_vec2();
        let finite = |uv: Vec2| if uv.is_finite() { uv } else { Vec2::ZERO };
        Ok(Some(uvs.into_iter().map(|uv| finite(moved(uv))).collect()))
    }

    fn camera(&mut self, camera: &gltf::Camera, to_world: Affine) -> Result<(), SceneError> {
        let Projection::Perspective(lens) = camera.projection() else {
            self.tell(&format!(
                "camera {} is orthographic, which is not supported; not used",
                camera.index()
            ));
            return Ok(());
        };
        if self.camera.is_some() {
            self.tell(&format!("camera {} is not used: the first one counts", camera.index()));
            return Ok(());
        }
        const HEIGHT: f64 = 512.0;
        let aspect = lens.aspect_ratio().map_or(1.0, f64::from).clamp(1.0 / 16.0, 16.0);
        let film = FilmDesc::new((HEIGHT * aspect).round().max(1.0) as u32, HEIGHT as u32);
        let half_height = (0.5 * f64::from(lens.yfov())).tan();
        let fov = (2.0 * (half_height * f64::from(film.width) / HEIGHT).atan()).to_degrees() as f32;
        let [view, up] =
            [DVec3::NEG_Z, DVec3::Y].map(|axis| to_world.vector(axis).normalize_or_zero().as_vec3());
        let position = to_world.map(DVec3::ZERO).as_vec3();
        let sees = view.cross(up).length() > 1e-3 && position + view != position;
        if !(fov > 0.0 && fov < 180.0 && sees && is_traceable(position)) {
            return Err(self.error(format!("camera {} sees nothing; allowed: an angle above 0 and below 180 degrees, axes across each other", camera.index())));
        }
        self.camera = Some((CameraDesc { up, ..CameraDesc::pinhole(position, position + view, fov) }, film));
        Ok(())
    }

    fn light(&mut self, light: &Light, to_world: Affine) -> Result<(), SceneError> {
        let name = format!("light {} `{}`", light.index(), light.name().unwrap_or_default());
        let intensity = light.intensity() * Rgb::from(light.color());
        if !intensity.is_finite() || intensity.min_element() < 0.0 {
            return Err(self.error(format!(
                "{name}: its intensity is {intensity}; allowed: finite numbers, 0 or above"
            )));
        }
        if light.range().is_some() {
            self.tell(&format!(
                "{name}: a range is not supported; its light falls with the square of the distance alone"
            ));
        }
        let position = to_world.map(DVec3::ZERO).as_vec3();
        let along = to_world.vector(DVec3::NEG_Z).normalize_or(DVec3::NEG_Z).as_vec3();
        let has_place = !matches!(light.kind(), Kind::Directional);
        if has_place && !is_traceable(position) {
            let reason = format!("{name}: stands at {position}; allowed: coordinates up to 1.8e18");
            return Err(self.error(reason));
        }
        match light.kind() {
            Kind::Point => self.point_lights.push(PointLightDesc { position, intensity }),
            Kind::Spot { inner_cone_angle, outer_cone_angle } => {
                let outer = outer_cone_angle.clamp(1e-3, std::f32::consts::PI);
                let inner = inner_cone_angle.clamp(0.0, outer);
                self.tell(&format!(
                    "{name}: its light fades evenly with the angle, rather than with its cosine, squared"
                ));
                self.spots.push(LightDesc::Spot(Spot { position, axis: along, intensity, inner, outer }));
            }
            Kind::Directional => {
                self.distant.push(LightDesc::Distant { direction: along, irradiance: intensity })
            }
        }
        Ok(())
    }

    fn scene(mut self, path: &Path) -> Result<SceneDesc, SceneError> {
        let (camera, film) = self.camera.unwrap_or_else(|| {
            let vertices = self.meshes.iter().flat_map(|mesh| mesh.vertices.iter().copied());
            let bounds = if self.meshes.is_empty() {
                Aabb::of_sphere(Vec3::ZERO, 1.0)
            } else {
                Aabb::of_points(vertices)
            };
            let camera = bare_mesh::camera(bounds);
            self.warnings.push(format!(
                "{}: no perspective camera: seen from {}",
                path.display(),
                camera.position
            ));
            (camera, FilmDesc::new(512, 512))
        });
        Ok(SceneDesc {
            name: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
            path: path.to_owned(),
            film,
            materials: self.materials.list,
            meshes: self.meshes,
            point_lights: self.point_lights,
            further_lights: [self.spots, self.distant].concat(),
            warnings: self.warnings,
            places: Places { file: path.display().to_string(), ..Places::default() },
            ..SceneDesc::new(camera)
        })
    }
}

/// The triangles of a list, a strip or a fan.
fn triangles(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => {
            let turned =
                |(k, t): (usize, &[u32])| if k % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] };
            indices.windows(3).enumerate().map(turned).collect()
        }
        Mode::TriangleFan => {
            let Some((&hub, rim)) = indices.split_first() else { return Vec::new() };
            rim.windows(2).map(|pair| [hub, pair[0], pair[1]]).collect()
        }
        _ => indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
    }
}

#[cfg(test)]
mod tests;
