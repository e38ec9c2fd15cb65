//! Intel's Open Image Denoise, in programs that are built with the feature `oidn`.

use oidn::{Device, RayTracing};
use thiserror::Error;

use crate::film::Image;
use crate::math::Rgb;

/// Why a picture is not denoised.
#[derive(Debug, Error)]
pub enum DenoiseError {
    /// The library does not run on this machine.
    #[error(
        "Open Image Denoise does not start: {reason}; it needs a processor with SSE4.1 and its device library beside it"
    )]
    Start {
        /// What the library says.
        reason: String,
    },
    /// It refuses the picture.
    #[error("Open Image Denoise fails: {reason}; render without --denoise")]
    Filter {
        /// What the library says.
        reason: String,
    },
}

/// The denoiser, ready for any number of pictures. It runs on the processor, by as many threads as that has.
pub struct Denoiser(Device);

impl Denoiser {
    /// Starts the library.
    ///
    /// # Errors
    /// When it does not run on this machine.
    pub fn new() -> Result<Denoiser, DenoiseError> {
        let device = Device::cpu().map_err(|error| DenoiseError::Start { reason: error.to_string() })?;
        Ok(Denoiser(device))
    }

    /// A picture (radiance) with less noise, by what is seen in it: albedo from 0 to 1 and normals in any one space, as large as
    /// the picture, and possibly noisy themselves.
    ///
    /// What comes out is a guess that is biased: it is to be looked at, not to be measured.
    ///
    /// # Errors
    /// When the library fails, as for pictures of different sizes.
    ///
    /// # Source
    /// Áfra, "Intel Open Image Denoise: Optimized CPU Inference", High-Performance Graphics 2019.
    pub fn denoise(&self, picture: &Image, albedo: &Image, normal: &Image) -> Result<Image, DenoiseError> {
        let failed = |reason: String| DenoiseError::Filter { reason };
        let (width, height) = (picture.width(), picture.height());
        let mut samples = samples(picture);
        let mut filter = RayTracing::try_new(&self.0).map_err(|error| failed(error.to_string()))?;
        filter.image_dimensions(width, height).hdr(true);
        filter.albedo_normal(&self::samples(albedo), &self::samples(normal));
        filter.filter_in_place(&mut samples).map_err(|error| failed(error.to_string()))?;
        let pixels = samples.as_chunks().0.iter().map(|&channels| Rgb::from_array(channels)).collect();
        Image::from_pixels(width, height, pixels).ok_or_else(|| failed("it gave too few pixels".into()))
    }
}

fn samples(image: &Image) -> Vec<f32> {
    image.pixels().iter().flat_map(|pixel| pixel.to_array()).collect()
}
