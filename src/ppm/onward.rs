use super::Settings;
use crate::bsdf::{Choice, Event, Scattering, sample_diffuse};
use crate::math::{Frame, Ray, Rgb, Rng, Vec3};
use crate::scene::SurfaceHit;

/// How a photon goes on.
pub(super) struct Onward {
    pub event: Event,
    /// `None` where a shading normal bends it to the wrong side of the true surface.
    pub ray: Option<Ray>,
    /// On its power.
    pub factor: Rgb,
    /// What the factor lacks for the shading normal.
    pub correction: f32,
}

/// Russian roulette between reflection, refraction, diffuse bounce and absorption, which is `None`.
pub(super) fn go_on(
    hit: &SurfaceHit,
    scattering: &Scattering,
    settings: &Settings,
    rng: &mut Rng,
) -> Option<Onward> {
    let (event, dir, factor) = match scattering.choose(rng.next_f32())? {
        Choice::Specular { event, wi, factor, .. } => (event, hit.frame().to_world(wi), factor),
        Choice::Diffuse { factor } => {
            let (wi, cosine_factor) = sample_diffuse(settings.sampling, Vec3::Z, rng);
            let factor = factor * (cosine_factor * scattering.coat.transmittance(wi.z));
            (Event::Diffuse, Frame::around(hit.receiver().ng).to_world(wi), factor)
        }
    };
    let ray = hit.continue_along(event, dir);
    let correction = if ray.is_some() { hit.adjoint_correction(event, dir) } else { 0.0 };
    Some(Onward { event, ray, factor, correction })
}
