//! Sixteen numbers at a time, by the widest instructions that the machine has.
//!
//! A [`Kernel`] is written once over any [`Lanes`]; [`Isa::run`] runs it with those of an instruction set that was found
//! at run time. Every set gives the same bits: no operation rounds differently, none is fused.
//!
//! ```
//! use caustica::simd::{Isa, Kernel, Lanes};
//! struct CountBelow<'a>(&'a [f32], f32);
//! impl Kernel for CountBelow<'_> {
//!     type Output = u32;
//!     #[inline(always)]
//!     fn run<L: Lanes>(self, lanes: L) -> u32 {
//!         lanes.le(lanes.load(self.0), lanes.splat(self.1)).count_ones()
//!     }
//! }
//! let numbers: Vec<f32> = (0..16u8).map(f32::from).collect();
//! for isa in Isa::available() {
//!     assert_eq!(isa.run(CountBelow(&numbers, 4.0)), 5);
//! }
//! ```

#![allow(unsafe_code)]
#![warn(clippy::undocumented_unsafe_blocks)]

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod lane_frame;
mod lane_vec3;
mod lanes;
mod philox;
mod portable;
pub mod warp;

use std::fmt;
use std::sync::LazyLock;

pub use lane_frame::LaneFrame;
pub use lane_vec3::LaneVec3;
pub use lanes::{Kernel, LANES, Lanes, Mask, first_lanes};
pub use philox::philox4x32;

use portable::Portable;

/// An instruction set that this machine has.
#[derive(Clone, Copy, Debug)]
pub struct Isa(Set);

#[derive(Clone, Copy, Debug)]
enum Set {
    Portable(Portable),
    #[cfg(target_arch = "x86_64")]
    Avx2(avx2::Avx2),
    #[cfg(target_arch = "x86_64")]
    Avx512(avx512::Avx512),
}

impl Isa {
    /// The widest of [`Isa::available`].
    pub fn best() -> Isa {
        static BEST: LazyLock<Isa> = LazyLock::new(|| Isa::available().last().unwrap_or(Isa::portable()));
        *BEST
    }

    /// All that this machine has, from the narrowest to the widest.
    pub fn available() -> impl Iterator<Item = Isa> {
        let portable = Some(Set::Portable(Portable));
        #[cfg(target_arch = "x86_64")]
        let vector = [avx2::Avx2::detect().map(Set::Avx2), avx512::Avx512::detect().map(Set::Avx512)];
        #[cfg(not(target_arch = "x86_64"))]
        let vector = [None; 0];
        [portable].into_iter().chain(vector).flatten().map(Isa)
    }

    /// The one that every machine has.
    pub fn portable() -> Isa {
        Isa(Set::Portable(Portable))
    }

    /// Runs a kernel with the instructions of this set.
    pub fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match self.0 {
            Set::Portable(lanes) => kernel.run(lanes),
            #[cfg(target_arch = "x86_64")]
            Set::Avx2(lanes) => lanes.run(kernel),
            #[cfg(target_arch = "x86_64")]
            Set::Avx512(lanes) => lanes.run(kernel),
        }
    }
}

impl fmt::Display for Isa {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self.0 {
            Set::Portable(_) => "portable",
            #[cfg(target_arch = "x86_64")]
            Set::Avx2(_) => "AVX2",
            #[cfg(target_arch = "x86_64")]
            Set::Avx512(_) => "AVX-512",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Everything that lanes can do with `a`, `b` and a mask, as bits.
    struct Everything<'a> {
        a: &'a [f32],
        b: &'a [f32],
        mask: Mask,
    }

    impl Kernel for Everything<'_> {
        type Output = (Vec<[u32; LANES]>, Vec<Mask>, [u64; LANES]);

