//! [`crate::math::warp`] in lanes, bit by bit.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

use super::{LaneVec3, Lanes, Mask};
use crate::math::warp::{COS, SIN};

/// [`crate::math::warp::square_to_cosine_hemisphere`] of `(u, v)`.
#[inline(always)]
pub fn square_to_cosine_hemisphere<L: Lanes>(lanes: L, u: L::F32, v: L::F32) -> LaneVec3<L> {
    let (x, y) = square_to_disk(lanes, u, v);
    let r2 = lanes.add(lanes.mul(x, x), lanes.mul(y, y));
    let z2 = lanes.sub(lanes.splat(1.0), r2);
    let zero = lanes.splat(0.0);
    LaneVec3 { x, y, z: lanes.sqrt(lanes.max(z2, zero)) }
}

/// [`crate::math::warp::square_to_uniform_sphere`] of `(u, v)`.
#[inline(always)]
pub fn square_to_uniform_sphere<L: Lanes>(lanes: L, u: L::F32, v: L::F32) -> LaneVec3<L> {
    let one = lanes.splat(1.0);
    let z = lanes.sub(one, lanes.mul(lanes.splat(2.0), u));
    let r = lanes.sqrt(lanes.max(lanes.sub(one, lanes.mul(z, z)), lanes.splat(0.0)));
    let (x, y) = unit_circle(lanes, v);
    LaneVec3 { x: lanes.mul(r, x), y: lanes.mul(r, y), z }
}

/// [`crate::math::warp::square_to_triangle`] of `(u, v)`.
#[inline(always)]
pub fn square_to_triangle<L: Lanes>(lanes: L, u: L::F32, v: L::F32) -> (L::F32, L::F32) {
    let s = lanes.sqrt(u);
    (lanes.mul(s, lanes.sub(lanes.splat(1.0), v)), lanes.mul(s, v))
}

#[inline(always)]
fn unit_circle<L: Lanes>(lanes: L, u: L::F32) -> (L::F32, L::F32) {
    let quarters = lanes.mul(lanes.splat(4.0), u);
    let rounded_up = lanes.add(quarters, lanes.splat(0.5));
    let mut nearest = lanes.splat(0.0);
    let mut at_least = [Mask::MAX; 5];
    for k in 1..5u8 {
        let quarter = lanes.splat(f32::from(k));
        at_least[usize::from(k)] = lanes.le(quarter, rounded_up);
        nearest = lanes.select(at_least[usize::from(k)], quarter, nearest);
    }
    let [_, first, second, third, fourth] = at_least;
    let angle = lanes.mul(lanes.splat(FRAC_PI_2), lanes.sub(quarters, nearest));
    let (sin, cos) = sin_cos_of_octant(lanes, angle);
    let is_odd = first & !second | third & !fourth;
    let (x, y) = (lanes.select(is_odd, sin, cos), lanes.select(is_odd, cos, sin));
    (negated_in(lanes, first & !third, x), negated_in(lanes, second & !fourth, y))
}

#[inline(always)]
fn negated_in<L: Lanes>(lanes: L, mask: Mask, x: L::F32) -> L::F32 {
    lanes.select(mask, lanes.mul(lanes.splat(-1.0), x), x)
}

#[inline(always)]
fn square_to_disk<L: Lanes>(lanes: L, u: L::F32, v: L::F32) -> (L::F32, L::F32) {
    let (zero, one, two) = (lanes.splat(0.0), lanes.splat(1.0), lanes.splat(2.0));
    let (x, y) = (lanes.sub(lanes.mul(two, u), one), lanes.sub(lanes.mul(two, v), one));
    let (x_size, y_size) = (lanes.copysign(x, one), lanes.copysign(y, one));
    let x_is_larger = lanes.lt(y_size, x_size);
    let (r, other) = (lanes.select(x_is_larger, x, y), lanes.select(x_is_larger, y, x));
    let angle = lanes.mul(lanes.splat(FRAC_PI_4), lanes.div(other, r));
    let (sin, cos) = sin_cos_of_octant(lanes, angle);
    let x = lanes.mul(r, lanes.select(x_is_larger, cos, sin));
    let y = lanes.mul(r, lanes.select(x_is_larger, sin, cos));
    let off_centre = lanes.lt(zero, lanes.copysign(r, one));
    (lanes.select(off_centre, x, zero), lanes.select(off_centre, y, zero))
}

#[inline(always)]
fn sin_cos_of_octant<L: Lanes>(lanes: L, x: L::F32) -> (L::F32, L::F32) {
    let z = lanes.mul(x, x);
    let sin = lanes.add(lanes.mul(lanes.mul(quadratic(lanes, SIN, z), z), x), x);
    let cos = lanes.mul(lanes.mul(quadratic(lanes, COS, z), z), z);
    let cos = lanes.sub(cos, lanes.mul(lanes.splat(0.5), z));
    (sin, lanes.add(cos, lanes.splat(1.0)))
}

