use std::path::Path;

use super::error::CliError;
use super::pictures::PicturePath;
use crate::denoise::Denoiser;
use crate::output::{Display, Metadata, Value};
use crate::ppm::Render;

/// The denoised picture beside the true one.
pub struct Denoised {
    path: PicturePath,
    denoiser: Denoiser,
}

impl Denoised {
    /// Checks, before any work is done, that it can be made and written.
    pub fn beside(picture: &Path, half: bool) -> Result<Denoised, CliError> {
        let path = PicturePath::new(picture)?.with_suffix("_denoised")?.with_half(half);
        Ok(Denoised { path, denoiser: Denoiser::new()? })
    }

    pub fn write(&self, render: &Render, metadata: &Metadata, display: &Display) -> Result<(), CliError> {
        let features = render.features();
        let picture = self.denoiser.denoise(&render.picture(), &features.albedo, &features.normal)?;
        let metadata = metadata.clone().with("caustica:denoised", Value::Text("Open Image Denoise".into()));
        self.path.write(&picture, &metadata, display)
    }
}