        #[inline(always)]
        fn run<L: Lanes>(self, lanes: L) -> Self::Output {
            let (a, b) = (lanes.load(self.a), lanes.load(self.b));
            let stored = |x| {
                let mut out = [f32::NAN; LANES];
                lanes.store(x, &mut out);
                out.map(f32::to_bits)
            };
            let compressed = stored(lanes.compress(self.mask, a));
            let kept =
                std::array::from_fn(|k| if k < self.mask.count_ones() as usize { compressed[k] } else { 0 });
            let numbers = [
                lanes.add(a, b),
                lanes.sub(a, b),
                lanes.mul(a, b),
                lanes.div(a, b),
                lanes.select(self.mask, a, b),
                lanes.splat(self.b.first().copied().unwrap_or(1.0)),
                lanes.sqrt(a),
                lanes.copysign(a, b),
            ];
            let mut numbers: Vec<_> = numbers.map(stored).map(without_nan_payload).to_vec();
            numbers.push(kept);
            let sum = lanes.add_where(self.mask, lanes.zero_f64(), a);
            let sum = lanes.add_where(!self.mask.rotate_left(3), sum, b);
            let same = self.a.last().copied().unwrap_or(1.0);
            let sum = lanes.add_same_where(self.mask.rotate_left(5), sum, same);
            let sum = lanes.load_f64(&lanes.to_array_f64(sum));
            let sums = lanes.to_array_f64(sum).map(|x| if x.is_nan() { 0 } else { x.to_bits() });
            (numbers, vec![lanes.le(a, b), lanes.lt(a, b)], sums)
        }
    }

    /// Everything that lanes can do with integers, lane by lane.
    struct Integers([u32; LANES], [u32; LANES], Mask);

    impl Kernel for Integers {
        type Output = ([[u32; 5]; LANES], Vec<u32>);

        #[inline(always)]
        fn run<L: Lanes>(self, lanes: L) -> Self::Output {
            let (a, b) = (lanes.load_u32(&self.0), lanes.load_u32(&self.1));
            let [low, high] = lanes.widening_mul(a, self.1[0]);
            let mut columns = [[0; LANES]; 5];
            for (to, x) in columns.iter_mut().zip([lanes.xor(a, b), lanes.add_u32(a, b), low, high]) {
                lanes.store_u32(x, to);
            }
            let mut unit = [0.0; LANES];
            lanes.store(lanes.unit_f32(a), &mut unit);
            columns[4] = unit.map(f32::to_bits);
            let mut front = [0; LANES];
            lanes.store_u32(lanes.compress_u32(self.2, a), &mut front);
            let front = front[..self.2.count_ones() as usize].to_vec();
            (std::array::from_fn(|lane| columns.map(|column| column[lane])), front)
        }
    }

    /// Which NaN comes out of NaNs is nobody's promise.
    fn without_nan_payload(bits: [u32; LANES]) -> [u32; LANES] {
        bits.map(|x| if f32::from_bits(x).is_nan() { f32::NAN.to_bits() } else { x })
    }

    fn numbers() -> impl Strategy<Value = Vec<f32>> {
        prop::collection::vec(
            prop_oneof![any::<f32>(), -2f32..2.0, Just(0.0), Just(1.0), Just(f32::NAN)],
            0..20,
        )
    }

    proptest! {
        #[test]
        fn all_sets_give_the_same_bits(a in numbers(), b in numbers(), mask: Mask) {
            let expected = Isa::portable().run(Everything { a: &a, b: &b, mask });
            for isa in Isa::available() {
                prop_assert_eq!(&isa.run(Everything { a: &a, b: &b, mask }), &expected, "{}", isa);
            }
        }

        #[test]
        fn all_sets_calculate_alike_with_integers(a: [u32; LANES], b: [u32; LANES], mask: Mask) {
            let expected = std::array::from_fn(|k| {
                let whole = u64::from(a[k]) * u64::from(b[0]);
                let unit = ((a[k] >> 8) as f32 / 16_777_216.0).to_bits();
                [a[k] ^ b[k], a[k].wrapping_add(b[k]), whole as u32, (whole >> 32) as u32, unit]
            });
            let front: Vec<u32> = (0..LANES).filter(|k| mask >> k & 1 == 1).map(|k| a[k]).collect();
            for isa in Isa::available() {
                prop_assert_eq!(isa.run(Integers(a, b, mask)), (expected, front.clone()), "{}", isa);
            }
        }

        /// The portable set against plain arithmetic.
        #[test]
        fn lanes_do_what_their_names_say(a in -9f32..9.0, b in -9f32..9.0, lane in 0usize..LANES) {
            let at = |x: f32| { let mut all = vec![3.0; LANES]; all[lane] = x; all };
            let mask = 1 << lane;
            let (numbers, masks, sums) = Isa::portable().run(Everything { a: &at(a), b: &at(b), mask });
            let lanes: Vec<f32> = numbers.iter().map(|n| f32::from_bits(n[lane])).collect();
            prop_assert_eq!(&lanes[..5], &[a + b, a - b, a * b, a / b, a]);
            prop_assert_eq!(f32::from_bits(numbers[8][0]), a);
            prop_assert_eq!(lanes[7], a.copysign(b));
            let root = a.sqrt();
            prop_assert!(lanes[6] == root || root.is_nan());
            prop_assert_eq!((masks[0] & mask != 0, masks[1] & mask != 0), (a <= b, a < b));
            let second = (!mask.rotate_left(3) >> lane) & 1 == 1;
            prop_assert_eq!(f64::from_bits(sums[lane]), f64::from(a) + if second { f64::from(b) } else { 0.0 });
        }
    }

    #[test]
    fn first_lanes_are_counted_from_below() {
        assert_eq!([0, 1, 5, 16, 99].map(first_lanes), [0, 1, 0b1_1111, 0xFFFF, 0xFFFF]);
    }

    #[test]
    fn the_best_set_is_the_last_one_found() {
        let names: Vec<String> = Isa::available().map(|isa| isa.to_string()).collect();
        assert_eq!(names[0], "portable");
        assert_eq!(Isa::best().to_string(), names[names.len() - 1]);
    }
}