/// `(c0 z + c1) z + c2`.
#[inline(always)]
fn quadratic<L: Lanes>(lanes: L, c: [f32; 3], z: L::F32) -> L::F32 {
    let first = lanes.add(lanes.mul(lanes.splat(c[0]), z), lanes.splat(c[1]));
    lanes.add(lanes.mul(first, z), lanes.splat(c[2]))
}

#[cfg(test)]
mod tests {
    use super::super::{Isa, Kernel, LANES, LaneFrame};
    use super::*;
    use crate::math::{self, Frame, Vec2, Vec3};
    use proptest::prelude::*;

    /// A direction around a normal in every lane.
    struct Around<'a> {
        normals: &'a [Vec3; LANES],
        u: &'a [Vec2; LANES],
    }

    impl Kernel for Around<'_> {
        type Output = [[f32; LANES]; 3];

        #[inline(always)]
        fn run<L: Lanes>(self, lanes: L) -> Self::Output {
            let columns = [0, 1, 2].map(|axis| self.normals.map(|n| n[axis]));
            let normals = LaneVec3::from_arrays(lanes, &columns);
            let [u, v] = [0, 1].map(|axis| self.u.map(|u| u[axis]));
            let local = square_to_cosine_hemisphere(lanes, lanes.load(&u), lanes.load(&v));
            LaneFrame::around(lanes, normals).to_world(lanes, local).to_arrays(lanes)
        }
    }

    fn unit_interval() -> impl Strategy<Value = f32> {
        prop_oneof![0f32..1.0, Just(0.0), Just(0.5), (0u8..=8).prop_map(|k| f32::from(k) / 8.0)]
    }

    fn normal() -> impl Strategy<Value = Vec3> {
        let slanted = (-1f32..1.0, -1f32..1.0, -1f32..1.0).prop_map(|v| Vec3::from(v).normalize_or(Vec3::X));
        prop_oneof![slanted, Just(Vec3::Y), Just(Vec3::NEG_Z), Just(Vec3::new(-0.0, 1.0, -0.0))]
    }

    /// Points of sphere and triangle in every lane.
    struct Points<'a>(&'a [Vec2; LANES]);

    impl Kernel for Points<'_> {
        type Output = [[f32; LANES]; 5];

        #[inline(always)]
        fn run<L: Lanes>(self, lanes: L) -> Self::Output {
            let [u, v] = [0, 1].map(|axis| self.0.map(|u| u[axis]));
            let (u, v) = (lanes.load(&u), lanes.load(&v));
            let [x, y, z] = square_to_uniform_sphere(lanes, u, v).to_arrays(lanes);
            let (b, c) = square_to_triangle(lanes, u, v);
            let [b, c, _] = LaneVec3 { x: b, y: c, z: c }.to_arrays(lanes);
            [x, y, z, b, c]
        }
    }

    proptest! {
        #[test]
        fn lanes_start_where_single_photons_start(
            u in prop::collection::vec((unit_interval(), unit_interval()).prop_map(Vec2::from), LANES),
        ) {
            let u = u.try_into().unwrap();
            for isa in Isa::available() {
                let points = isa.run(Points(&u));
                for (lane, &u) in u.iter().enumerate() {
                    let (dir, b) = (math::warp::square_to_uniform_sphere(u), math::warp::square_to_triangle(u));
                    let expected = [dir.x, dir.y, dir.z, b.x, b.y].map(f32::to_bits);
                    prop_assert_eq!(points.map(|column| column[lane].to_bits()), expected, "{} {}", isa, u);
                }
            }
        }

        #[test]
        fn lanes_turn_where_single_photons_turn(
            normals in prop::collection::vec(normal(), LANES),
            u in prop::collection::vec((unit_interval(), unit_interval()).prop_map(Vec2::from), LANES),
        ) {
            let (normals, u) = (normals.try_into().unwrap(), u.try_into().unwrap());
            let expected: Vec<[u32; 3]> = (0..LANES).map(|k| {
                let (normal, u): (&[Vec3; LANES], &[Vec2; LANES]) = (&normals, &u);
                let local = math::warp::square_to_cosine_hemisphere(u[k]);
                Frame::around(normal[k]).to_world(local).to_array().map(f32::to_bits)
            }).collect();
            for isa in Isa::available() {
                let dirs = isa.run(Around { normals: &normals, u: &u });
                for (lane, expected) in expected.iter().enumerate() {
                    prop_assert_eq!(&dirs.map(|column| column[lane].to_bits()), expected, "{}", isa);
                }
            }
        }
    }
}
