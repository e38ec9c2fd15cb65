//! The tables `[[mesh]]`: an OBJ or PLY file, where it goes, its normals and materials.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::super::{Material, Mesh, SceneError, Textures};
use super::access::{Denial, Reader};
use super::fields::{Field, Fields, Names};
use super::geometry::{Normals, Placement};
use super::mesh_memory::{self, Kind};
use super::obj::{self, Obj};
use super::source::file_error;
use super::transform::Transform;
use super::{mtl, objects};
use crate::bsdf::Bsdf;
use crate::math::Rgb;

/// What meshes add to a scene beside themselves.
pub(super) struct Found {
    pub materials: Vec<Material>,
    pub warnings: Vec<String>,
    pub triangles: u64,
}

/// More libraries of one mesh are not read: a line of a few bytes could ask for the same large file again and again.
const MOST_LIBRARIES: usize = 64;

const NO_MATERIAL: &str =
    "field `material` is missing; allowed: the name of a material, as a PLY file has none";

/// A `[[mesh]]` table that has been checked, before its file is read.
struct Entry<'a> {
    table: &'a Fields<'a>,
    reader: &'a Reader<'a>,
    /// As the scene file writes it.
    file: &'a str,
    path: PathBuf,
    transform: Transform,
    normals: Normals,
    material: Option<u32>,
}

/// The meshes in the order of the file, which may name the materials `names`. Those of MTL files are appended to
/// what was found.
pub(super) fn meshes(
    root: &Fields,
    reader: &Reader,
    names: &Names,
    found: &mut Found,
) -> Result<Vec<Mesh>, SceneError> {
    let known = ["file", "scale", "rotate", "translate", "normals", "material"];
    objects::each(root, "mesh", &known, |table| {
        let file = table.required("file", "the path of an OBJ or PLY file")?;
        let path = reader.beside_scene(file.string()?);
        let named = table.optional("material").map(|_| objects::material(table, names));
        let (transform, normals) = (Transform::read(table)?, normals(table)?);
        let (file_name, material) = (file.string()?, named.transpose()?);
        Entry { table, reader, file: file_name, path, transform, normals, material }.mesh(&file, found)
    })
}

fn normals(table: &Fields) -> Result<Normals, SceneError> {
    const CHOICES: [Normals; 3] = [Normals::Smooth, Normals::Flat, Normals::File];
    let names = ["smooth", "flat", "file"].into_iter().collect();
    let choice = table.optional("normals").map(|field| field.choice(&names));
    Ok(choice.transpose()?.map_or(Normals::FileOrFlat, |i| CHOICES[i]))
}

