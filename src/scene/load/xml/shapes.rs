//! `<shape>`: mesh files, and meshes and spheres by formula.

use super::super::super::{Mesh, SceneError, SphereDesc};
use super::super::access::Denial;
use super::super::fields::{COORDINATE, POSITIVE};
use super::super::geometry::{Geometry, Normals, Placement};
use super::super::mesh_memory::{self, Kind};
use super::super::obj;
use super::element::Element;
use super::look::Look;
use super::materials::{Added, Materials};
use super::object::{Context, Object};
use super::{emitters, interiors, tessellate};
use crate::bsdf::Bsdf;
use crate::input;
use crate::math::{DVec3, Rgb, Vec3};

const KINDS: &str = "`obj`, `ply`, `rectangle`, `cube`, `sphere`, `disk`, `cylinder`";

/// The shapes of a scene in its order, and their lines.
#[derive(Default)]
pub(super) struct Shapes {
    pub meshes: Vec<Mesh>,
    pub mesh_lines: Vec<u32>,
    pub spheres: Vec<SphereDesc>,
    pub sphere_lines: Vec<u32>,
    triangles: u64,
    /// The first mesh that Mitsuba shows black from behind, and how many there are.
    half_seen: Option<(String, usize)>,
}

impl Shapes {
    pub fn read<'a>(
        &mut self,
        element: &'a Element,
        materials: &mut Materials,
        context: &'a Context<'a>,
    ) -> Result<(), SceneError> {
        let object = Object::new(element, context)?;
        let kind = object.kind()?;
        if !KINDS.contains(&format!("`{kind}`")) {
            let reason = format!("shape `{kind}` is not supported; allowed: {KINDS}");
            return context.unsupported(element, &reason, "the picture lacks it");
        }
        let emission = emitters::radiance(&object, context)?;
        let absorption = interiors::absorption(&object, context)?;
        let (material, surface) =
            materials.of_shape(object.object("bsdf")?, Added { emission, absorption }, context)?;
        if absorption != Rgb::ZERO && surface.bsdf.ior().is_none() {
            return Err(object.error(interiors::NO_INSIDE));
        }
        let look = Look { material, surface, emission };
        match kind {
            "sphere" => self.sphere(&object, &look)?,
            "obj" | "ply" => self.file(&object, kind, &look)?,
            _ => self.formula(&object, kind, &look)?,
        }
        object.finish()
    }

    fn sphere(&mut self, object: &Object, look: &Look) -> Result<(), SceneError> {
        let to_world = object.transform("to_world")?;
        let Some(scale) = to_world.uniform_scale() else {
            return Err(object.error(
                "`to_world` makes it no sphere; allowed: rotations, translations and scales that are even in all directions",
            ));
        };
        if look.has_pictures() && !look.lies_as_here(&to_world) {
            let reason = "a picture on a sphere whose poles do not lie along y, or whose middle is not at +x, is not supported; allowed: \
                `to_world` by <rotate x=\"1\" angle=\"-90\"/><rotate y=\"1\" angle=\"180\"/>, without `to_uv`";
            let lacks = "it is turned in the picture";
            object.context.unsupported(object.element, &format!("shape `sphere`: {reason}"), lacks)?;
        }
        let flip = object.boolean("flip_normals")?;
        if flip && look.emission != Rgb::ZERO {
            return Err(object
                .error("`flip_normals` of a sphere that emits is not supported; allowed: light outward"));
        }
        if flip && look.surface.bsdf.ior().is_some() {
            return Err(object.error(
                "`flip_normals` of a dielectric is not supported; allowed: exchanged `int_ior` and `ext_ior`",
            ));
        }
        let center = object.vector("center", &COORDINATE)?.unwrap_or(DVec3::ZERO);
        let radius = scale * object.f64("radius", 1.0, &POSITIVE)?;
        let center = object.placed(to_world.map(center))?;
        object.placed(DVec3::splat(f64::from(center.abs().max_element()) + radius))?;
        if radius as f32 <= 0.0 {
            return Err(object.error(format!("its radius of {radius} is too small; allowed: what f32 holds")));
        }
        self.spheres.push(SphereDesc { center, radius: radius as f32, material: look.material });
        self.sphere_lines.push(object.element.place.main_line as u32);
        Ok(())
    }

    fn file(&mut self, object: &Object, kind: &str, look: &Look) -> Result<(), SceneError> {
        let missing = || object.error("`filename` is missing; allowed: the path of a mesh file");
        let name = object.string("filename")?.ok_or_else(missing)?;
        object.has_no_use_for(&["flip_tex_coords"]);
        let path = object.context.reader.beside_scene(name);
        let expected = if kind == "obj" { "an OBJ mesh" } else { "a PLY mesh" };
        let denied = |denial: Denial| object.error(format!("`{name}` {}", denial.reason()));
        let bytes = object.context.reader.read(&path, expected).map_err(denied)?;
        let flat = object.boolean("face_normals")?;
        let format = match kind {
            "obj" => Kind::Obj(obj::Keep { normals: !flat, uvs: look.has_pictures() }),
            _ => Kind::Ply,
        };
        let parsed = mesh_memory::parse(&path, bytes, format, object.context.reader.memory())?;
        let geometry = look.upright(parsed.geometry, kind);
        self.place(object, look, geometry, name, if flat { Normals::Flat } else { Normals::FileOrSmooth })
    }

    fn formula(&mut self, object: &Object, kind: &str, look: &Look) -> Result<(), SceneError> {
        let geometry = match kind {
            "rectangle" => look.upright(tessellate::rectangle(), kind),
            "cube" => tessellate::cube(),
            "disk" => tessellate::disk(),
            _ => cylinder(object)?,
        };
        let flat = object.boolean("face_normals")?;
        let name = object
            .element
            .attribute("id")
            .map_or_else(|| format!("{kind} in line {}", object.element.place.line), str::to_owned);
        self.place(object, look, geometry, &name, if flat { Normals::Flat } else { Normals::FileOrFlat })
    }

    fn place(
        &mut self,
        object: &Object,
        look: &Look,
        geometry: Geometry,
        name: &str,
        normals: Normals,
    ) -> Result<(), SceneError> {
        if look.has_pictures() && geometry.uvs.is_none() {
            let reason = format!(
                "{}: has a picture, but no texture coordinates here; allowed: `rectangle`, `sphere`, mesh files with some",
                object.element.label()
            );
            object.context.unsupported(object.element, &reason, "one place of the picture is all over it")?;
        }
        let n_triangles = geometry.triangles.len();
        self.count(object, n_triangles as u64)?;
        let to_world = object.transform("to_world")?;
        let path = object.context.reader.beside_scene(name);
        let placement = Placement {
            name,
            path: &path,
            motion: &to_world,
            normals,
            flip: object.boolean("flip_normals")?,
            keeps_unit_normals: true,
            error: &|reason| object.error(reason),
        };
        let mut warnings = Vec::new();
        let mesh = placement.mesh(geometry, vec![look.material; n_triangles], &mut warnings)?;
        object.context.warn_all(warnings);
        self.look_behind(object, &mesh, look);
        self.meshes.push(mesh);
        self.mesh_lines.push(object.element.place.main_line as u32);
        Ok(())
    }

    fn count(&mut self, object: &Object, n: u64) -> Result<(), SceneError> {
        /// Bytes that a triangle takes until it is traced.
        const COST: u64 = 64;
        /// Memory is looked at whenever so many more have come.
        const STEP: u64 = 1 << 20;
        let before = self.triangles;
        self.triangles += n;
        let counted = object.context.reader.limits().check_triangles(self.triangles);
        counted.map_err(|reason| object.error(reason))?;
        if self.triangles / STEP > before / STEP {
            input::check_memory(COST * self.triangles)
                .map_err(|e| object.error(format!("too many triangles: {e}")))?;
        }
        Ok(())
    }

    /// Notes a mesh whose back can be seen and is black in Mitsuba alone.
    fn look_behind(&mut self, object: &Object, mesh: &Mesh, look: &Look) {
        let black = matches!(look.surface.bsdf, Bsdf::Diffuse { albedo } if albedo == Rgb::ZERO);
        if !look.surface.one_sided || black || is_closed(mesh) {
            return;
        }
        match &mut self.half_seen {
            Some((_, n)) => *n += 1,
            None => self.half_seen = Some((object.element.place.told(&object.element.label()), 1)),
        }
    }

    /// The note about all those meshes, if there are any.
    pub fn note_of_backs(&self) -> Option<String> {
        let (first, n) = self.half_seen.as_ref()?;
        let more = if *n > 1 { format!(" (and {} more)", n - 1) } else { String::new() };
        Some(format!(
            "{first}{more}: open, and its bsdf is not `twosided`: its back is black in Mitsuba, here it is as its front"
        ))
    }
}

