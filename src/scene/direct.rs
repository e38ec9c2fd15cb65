use super::{Receiver, Scene};
use crate::light::{IlluminationSample, Lights};
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
    pub fn direct_from_points(&self, lights: &Lights, receiver: &Receiver) -> DirectLight {
        lights
            .illuminate_delta(receiver.p)
            .map(|sample| self.arriving(receiver, &sample))
            .fold(DirectLight::default(), DirectLight::plus)
    }

    /// An unbiased estimate of the irradiance from all area lights, from one shadow ray.
    pub fn direct_from_areas(&self, lights: &Lights, receiver: &Receiver, rng: &mut Rng) -> DirectLight {
        lights
            .illuminate_area(receiver.p, rng)
            .map_or(DirectLight::default(), |sample| self.arriving(receiver, &sample))
    }

    /// The shadow rays of [`Scene::direct_from_points`] and [`Scene::direct_from_areas`], in this order.
    pub fn shadow_rays(
        &self,
        lights: &Lights,
        receiver: &Receiver,
        rng: &mut Rng,
    ) -> impl Iterator<Item = Ray> {
        let samples = lights.illuminate_delta(receiver.p);
        samples.chain(lights.illuminate_area(receiver.p, rng)).filter_map(|s| shadow_ray(receiver, &s))
    }

    /// What of the illumination `sample` arrives at the receiver, by one shadow ray unless it faces away.
    pub fn arriving(&self, receiver: &Receiver, sample: &IlluminationSample) -> DirectLight {
        let Some(ray) = shadow_ray(receiver, sample) else { return DirectLight::default() };
        let cos = receiver.ns.dot(sample.wi);
        let irradiance = if self.occluded(&ray) { Rgb::ZERO } else { cos * sample.irradiance };
        DirectLight { irradiance, shadow_rays: 1 }
    }
}

/// From the receiver to just before the light: nothing rests on a hit exactly at either end.
/// `None` where the receiver faces away.
fn shadow_ray(receiver: &Receiver, sample: &IlluminationSample) -> Option<Ray> {
    if receiver.ns.dot(sample.wi) <= 0.0 || receiver.ng.dot(sample.wi) <= 0.0 {
        return None;
    }
    let origin = offset_origin(receiver.p, receiver.p_error, receiver.ng, sample.wi);
    let dir = sample.target - origin;
    let t_max = 1.0 - sample.target_error / dir.length();
    Some(Ray { origin, dir, t_max })
}
