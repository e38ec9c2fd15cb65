//! The sums that photons in lanes add their power to.

use super::FluxLedger;
use super::flights::Flights;
use crate::math::DVec3;
use crate::simd::{Kernel, LANES, LaneVec3, Lanes, Mask, first_lanes};

/// A sum of each lane.
type Sums = [f64; LANES];

/// What photons carried to where they went, lane by lane, so that no instruction set adds in another order.
#[derive(Debug)]
#[repr(C, align(64))]
pub(super) struct LaneFlux {
    landed: [Sums; 3],
    sent_on: [Sums; 3],
    escaped: [Sums; 3],
    variance: Sums,
}

impl LaneFlux {
    pub const ZERO: LaneFlux = LaneFlux {
        landed: [[0.0; LANES]; 3],
        sent_on: [[0.0; LANES]; 3],
        escaped: [[0.0; LANES]; 3],
        variance: [0.0; LANES],
    };

    /// Photons of `mask` that reach surfaces of this albedo. One that is no number sends nothing on.
    ///
    /// A photon of power `P` flies on with `P albedo / p` at the probability `p`, the largest albedo of a channel, so with a variance
    /// of at most `P² albedo`; twice that covers uniform bounces, which scale it by a factor whose square has the mean 4/3.
    #[inline(always)]
    pub fn land<L: Lanes>(&mut self, lanes: L, mask: Mask, power: LaneVec3<L>, albedo: LaneVec3<L>) {
        let sent_on = power.mul(lanes, albedo);
        let infinity = lanes.splat(f32::INFINITY);
        let finite =
            lanes.lt(sent_on.x, infinity) & lanes.lt(sent_on.y, infinity) & lanes.lt(sent_on.z, infinity);
        add(lanes, mask, power, &mut self.landed);
        add(lanes, mask & finite, sent_on, &mut self.sent_on);
        let squares = power.dot(lanes, sent_on);
        add_to(lanes, mask & finite, lanes.add(squares, squares), &mut self.variance);
    }

    /// Photons of `mask` that leave the scene.
    #[inline(always)]
    pub fn escape<L: Lanes>(&mut self, lanes: L, mask: Mask, power: LaneVec3<L>) {
        if mask != 0 {
            add(lanes, mask, power, &mut self.escaped);
        }
    }

    /// Moves all sums into a ledger.
    pub fn settle(&mut self, ledger: &mut FluxLedger) {
        ledger.land(total(&self.landed), total(&self.sent_on));
        ledger.escaped += total(&self.escaped);
        ledger.roulette_variance += self.variance.iter().sum::<f64>();
        *self = LaneFlux::ZERO;
    }
}

#[inline(always)]
fn add<L: Lanes>(lanes: L, mask: Mask, power: LaneVec3<L>, [x, y, z]: &mut [Sums; 3]) {
    add_to(lanes, mask, power.x, x);
    add_to(lanes, mask, power.y, y);
    add_to(lanes, mask, power.z, z);
}

#[inline(always)]
fn add_to<L: Lanes>(lanes: L, mask: Mask, x: L::F32, sums: &mut Sums) {
    *sums = lanes.to_array_f64(lanes.add_where(mask, lanes.load_f64(sums), x));
}

fn total(sums: &[Sums; 3]) -> DVec3 {
    DVec3::from(sums.map(|lanes| lanes.iter().sum()))
}

/// The power of all photons on their way.
pub(super) struct PowerOf<'a>(pub &'a Flights);

impl Kernel for PowerOf<'_> {
    type Output = DVec3;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> DVec3 {
        let [red, green, blue] = self.0.powers();
        let (mut x, mut y, mut z) = (lanes.zero_f64(), lanes.zero_f64(), lanes.zero_f64());
        let mut first = 0;
        while first < red.len() {
            let mask = first_lanes(red.len() - first);
            x = lanes.add_where(mask, x, lanes.load(&red[first..]));
            y = lanes.add_where(mask, y, lanes.load(&green[first..]));
            z = lanes.add_where(mask, z, lanes.load(&blue[first..]));
            first += LANES;
        }
        total(&[lanes.to_array_f64(x), lanes.to_array_f64(y), lanes.to_array_f64(z)])
    }
}
