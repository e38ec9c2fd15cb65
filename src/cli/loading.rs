//! Scene files, for all commands that take one.

use std::path::Path;

use super::error::CliError;
use crate::scene::{Access, SceneDesc, load_with};

/// Loads a scene that is to be rendered in `size`, if one is asked for.
pub fn load_sized(
    path: &Path,
    access: impl Into<Access>,
    size: Option<(u32, u32)>,
) -> Result<SceneDesc, CliError> {
    let mut desc = load(path, access)?;
    desc.film = size.map_or(desc.film, |size| desc.film.resized(size));
    Ok(desc)
}

/// Loads a scene and passes on what its loader noticed.
pub fn load(path: &Path, access: impl Into<Access>) -> Result<SceneDesc, CliError> {
    const MOST_TOLD: usize = 100;
    let desc = load_with(path, &access.into())?;
    for warning in desc.warnings.iter().take(MOST_TOLD) {
        note!("warning: {warning}");
    }
    if desc.warnings.len() > MOST_TOLD {
        note!("warning: and {} more warnings", desc.warnings.len() - MOST_TOLD);
    }
    Ok(desc)
}
