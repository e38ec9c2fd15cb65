//! Scenes as files: the TOML of this program or the XML of Mitsuba 3, with meshes as PLY and copies of pictures beside them.

mod normal_form;
mod pictures;
mod ply;
mod toml;
mod xml;

use std::path::{Path, PathBuf};

pub use normal_form::normal_form;

use self::pictures::Pictures;
use super::{Mesh, SceneDesc};
use crate::math::{Vec2, Vec3};

/// A scene as the contents of files.
#[derive(Clone, Debug, PartialEq)]
pub struct SavedScene {
    /// The scene file.
    pub text: String,
    /// The mesh files, with their paths relative to the scene file.
    pub meshes: Vec<(PathBuf, Vec<u8>)>,
    /// The picture files, in the same way.
    pub pictures: Vec<(PathBuf, Vec<u8>)>,
    /// What the files lack of the scene.
    pub warnings: Vec<String>,
}

/// Why a scene has no file of that kind.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SaveError {
    /// The name says of what kind the file is to be.
    #[error("{}: unknown kind of scene file; allowed: names that end in .toml or .xml", path.display())]
    UnknownKind {
        /// The file.
        path: PathBuf,
    },
    /// The format has no word for a part of the scene.
    #[error("{what} cannot be written as Mitsuba's XML; allowed: {allowed}")]
    NoCounterpart {
        /// The part and what it is.
        what: String,
        /// What can be written, and the way around.
        allowed: String,
    },
    /// A picture is no longer what was loaded.
    #[error("{}: the picture cannot be copied: {reason}; allowed: the file that the scene was read with", path.display())]
    Picture {
        /// Its file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
}

/// The files of a scene whose scene file is to be `path`: TOML or XML by its name.
///
/// They describe [`normal_form`] of the scene exactly: all numbers come back as they are, but for directions of lights, which may
/// differ in their last bit. Meshes and copies of the picture files stand in folders beside the scene file, called as it with
/// `_meshes` and `_pictures` in place of the extension. A `lenient` writer replaces what XML has no word for, and says by what.
///
/// # Errors
/// A [`SaveError`] for other kinds of files, for pictures whose files are gone, and for what XML has no word for unless the writer
/// is `lenient`.
pub fn save(desc: &SceneDesc, path: &Path, lenient: bool) -> Result<SavedScene, SaveError> {
    let desc = normal_form(desc.clone());
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let folder = format!("{stem}_meshes");
    let pictures = Pictures::new(format!("{stem}_pictures"));
    let kind = path.extension().map(|extension| extension.to_ascii_lowercase());
    match kind.as_ref().and_then(|kind| kind.to_str()) {
        Some("toml") => toml::write(&desc, &folder, pictures),
        Some("xml") => xml::write(&desc, &folder, pictures, lenient),
        _ => Err(SaveError::UnknownKind { path: path.to_owned() }),
    }
}

/// The texture coordinates of every quad.
const QUAD_UVS: [Vec2; 4] = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];

/// The corners of a mesh that is a quad: two triangles around one corner, flat.
fn quad_corners(mesh: &Mesh) -> Option<[Vec3; 4]> {
    let corners = <[_; 4]>::try_from(&mesh.vertices[..]).ok()?;
    let is_plain = mesh.normals.is_none() && mesh.uvs.as_deref() == Some(&QUAD_UVS);
    let is_quad = is_plain && mesh.triangles == [[0, 1, 2], [0, 2, 3]];
    (is_quad && super::load::check_quad(&corners).is_ok()).then_some(corners)
}

/// The degrees that readers turn into these radians, where there are such.
fn degrees(radians: f32) -> f32 {
    let nearest = radians.to_degrees();
    let around = [nearest, nearest.next_up(), nearest.next_down(), nearest.next_up().next_up()];
    around.into_iter().find(|degrees| degrees.to_radians() == radians).unwrap_or(nearest)
}

/// Names of mesh files: numbered, so that no two are the same.
fn mesh_file(folder: &str, number: usize) -> PathBuf {
    Path::new(folder).join(format!("mesh_{number:04}.ply"))
}

#[cfg(test)]
mod tests;