fn cylinder(object: &Object) -> Result<Geometry, SceneError> {
    let p0 = object.vector("p0", &COORDINATE)?.unwrap_or(DVec3::ZERO);
    let p1 = object.vector("p1", &COORDINATE)?.unwrap_or(DVec3::Z);
    let radius = object.f64("radius", 1.0, &POSITIVE)?;
    if p0 == p1 {
        return Err(object.error("`p0` equals `p1`; allowed: any other point"));
    }
    Ok(tessellate::cylinder(p0, p1, radius))
}

/// Whether every edge has another one that runs the other way, as in a closed mesh.
///
/// Sums hashes of edges by the bits of their ends, with opposite signs for opposite directions: 0 unless some edge is alone,
/// but for one chance in 2⁶⁴.
fn is_closed(mesh: &Mesh) -> bool {
    let key = |p: Vec3| {
        // Zeros of both signs are one place.
        let [x, y, z] = (p + Vec3::ZERO).to_array().map(|c| u64::from(c.to_bits()));
        mixed(x ^ mixed(y ^ mixed(z)))
    };
    let edge = |a: u64, b: u64| {
        let hash = mixed(a.min(b) ^ mixed(a.max(b)));
        if a < b { hash } else { hash.wrapping_neg() }
    };
    let sum = (0..mesh.triangles.len()).fold(0u64, |sum, t| {
        let [a, b, c] = mesh.corners(t).map(key);
        sum.wrapping_add(edge(a, b)).wrapping_add(edge(b, c)).wrapping_add(edge(c, a))
    });
    sum == 0
}

