use crate::math::{Rgb, Vec3};

/// The start of a photon.
#[derive(Clone, Copy, Debug)]
pub struct EmissionSample {
    /// Where it starts, already off the light's surface.
    pub origin: Vec3,
    /// Where it goes, unit.
    pub dir: Vec3,
    /// What it carries: emitted flux over the density of the sample (W).
    pub power: Rgb,
}

/// The end of a shadow ray on a light.
#[derive(Clone, Copy, Debug)]
pub struct IlluminationSample {
    /// The point on the light, already off its surface.
    pub target: Vec3,
    /// How uncertain `target` is, in scene units; the shadow ray ends that far before it.
    pub target_error: f32,
    /// Direction to the light, unit.
    pub wi: Vec3,
    /// Irradiance on a surface that faces the light, over the density of the sample (W/m²).
    pub irradiance: Rgb,
    /// The density of `wi` (1/sr); infinite of a light without extent.
    pub pdf_w: f32,
}
