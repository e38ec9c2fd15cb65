use std::path::{Path, PathBuf};

use super::args::DisplayArgs;
use super::error::CliError;
use crate::film::Image;
use crate::output::{
    Display, ExrLayer, LARGEST_HALF, Metadata, check_writable, write_exr, write_exr_half, write_exr_layers,
    write_png,
};

/// Where a picture goes: an EXR for numbers and a PNG of the same name for eyes.
#[derive(Clone, Debug)]
pub struct PicturePath {
    exr: PathBuf,
    png: PathBuf,
    half: bool,
}

impl PicturePath {
    /// Checks, before any work is done, that both files can be written.
    pub fn new(exr: &Path) -> Result<PicturePath, CliError> {
        check_writable(exr).map_err(CliError::BadOutput)?;
        if exr.extension().is_none_or(|e| !e.eq_ignore_ascii_case("exr")) {
            return Err(CliError::NotExrName { path: exr.into() });
        }
        let png = exr.with_extension("png");
        check_writable(&png).map_err(CliError::BadOutput)?;
        Ok(PicturePath { exr: exr.into(), png, half: false })
    }

    /// Whether [`PicturePath::write`] keeps 16 bits a sample.
    pub fn with_half(self, half: bool) -> PicturePath {
        PicturePath { half, ..self }
    }

    /// A picture whose folder was found to be writable before.
    pub fn in_checked_folder(folder: &Path, name: &str) -> PicturePath {
        let exr = folder.join(name);
        PicturePath { png: exr.with_extension("png"), exr, half: false }
    }

    /// A picture of the same name with `suffix` before its extension.
    pub fn with_suffix(&self, suffix: &str) -> Result<PicturePath, CliError> {
        let stem = self.exr.file_stem().unwrap_or_default().to_string_lossy();
        PicturePath::new(&self.exr.with_file_name(format!("{stem}{suffix}.exr")))
    }

    /// Writes both files; warns of pixels that are not numbers.
    pub fn write(&self, image: &Image, metadata: &Metadata, display: &Display) -> Result<(), CliError> {
        self.write_layers(image, &[], metadata, display)
    }

    /// Writes both files, the EXR with further layers.
    pub fn write_layers(
        &self,
        image: &Image,
        layers: &[ExrLayer],
        metadata: &Metadata,
        display: &Display,
    ) -> Result<(), CliError> {
        self.warn_of_non_finite(image);
        if self.half {
            let clamped = write_exr_half(&self.exr, image, layers, metadata)?;
            self.warn_of_clamped(clamped);
        } else {
            write_exr_layers(&self.exr, image, layers, metadata)?;
        }
        Ok(write_png(&self.png, image, display)?)
    }

    /// Writes the EXR alone.
    pub fn write_exr(&self, image: &Image, metadata: &Metadata) -> Result<(), CliError> {
        self.warn_of_non_finite(image);
        Ok(write_exr(&self.exr, image, metadata)?)
    }

    fn warn_of_clamped(&self, n: usize) {
        if n > 0 {
            let path = self.exr.display();
            note!(
                "warning: {path}: {n} values beyond ±{LARGEST_HALF}, the most that 16 bits hold, became that"
            );
        }
    }

    fn warn_of_non_finite(&self, image: &Image) {
        if let Some((x, y)) = image.first_non_finite() {
            let count = image.count_non_finite();
            note!("warning: {}: {count} pixels are not finite, the first at ({x}, {y})", self.exr.display());
        }
    }

    pub fn exr(&self) -> &Path {
        &self.exr
    }

    pub fn png(&self) -> &Path {
        &self.png
    }
}

/// Where a picture goes that the user gave no name.
pub fn default_output(scene: &str, suffix: &str) -> PathBuf {
    PathBuf::from("out").join(format!("{scene}{suffix}.exr"))
}

impl From<&DisplayArgs> for Display {
    fn from(args: &DisplayArgs) -> Display {
        Display { exposure: args.exposure, curve: args.curve.into(), gamma: args.gamma }
    }
}
