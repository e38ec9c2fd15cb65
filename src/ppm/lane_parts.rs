use super::evenness::{PARTS, PartSums};
use crate::math::{Rgb, mean};
use crate::simd::{LANES, LaneFrame, LaneVec3, Lanes, Mask};

/// Where in the discs of up to sixteen hit points the photons of a pass lie; see [`PartSums`].
pub(super) struct LaneParts<L: Lanes> {
    frame: LaneFrame<L>,
    flux: [L::F64; PARTS],
    squares: L::F64,
}

/// The sums of all lanes.
pub(super) struct PartArrays {
    flux: [[f64; LANES]; PARTS],
    squares: [f64; LANES],
}

impl<L: Lanes> LaneParts<L> {
    /// Quadrants are told in [`Frame::around`](crate::math::Frame::around) the normals.
    #[inline(always)]
    pub(super) fn zero(lanes: L, ng: LaneVec3<L>) -> LaneParts<L> {
        let frame = LaneFrame::around(lanes, ng);
        LaneParts { frame, flux: [lanes.zero_f64(); PARTS], squares: lanes.zero_f64() }
    }

    /// Adds a photon to the hit points of `accepted`; `inner` is where it lies in the inner half of the area.
    #[inline(always)]
    pub(super) fn add(
        &mut self,
        lanes: L,
        accepted: Mask,
        offset: LaneVec3<L>,
        inner: Mask,
        power: Rgb,
        response: Option<L::F32>,
    ) {
        let zero = lanes.splat(0.0);
        let right = lanes.lt(offset.dot(lanes, self.frame.tangent), zero);
        let upper = lanes.lt(offset.dot(lanes, self.frame.bitangent), zero);
        let flux = lanes.splat(mean(power));
        let flux = match response {
            Some(response) => lanes.mul(response, flux),
            None => flux,
        };
        let sides = [[inner, right, upper], [!inner, !right, !upper]];
        let mut part = 0;
        while part < PARTS {
            let here = sides[part >> 2 & 1][0] & sides[part >> 1 & 1][1] & sides[part & 1][2];
            self.flux[part] = lanes.add_where(accepted & here, self.flux[part], flux);
            part += 1;
        }
        self.squares = lanes.add_where(accepted, self.squares, lanes.mul(flux, flux));
    }

    #[inline(always)]
    pub(super) fn to_arrays(&self, lanes: L) -> PartArrays {
        let mut flux = [[0.0; LANES]; PARTS];
        let mut part = 0;
        while part < PARTS {
            flux[part] = lanes.to_array_f64(self.flux[part]);
            part += 1;
        }
        PartArrays { flux, squares: lanes.to_array_f64(self.squares) }
    }
}

impl PartArrays {
    pub(super) fn lane(&self, lane: usize) -> PartSums {
        PartSums { flux: self.flux.map(|lanes| lanes[lane]), squares: self.squares[lane] }
    }
}
