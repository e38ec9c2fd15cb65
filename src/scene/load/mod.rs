//! Scene files (TOML, or the XML of Mitsuba 3) and the meshes they name (OBJ with MTL, PLY), turned into a [`SceneDesc`] by the rules in the
//! documentation of [`crate::scene`].

mod access;
mod affine;
mod bare_mesh;
mod fields;
mod files_read;
mod geometry;
mod gltf;
mod lights;
mod material;
mod mesh_entry;
mod mesh_memory;
mod mtl;
mod obj;
mod objects;
mod pictures;
mod places;
mod ply;
mod polygon;
mod scene_text;
mod settings;
mod source;
mod statements;
#[cfg(test)]
mod testing;
mod transform;
mod xml;

use std::path::Path;

use toml::de::DeTable;

use self::access::Reader;
pub use self::access::{Access, Limits};
use self::fields::Fields;
pub use self::files_read::FilesRead;
use self::mesh_entry::Found;
pub use self::mesh_memory::MeshMemory;
pub(super) use self::objects::check_quad;
use self::source::Source;
use super::{SceneDesc, SceneError, media};
use crate::math::Rgb;

/// Reads a scene file and the meshes it names, whose paths are relative to it: [`load_with`] access to any file.
///
/// # Errors
/// As those of [`load_with`].
pub fn load(path: &Path) -> Result<SceneDesc, SceneError> {
    load_with(path, &Access::any())
}

/// Reads a scene file and the meshes it names, as far as it is given access to them.
///
/// # Errors
/// A [`SceneError`] for anything missing, unknown, of the wrong type or out of range. What is repaired instead is
/// told in [`SceneDesc::warnings`]; so is a scene without light, which renders black.
pub fn load_with(path: &Path, access: &Access) -> Result<SceneDesc, SceneError> {
    let reader = Reader::new(access, path)?;
    let extension = path.extension().map(|extension| extension.to_ascii_lowercase());
    let mut scene = match extension.as_ref().and_then(|extension| extension.to_str()) {
        Some("xml") => xml::read(path, &reader)?,
        Some("gltf" | "glb") => without_parameters(path, &reader).and_then(|()| gltf::read(path, &reader))?,
        Some("obj") => without_parameters(path, &reader).and_then(|()| bare_mesh::read(path, &reader))?,
        _ => without_parameters(path, &reader).and_then(|()| read_toml(path, &reader))?,
    };
    check_media(&scene)?;
    warn_of_darkness(&mut scene);
    Ok(scene)
}

fn check_media(scene: &SceneDesc) -> Result<(), SceneError> {
    let count = media::count(&scene.materials);
    if count <= media::MOST_MEDIA {
        return Ok(());
    }
    let reason = format!("its glass absorbs in {count} ways; allowed: {} at most", media::MOST_MEDIA);
    Err(source::file_error(&scene.path, reason))
}

fn without_parameters(path: &Path, reader: &Reader) -> Result<(), SceneError> {
    let Some(name) = reader.definitions().keys().next() else { return Ok(()) };
    let reason = format!("-D {name}: the file has no parameters; allowed: -D for Mitsuba's XML");
    Err(source::file_error(path, reason))
}

fn read_toml(path: &Path, reader: &Reader) -> Result<SceneDesc, SceneError> {
    let text = scene_text::read_scene_text(path, reader)?;
    let source = Source::new(path, &text);
    let table = DeTable::parse(&text).map_err(|e| syntax_error(&source, &e))?;
    const TABLES: [&str; 11] = [
        "film",
        "camera",
        "render",
        "material",
        "point_light",
        "spot_light",
        "distant_light",
        "environment",
        "sphere",
        "quad",
        "mesh",
    ];
    read_scene(path, &Fields::root(&source, &table, &TABLES)?, reader)
}

fn syntax_error(source: &Source, error: &toml::de::Error) -> SceneError {
    let span = error.span().unwrap_or(0..0);
    let key = source.text.get(span.clone()).filter(|_| error.message() == "duplicate key");
    let named = key.map_or(String::new(), |key| format!(" `{key}`; allowed: each key once in its table"));
    source.error(&span, format!("{}{named}", error.message()))
}

fn read_scene(path: &Path, root: &Fields, reader: &Reader) -> Result<SceneDesc, SceneError> {
    let mut warnings = Vec::new();
    let own = material::materials(root, reader, &mut warnings)?;
    let names = own.iter().map(|material| material.name.as_str()).collect();
    let film = settings::film(root, reader.limits())?;
    let camera = settings::camera(root)?;
    let render = settings::render(root, reader.limits())?;
    settings::check_eye_paths(&film, &render, reader.limits()).map_err(|reason| {
        let place = root.optional("film").or_else(|| root.optional("render"));
        place.map_or_else(|| root.error(reason.clone()), |field| field.error(reason.clone()))
    })?;
    let spheres = objects::spheres(root, &names)?;
    let point_lights = objects::point_lights(root, &mut warnings)?;
    let further_lights = lights::further_lights(root, reader)?;
    let mut meshes = objects::quads(root, &names)?;
    let mut found = Found { materials: own.clone(), warnings, triangles: 0 };
    meshes.extend(mesh_entry::meshes(root, reader, &names, &mut found)?);
    Ok(SceneDesc {
        name: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        path: path.to_owned(),
        film,
        camera,
        render,
        spheres,
        point_lights,
        further_lights,
        meshes,
        materials: found.materials,
        warnings: found.warnings,
        places: places::places(path, root)?,
    })
}

