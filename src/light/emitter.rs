use super::{EmissionSample, Light, error, normal, point_on};
use crate::math::{Frame, Rgb, Rng, Vec3, offset_origin, warp};

/// A light, with what is the same for all of its photons.
#[derive(Clone, Copy, Debug)]
pub(super) struct Emitter {
    light: Light,
    flux: Rgb,
    /// Around the side that shines; any for a point.
    frame: Frame,
    p_error: f32,
}

impl Emitter {
    pub(super) fn new(light: Light) -> Emitter {
        let (ng, p_error) = match light {
            Light::Point { .. } => (Vec3::Z, 0.0),
            Light::Triangle { corners, .. } => (normal(&corners), error(&corners)),
        };
        Emitter { light, flux: light.flux(), frame: Frame::around(ng), p_error }
    }

    /// See [`Light::sample_emission`].
    pub(super) fn sample(&self, rng: &mut Rng) -> EmissionSample {
        let Emitter { light, flux: power, frame, p_error } = *self;
        match light {
            Light::Point { position, .. } => {
                let dir = warp::square_to_uniform_sphere(rng.next_vec2());
                EmissionSample { origin: position, dir, power }
            }
            Light::Triangle { corners, .. } => {
                let p = point_on(&corners, rng.next_vec2());
                let dir = frame.to_world(warp::square_to_cosine_hemisphere(rng.next_vec2()));
                EmissionSample { origin: offset_origin(p, p_error, frame.normal, dir), dir, power }
            }
        }
    }
}
