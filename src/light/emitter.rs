use std::f64::consts::FRAC_1_PI;

use super::{EmissionSample, Light, Patch, error, normal, point_of_sphere, point_on};
use crate::math::{Frame, Rgb, Rng, Vec2, Vec3, offset_origin, warp};

impl Light {
    /// A photon: origin and direction drawn in proportion to the emitted flux.
    pub fn sample_emission(&self, rng: &mut Rng) -> EmissionSample {
        Emitter::new(self.clone()).sample(rng)
    }
}

/// A light, with what is the same for all of its photons.
#[derive(Clone, Debug)]
pub(super) struct Emitter {
    pub kind: Kind,
    /// Of what is no triangle, all are its middle.
    pub corners: [Vec3; 3],
    pub flux: Rgb,
    /// Around the side that shines; any of what is no triangle.
    pub frame: Frame,
    pub p_error: f32,
}

/// How photons leave a light: points and triangles, of which scenes have most, also in lanes.
#[derive(Clone, Debug)]
pub(super) enum Kind {
    Point,
    Triangle,
    Other(Light),
}

impl Emitter {
    pub(super) fn new(light: Light) -> Emitter {
        let flux = light.flux();
        let around = |kind, middle| Emitter {
            kind,
            corners: [middle; 3],
            flux,
            frame: Frame::around(Vec3::Z),
            p_error: 0.0,
        };
        match &light {
            Light::Point { position, .. } => around(Kind::Point, *position),
            Light::Spot(spot) => around(Kind::Other(light.clone()), spot.position),
            Light::Distant(distant) => around(Kind::Other(light.clone()), distant.ball.center),
            Light::Sphere { center, .. } => around(Kind::Other(light.clone()), *center),
            Light::Environment(_) => around(Kind::Other(light), Vec3::ZERO),
            Light::Triangle { corners, .. } => {
                let frame = Frame::around(normal(corners));
                Emitter { kind: Kind::Triangle, corners: *corners, flux, frame, p_error: error(corners) }
            }
        }
    }

    /// See [`Light::sample_emission`].
    pub(super) fn sample(&self, rng: &mut Rng) -> EmissionSample {
        let Emitter { corners, flux: power, frame, p_error, .. } = self;
        match &self.kind {
            Kind::Point => {
                let dir = warp::square_to_uniform_sphere(rng.next_vec2());
                EmissionSample { origin: corners[0], dir, power: *power }
            }
            Kind::Triangle => {
                let p = point_on(corners, rng.next_vec2());
                let dir = frame.to_world(warp::square_to_cosine_hemisphere(rng.next_vec2()));
                EmissionSample { origin: offset_origin(p, *p_error, frame.normal, dir), dir, power: *power }
            }
            Kind::Other(light) => self.other(light, rng.next_vec2(), rng.next_vec2()),
        }
    }

    /// A photon of a light that is neither point nor triangle, by the numbers of its place and of its direction.
    pub(super) fn other(&self, light: &Light, place: Vec2, u: Vec2) -> EmissionSample {
        let power = self.flux;
        match light {
            Light::Spot(spot) => EmissionSample { origin: spot.position, dir: spot.sample(u), power },
            Light::Distant(distant) => distant.emit(place),
            Light::Environment(environment) => environment.emit(place, u),
            Light::Sphere { center, radius, .. } => {
                let Patch { p, ng, p_error } = point_of_sphere(*center, *radius, place);
                let dir = Frame::around(ng).to_world(warp::square_to_cosine_hemisphere(u));
                EmissionSample { origin: offset_origin(p, p_error, ng, dir), dir, power }
            }
            Light::Point { .. } | Light::Triangle { .. } => {
                EmissionSample { origin: self.corners[0], dir: Vec3::Z, power: Rgb::ZERO }
            }
        }
    }

    /// Whether its light comes from afar: then no place is its own, and none of its photons are aimed.
    pub(super) fn is_far(&self) -> bool {
        matches!(&self.kind, Kind::Other(Light::Distant(_) | Light::Environment(_)))
    }

    /// A point that photons start from, off the surface on the side that shines; uniform over its area.
    pub(super) fn origin(&self, u: Vec2) -> Vec3 {
        match &self.kind {
            Kind::Triangle => point_on(&self.corners, u) + self.p_error * self.frame.normal,
            Kind::Other(Light::Sphere { center, radius, .. }) => {
                let Patch { p, ng, p_error } = point_of_sphere(*center, *radius, u);
                p + p_error * ng
            }
            Kind::Point | Kind::Other(_) => self.corners[0],
        }
    }

    /// A direction as [`Emitter::sample`] draws it for a photon from `origin`.
    pub(super) fn direction(&self, origin: Vec3, u: Vec2) -> Vec3 {
        match &self.kind {
            Kind::Triangle => self.frame.to_world(warp::square_to_cosine_hemisphere(u)),
            Kind::Other(Light::Spot(spot)) => spot.sample(u),
            Kind::Other(Light::Sphere { center, .. }) => {
                Frame::around(outward(origin, *center)).to_world(warp::square_to_cosine_hemisphere(u))
            }
            Kind::Point | Kind::Other(_) => warp::square_to_uniform_sphere(u),
        }
    }

    /// The density by which [`Emitter::sample`] draws the direction `dir` of a photon from `origin` (1/sr): 0 where it does not
    /// shine. Any of light from afar.
    pub(super) fn pdf_w(&self, origin: Vec3, dir: Vec3) -> f64 {
        let lambertian = |ng: Vec3| FRAC_1_PI * ng.as_dvec3().dot(dir.as_dvec3()).max(0.0);
        match &self.kind {
            Kind::Triangle => lambertian(self.frame.normal),
            Kind::Other(Light::Sphere { center, .. }) => lambertian(outward(origin, *center)),
            Kind::Other(Light::Spot(spot)) => f64::from(spot.falloff(dir)) / spot.solid_angle(),
            Kind::Point | Kind::Other(_) => 0.25 * FRAC_1_PI,
        }
    }
}

fn outward(origin: Vec3, center: Vec3) -> Vec3 {
    (origin - center).normalize_or(Vec3::Y)
}
