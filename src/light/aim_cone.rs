use std::f64::consts::TAU;

use crate::math::{BoundingSphere, DVec3, Frame, Vec2, Vec3, warp};

/// The directions from a point outside of a ball to it.
///
/// Everything is computed from the sine, and `1 - cos` as `sin² / (1 + cos)`: a cone of 1e-4 has half of its digits left
/// that way, and none otherwise.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cone {
    /// Unit.
    axis: DVec3,
    /// Of half the angle.
    sin2: f64,
    /// `1 - cos` of half the angle.
    versine: f64,
}

/// By how much more than a ball takes half an angle is, in radians: more than directions and frames in f32 are rounded by, so
/// that no rounding of a sample takes density from the directions that meet the ball.
const MARGIN: f64 = 1e-6;

impl Cone {
    /// `None` for points inside of the ball, on it, or so near that it covers half of all directions.
    pub fn of(ball: &BoundingSphere, from: Vec3) -> Option<Cone> {
        let to = ball.center.as_dvec3() - from.as_dvec3();
        let distance = to.length();
        let sin = f64::from(ball.radius) / distance + MARGIN;
        // 0/0 where the ball is a point that is met exactly.
        if sin >= 1.0 || sin.is_nan() {
            return None;
        }
        let sin2 = sin * sin;
        Some(Cone { axis: to / distance, sin2, versine: sin2 / (1.0 + (1.0 - sin2).sqrt()) })
    }

    pub fn solid_angle(&self) -> f64 {
        TAU * self.versine
    }

    /// Whether the line along `dir` passes the centre nearer than the radius, ahead.
    pub fn contains(&self, dir: Vec3) -> bool {
        let dir = dir.as_dvec3();
        dir.dot(self.axis) > 0.0 && dir.cross(self.axis).length_squared() <= self.sin2 * dir.length_squared()
    }

    /// A direction, uniform in solid angle: `1 - cos θ` is as uniform as the squared radius in a disc.
    pub fn sample(&self, u: Vec2) -> Vec3 {
        let disc = warp::square_to_disk(u);
        let versine = f64::from(disc.length_squared()) * self.versine;
        let local = (disc * (self.versine * (2.0 - versine)).sqrt() as f32).extend((1.0 - versine) as f32);
        Frame::around(self.axis.as_vec3()).to_world(local)
    }

    /// The share of what a Lambertian surface of the normal `n` emits here that goes into the cone.
    ///
    /// `sin² α cos β`, with `β` between normal and axis, where the horizon does not cut the cone. Where it does, about right:
    /// `sin α (cos β + sin α)² / 4`, which goes on smoothly from there to 0 as the cone sets.
    pub fn lambertian_share(&self, n: Vec3) -> f64 {
        let (cos, sin) = (n.as_dvec3().dot(self.axis), self.sin2.sqrt());
        if cos >= sin { self.sin2 * cos } else { 0.25 * sin * (cos + sin).max(0.0).powi(2) }
    }

    /// The share of all directions.
    pub fn uniform_share(&self) -> f64 {
        0.5 * self.versine
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Rng, Stream};

    fn ball(distance: f32, radius: f32) -> (BoundingSphere, Vec3) {
        let axis = Vec3::new(0.36, -0.48, 0.8);
        (BoundingSphere { center: distance * axis, radius }, axis)
    }

    /// `π (R/d)²` where the cone is narrow, at any distance.
    #[test]
    fn narrow_cones_keep_their_digits() {
        for (distance, angle) in [(1.0f32, 1e-2f32), (1e4, 1e-4), (1e-3, 1e-3)] {
            let (ball, _) = ball(distance, distance * angle);
            let cone = Cone::of(&ball, Vec3::ZERO).unwrap();
            let expected = 0.5 * TAU * (f64::from(angle) + MARGIN).powi(2);
            assert!((cone.solid_angle() / expected - 1.0).abs() < 1e-4, "{distance}, {angle}");
        }
    }

    #[test]
    fn half_a_sphere_of_directions_is_the_widest_cone() {
        let (ball, axis) = ball(1.0, 1.0 - 1e-5);
        let cone = Cone::of(&ball, Vec3::ZERO).unwrap();
        assert!(
            (0.98..1.0).contains(&(cone.solid_angle() / TAU)) && cone.contains(axis) && !cone.contains(-axis)
        );
        for inside in [axis, ball.center, ball.center * 0.5] {
            assert!(Cone::of(&ball, inside).is_none());
        }
    }

    /// Every sample is inside, and `1 - cos` has the moments of a uniform number: what cosines are rounded to would show.
    #[test]
    fn samples_fill_the_cone_evenly() {
        const N: u32 = 40_000;
        for angle in [1e-4f32, 0.1, 0.9] {
            let (ball, _) = ball(1e4, 1e4 * angle);
            let cone = Cone::of(&ball, Vec3::ZERO).unwrap();
            let (mut rng, mut sums, mut inside) = (Rng::new(3, Stream::Test, 0, 0), DVec3::ZERO, 0);
            for _ in 0..N {
                let dir = cone.sample(rng.next_vec2());
                inside += u32::from(cone.contains(dir));
                let sin2 = dir.as_dvec3().cross(cone.axis).length_squared() / dir.as_dvec3().length_squared();
                let u = sin2 / (1.0 + (1.0 - sin2).sqrt()) / cone.versine;
                sums += DVec3::new(
                    u,
                    u * u,
                    f64::from(dir.normalize().dot(cone.axis.any_orthonormal_vector().as_vec3())),
                );
            }
            assert!(N - inside < N / 500, "{angle}: {inside}");
            let mean = sums / f64::from(N);
            assert!((mean.x - 0.5).abs() < 0.005 && (mean.y - 1.0 / 3.0).abs() < 0.005, "{angle}: {mean}");
            assert!(mean.z.abs() < 0.01 * cone.sin2.sqrt(), "{angle}: {mean}");
        }
    }

    /// Against the mean of many directions, also where the horizon cuts the cone.
    #[test]
    fn shares_are_those_of_samples() {
        const N: u32 = 200_000;
        let (ball, axis) = ball(3.0, 0.6);
        let cone = Cone::of(&ball, Vec3::ZERO).unwrap();
        for (tilt, tolerance) in [(1.0, 0.02), (0.5, 0.02), (0.0, 0.25), (-0.1, 2.0)] {
            let side = axis.any_orthonormal_vector();
            let frame = Frame::around((tilt * axis + (1.0f32 - tilt * tilt).sqrt() * side).normalize());
            let mut rng = Rng::new(4, Stream::Test, 0, 0);
            let dirs = (0..N).map(|_| frame.to_world(warp::square_to_cosine_hemisphere(rng.next_vec2())));
            let share = dirs.filter(|&dir| cone.contains(dir)).count() as f64 / f64::from(N);
            let estimate = cone.lambertian_share(frame.normal);
            assert!((estimate / share - 1.0).abs() < tolerance, "{tilt}: {estimate} for {share}");
        }
        assert_eq!(cone.lambertian_share(-axis), 0.0);
    }
}