fn warn_of_darkness(scene: &mut SceneDesc) {
    let shines = |m: &u32| scene.materials[*m as usize].emission != Rgb::ZERO;
    let emitters = scene.meshes.iter().flat_map(|mesh| &mesh.materials).any(shines)
        || scene.spheres.iter().any(|sphere| shines(&sphere.material));
    if !emitters
        && scene.further_lights.is_empty()
        && scene.point_lights.iter().all(|light| light.intensity == Rgb::ZERO)
    {
        let reason =
            "no light that shines (point light, or quad or mesh with emission): the picture is black";
        scene.warnings.push(format!("{}: {reason}", scene.path.display()));
    }
}

#[cfg(test)]
mod tests {
    use super::testing::{BASE, changed_fails_with, folder, good, read};
    use super::*;

    #[test]
    fn mistakes_of_syntax_are_told() {
        for (old, new, place, words) in [
            ("fov = 40", "fov = 40\nfov = 41", "s.toml:5:1", "duplicate key `fov`"),
            ("fov = 40", "fov = ", "s.toml:4:", "expected"),
            (
                "[camera]",
                "[camer]",
                "s.toml:1:2",
                "unknown field `camer`; did you mean `camera`? allowed: `film`",
            ),
            ("[camera]", "[camera", "s.toml:1:8", "unclosed table"),
            ("[camera]", "camera = 3\n[film]", "s.toml:3:1: film", "unknown field `position`"),
        ] {
            changed_fails_with(old, new, place, words);
        }
    }

    #[test]
    fn files_that_are_no_scene_are_refused() {
        let (folder, path) = folder(b"[camera]\nname = \"caf\xe9\"\n", &[]);
        let error = |path: &Path| load(path).unwrap_err().to_string();
        assert!(error(&path).contains("s.toml: is not UTF-8 (line 2)"), "{}", error(&path));
        assert!(error(folder.path()).contains("is a folder; a scene file (TOML or XML, UTF-8) is expected"));
        assert!(error(&folder.path().join("x.toml")).contains("x.toml: cannot be read: "));
        for empty in ["", " \n\n"] {
            assert!(read(empty, &[]).unwrap_err().starts_with("s.toml: is empty; a scene file"));
        }
        assert!(
            read("# only a comment", &[])
                .unwrap_err()
                .contains("field `camera` is missing; allowed: a table [camera]")
        );
    }

    #[test]
    fn a_byte_order_mark_and_crlf_are_in_order() {
        let scene = good(&format!("\u{feff}{}", BASE.replace('\n', "\r\n")), &[]);
        assert_eq!(scene.camera, good(BASE, &[]).camera);
    }

    #[test]
    fn more_media_than_a_byte_numbers_are_refused() {
        let glass = |count: usize| {
            let one =
                |k| format!("[material.g{k}]\ndielectric = {{ ior = 1.5 }}\nabsorption = [{k}, 0, 0]\n");
            (0..count).map(one).collect::<String>()
        };
        assert_eq!(good(&format!("{BASE}{}", glass(255)), &[]).materials.len(), 256);
        let error = read(&format!("{BASE}{}", glass(256)), &[]).unwrap_err();
        assert_eq!(error, "s.toml: its glass absorbs in 256 ways; allowed: 255 at most");
    }

    #[test]
    fn darkness_is_a_warning() {
        let dark = BASE.split("[[point_light]]").next().unwrap();
        let zero = BASE.replace("intensity = [1, 1, 1]", "intensity = [0, 0.0, 0]");
        let light = "[material.l]\ndiffuse = { albedo = [0, 0, 0] }\nemission = [E, 0, 0]\n";
        let quad = "[[quad]]\ncorners = [[0,0,0],[1,0,0],[1,1,0],[0,1,0]]\nmaterial = \"l\"\n";
        let warnings = |text: &str| good(text, &[]).warnings.join("\n");
        assert!(warnings(dark).contains("s.toml: no light that shines"));
        let both = warnings(&zero);
        assert!(
            both.contains("s.toml:7: point_light 1: intensity is zero") && both.contains("no light"),
            "{both}"
        );
        assert!(
            warnings(&format!("{dark}{}{quad}", light.replace('E', "0")))
                .contains("material `l`: emission is zero")
        );
        assert!(warnings(&format!("{dark}{}", light.replace('E', "1"))).contains("no light"));
        assert_eq!(warnings(&format!("{dark}{}{quad}", light.replace('E', "1"))), "");
    }
}
