use std::f64::consts::FRAC_1_PI;

use super::{EmissionSample, Light, error, normal, point_on};
use crate::math::{Frame, Rgb, Rng, Vec2, Vec3, offset_origin, warp};

/// A light, with what is the same for all of its photons.
#[derive(Clone, Copy, Debug)]
pub(super) struct Emitter {
    pub is_point: bool,
    /// Of a point, all are itself.
    pub corners: [Vec3; 3],
    pub flux: Rgb,
    /// Around the side that shines; any for a point.
    pub frame: Frame,
    pub p_error: f32,
}

impl Emitter {
    pub(super) fn new(light: Light) -> Emitter {
        let flux = light.flux();
        match light {
            Light::Point { position, .. } => Emitter {
                is_point: true,
                corners: [position; 3],
                flux,
                frame: Frame::around(Vec3::Z),
                p_error: 0.0,
            },
            Light::Triangle { corners, .. } => {
                let frame = Frame::around(normal(&corners));
                Emitter { is_point: false, corners, flux, frame, p_error: error(&corners) }
            }
        }
    }

    /// See [`Light::sample_emission`].
    pub(super) fn sample(&self, rng: &mut Rng) -> EmissionSample {
        let Emitter { is_point, corners, flux: power, frame, p_error } = *self;
        if is_point {
            let dir = warp::square_to_uniform_sphere(rng.next_vec2());
            return EmissionSample { origin: corners[0], dir, power };
        }
        let p = point_on(&corners, rng.next_vec2());
        let dir = frame.to_world(warp::square_to_cosine_hemisphere(rng.next_vec2()));
        EmissionSample { origin: offset_origin(p, p_error, frame.normal, dir), dir, power }
    }

    /// A point that photons start from, off the surface on the side that shines; uniform over its area.
    pub(super) fn origin(&self, u: Vec2) -> Vec3 {
        if self.is_point {
            self.corners[0]
        } else {
            point_on(&self.corners, u) + self.p_error * self.frame.normal
        }
    }

    /// A direction as [`Emitter::sample`] draws it.
    pub(super) fn direction(&self, u: Vec2) -> Vec3 {
        if self.is_point {
            warp::square_to_uniform_sphere(u)
        } else {
            self.frame.to_world(warp::square_to_cosine_hemisphere(u))
        }
    }

    /// The density by which [`Emitter::sample`] draws the direction `dir` (1/sr): 0 where it does not shine.
    pub(super) fn pdf_w(&self, dir: Vec3) -> f64 {
        if self.is_point {
            0.25 * FRAC_1_PI
        } else {
            FRAC_1_PI * self.frame.normal.as_dvec3().dot(dir.as_dvec3()).max(0.0)
        }
    }
}
