//! Scenes as files: the TOML of this program or the XML of Mitsuba 3, with meshes as PLY and copies of pictures beside them.

mod degrees;
mod normal_form;
mod pictures;
mod ply;
mod quads;
mod saved_scene;
mod toml;
mod xml;

use std::path::Path;

pub use normal_form::normal_form;
pub use saved_scene::{SaveError, SavedScene};

use self::pictures::Pictures;
use super::SceneDesc;

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

#[cfg(test)]
mod tests;
