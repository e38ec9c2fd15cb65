use std::f32::consts::PI;

use super::{EmissionSample, IlluminationSample};
use crate::math::{BoundingSphere, Frame, Rgb, Vec2, Vec3, warp};

/// A light so far away that its rays are parallel: they fill the cross-section of a ball around the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distant {
    /// Where its light goes, unit.
    pub direction: Vec3,
    /// Irradiance on a surface that faces it (W/m²).
    pub irradiance: Rgb,
    /// Around the scene.
    pub ball: BoundingSphere,
}

impl Distant {
    /// What enters the ball (W): `π R² E`.
    pub fn flux(&self) -> Rgb {
        cross_section(&self.ball) * self.irradiance
    }

    pub(super) fn emit(&self, u: Vec2) -> EmissionSample {
        let origin = outside(&self.ball, self.direction, u);
        EmissionSample { origin, dir: self.direction, power: self.flux() }
    }

    pub(super) fn illuminate(&self, p: Vec3) -> IlluminationSample {
        let (wi, irradiance) = (-self.direction, self.irradiance);
        let target = beyond(&self.ball, p, wi);
        IlluminationSample { target, target_error: 0.0, wi, irradiance, pdf_w: f32::INFINITY }
    }
}

/// Of a ball (m²).
pub(super) fn cross_section(ball: &BoundingSphere) -> f32 {
    PI * ball.radius * ball.radius
}

/// A point before the ball, uniform over its cross-section, from which light goes along `dir`.
pub(super) fn outside(ball: &BoundingSphere, dir: Vec3, u: Vec2) -> Vec3 {
    let frame = Frame::around(dir);
    ball.center + ball.radius * frame.to_world(warp::square_to_disk(u).extend(-1.0))
}

/// A point along `wi` from `p` that lies beyond the ball.
pub(super) fn beyond(ball: &BoundingSphere, p: Vec3, wi: Vec3) -> Vec3 {
    p + (2.0 * ball.radius + p.distance(ball.center)) * wi
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Rng, Stream};

    /// Photons through a disc in the ball bring the irradiance times its area. Catches a cross-section of another ball and a
    /// disc that lies askew.
    #[test]
    fn photons_bring_the_irradiance() {
        const N: u32 = 100_000;
        let ball = BoundingSphere { center: Vec3::new(1.0, 2.0, -3.0), radius: 4.0 };
        let light = Distant { direction: Vec3::new(0.6, -0.8, 0.0), irradiance: Rgb::splat(5.0), ball };
        let mut rng = Rng::new(1, Stream::Test, 0, 0);
        let mut through = 0.0;
        for _ in 0..N {
            let photon = light.emit(rng.next_vec2());
            let to_center = ball.center - photon.origin;
            assert!((to_center.dot(photon.dir) - 4.0).abs() < 1e-4, "before the ball");
            // A disc of radius 1 around the centre that faces the light.
            through +=
                if to_center.cross(photon.dir).length() < 1.0 { photon.power.x / N as f32 } else { 0.0 };
        }
        assert!((through / (PI * 5.0) - 1.0).abs() < 0.04, "{through}");
    }

    /// From inside and outside of the ball: along the ray, and farther than the far side of the ball, where the ray meets it at
    /// `b + √(b² - |p - c|² + R²)` with `b = (c - p) · wi`. Shadow rays that end earlier would miss what is between.
    #[test]
    fn what_lies_beyond_is_past_the_far_side_of_the_ball() {
        let ball = BoundingSphere { center: Vec3::new(1.0, 2.0, -3.0), radius: 4.0 };
        let wi = Vec3::new(0.6, 0.0, 0.8);
        for p in [ball.center, ball.center - 3.9 * wi, ball.center + 3.9 * wi, ball.center - 20.0 * wi] {
            let along = beyond(&ball, p, wi) - p;
            let b = (ball.center - p).dot(wi);
            let far = b + (b * b - p.distance_squared(ball.center) + 16.0).max(0.0).sqrt();
            assert!(along.dot(wi) > far + 3.0, "{p}: {along}, not beyond {far}");
            assert!(along.cross(wi).length() < 1e-4, "{along} is not along {wi}");
        }
    }

    /// Light comes from where it does not go to.
    #[test]
    fn shadow_rays_go_against_the_light() {
        let ball = BoundingSphere { center: Vec3::ZERO, radius: 1.0 };
        let direction = Vec3::new(0.6, -0.8, 0.0);
        let light = Distant { direction, irradiance: Rgb::new(1.0, 2.0, 3.0), ball };
        let sample = light.illuminate(Vec3::new(0.5, 0.0, 0.0));
        assert_eq!((sample.wi, sample.irradiance), (-direction, light.irradiance));
        assert!((sample.target - Vec3::new(0.5, 0.0, 0.0)).normalize().distance(-direction) < 1e-6);
        assert_eq!((sample.target_error, sample.pdf_w), (0.0, f32::INFINITY));
    }
}