impl Entry<'_> {
    fn mesh(&self, file: &Field, found: &mut Found) -> Result<Mesh, SceneError> {
        let keep = obj::Keep {
            normals: matches!(self.normals, Normals::File | Normals::FileOrFlat),
            uvs: self
                .material
                .is_some_and(|material| found.materials[material as usize].textures != Textures::NONE),
        };
        let is_ply = is_ply(&self.path);
        let kind = if is_ply { Kind::Ply } else { Kind::Obj(keep) };
        let obj = mesh_memory::parse(&self.path, self.bytes(file)?, kind, self.reader.memory())?;
        let n_triangles = obj.geometry.triangles.len();
        found.triangles += n_triangles as u64;
        let counted = self.reader.limits().check_triangles(found.triangles);
        counted.map_err(|reason| file_error(&self.path, reason))?;
        let materials = match self.material {
            Some(material) => vec![material; n_triangles],
            None if is_ply => return Err(self.table.error(String::from(NO_MATERIAL))),
            None => self.own_materials(&obj, found)?,
        };
        let placement = Placement {
            name: self.file,
            path: &self.path,
            motion: &self.transform,
            normals: self.normals,
            flip: false,
            keeps_unit_normals: is_ply,
            error: &|reason| self.table.error(reason),
        };
        placement.mesh(obj.geometry, materials, &mut found.warnings)
    }

    fn bytes(&self, file: &Field) -> Result<Vec<u8>, SceneError> {
        let shown = self.path.display();
        let is_water = self.path.file_name().is_some_and(|name| name == "surface.obj")
            && !self.reader.is_file(&self.path);
        let hint =
            if is_water { format!("; write it with: caustica surface {shown}") } else { String::new() };
        let denied = |denial: Denial| file.error(format!(": `{shown}` {}{hint}", denial.reason()));
        let kind = if is_ply(&self.path) { "a PLY mesh" } else { "an OBJ mesh" };
        self.reader.read(&self.path, kind).map_err(denied)
    }

    /// The material of each triangle by the OBJ's own libraries; those in use are appended to what was found.
    fn own_materials(&self, obj: &Obj, found: &mut Found) -> Result<Vec<u32>, SceneError> {
        let Found { materials, warnings, .. } = found;
        let library = self.library(&obj.libraries, warnings)?;
        // The last one of a name counts.
        let library = library.iter().map(|material| (material.name.as_str(), material)).collect();
        let mut by_name = vec![None; obj.material_names.len()];
        let mut unnamed = None;
        let mut of_triangle = |name: &Option<u32>| {
            let known = name.map_or(&mut unnamed, |i| &mut by_name[i as usize]);
            *known.get_or_insert_with(|| {
                let name = name.map(|i| obj.material_names[i as usize].as_str());
                let (bsdf, emission, opacity) = self.surface(name, &library, warnings);
                let name = format!("{}:{}", self.file, name.unwrap_or("(none)"));
                materials.push(Material { opacity, ..Material::plain(name, bsdf, emission) });
                materials.len() as u32 - 1
            })
        };
        Ok(obj.materials.iter().map(&mut of_triangle).collect())
    }

    fn surface(
        &self,
        name: Option<&str>,
        library: &BTreeMap<&str, &mtl::Mtl>,
        warnings: &mut Vec<String>,
    ) -> (Bsdf, Rgb, f32) {
        let path = self.path.display();
        let (grey, black) = mtl::grey();
        let Some(name) = name else {
            warnings.push(format!("{path}: faces without a material become diffuse grey 0.5"));
            return (grey, black, 1.0);
        };
        let Some(material) = library.get(name) else {
            warnings.push(format!("{path}: unknown material `{name}` becomes diffuse grey 0.5"));
            return (grey, black, 1.0);
        };
        let label = format!("{path}: material `{name}`");
        let (bsdf, emission) = mtl::surface(material, &label, warnings);
        (bsdf, emission, mtl::opacity(material, &bsdf, &label, warnings))
    }

    /// All materials of the libraries that the OBJ file names. The rest of a `mtllib` line is one name if there
    /// is such a file, else a list of names.
    fn library(
        &self,
        libraries: &[(usize, String)],
        warnings: &mut Vec<String>,
    ) -> Result<Vec<mtl::Mtl>, SceneError> {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let files = |(at, names): &(usize, String)| match folder.join(names) {
            whole if self.reader.is_file(&whole) => vec![(*at, whole)],
            _ => names.split_whitespace().map(|name| (*at, folder.join(name))).collect(),
        };
        let mut seen = BTreeSet::new();
        let once = libraries.iter().flat_map(files).filter(|(_, path)| seen.insert(path.clone()));
        let mut materials = Vec::new();
        for (n, (line, path)) in once.enumerate() {
            if n == MOST_LIBRARIES {
                let obj = self.path.display();
                warnings.push(format!(
                    "{obj}:{line}: more than {MOST_LIBRARIES} MTL files; the rest is not read"
                ));
                break;
            }
            match self.reader.read(&path, "an MTL file") {
                Ok(bytes) => materials.extend(mtl::parse(&path, &String::from_utf8_lossy(&bytes), warnings)),
                Err(Denial::Unreadable(reason)) => {
                    warnings.push(format!("{}: {reason}; its materials become grey 0.5", path.display()));
                }
                Err(Denial::Forbidden(reason)) => {
                    let reason = format!("mtllib `{}` {reason}", path.display());
                    return Err(SceneError::Line { path: self.path.clone(), line, reason });
                }
            }
        }
        Ok(materials)
    }
}

fn is_ply(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("ply"))
}

#[cfg(test)]
mod tests {
    use super::super::testing::{BASE, TRIANGLE, added_fails_with, close, good, mesh_with, normal, read};
    use super::*;
    use crate::math::Vec3;

