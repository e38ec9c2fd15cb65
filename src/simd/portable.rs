use std::array::from_fn;

use super::{LANES, Lanes, Mask};
use crate::math::unit_f32;

/// Plain arrays: for any machine, and the twin that the vector instructions are held against.
#[derive(Clone, Copy, Debug)]
pub(super) struct Portable;

fn mask(holds: impl Fn(usize) -> bool) -> Mask {
    (0..LANES).fold(0, |mask, k| mask | Mask::from(holds(k)) << k)
}

fn has(mask: Mask, lane: usize) -> bool {
    mask >> lane & 1 == 1
}

fn compress<T: Copy>(mask: Mask, lanes: [T; LANES]) -> [T; LANES] {
    let mut out = lanes;
    let mut n = 0;
    for (k, &lane) in lanes.iter().enumerate() {
        out[n] = lane;
        n += usize::from(has(mask, k));
    }
    out
}

impl Lanes for Portable {
    type F32 = [f32; LANES];
    type F64 = [f64; LANES];
    type U32 = [u32; LANES];

    #[inline(always)]
    fn load(self, from: &[f32]) -> [f32; LANES] {
        match from.first_chunk() {
            Some(all) => *all,
            None => from_fn(|k| from.get(k).copied().unwrap_or(0.0)),
        }
    }

    #[inline(always)]
    fn store(self, lanes: [f32; LANES], to: &mut [f32]) {
        to[..LANES].copy_from_slice(&lanes);
    }

    #[inline(always)]
    fn splat(self, x: f32) -> [f32; LANES] {
        [x; LANES]
    }

    #[inline(always)]
    fn add(self, a: [f32; LANES], b: [f32; LANES]) -> [f32; LANES] {
        from_fn(|k| a[k] + b[k])
    }

    #[inline(always)]
    fn sub(self, a: [f32; LANES], b: [f32; LANES]) -> [f32; LANES] {
        from_fn(|k| a[k] - b[k])
    }

    #[inline(always)]
    fn mul(self, a: [f32; LANES], b: [f32; LANES]) -> [f32; LANES] {
        from_fn(|k| a[k] * b[k])
    }

    #[inline(always)]
    fn div(self, a: [f32; LANES], b: [f32; LANES]) -> [f32; LANES] {
        from_fn(|k| a[k] / b[k])
    }

    #[inline(always)]
    fn sqrt(self, x: [f32; LANES]) -> [f32; LANES] {
        x.map(f32::sqrt)
    }

    #[inline(always)]
    fn copysign(self, size: [f32; LANES], sign: [f32; LANES]) -> [f32; LANES] {
        from_fn(|k| size[k].copysign(sign[k]))
    }

    #[inline(always)]
    fn le(self, a: [f32; LANES], b: [f32; LANES]) -> Mask {
        mask(|k| a[k] <= b[k])
    }

    #[inline(always)]
    fn lt(self, a: [f32; LANES], b: [f32; LANES]) -> Mask {
        mask(|k| a[k] < b[k])
    }

    #[inline(always)]
    fn select(self, mask: Mask, yes: [f32; LANES], no: [f32; LANES]) -> [f32; LANES] {
        from_fn(|k| if has(mask, k) { yes[k] } else { no[k] })
    }

    #[inline(always)]
    fn compress(self, mask: Mask, lanes: [f32; LANES]) -> [f32; LANES] {
        compress(mask, lanes)
    }

    #[inline(always)]
    fn compress_u32(self, mask: Mask, lanes: [u32; LANES]) -> [u32; LANES] {
        compress(mask, lanes)
    }

    #[inline(always)]
    fn zero_f64(self) -> [f64; LANES] {
        [0.0; LANES]
    }

    #[inline(always)]
    fn add_where(self, mask: Mask, sum: [f64; LANES], x: [f32; LANES]) -> [f64; LANES] {
        from_fn(|k| if has(mask, k) { sum[k] + f64::from(x[k]) } else { sum[k] })
    }

    #[inline(always)]
    fn add_same_where(self, mask: Mask, sum: [f64; LANES], x: f32) -> [f64; LANES] {
        from_fn(|k| if has(mask, k) { sum[k] + f64::from(x) } else { sum[k] })
    }

    #[inline(always)]
    fn load_f64(self, from: &[f64; LANES]) -> [f64; LANES] {
        *from
    }

    #[inline(always)]
    fn to_array_f64(self, lanes: [f64; LANES]) -> [f64; LANES] {
        lanes
    }

    #[inline(always)]
    fn load_u32(self, from: &[u32; LANES]) -> [u32; LANES] {
        *from
    }

    #[inline(always)]
    fn store_u32(self, lanes: [u32; LANES], to: &mut [u32]) {
        to[..LANES].copy_from_slice(&lanes);
    }

    #[inline(always)]
    fn splat_u32(self, x: u32) -> [u32; LANES] {
        [x; LANES]
    }

    #[inline(always)]
    fn xor(self, a: [u32; LANES], b: [u32; LANES]) -> [u32; LANES] {
        from_fn(|k| a[k] ^ b[k])
    }

    #[inline(always)]
    fn add_u32(self, a: [u32; LANES], b: [u32; LANES]) -> [u32; LANES] {
        from_fn(|k| a[k].wrapping_add(b[k]))
    }

    #[inline(always)]
    fn widening_mul(self, a: [u32; LANES], b: u32) -> [[u32; LANES]; 2] {
        let whole: [u64; LANES] = from_fn(|k| u64::from(a[k]) * u64::from(b));
        [whole.map(|x| x as u32), whole.map(|x| (x >> 32) as u32)]
    }

    #[inline(always)]
    fn unit_f32(self, x: [u32; LANES]) -> [f32; LANES] {
        x.map(unit_f32)
    }
}
