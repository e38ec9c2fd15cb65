use crate::math::rng::{self, Rng, Stream};
use crate::simd::{Lanes, philox4x32};

/// The random numbers of a chunk of photons at one segment of their paths: emission is the first, every bounce one more.
#[derive(Clone, Copy, Debug)]
pub(super) struct Draws {
    pub seed: u64,
    pub pass: u32,
    /// The path that is number 0 of the chunk; a multiple of a power of two above all numbers in the chunk.
    pub first: u64,
    pub segment: u32,
}

impl Draws {
    /// Whether the photons come straight from their lights.
    pub fn is_first_flight(&self) -> bool {
        self.segment == 1
    }

    /// The numbers of one photon.
    pub fn of(&self, path: u32) -> Rng {
        Rng::at_segment(self.seed, Stream::Photon, self.pass, self.first + u64::from(path), self.segment)
    }

    /// Of [`Draws::of`] the numbers from `4 · block` on, four of each of sixteen photons.
    #[inline(always)]
    pub fn in_lanes<L: Lanes>(&self, lanes: L, paths: L::U32, block: u32) -> [L::F32; 4] {
        let [low, high, pass, first_block] =
            rng::counter(Stream::Photon, self.pass, self.first, self.segment);
        let counter = [
            lanes.add_u32(lanes.splat_u32(low), paths),
            lanes.splat_u32(high),
            lanes.splat_u32(pass),
            lanes.splat_u32(first_block + block),
        ];
        let [a, b, c, d] = philox4x32(lanes, counter, rng::key(self.seed));
        [lanes.unit_f32(a), lanes.unit_f32(b), lanes.unit_f32(c), lanes.unit_f32(d)]
    }
}
