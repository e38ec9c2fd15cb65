//! Sixteen photons that leave their lights.

use super::draws::Draws;
use super::flights::{COUNT, Flights, LaneFlights};
use crate::light::{LaneEmission, Lights};
use crate::simd::{Kernel, Lanes, Mask};

/// Emits the photons `first`, `first + 1`, ... of a chunk: those of the lanes of `mask`.
///
/// Returns those that are dropped for want of power.
pub(super) struct Emission<'a> {
    pub lights: &'a Lights,
    pub draws: Draws,
    pub first: u32,
    pub mask: Mask,
    pub flights: &'a mut Flights,
}

impl Kernel for Emission<'_> {
    type Output = Mask;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Mask {
        let path = lanes.add_u32(lanes.splat_u32(self.first), lanes.load_u32(&COUNT));
        let [coarse, a, b, c] = self.draws.in_lanes(lanes, path, 0);
        let [d, fine, ..] = self.draws.in_lanes(lanes, path, 1);
        let LaneEmission { origin, dir, power } =
            self.lights.sample_emissions(lanes, [coarse, fine], [a, b, c, d]);
        let flights = LaneFlights { origin, dir, power, path };
        let bright = flights.have_power(lanes) & flights.are_finite(lanes);
        self.flights.push(lanes, self.mask & bright, &flights);
        self.mask & !bright
    }
}
