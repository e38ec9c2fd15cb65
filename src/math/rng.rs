use super::Vec2;

/// What a random number is for. Streams never share a number, so adding draws to one shifts no other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Stream {
    /// Positions of eye samples on the film.
    Eye,
    /// Points on area lights for shadow rays of hit points.
    DirectLight,
    /// Emission and bounces of photons.
    Photon,
    /// Paths of the reference path tracer.
    PathTracer,
    /// Anything that a test draws.
    Test,
    /// Paths of the reference light tracer.
    LightTracer,
    /// The light tracer's eye rays, which find the lamps that the camera sees.
    SeenLamps,
    /// Rays that measurements send into meshes.
    Probe,
    /// The ways on of faint eye paths.
    EyeRoulette,
    /// Points of the lens that eye samples look through.
    Lens,
    /// Emission and bounces of photons that are aimed at casters of caustics.
    AimedPhoton,
    /// Facets of rough surfaces on eye paths, and light that these reflect straight from its source.
    Facet,
}

/// A counter-based generator: number `dimension` of `(seed, stream, pass, index)` is a pure function of these five.
///
/// One generator belongs to one path, so a picture depends neither on the number of threads nor on their order.
/// Philox4x32 with ten rounds turns the 128-bit counter `(index, pass, stream and block)` under the 64-bit key
/// `seed` into four 32-bit numbers; no two keys share a counter, so streams cannot overlap.
///
/// # Source
/// Salmon, Moraes, Dror and Shaw, "Parallel Random Numbers: As Easy as 1, 2, 3", SC 2011, section 3.3.
///
/// ```
/// use caustica::math::{Rng, Stream};
/// let draw = || Rng::new(1, Stream::Photon, 3, 42).next_f32();
/// assert_eq!(draw(), draw());
/// ```
#[derive(Clone, Debug)]
pub struct Rng {
    key: [u32; 2],
    counter: [u32; 4],
    block: [u32; 4],
    used: usize,
}

impl Rng {
    /// The generator of one path: path number `index` of `stream` in pass number `pass`.
    pub fn new(seed: u64, stream: Stream, pass: u32, index: u64) -> Rng {
        Rng::at_segment(seed, stream, pass, index, 0)
    }

    /// The generator of one segment of a path, which draws nothing that another segment draws: so what happens there
    /// can be told without what happened before. Segments count to 1023.
    pub fn at_segment(seed: u64, stream: Stream, pass: u32, index: u64, segment: u32) -> Rng {
        Rng { key: key(seed), counter: counter(stream, pass, index, segment), block: [0; 4], used: 4 }
    }

    /// The next 32 random bits.
    pub fn next_u32(&mut self) -> u32 {
        if self.used == 4 {
            self.block = philox4x32(self.counter, self.key);
            self.counter[3] += 1;
            self.used = 0;
        }
        self.used += 1;
        self.block[self.used - 1]
    }

    /// A multiple of 2⁻²⁴ in `[0, 1)`.
    pub fn next_f32(&mut self) -> f32 {
        unit_f32(self.next_u32())
    }

    /// A point of the unit square.
    pub fn next_vec2(&mut self) -> Vec2 {
        Vec2::new(self.next_f32(), self.next_f32())
    }
}

/// The spacing of the numbers that [`unit_f32`] makes.
pub const UNIT: f32 = 1.0 / (1u32 << 24) as f32;

/// Random bits as a multiple of 2⁻²⁴ in `[0, 1)`.
pub fn unit_f32(bits: u32) -> f32 {
    (bits >> 8) as f32 * UNIT
}

/// The key of Philox that a seed stands for.
pub fn key(seed: u64) -> [u32; 2] {
    [seed as u32, (seed >> 32) as u32]
}

/// The counter of the first four numbers of [`Rng::at_segment`]; the last part of it counts on.
pub fn counter(stream: Stream, pass: u32, index: u64, segment: u32) -> [u32; 4] {
    const BLOCKS_BITS: u32 = 14;
    [index as u32, (index >> 32) as u32, pass, (stream as u32) << 24 | segment << BLOCKS_BITS]
}

/// How often Philox mixes.
pub const PHILOX_ROUNDS: usize = 10;
/// What Philox multiplies the first and the third part of the counter by.
pub const PHILOX_MULTIPLIERS: [u32; 2] = [0xD251_1F53, 0xCD9E_8D57];
/// What Philox adds to the key after each round.
pub const PHILOX_WEYL: [u32; 2] = [0x9E37_79B9, 0xBB67_AE85];

/// Four random numbers from a counter and a key.
///
/// # Source
/// See [`Rng`].
pub fn philox4x32(counter: [u32; 4], key: [u32; 2]) -> [u32; 4] {
    let (mut c, mut k) = (counter, key);
    for _ in 0..PHILOX_ROUNDS {
        let a = u64::from(PHILOX_MULTIPLIERS[0]) * u64::from(c[0]);
        let b = u64::from(PHILOX_MULTIPLIERS[1]) * u64::from(c[2]);
        c = [(b >> 32) as u32 ^ c[1] ^ k[0], b as u32, (a >> 32) as u32 ^ c[3] ^ k[1], a as u32];
        k = [k[0].wrapping_add(PHILOX_WEYL[0]), k[1].wrapping_add(PHILOX_WEYL[1])];
    }
    c
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The known answers that the authors of Philox publish with their library (Random123, `kat_vectors`).
    #[test]
    fn philox_gives_the_published_answers() {
        let ones = u32::MAX;
        assert_eq!(philox4x32([0; 4], [0; 2]), [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8]);
        assert_eq!(philox4x32([ones; 4], [ones; 2]), [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd]);
        assert_eq!(
            philox4x32([0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344], [0xa409_3822, 0x299f_31d0]),
            [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1]
        );
    }

    #[test]
    fn every_part_of_the_key_changes_the_numbers() {
        let first = |seed, stream, pass, index| Rng::new(seed, stream, pass, index).next_u32();
        let base = first(1, Stream::Eye, 0, 0);
        for other in [
            first(2, Stream::Eye, 0, 0),
            first(1 << 40 | 1, Stream::Eye, 0, 0),
            first(1, Stream::Photon, 0, 0),
            first(1, Stream::Eye, 1, 0),
            first(1, Stream::Eye, 0, 1),
            first(1, Stream::Eye, 0, 1 << 40),
            Rng::at_segment(1, Stream::Eye, 0, 0, 1).next_u32(),
            Rng::at_segment(1, Stream::Eye, 0, 0, 1023).next_u32(),
        ] {
            assert_ne!(base, other);
        }
    }

    #[test]
    fn the_longest_path_stays_within_its_stream() {
        let [.., last] = counter(Stream::Eye, 0, 0, 1023);
        assert!(last < counter(Stream::DirectLight, 0, 0, 0)[3]);
        assert!(last + 16_000 < counter(Stream::DirectLight, 0, 0, 0)[3]);
    }

    #[test]
    fn floats_stay_below_one() {
        let mut rng = Rng::new(7, Stream::Test, 0, 0);
        assert!((0..100_000).all(|_| (0.0..1.0).contains(&rng.next_f32())));
    }
}
