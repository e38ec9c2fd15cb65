use super::{LANES, Lanes, Mask};
use crate::math::Vec3;

/// Sixteen vectors. Sums of products are added in the order x, y, z, as those of [`Vec3`].
#[derive(Clone, Copy)]
pub struct LaneVec3<L: Lanes> {
    /// All x.
    pub x: L::F32,
    /// All y.
    pub y: L::F32,
    /// All z.
    pub z: L::F32,
}

impl<L: Lanes> LaneVec3<L> {
    /// From columns of x, y and z; see [`Lanes::load`].
    #[inline(always)]
    pub fn load(lanes: L, [x, y, z]: [&[f32]; 3]) -> LaneVec3<L> {
        LaneVec3 { x: lanes.load(x), y: lanes.load(y), z: lanes.load(z) }
    }

    /// From all x, all y, all z.
    #[inline(always)]
    pub fn from_arrays(lanes: L, [x, y, z]: &[[f32; LANES]; 3]) -> LaneVec3<L> {
        LaneVec3 { x: lanes.load(x), y: lanes.load(y), z: lanes.load(z) }
    }

    /// The same vector in all lanes.
    #[inline(always)]
    pub fn splat(lanes: L, v: Vec3) -> LaneVec3<L> {
        LaneVec3 { x: lanes.splat(v.x), y: lanes.splat(v.y), z: lanes.splat(v.z) }
    }

    /// `self + other`.
    #[inline(always)]
    pub fn add(self, lanes: L, other: LaneVec3<L>) -> LaneVec3<L> {
        LaneVec3 {
            x: lanes.add(self.x, other.x),
            y: lanes.add(self.y, other.y),
            z: lanes.add(self.z, other.z),
        }
    }

    /// The products of the components.
    #[inline(always)]
    pub fn mul(self, lanes: L, other: LaneVec3<L>) -> LaneVec3<L> {
        LaneVec3 {
            x: lanes.mul(self.x, other.x),
            y: lanes.mul(self.y, other.y),
            z: lanes.mul(self.z, other.z),
        }
    }

    /// `factor · self`.
    #[inline(always)]
    pub fn scaled(self, lanes: L, factor: L::F32) -> LaneVec3<L> {
        LaneVec3 { x: lanes.mul(factor, self.x), y: lanes.mul(factor, self.y), z: lanes.mul(factor, self.z) }
    }

    /// `self` in the lanes of `mask`, `other` elsewhere.
    #[inline(always)]
    pub fn or(self, lanes: L, mask: Mask, other: LaneVec3<L>) -> LaneVec3<L> {
        LaneVec3 {
            x: lanes.select(mask, self.x, other.x),
            y: lanes.select(mask, self.y, other.y),
            z: lanes.select(mask, self.z, other.z),
        }
    }

    /// The lanes of `mask`, moved to the front; see [`Lanes::compress`].
    #[inline(always)]
    pub fn compress(self, lanes: L, mask: Mask) -> LaneVec3<L> {
        LaneVec3 {
            x: lanes.compress(mask, self.x),
            y: lanes.compress(mask, self.y),
            z: lanes.compress(mask, self.z),
        }
    }

    /// Writes columns of x, y and z; see [`Lanes::store`].
    #[inline(always)]
    pub fn store(self, lanes: L, [x, y, z]: [&mut [f32]; 3]) {
        lanes.store(self.x, x);
        lanes.store(self.y, y);
        lanes.store(self.z, z);
    }

    /// All x, all y, all z.
    #[inline(always)]
    pub fn to_arrays(self, lanes: L) -> [[f32; LANES]; 3] {
        let mut columns = [[0.0; LANES]; 3];
        let [x, y, z] = &mut columns;
        self.store(lanes, [x, y, z]);
        columns
    }

    /// `self - other`.
    #[inline(always)]
    pub fn sub(self, lanes: L, other: LaneVec3<L>) -> LaneVec3<L> {
        LaneVec3 {
            x: lanes.sub(self.x, other.x),
            y: lanes.sub(self.y, other.y),
            z: lanes.sub(self.z, other.z),
        }
    }

    /// The scalar products with `other`.
    #[inline(always)]
    pub fn dot(self, lanes: L, other: LaneVec3<L>) -> L::F32 {
        let xy = lanes.add(lanes.mul(self.x, other.x), lanes.mul(self.y, other.y));
        lanes.add(xy, lanes.mul(self.z, other.z))
    }
}
