use super::{Receiver, Scene};
use crate::light::IlluminationSample;
use crate::math::{Ray, Rgb, Rng, offset_origin};

/// Light that arrives at a receiver straight from the lights.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DirectLight {
    /// Irradiance (W/m²) with respect to the shading normal.
    pub irradiance: Rgb,
    /// Shadow rays that it took.
    pub shadow_rays: u32,
}

impl DirectLight {
    fn plus(self, other: DirectLight) -> DirectLight {
        DirectLight {
            irradiance: self.irradiance + other.irradiance,
            shadow_rays: self.shadow_rays + other.shadow_rays,
        }
    }
}

impl Scene {
    /// The exact irradiance from all point lights: `Σ I cos θ / d²` over those that are visible.
    pub fn direct_from_points(&self, receiver: &Receiver) -> DirectLight {
        self.lights()
            .illuminate_delta(receiver.p)
            .map(|sample| self.arriving(receiver, &sample))
            .fold(DirectLight::default(), DirectLight::plus)
    }

    /// An unbiased estimate of the irradiance from all area lights, from one shadow ray.
    pub fn direct_from_areas(&self, receiver: &Receiver, rng: &mut Rng) -> DirectLight {
        self.lights()
            .illuminate_area(receiver.p, rng)
            .map_or(DirectLight::default(), |sample| self.arriving(receiver, &sample))
    }

    fn arriving(&self, receiver: &Receiver, sample: &IlluminationSample) -> DirectLight {
        let cos = receiver.ns.dot(sample.wi);
        if cos <= 0.0 || receiver.ng.dot(sample.wi) <= 0.0 {
            return DirectLight::default();
        }
        let visible = !self.occluded(&shadow_ray(receiver, sample));
        let irradiance = if visible { cos * sample.irradiance } else { Rgb::ZERO };
        DirectLight { irradiance, shadow_rays: 1 }
    }
}

/// From the receiver to just before the light: nothing rests on a hit exactly at either end.
fn shadow_ray(receiver: &Receiver, sample: &IlluminationSample) -> Ray {
    let origin = offset_origin(receiver.p, receiver.p_error, receiver.ng, sample.wi);
    let dir = sample.target - origin;
    let t_max = 1.0 - sample.target_error / dir.length();
    Ray { origin, dir, t_max }
}
