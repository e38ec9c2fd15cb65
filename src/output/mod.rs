//! Pictures on disk: EXR for numbers, PNG for eyes, and the safe way to put any file in its place.

mod atomic;
mod curve;
mod error;
mod exr_header;
mod exr_layer;
mod exr_read;
mod exr_write;
mod metadata;
mod part;
mod png;
mod png_read;

pub use self::png::{Display, encode_png, write_png, write_png_samples};
pub use atomic::{check_writable, replace_atomically, write_atomically, write_bytes};
pub use curve::Curve;
pub use error::OutputError;
pub use exr_layer::{ExrLayer, LayerChannels};
pub use exr_read::{MAX_PIXELS, read_exr, read_exr_bytes, read_exr_layer, read_exr_named};
pub use exr_write::{LARGEST_HALF, encode_exr, write_exr, write_exr_half, write_exr_layers};
pub use metadata::{Metadata, Value};
pub use png_read::{read_png, read_png_bytes, read_png_opacity_bytes};

use std::path::Path;

/// The longest side, in pixels, that PNG and EXR files can state.
const MAX_SIDE: usize = i32::MAX as usize;

fn check_sides(path: &Path, width: usize, height: usize) -> Result<(), OutputError> {
    if [width, height].iter().all(|side| (1..=MAX_SIDE).contains(side)) {
        return Ok(());
    }
    Err(OutputError::Size { path: path.to_path_buf(), width, height, limit: MAX_SIDE })
}
