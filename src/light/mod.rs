//! Where light comes from: a closed set of lights, and the choice among them.

mod aim;
mod aim_cone;
mod cell_split;
mod choice;
mod distant;
mod emitter;
mod environment;
mod guide;
mod guide_tree;
mod lane_emission;
mod sample;
mod selection;
mod spot;
mod start;
mod tally;

pub use aim::{Aim, AimedSample};
pub use distant::Distant;
pub use environment::{Environment, Panorama};
pub use guide::Guide;
pub(crate) use guide_tree::GuideTree;
pub(crate) use lane_emission::LaneEmission;
pub use sample::{EmissionSample, IlluminationSample};
pub use selection::Lights;
pub use spot::Spot;
pub use start::{Numbers, Start, start};
pub(crate) use tally::{Example, LEVELS, Purpose};

use std::f32::consts::PI;
use std::sync::Arc;

use crate::math::{Frame, RELATIVE_POSITION_ERROR, Rgb, Vec2, Vec3, offset_origin, warp};

/// A source of light.
#[derive(Clone, Debug, PartialEq)]
pub enum Light {
    /// A point that shines alike in all directions.
    Point {
        /// Where it is.
        position: Vec3,
        /// Radiant intensity (W/sr).
        intensity: Rgb,
    },
    /// A point that shines into a cone.
    Spot(Spot),
    /// A light so far away that its rays are parallel.
    Distant(Distant),
    /// A Lambertian sphere that shines outward.
    Sphere {
        /// Its middle.
        center: Vec3,
        /// Its radius, above 0.
        radius: f32,
        /// Radiance (W/m²/sr).
        radiance: Rgb,
    },
    /// Light from all around.
    Environment(Arc<Environment>),
    /// A Lambertian triangle that shines to the side from which its corners run counter-clockwise.
    Triangle {
        /// The corners.
        corners: [Vec3; 3],
        /// Radiance (W/m²/sr).
        radiance: Rgb,
    },
}

impl Light {
    /// The whole emitted flux (W): `4π I` for a point, `π A L` for a Lambertian triangle or sphere; of light from afar what enters a
    /// ball around the scene.
    ///
    /// ```
    /// use caustica::{light::Light, math::{Rgb, Vec3}};
    /// let corners = [Vec3::ZERO, 80.0 * Vec3::X, 80.0 * (Vec3::X + Vec3::Z)];
    /// let half_of_cornell_b = Light::Triangle { corners, radiance: Rgb::splat(80.0) };
    /// assert!((half_of_cornell_b.flux().x - 804_247.7).abs() < 0.1);
    /// ```
    pub fn flux(&self) -> Rgb {
        match self {
            Light::Point { intensity, .. } => 4.0 * PI * *intensity,
            Light::Spot(spot) => spot.solid_angle() as f32 * spot.intensity,
            Light::Distant(distant) => distant.flux(),
            Light::Triangle { corners, radiance } => PI * area(corners) * *radiance,
            Light::Sphere { radius, radiance, .. } => PI * sphere_area(*radius) * *radiance,
            Light::Environment(environment) => environment.flux(),
        }
    }

    /// The light's illumination of the point `p`: exact where the light has no extent, else one sample of its area.
    ///
    /// `None` where the light does not shine towards `p`, or `p` is the light itself.
    pub fn illuminate(&self, p: Vec3, u: Vec2) -> Option<IlluminationSample> {
        match self {
            Light::Point { position, intensity } => from_point(p, *position, *intensity),
            Light::Spot(spot) => {
                let sample = from_point(p, spot.position, spot.intensity)?;
                let falloff = spot.falloff(-sample.wi);
                let irradiance = falloff * sample.irradiance;
                (falloff > 0.0).then_some(IlluminationSample { irradiance, ..sample })
            }
            Light::Distant(distant) => Some(distant.illuminate(p)),
            Light::Environment(environment) => environment.illuminate(p, u),
            Light::Triangle { corners, radiance } => {
                let on = Patch { p: point_on(corners, u), ng: normal(corners), p_error: error(corners) };
                from_patch(p, on, area(corners), *radiance)
            }
            Light::Sphere { center, radius, radiance } => from_sphere(p, *center, *radius, *radiance, u),
        }
    }

    /// Whether its illumination of a point is known without sampling.
    pub fn is_delta(&self) -> bool {
        match self {
            Light::Point { .. } | Light::Spot(_) | Light::Distant(_) => true,
            Light::Triangle { .. } | Light::Sphere { .. } | Light::Environment(_) => false,
        }
    }
}

