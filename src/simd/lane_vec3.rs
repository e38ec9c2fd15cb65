use super::Lanes;
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

    /// The same vector in all lanes.
    #[inline(always)]
    pub fn splat(lanes: L, v: Vec3) -> LaneVec3<L> {
        LaneVec3 { x: lanes.splat(v.x), y: lanes.splat(v.y), z: lanes.splat(v.z) }
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