/// A bijection of 64 bits that leaves no pattern.
///
/// # Source
/// Steele, Lea and Flood, "Fast Splittable Pseudorandom Number Generators", OOPSLA 2014: the finalizer of SplitMix64.
fn mixed(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

#[cfg(test)]
mod tests {
    use super::super::super::testing::{close, normal};
    use super::super::testing::{fails, good};
    use super::*;

    fn mesh(shape: &str, files: &[(&str, &str)]) -> Mesh {
        good(shape, files).meshes[0].clone()
    }

    const ROOF: &str = "v 0 0 0\nv 0 0 1\nv 1 1 0\nv 1 1 1\nv 2 0 0\nv 2 0 1\nf 1 2 4 3\nf 3 4 6 5\n";

    #[test]
    fn mesh_files_are_smooth_unless_they_are_to_be_flat() {
        let files = [("m.obj", ROOF)];
        let shape =
            |more: &str| format!("<shape type='obj'><string name='filename' value='m.obj'/>{more}</shape>");
        let smooth = mesh(&shape(""), &files);
        assert!(smooth.normals.as_ref().unwrap().iter().any(|n| close(*n, Vec3::Y)));
        assert_eq!(mesh(&shape("<boolean name='face_normals' value='true'/>"), &files).normals, None);
        let flipped = mesh(&shape("<boolean name='flip_normals' value='true'/>"), &files);
        assert!(normal(&flipped, 0).y < 0.0 && flipped.normals.unwrap().iter().all(|n| n.y < 0.0));
        let moved =
            mesh(&shape("<transform name='to_world'><scale x='-1'/><translate y='3'/></transform>"), &files);
        assert!(
            normal(&moved, 0).y > 0.0 && moved.vertices[0].y == 3.0,
            "normals are mirrored, not inverted"
        );
    }

    #[test]
    fn ply_files_are_read() {
        let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
            element face 1\nproperty list uchar int vertex_index\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
        let shape = "<shape type='ply'><string name='filename' value='m.ply'/></shape>";
        let read = mesh(shape, &[("m.ply", ply)]);
        assert_eq!(
            (read.name.as_str(), read.triangles.len(), read.normals),
            ("m.ply", 1, Some(vec![Vec3::Z; 3]))
        );
    }

    #[test]
    fn formulas_are_placed() {
        let lamp = mesh(
            "<shape type='rectangle'><transform name='to_world'><scale value='2'/><rotate x='1' angle='90'/></transform></shape>",
            &[],
        );
        assert!(close(normal(&lamp, 0), Vec3::NEG_Y) && lamp.vertices[2].x == 2.0);
        let disk = mesh("<shape type='disk'><boolean name='flip_normals' value='true'/></shape>", &[]);
        assert!(close(normal(&disk, 0), Vec3::NEG_Z));
        let tube = mesh(
            "<shape type='cylinder'><point name='p1' value='0,0,5'/><float name='radius' value='2'/></shape>",
            &[],
        );
        assert!(
            tube.normals.is_some()
                && tube.vertices.iter().all(|v| (v.truncate().length() - 2.0).abs() < 1e-5)
        );
        let ball = good("<shape type='sphere'><point name='center' x='1'/><float name='radius' value='3'/><transform name='to_world'><scale value='2'/><translate y='1'/></transform></shape>", &[]).spheres[0];
        assert_eq!((ball.center, ball.radius), (Vec3::new(2.0, 1.0, 0.0), 6.0));
    }

    #[test]
    fn closed_meshes_are_told_from_open_ones() {
        let shape = |kind: &str| mesh(&format!("<shape type='{kind}'/>"), &[]);
        assert!(is_closed(&shape("cube")));
        assert!(
            !is_closed(&shape("rectangle")) && !is_closed(&shape("disk")) && !is_closed(&shape("cylinder"))
        );
        let mut open = shape("cube");
        open.triangles.pop();
        assert!(!is_closed(&open));
        let mut turned = shape("cube");
        turned.triangles[3].swap(0, 1);
        assert!(!is_closed(&turned));
    }

    #[test]
    fn backs_that_differ_are_noted_once() {
        let warnings = |body: &str| good(body, &[]).warnings.join("\n");
        let two = warnings("<shape type='rectangle'/><shape type='disk'/>");
        assert!(
            two.contains("s.xml:7: shape `rectangle` (and 1 more): open, and its bsdf is not `twosided`"),
            "{two}"
        );
        assert!(
            !warnings("<shape type='rectangle'><bsdf type='twosided'><bsdf type='diffuse'/></bsdf></shape>")
                .contains("open")
        );
        assert!(!warnings("<shape type='cube'/>").contains("open"));
    }

    #[test]
    fn what_is_no_shape_of_ours_is_refused() {
        for (text, words) in [
            ("<shape type='hair'/>", "shape `hair` is not supported; allowed: `obj`"),
            ("<shape type='obj'/>", "shape `obj`: `filename` is missing"),
            (
                "<shape type='ply'><string name='filename' value='no.ply'/></shape>",
                "shape `ply`: `no.ply` cannot be read",
            ),
            (
                "<shape type='sphere'><transform name='to_world'><scale x='2'/></transform></shape>",
                "makes it no sphere",
            ),
            (
                "<shape type='sphere'><boolean name='flip_normals' value='true'/><emitter type='area'/></shape>",
                "a sphere that emits",
            ),
            (
                "<shape type='sphere'><boolean name='flip_normals' value='true'/><bsdf type='dielectric'/></shape>",
                "exchanged `int_ior`",
            ),
            ("<shape type='cube'><float name='size' value='2'/></shape>", "<float> `size` is not supported"),
            (
                "<shape type='cube'><float name='a' value='2'/><float name='a' value='3'/></shape>",
                "`a` is given twice",
            ),
            (
                "<shape type='cube'><boolean name='flip_normals' value='yes'/></shape>",
                "value `yes`; allowed: <boolean>, true or false",
            ),
            ("<shape type='cylinder'><point name='p1' value='0,0,0'/></shape>", "`p0` equals `p1`"),
            (
                "<shape type='cube'><transform name='to_world'><scale value='1e30'/></transform></shape>",
                "take a vertex to",
            ),
        ] {
            fails(text, 7, words);
        }
    }
}