fn from_point(p: Vec3, position: Vec3, intensity: Rgb) -> Option<IlluminationSample> {
    let (wi, distance2) = direction(p, position)?;
    let target_error = RELATIVE_POSITION_ERROR * position.abs().max_element();
    let irradiance = intensity / distance2;
    Some(IlluminationSample { target: position, target_error, wi, irradiance, pdf_w: f32::INFINITY })
}

/// A point of a surface that shines.
#[derive(Clone, Copy)]
struct Patch {
    p: Vec3,
    ng: Vec3,
    p_error: f32,
}

/// By a patch drawn uniformly over an `area`.
fn from_patch(p: Vec3, patch: Patch, area: f32, radiance: Rgb) -> Option<IlluminationSample> {
    let Patch { p: point, ng, p_error: target_error } = patch;
    let (wi, distance2) = direction(p, point)?;
    let cos = -ng.dot(wi);
    let solid_angle = cos * area / distance2;
    let (irradiance, pdf_w) = (radiance * solid_angle, solid_angle.recip());
    let target = offset_origin(point, target_error, ng, -wi);
    (cos > 0.0).then_some(IlluminationSample { target, target_error, wi, irradiance, pdf_w })
}

/// By a direction drawn uniformly from those that meet the sphere. `None` inside of it, where it does not shine.
///
/// # Source
/// Shirley, Wang and Zimmerman, "Monte Carlo Techniques for Direct Lighting Calculations", ACM TOG 15(1), 1996, section 3.2.
fn from_sphere(p: Vec3, center: Vec3, radius: f32, radiance: Rgb, u: Vec2) -> Option<IlluminationSample> {
    let (axis, distance2) = direction(p, center)?;
    let versine = versine_of_sphere(radius, distance2)?;
    let down = u.x * versine;
    let sin2 = down * (2.0 - down);
    let turn = 2.0 * PI * u.y;
    let local = Vec3::new(sin2.sqrt() * turn.cos(), sin2.sqrt() * turn.sin(), 1.0 - down);
    let wi = Frame::around(axis).to_world(local);
    let half_chord = (radius * radius - distance2 * sin2).max(0.0).sqrt();
    let to_point = distance2.sqrt() * (1.0 - down) - half_chord;
    let ng = (p + to_point * wi - center).normalize_or(-axis);
    let target_error = RELATIVE_POSITION_ERROR * (center.abs().max_element() + radius);
    let target = offset_origin(center + radius * ng, target_error, ng, -wi);
    let solid_angle = 2.0 * PI * versine;
    let (irradiance, pdf_w) = (radiance * solid_angle, solid_angle.recip());
    Some(IlluminationSample { target, target_error, wi, irradiance, pdf_w })
}

/// `1 - cos` of half the angle that a sphere takes, from the sine so that small ones keep their digits. `None` inside.
fn versine_of_sphere(radius: f32, distance2: f32) -> Option<f32> {
    let sin2 = radius * radius / distance2;
    (sin2 < 1.0).then(|| sin2 / (1.0 + (1.0 - sin2).sqrt()))
}

/// Uniform over its area.
fn point_of_sphere(center: Vec3, radius: f32, u: Vec2) -> Patch {
    let ng = warp::square_to_uniform_sphere(u);
    let p_error = RELATIVE_POSITION_ERROR * (center.abs().max_element() + radius);
    Patch { p: center + radius * ng, ng, p_error }
}

fn sphere_area(radius: f32) -> f32 {
    4.0 * PI * radius * radius
}

fn direction(from: Vec3, to: Vec3) -> Option<(Vec3, f32)> {
    let d = to - from;
    let distance2 = d.length_squared();
    (distance2 > 0.0).then(|| (d / distance2.sqrt(), distance2))
}

fn point_on(corners: &[Vec3; 3], u: Vec2) -> Vec3 {
    let b = warp::square_to_triangle(u);
    (1.0 - b.x - b.y) * corners[0] + b.x * corners[1] + b.y * corners[2]
}

fn cross(corners: &[Vec3; 3]) -> Vec3 {
    (corners[1] - corners[0]).cross(corners[2] - corners[0])
}

fn normal(corners: &[Vec3; 3]) -> Vec3 {
    cross(corners).normalize()
}

fn area(corners: &[Vec3; 3]) -> f32 {
    0.5 * cross(corners).length()
}