    #[test]
    fn mistakes_in_a_mesh_are_told() {
        for (tables, line, words) in [
            (
                "[[mesh]]\nmaterial = \"a\"",
                10,
                "mesh 1: field `file` is missing; allowed: the path of an OBJ or PLY file",
            ),
            ("[[mesh]]\nfile = \"no.obj\"", 11, "field `file`: `no.obj` cannot be read"),
            ("[[mesh]]\nfile = \"surface.obj\"", 11, "write it with: caustica surface surface.obj"),
            ("[[mesh]]\nfile = \".\"", 11, "is a folder; an OBJ mesh is expected"),
            (
                "[[mesh]]\nfile = \"m.obj\"\nscale = 0",
                12,
                "is 0; allowed: a number or three numbers, none of them zero",
            ),
            ("[[mesh]]\nfile = \"m.obj\"\nscale = [1, 0, 1]", 12, "none of them zero"),
            ("[[mesh]]\nfile = \"m.obj\"\nscale = [1, 2]", 12, "allowed: an array of 3 numbers"),
            ("[[mesh]]\nfile = \"m.obj\"\nscale = inf", 12, "is inf; allowed: a finite number"),
            ("[[mesh]]\nfile = \"m.obj\"\nscale = 1e30", 10, "take a vertex to [1"),
            (
                "[[mesh]]\nfile = \"m.obj\"\nrotate = { axis = [0, 0, 0], degrees = 3 }",
                12,
                "mesh 1, rotate: field `axis` is [0, 0, 0]; allowed: a direction",
            ),
            ("[[mesh]]\nfile = \"m.obj\"\nrotate = { axis = [0, 1, 0] }", 12, "field `degrees` is missing"),
            (
                "[[mesh]]\nfile = \"m.obj\"\nnormals = \"smoth\"",
                12,
                "unknown name `smoth`; did you mean `smooth`? allowed: `smooth`, `flat`, `file`",
            ),
            (
                "[[mesh]]\nfile = \"m.obj\"\nnormals = \"file\"",
                10,
                "m.obj` has none; allowed: `smooth` or `flat`",
            ),
            ("[[mesh]]\nfile = \"m.obj\"\nmaterial = \"b\"", 12, "unknown name `b`;"),
        ] {
            added_fails_with(tables, line, words);
        }
    }

    #[test]
    fn meshes_are_scaled_then_rotated_then_translated() {
        let table =
            "scale = [2, 3, 4]\nrotate = { axis = [0, 0, 2], degrees = 90 }\ntranslate = [10, 20, 30]";
        let (mesh, scene) =
            mesh_with(&format!("{table}\nmaterial = \"a\""), "v 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3");
        let expected = [Vec3::new(10., 22., 30.), Vec3::new(7., 20., 30.), Vec3::new(10., 20., 34.)];
        assert!(mesh.vertices.iter().zip(expected).all(|(&v, e)| close(v, e)), "{:?}", mesh.vertices);
        assert_eq!((mesh.name.as_str(), mesh.materials, mesh.normals), ("m.obj", vec![0], None));
        assert!(scene.warnings.is_empty());
    }

    #[test]
    fn a_mirroring_scale_keeps_normals_outward() {
        let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 5\nf 1//1 2//1 3//1";
        for (scale, z) in [
            ("[1, 1, 1]", 1.0),
            ("[-1, 1, 1]", 1.0),
            ("[1, 1, -1]", -1.0),
            ("-1", -1.0),
            ("[-1, -1, 1]", 1.0),
        ] {
            let (mesh, _) = mesh_with(&format!("scale = {scale}\nmaterial = \"a\""), obj);
            assert!(close(normal(&mesh, 0), z * Vec3::Z), "{scale}");
            assert!(mesh.normals.unwrap().iter().all(|&n| close(n, z * Vec3::Z)), "{scale}");
        }
    }

    #[test]
    fn normals_come_from_where_the_scene_says() {
        // A roof of two faces whose file normals all point up.
        let roof = "v 0 0 0\nv 0 0 1\nv 1 1 0\nv 1 1 1\nv 2 0 0\nv 2 0 1\nvn 0 2 0\n\
            f 1//1 2//1 4//1 3//1\nf 3//1 4//1 6//1 5//1\n";
        let normals =
            |table: &str, obj: &str| mesh_with(&format!("{table}\nmaterial = \"a\""), obj).0.normals;
        assert_eq!(normals("", roof), Some(vec![Vec3::Y; 6]));
        assert_eq!(normals("normals = \"file\"", roof), Some(vec![Vec3::Y; 6]));
        assert_eq!(normals("normals = \"flat\"", roof), None);
        assert_eq!(normals("", TRIANGLE), None);
        // Smoothing joins what differing normals in the file would split.
        let split = roof.replace("f 3//1 4//1", "vn 1 0 0\nf 3//2 4//2");
        let smooth = normals("normals = \"smooth\"", &split).unwrap();
        let ridge = smooth.iter().filter(|n| close(**n, Vec3::Y)).count();
        let slopes = smooth.iter().filter(|n| (n.y - 0.5f32.sqrt()).abs() < 1e-5 && n.z.abs() < 1e-6).count();
        assert_eq!((ridge, slopes), (2, 4), "{smooth:?}");
    }

    #[test]
    fn missing_normals_fall_back_to_the_faces() {
        let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 1 0 0\nvn nan 0 0\nf 1//1 2//2 3";
        let (mesh, scene) = mesh_with("material = \"a\"", obj);
        assert_eq!(mesh.normals, Some(vec![Vec3::X, Vec3::Z, Vec3::Z]));
        assert!(
            scene.warnings[0]
                .contains("m.obj: missing or zero vertex normals replaced by those of the faces around: 2"),
            "{:?}",
            scene.warnings
        );
    }

