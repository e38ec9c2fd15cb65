//! How surfaces scatter light: a closed set of materials, in the local shading frame.
//!
//! [`Bsdf::scatter`] names all lobes of a surface for light along one direction. The eye pass follows every
//! specular lobe; photons and the path tracer choose one by roulette ([`Scattering::choose`]).

mod fresnel;
mod scattering;

pub use fresnel::{Refraction, fresnel_reflectance, reflect, refract};
pub use scattering::{Choice, DiffuseSampling, Event, Scattering, SpecularLobe, Transport, sample_diffuse};

use crate::math::{Rgb, Vec3};

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

impl Bsdf {
    /// The Lambertian share of the incident power: `f = albedo / π` on the side of `wo`.
    pub fn albedo(&self) -> Rgb {
        match *self {
            Bsdf::Diffuse { albedo } => albedo,
            Bsdf::Mirror { .. } | Bsdf::Dielectric { .. } => Rgb::ZERO,
            Bsdf::FixedWeight { color, reflectivity, transparency, .. } => {
                (1.0 - reflectivity - transparency).max(0.0) * color
            }
        }
    }

    /// All lobes for a path that arrives along `wo` (unit, local, pointing back along the path).
    ///
    /// Radiance crossing an interface is scaled by `1 / eta²`, since its cone widens or narrows (Veach, "Robust
    /// Monte Carlo Methods for Light Transport Simulation", 1997, section 5.2); power is not. The course's
    /// material is the exception that its assignment asks for: along the specular chain from the camera its
    /// transparency is the whole weight.
    pub fn scatter(&self, wo: Vec3, transport: Transport) -> Scattering {
        let specular = match *self {
            Bsdf::Diffuse { .. } => [None, None],
            Bsdf::Mirror { reflectance } => [Some(mirrored(wo, reflectance)), None],
            Bsdf::Dielectric { ior } => dielectric_lobes(wo, ior, transport),
            Bsdf::FixedWeight { reflectivity, transparency, ior, .. } => {
                fixed_weight_lobes(wo, [reflectivity, transparency], ior, transport)
            }
        };
        Scattering::new(self.albedo(), specular)
    }
}

fn mirrored(wo: Vec3, share: Rgb) -> SpecularLobe {
    SpecularLobe { event: Event::Reflection, wi: reflect(wo), share, scale: 1.0 }
}

fn refracted(refraction: Refraction, share: f32, scale: f32) -> SpecularLobe {
    SpecularLobe { event: Event::Transmission, wi: refraction.wi, share: Rgb::splat(share), scale }
}

fn dielectric_lobes(wo: Vec3, ior: f32, transport: Transport) -> [Option<SpecularLobe>; 2] {
    let Some(refraction) = refract(wo, ior) else {
        return [Some(mirrored(wo, Rgb::ONE)), None];
    };
    let reflectance = fresnel_reflectance(wo.z.abs(), refraction.wi.z.abs(), refraction.eta);
    let scale = match transport {
        Transport::Camera | Transport::Radiance => refraction.eta.powi(-2),
        Transport::Power => 1.0,
    };
    [Some(mirrored(wo, Rgb::splat(reflectance))), Some(refracted(refraction, 1.0 - reflectance, scale))]
}

fn fixed_weight_lobes(
    wo: Vec3,
    [reflectivity, transparency]: [f32; 2],
    ior: f32,
    transport: Transport,
) -> [Option<SpecularLobe>; 2] {
    let Some(refraction) = refract(wo, ior) else {
        return [Some(mirrored(wo, Rgb::splat(reflectivity + transparency))), None];
    };
    let scale = match transport {
        Transport::Radiance => refraction.eta.powi(-2),
        Transport::Camera | Transport::Power => 1.0,
    };
    [Some(mirrored(wo, Rgb::splat(reflectivity))), Some(refracted(refraction, transparency, scale))]
}

#[cfg(test)]
mod tests;