fn error(corners: &[Vec3; 3]) -> f32 {
    let largest = corners.iter().fold(0.0, |m: f32, c| m.max(c.abs().max_element()));
    RELATIVE_POSITION_ERROR * largest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{DVec3, Rng, Stream};

    const LAMP: Light = Light::Triangle {
        corners: [Vec3::ZERO, Vec3::new(2.0, 0.0, 0.0), Vec3::new(0.0, 0.0, 2.0)],
        radiance: Rgb::new(3.0, 2.0, 1.0),
    };

    #[test]
    fn triangle_shines_to_its_front_alone() {
        assert!(LAMP.illuminate(Vec3::new(0.5, -1.0, 0.5), Vec2::splat(0.3)).is_some());
        assert!(LAMP.illuminate(Vec3::new(0.5, 1.0, 0.5), Vec2::splat(0.3)).is_none());
        let mut rng = Rng::new(1, Stream::Test, 0, 0);
        assert!((0..1000).map(|_| LAMP.sample_emission(&mut rng)).all(|e| e.dir.y < 0.0 && e.origin.y < 0.0));
    }

    #[test]
    fn no_light_reaches_the_light_itself() {
        let light = Light::Point { position: Vec3::ONE, intensity: Rgb::ONE };
        assert!(light.illuminate(Vec3::ONE, Vec2::ZERO).is_none());
    }

    /// Far away a triangle is a point of intensity `L A cos θ`.
    #[test]
    fn triangle_follows_the_inverse_square_law_from_afar() {
        let p = Vec3::new(1.0 / 1.5, -1000.0, 1.0 / 1.5);
        let sample = LAMP.illuminate(p, Vec2::new(0.2, 0.9)).unwrap();
        assert!((sample.irradiance.x / (3.0 * 2.0 / 1e6) - 1.0).abs() < 1e-3);
    }

    /// Photons and shadow rays must agree: the flux that a closed sphere around the light receives is its flux.
    #[test]
    fn illumination_integrates_to_the_emitted_flux() {
        const N: u32 = 100_000;
        let (center, radius) = (Vec3::splat(0.5), 5.0f32);
        let spot = Spot {
            position: Vec3::ONE,
            axis: Vec3::NEG_Y,
            intensity: Rgb::splat(2.0),
            inner: 0.5,
            outer: 1.5,
        };
        let ball = Light::Sphere { center: Vec3::ONE, radius: 1.5, radiance: Rgb::splat(2.0) };
        let point = Light::Point { position: Vec3::ZERO, intensity: Rgb::splat(2.0) };
        for light in [LAMP, point, Light::Spot(spot), ball] {
            let mut rng = Rng::new(5, Stream::Test, 0, 0);
            let sum: f64 = (0..N)
                .filter_map(|_| {
                    let n = warp::square_to_uniform_sphere(rng.next_vec2());
                    let sample = light.illuminate(center + radius * n, rng.next_vec2())?;
                    Some(f64::from(sample.irradiance.x * -sample.wi.dot(n)))
                })
                .sum();
            let flux = sum / f64::from(N) * f64::from(4.0 * PI * radius * radius);
            assert!((flux / f64::from(light.flux().x) - 1.0).abs() < 0.02, "{flux} of {}", light.flux().x);
        }
    }

    /// Directions to a ball are uniform in the cone around it, and end on the ball: `cos` has the mean `(1 + cos_max) / 2`.
    #[test]
    fn a_ball_is_sampled_over_its_cone_and_met_on_its_surface() {
        const STEPS: u32 = 64;
        let (p, center, radius) = (Vec3::new(0.5, -1.0, 2.0), Vec3::new(1.5, 1.0, 4.0), 1.8f32);
        let axis = (center - p).normalize();
        let cos_max = (1.0 - radius * radius / p.distance_squared(center)).sqrt();
        let mut sum = DVec3::ZERO;
        for k in 0..STEPS * STEPS {
            let u = Vec2::new((k / STEPS) as f32 + 0.5, (k % STEPS) as f32 + 0.5) / STEPS as f32;
            let sample = from_sphere(p, center, radius, Rgb::ONE, u).unwrap();
            assert!((sample.target.distance(center) / radius - 1.0).abs() < 1e-4, "{u}");
            assert!((sample.target - p).normalize().distance(sample.wi) < 1e-4, "{u}");
            assert!((sample.target - center).dot(sample.wi) < 5e-3, "{u}: behind the ball's outline");
            sum += sample.wi.as_dvec3();
        }
        let expected = 0.5 * (1.0 + cos_max) * axis;
        assert!((sum / f64::from(STEPS * STEPS)).distance(expected.as_dvec3()) < 1e-4);
        assert!(
            from_sphere(center + 0.5 * radius * axis, center, radius, Rgb::ONE, Vec2::splat(0.5)).is_none()
        );
    }
}