    #[test]
    fn repairs_of_meshes_are_counted_in_warnings() {
        let obj = format!("{TRIANGLE}f 1 2\nf 1\nl 1 2\nf 1 2 2\nf 1 2 1\n");
        let (mesh, scene) = mesh_with("material = \"a\"", &obj);
        assert_eq!((mesh.triangles.len(), mesh.materials.len()), (1, 1));
        assert!(
            scene.warnings[0].contains("m.obj: ignored points, lines and faces of fewer than 3 vertices: 3")
        );
        assert!(scene.warnings[1].contains("m.obj: dropped triangles without area: 2"));
        let flat =
            read(&format!("{BASE}[[mesh]]\nfile = \"m.obj\""), &[("m.obj", "v 0 0 0\nv 1 1 1\nf 1 2 1\n")]);
        assert!(flat.unwrap_err().starts_with("m.obj: empty mesh: no triangle has an area"));
        let wrong = read(&format!("{BASE}[[mesh]]\nfile = \"m.obj\""), &[("m.obj", "v 0 0 0\nf 1 2 3\n")]);
        assert!(wrong.unwrap_err().starts_with("m.obj:2: vertex index 3 is out of range"));
    }

    #[test]
    fn mtl_materials_count_unless_the_scene_names_one() {
        let obj = format!(
            "mtllib one.mtl two.mtl\nmtllib one.mtl\n{TRIANGLE}usemtl red\nf 1 2 3\nusemtl lamp\nf 1 2 3\nusemtl red\nf 3 2 1\nusemtl no\nf 1 2 3\n"
        );
        let one = "newmtl unused\nKd 1 1 1\nnewmtl red\nKd 0.9 0 0\n";
        let files =
            [("m.obj", obj.as_str()), ("one.mtl", one), ("two.mtl", "newmtl lamp\nKd 0 0 0\nKe 7 7 7")];
        let text = format!("{BASE}[[mesh]]\nfile = \"m.obj\"\n");
        let scene = good(&text, &files);
        let names: Vec<&str> = scene.materials.iter().map(|m| m.name.as_str()).collect();
        assert_eq!(names, ["a", "m.obj:(none)", "m.obj:red", "m.obj:lamp", "m.obj:no"]);
        assert_eq!(scene.meshes[0].materials, [1, 2, 3, 2, 4]);
        assert_eq!(scene.materials[3].emission, Rgb::splat(7.0));
        let grey = Bsdf::Diffuse { albedo: Rgb::splat(0.5) };
        assert_eq!((scene.materials[1].bsdf, scene.materials[4].bsdf), (grey, grey));
        assert_eq!(scene.warnings.len(), 2, "{:?}", scene.warnings);
        assert!(scene.warnings[0].contains("m.obj: faces without a material become diffuse grey 0.5"));
        assert!(scene.warnings[1].contains("m.obj: unknown material `no` becomes diffuse grey 0.5"));
        let scene = good(&format!("{text}material = \"a\"\n"), &files);
        assert_eq!((scene.materials.len(), scene.warnings.len()), (1, 0));
    }

    #[test]
    fn a_missing_library_is_told_once() {
        let obj = format!("mtllib one.mtl two.mtl\nmtllib one.mtl\n{TRIANGLE}");
        let (_, scene) = mesh_with("", &obj);
        let told = |name: &str| scene.warnings.iter().filter(|w| w.contains(name)).count();
        assert_eq!((told("one.mtl: cannot be read"), told("two.mtl: cannot be read")), (1, 1));
    }

    #[test]
    fn libraries_may_have_blanks_in_their_names_and_the_last_material_of_a_name_counts() {
        let obj = format!("mtllib my own.mtl\nusemtl red\n{TRIANGLE}");
        let library = "newmtl red\nKd 0 0 0\nnewmtl red\nKd 1 0 0\n";
        let scene =
            good(&format!("{BASE}[[mesh]]\nfile = \"m.obj\"\n"), &[("m.obj", &obj), ("my own.mtl", library)]);
        assert_eq!(scene.materials[1].bsdf, Bsdf::Diffuse { albedo: Rgb::X });
        assert!(scene.warnings.is_empty());
    }

    #[test]
    fn a_scene_cannot_name_what_a_mesh_brought_along() {
        let first = format!("{BASE}[[mesh]]\nfile = \"m.obj\"\n");
        let error = read(
            &format!("{first}{}", "[[mesh]]\nfile = \"m.obj\"\nmaterial = \"m.obj:(none)\"\n"),
            &[("m.obj", TRIANGLE)],
        );
        assert!(error.unwrap_err().contains("unknown name `m.obj:(none)`; allowed: `a`"));
    }
}
