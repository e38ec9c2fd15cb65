use super::Lanes;
use crate::math::rng::{PHILOX_MULTIPLIERS, PHILOX_ROUNDS, PHILOX_WEYL};

/// [`crate::math::rng::philox4x32`] of sixteen counters under one key.
#[inline(always)]
pub fn philox4x32<L: Lanes>(lanes: L, counter: [L::U32; 4], key: [u32; 2]) -> [L::U32; 4] {
    let (mut c, mut k) = (counter, key);
    for _ in 0..PHILOX_ROUNDS {
        let [a_low, a_high] = lanes.widening_mul(c[0], PHILOX_MULTIPLIERS[0]);
        let [b_low, b_high] = lanes.widening_mul(c[2], PHILOX_MULTIPLIERS[1]);
        let first = lanes.xor(lanes.xor(b_high, c[1]), lanes.splat_u32(k[0]));
        let third = lanes.xor(lanes.xor(a_high, c[3]), lanes.splat_u32(k[1]));
        c = [first, b_low, third, a_low];
        k = [k[0].wrapping_add(PHILOX_WEYL[0]), k[1].wrapping_add(PHILOX_WEYL[1])];
    }
    c
}

#[cfg(test)]
mod tests {
    use super::super::{Isa, Kernel, LANES};
    use super::*;
    use crate::math::rng;
    use proptest::prelude::*;

    /// The lanes are those of one array, rotated differently in each part of the counter.
    struct Philox([[u32; LANES]; 4], [u32; 2]);

    impl Kernel for Philox {
        type Output = [[u32; LANES]; 4];

        #[inline(always)]
        fn run<L: Lanes>(self, lanes: L) -> Self::Output {
            let [a, b, c, d] = &self.0;
            let counter = [lanes.load_u32(a), lanes.load_u32(b), lanes.load_u32(c), lanes.load_u32(d)];
            let numbers = philox4x32(lanes, counter, self.1);
            let mut out = [[0; LANES]; 4];
            for (to, lane) in out.iter_mut().zip(numbers) {
                lanes.store_u32(lane, to);
            }
            out
        }
    }

    proptest! {
        #[test]
        fn sixteen_counters_give_what_each_gives_alone(counter: [[u32; LANES]; 4], key: [u32; 2]) {
            for isa in Isa::available() {
                let numbers = isa.run(Philox(counter, key));
                for lane in 0..LANES {
                    let alone = rng::philox4x32(counter.map(|part| part[lane]), key);
                    prop_assert_eq!(numbers.map(|part| part[lane]), alone, "{}", isa);
                }
            }
        }
    }
}
