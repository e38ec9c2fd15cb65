use std::f64::consts::TAU;

use crate::math::{Frame, Rgb, Vec2, Vec3};

/// A point that shines into a cone, fully up to the angle `inner` from its axis and then less, to nothing at `outer`:
/// `I(θ) = I (outer - θ) / (outer - inner)` between the two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// Where it is.
    pub position: Vec3,
    /// The middle of the cone, unit.
    pub axis: Vec3,
    /// Radiant intensity along the axis (W/sr).
    pub intensity: Rgb,
    /// In radians, from 0 to `outer`.
    pub inner: f32,
    /// In radians, above 0 and up to π.
    pub outer: f32,
}

impl Spot {
    /// The share of the intensity that goes along `dir`, unit.
    pub fn falloff(&self, dir: Vec3) -> f32 {
        let angle = (dir - self.axis).length().atan2((dir + self.axis).length()) * 2.0;
        if angle <= self.inner { 1.0 } else { ((self.outer - angle) / (self.outer - self.inner)).max(0.0) }
    }

    /// The integral of the falloff over all directions (sr): `2π (1 - (sin outer - sin inner) / (outer - inner))`.
    pub fn solid_angle(&self) -> f64 {
        TAU * (self.full() + self.fading(f64::from(self.outer)))
    }

    /// `1 - cos inner`.
    fn full(&self) -> f64 {
        2.0 * (0.5 * f64::from(self.inner)).sin().powi(2)
    }

    /// `∫ (outer - t) / (outer - inner) sin t dt` from `inner` to `angle`.
    fn fading(&self, angle: f64) -> f64 {
        let (inner, outer) = (f64::from(self.inner), f64::from(self.outer));
        let antiderivative = |t: f64| (t - outer) * t.cos() - t.sin();
        if outer > inner { (antiderivative(angle) - antiderivative(inner)) / (outer - inner) } else { 0.0 }
    }

    /// A direction, as often as light goes there.
    pub fn sample(&self, u: Vec2) -> Vec3 {
        let (full, all) = (self.full(), self.full() + self.fading(f64::from(self.outer)));
        let target = f64::from(u.x) * all;
        let angle =
            if target < full { 2.0 * (0.5 * target).sqrt().asin() } else { self.fading_angle(target - full) };
        let turn = TAU * f64::from(u.y);
        let local = [angle.sin() * turn.cos(), angle.sin() * turn.sin(), angle.cos()].map(|x| x as f32);
        Frame::around(self.axis).to_world(Vec3::from_array(local))
    }

    /// Where [`Spot::fading`] is `target`, by bisection down to the last bits.
    fn fading_angle(&self, target: f64) -> f64 {
        const STEPS: u32 = 40;
        let (mut low, mut high) = (f64::from(self.inner), f64::from(self.outer));
        for _ in 0..STEPS {
            let middle = 0.5 * (low + high);
            if self.fading(middle) < target { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Rng, Stream, warp};

    fn spots() -> [Spot; 3] {
        let spot = |inner, outer| Spot {
            position: Vec3::ZERO,
            axis: Vec3::new(0.48, 0.6, -0.64),
            intensity: Rgb::ONE,
            inner,
            outer,
        };
        [spot(0.2, 0.5), spot(0.0, 3.0), spot(0.7, 0.7)]
    }

    /// Against the mean of the falloff over all directions.
    #[test]
    fn the_solid_angle_is_the_integral_of_the_falloff() {
        const N: usize = 400_000;
        for spot in spots() {
            let mut rng = Rng::new(1, Stream::Test, 0, 0);
            let falloff = (0..N).map(|_| spot.falloff(warp::square_to_uniform_sphere(rng.next_vec2())));
            let integral = falloff.map(f64::from).sum::<f64>() / N as f64 * 2.0 * TAU;
            assert!((integral / spot.solid_angle() - 1.0).abs() < 0.02, "{spot:?}: {integral}");
        }
    }

    /// The mean of any function over samples is its mean over the falloff. Catches directions drawn uniformly in the cone.
    #[test]
    fn directions_are_as_frequent_as_light() {
        const N: usize = 200_000;
        for spot in spots() {
            let mut rng = Rng::new(2, Stream::Test, 0, 0);
            let of = |dir: Vec3| f64::from(dir.dot(spot.axis)).powi(3);
            let drawn = (0..N).map(|_| of(spot.sample(rng.next_vec2()))).sum::<f64>() / N as f64;
            let mut weighed = 0.0;
            for _ in 0..N {
                let dir = warp::square_to_uniform_sphere(rng.next_vec2());
                weighed += of(dir) * f64::from(spot.falloff(dir)) / N as f64 * 2.0 * TAU / spot.solid_angle();
            }
            assert!((drawn - weighed).abs() < 0.03, "{spot:?}: {drawn} {weighed}");
        }
    }

    /// Around the axis directions turn evenly, by `2π u.y`: equal steps of it are equal angles, which add up to a full turn, and
    /// leave the angle from the axis as it is.
    #[test]
    fn directions_turn_evenly_around_the_axis() {
        for spot in spots() {
            for share in [0.1, 0.9] {
                let across = |k: u8| {
                    let dir = spot.sample(Vec2::new(share, f32::from(k) / 8.0));
                    let along = dir.dot(spot.axis);
                    assert!((along - spot.sample(Vec2::new(share, 0.0)).dot(spot.axis)).abs() < 1e-6);
                    (dir - along * spot.axis).normalize()
                };
                for k in 0..8 {
                    let (now, next) = (across(k), across(k + 1));
                    let turn = now.cross(next).dot(spot.axis).atan2(now.dot(next));
                    assert!((turn - std::f32::consts::FRAC_PI_4).abs() < 1e-4, "{spot:?}: {turn}");
                }
            }
        }
    }
}
