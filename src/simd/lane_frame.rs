use super::{LaneVec3, Lanes};

/// Sixteen frames: [`crate::math::Frame`] in lanes, bit by bit.
#[derive(Clone, Copy)]
pub struct LaneFrame<L: Lanes> {
    /// Local x.
    pub tangent: LaneVec3<L>,
    /// Local y.
    pub bitangent: LaneVec3<L>,
    /// Local z.
    pub normal: LaneVec3<L>,
}

impl<L: Lanes> LaneFrame<L> {
    /// The frames around unit vectors.
    #[inline(always)]
    pub fn around(lanes: L, normal: LaneVec3<L>) -> LaneFrame<L> {
        let LaneVec3 { x, y, z } = normal;
        let (one, minus_one) = (lanes.splat(1.0), lanes.splat(-1.0));
        let sign = lanes.copysign(one, lanes.add(z, lanes.splat(0.5)));
        let a = lanes.div(minus_one, lanes.add(sign, z));
        let b = lanes.mul(lanes.mul(x, y), a);
        let xx = lanes.mul(lanes.mul(lanes.mul(sign, x), x), a);
        let yy = lanes.mul(lanes.mul(y, y), a);
        let minus_sign = lanes.mul(minus_one, sign);
        LaneFrame {
            tangent: LaneVec3 { x: lanes.add(one, xx), y: lanes.mul(sign, b), z: lanes.mul(minus_sign, x) },
            bitangent: LaneVec3 { x: b, y: lanes.add(sign, yy), z: lanes.mul(minus_one, y) },
            normal,
        }
    }

    /// World coordinates of local vectors.
    #[inline(always)]
    pub fn to_world(&self, lanes: L, v: LaneVec3<L>) -> LaneVec3<L> {
        let xy = self.tangent.scaled(lanes, v.x).add(lanes, self.bitangent.scaled(lanes, v.y));
        xy.add(lanes, self.normal.scaled(lanes, v.z))
    }
}
