use super::{Receiver, Scene, SurfaceHit};
use crate::bsdf::GlossyLobe;
use crate::light::{Environment, IlluminationSample, Lights};
use crate::math::{Ray, Rgb, Rng, Vec3, balance, offset_origin};

/// Light that arrives at a receiver straight from the lights.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DirectIrradiance {
    /// Irradiance (W/m²) with respect to the shading normal, under the coat.
    pub irradiance: Rgb,
    /// Shadow rays that it took.
    pub shadow_rays: u32,
}

impl DirectIrradiance {
    fn plus(self, other: DirectIrradiance) -> DirectIrradiance {
        DirectIrradiance {
            irradiance: self.irradiance + other.irradiance,
            shadow_rays: self.shadow_rays + other.shadow_rays,
        }
    }
}

impl Scene {
    /// The exact irradiance from all point lights: `Σ I cos θ / d²` over those that are visible.
    pub fn direct_from_points(&self, lights: &Lights, receiver: &Receiver) -> DirectIrradiance {
        lights
            .illuminate_delta(receiver.p)
            .map(|sample| self.arriving(receiver, &sample))
            .fold(DirectIrradiance::default(), DirectIrradiance::plus)
    }

    /// An unbiased estimate of the irradiance from all area lights, from one shadow ray.
    pub fn direct_from_areas(&self, lights: &Lights, receiver: &Receiver, rng: &mut Rng) -> DirectIrradiance {
        lights
            .illuminate_area(receiver.p, rng)
            .map_or(DirectIrradiance::default(), |sample| self.arriving(receiver, &sample))
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
    pub fn arriving(&self, receiver: &Receiver, sample: &IlluminationSample) -> DirectIrradiance {
        let Some(ray) = shadow_ray(receiver, sample) else { return DirectIrradiance::default() };
        let cos = receiver.ns.dot(sample.wi);
        let received = cos * receiver.coat.transmittance(cos);
        let irradiance = if self.occluded(&ray) {
            Rgb::ZERO
        } else {
            received * sample.irradiance * self.direct_transmittance(ray.origin, ray.dir.length())
        };
        DirectIrradiance { irradiance, shadow_rays: 1 }
    }
}

impl Scene {
    /// An estimate of the radiance along `hit.wo` of what the rough surface at `hit` makes of light straight from its
    /// sources, and the shadow rays that it took: all point lights, and one sample of the area lights with the weight that the balance
    /// heuristic gives it beside [`Scene::found_emission`].
    pub fn direct_on_rough(
        &self,
        lights: &Lights,
        hit: &SurfaceHit,
        glossy: &GlossyLobe,
        rng: &mut Rng,
    ) -> (Rgb, u32) {
        let frame = hit.frame();
        let samples = lights.illuminate_delta(hit.p).chain(lights.illuminate_area(hit.p, rng));
        samples.fold((Rgb::ZERO, 0), |(sum, rays), sample| {
            let response = glossy.respond(frame.to_local(sample.wi));
            let lit = response.and_then(|r| Some((r, hit.continue_along(r.event, sample.wi)?)));
            let Some((response, Ray { origin, .. })) = lit else { return (sum, rays) };
            let weight = balance(sample.pdf_w, response.pdf_w);
            let ray = towards(origin, &sample);
            let found = if self.occluded(&ray) { 0.0 } else { weight };
            let left = self.direct_transmittance(origin, ray.dir.length());
            (sum + found * response.value * sample.irradiance * left, rays + 1)
        })
    }

    /// The radiance of a lamp at `hit` that counts for a path which came there by an event of the density `pdf_w`: what
    /// [`Scene::direct_on_rough`] leaves of it, and all after a perfectly specular event.
    pub fn found_emission(&self, lights: &Lights, hit: &SurfaceHit, pdf_w: f32) -> Rgb {
        let emission = self.emission(hit);
        if emission == Rgb::ZERO || pdf_w.is_infinite() {
            return emission;
        }
        let by_light = if hit.sphere_radius > 0.0 {
            let center = hit.p - hit.sphere_radius * hit.ng;
            let from = hit.p + hit.t * hit.wo;
            lights.sphere_pdf_w(emission, hit.sphere_radius, from.distance_squared(center))
        } else {
            lights.area_pdf_w(emission, hit.ng.dot(hit.wo), hit.t * hit.t)
        };
        balance(pdf_w, by_light) * emission
    }

    /// The same of the environment, for a ray that meets nothing.
    pub fn found_sky(&self, lights: &Lights, around: &Environment, ray: &Ray, pdf_w: f32) -> Rgb {
        let dir = ray.dir.normalize();
        balance(pdf_w, lights.environment_pdf_w(dir)) * around.radiance(dir)
    }
}

/// From the receiver to just before the light: nothing rests on a hit exactly at either end.
/// `None` where the receiver faces away.
fn shadow_ray(receiver: &Receiver, sample: &IlluminationSample) -> Option<Ray> {
    if receiver.ns.dot(sample.wi) <= 0.0 || receiver.ng.dot(sample.wi) <= 0.0 {
        return None;
    }
    Some(towards(offset_origin(receiver.p, receiver.p_error, receiver.ng, sample.wi), sample))
}

fn towards(origin: Vec3, sample: &IlluminationSample) -> Ray {
    let dir = sample.target - origin;
    let t_max = 1.0 - sample.target_error / dir.length();
    Ray { origin, dir, t_max }
}
