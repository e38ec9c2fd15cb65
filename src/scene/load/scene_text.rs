//! The text of a scene file, as it is read.

use std::path::Path;

use super::super::SceneError;
use super::access::{Denial, Reader};
use super::source::file_error;
use crate::input;

/// The text of a scene file without its byte order mark, if it has one.
pub(super) fn read_scene_text(path: &Path, reader: &Reader) -> Result<String, SceneError> {
    const KIND: &str = "a scene file (TOML or XML, UTF-8)";
    let bytes = reader.read(path, KIND).map_err(|denial: Denial| file_error(path, denial.reason()))?;
    let most = reader.limits().scene_bytes;
    if bytes.len() as u64 > most {
        let (length, most) = (input::size(bytes.len() as u64), input::size(most));
        return Err(file_error(path, format!("holds {length}; allowed in the sandbox: {most}")));
    }
    let text = String::from_utf8(bytes).map_err(|e| {
        let line = e.as_bytes()[..e.utf8_error().valid_up_to()].split(|&b| b == b'\n').count();
        file_error(path, format!("is not UTF-8 (line {line}); {KIND} is expected"))
    })?;
    if text.trim().is_empty() {
        return Err(file_error(path, format!("is empty; {KIND} with at least a camera is expected")));
    }
    Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
}
