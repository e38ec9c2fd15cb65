//! How surfaces scatter light: a closed set of materials, sampled and evaluated in the local shading frame.

use crate::math::Rgb;

/// A surface's scattering function. Reflectances are dimensionless and in `[0, 1]` per channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bsdf {
    /// Lambertian, two-sided: `f = albedo / π`.
    Diffuse {
        /// Reflected share of the incident power.
        albedo: Rgb,
    },
    /// A perfect mirror on both sides, without Fresnel's law.
    Mirror {
        /// Reflected share of the incident power.
        reflectance: Rgb,
    },
    /// A smooth, lossless interface that obeys Fresnel's law.
    Dielectric {
        /// Index of refraction inside (behind the geometric normal) over outside.
        ior: f32,
    },
    /// The course's material: fixed shares of mirror reflection and refraction, the rest Lambertian.
    ///
    /// `f = (1 - reflectivity - transparency) color / π` beside the two specular shares; no Fresnel's law.
    FixedWeight {
        /// Colour of the Lambertian share.
        color: Rgb,
        /// Share of mirror reflection.
        reflectivity: f32,
        /// Share of refraction; under total internal reflection it is mirrored.
        transparency: f32,
        /// Index of refraction inside (behind the geometric normal) over outside.
        ior: f32,
    },
}
