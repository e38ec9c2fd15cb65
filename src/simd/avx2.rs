use std::arch::x86_64::*;

use super::{Kernel, LANES, Lanes, Mask};
use crate::math::UNIT;

/// Two registers hold all lanes; its existence proves that the machine has AVX2 and POPCNT.
#[derive(Clone, Copy, Debug)]
pub(super) struct Avx2(());

/// The lanes of each mask of eight, in order: what moves them to the front.
static FRONT: [[i32; 8]; 256] = front();

const fn front() -> [[i32; 8]; 256] {
    let mut table = [[0; 8]; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut lane, mut n) = (0, 0);
        while lane < 8 {
            if mask >> lane & 1 == 1 {
                table[mask][n] = lane;
                n += 1;
            }
            lane += 1;
        }
        mask += 1;
    }
    table
}

/// An instruction whose operands are all values.
macro_rules! instruction {
    ($call:expr) => {
        // SAFETY: a value of `Avx2` proves that the machine has AVX2, and no memory is touched.
        unsafe { $call }
    };
}
impl Avx2 {
    pub(super) fn detect() -> Option<Avx2> {
        (is_x86_feature_detected!("avx2") && is_x86_feature_detected!("popcnt")).then_some(Avx2(()))
    }

    pub(super) fn run<K: Kernel>(self, kernel: K) -> K::Output {
        #[target_feature(enable = "avx2,popcnt")]
        fn with_avx2<K: Kernel>(lanes: Avx2, kernel: K) -> K::Output {
            kernel.run(lanes)
        }
        // SAFETY: `self` proves that the machine has both.
        unsafe { with_avx2(self, kernel) }
    }

    /// All bits of the lanes in `mask`.
    #[inline(always)]
    fn expand(self, mask: u8) -> __m256 {
        instruction!({
            let bits = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
            let chosen = _mm256_and_si256(_mm256_set1_epi32(i32::from(mask)), bits);
            _mm256_castsi256_ps(_mm256_cmpeq_epi32(chosen, bits))
        })
    }

    #[inline(always)]
    fn bits(self, [low, high]: [__m256; 2]) -> Mask {
        instruction!(_mm256_movemask_ps(low) as Mask | (_mm256_movemask_ps(high) as Mask) << 8)
    }

    /// Lower and upper halves of the products.
    #[inline(always)]
    fn widening_mul_half(self, a: __m256i, b: u32) -> [__m256i; 2] {
        const ODD: i32 = 0b1010_1010;
        instruction!({
            let b = _mm256_set1_epi32(b.cast_signed());
            let (even, odd) = (_mm256_mul_epu32(a, b), _mm256_mul_epu32(_mm256_srli_epi64::<32>(a), b));
            let low = _mm256_blend_epi32::<ODD>(even, _mm256_slli_epi64::<32>(odd));
            [low, _mm256_blend_epi32::<ODD>(_mm256_srli_epi64::<32>(even), odd)]
        })
    }

    #[inline(always)]
    fn front(self, mask: u8, lanes: __m256) -> __m256 {
        // SAFETY: the machine has AVX2, and a row of the table is as long as the register.
        unsafe {
            let order = _mm256_loadu_si256(FRONT[usize::from(mask)].as_ptr().cast());
            _mm256_permutevar8x32_ps(lanes, order)
        }
    }
}

/// The same instruction on both halves.
macro_rules! on_halves {
    ($call:ident, $a:expr, $b:expr) => {
        instruction!([$call($a[0], $b[0]), $call($a[1], $b[1])])
    };
}

impl Lanes for Avx2 {
    type F32 = [__m256; 2];
    type F64 = [__m256d; 4];
    type U32 = [__m256i; 2];

    #[inline(always)]
    fn load(self, from: &[f32]) -> [__m256; 2] {
        let mut padded = [0.0; LANES];
        let all = from.first_chunk().unwrap_or_else(|| {
            padded[..from.len()].copy_from_slice(from);
            &padded
        });
        // SAFETY: the machine has AVX2, and the array has sixteen numbers.
        unsafe { [_mm256_loadu_ps(all.as_ptr()), _mm256_loadu_ps(all[8..].as_ptr())] }
    }

    #[inline(always)]
    fn store(self, [low, high]: [__m256; 2], to: &mut [f32]) {
        let (first, second) = to[..LANES].split_at_mut(8);
        // SAFETY: the machine has AVX2, and each half has room for its eight lanes.
        unsafe {
            _mm256_storeu_ps(first.as_mut_ptr(), low);
            _mm256_storeu_ps(second.as_mut_ptr(), high);
        }
    }

    #[inline(always)]
    fn splat(self, x: f32) -> [__m256; 2] {
        instruction!([_mm256_set1_ps(x); 2])
    }

    #[inline(always)]
    fn add(self, a: [__m256; 2], b: [__m256; 2]) -> [__m256; 2] {
        on_halves!(_mm256_add_ps, a, b)
    }

    #[inline(always)]
    fn sub(self, a: [__m256; 2], b: [__m256; 2]) -> [__m256; 2] {
        on_halves!(_mm256_sub_ps, a, b)
    }

    #[inline(always)]
    fn mul(self, a: [__m256; 2], b: [__m256; 2]) -> [__m256; 2] {
        on_halves!(_mm256_mul_ps, a, b)
    }

    #[inline(always)]
    fn div(self, a: [__m256; 2], b: [__m256; 2]) -> [__m256; 2] {
        on_halves!(_mm256_div_ps, a, b)
    }

    #[inline(always)]
    fn sqrt(self, [low, high]: [__m256; 2]) -> [__m256; 2] {
        instruction!([_mm256_sqrt_ps(low), _mm256_sqrt_ps(high)])
    }

    #[inline(always)]
    fn copysign(self, size: [__m256; 2], sign: [__m256; 2]) -> [__m256; 2] {
        let sign_bit = self.splat(-0.0);
        let (size, sign) =
            (on_halves!(_mm256_andnot_ps, sign_bit, size), on_halves!(_mm256_and_ps, sign_bit, sign));
        on_halves!(_mm256_or_ps, size, sign)
    }

    #[inline(always)]
    fn le(self, a: [__m256; 2], b: [__m256; 2]) -> Mask {
        self.bits(instruction!([
            _mm256_cmp_ps::<_CMP_LE_OQ>(a[0], b[0]),
            _mm256_cmp_ps::<_CMP_LE_OQ>(a[1], b[1])
        ]))
    }

    #[inline(always)]
    fn lt(self, a: [__m256; 2], b: [__m256; 2]) -> Mask {
        self.bits(instruction!([
            _mm256_cmp_ps::<_CMP_LT_OQ>(a[0], b[0]),
            _mm256_cmp_ps::<_CMP_LT_OQ>(a[1], b[1])
        ]))
    }

    #[inline(always)]
    fn select(self, mask: Mask, yes: [__m256; 2], no: [__m256; 2]) -> [__m256; 2] {
        let (low, high) = (self.expand(mask as u8), self.expand((mask >> 8) as u8));
        instruction!([_mm256_blendv_ps(no[0], yes[0], low), _mm256_blendv_ps(no[1], yes[1], high)])
    }

    #[inline(always)]
    fn compress(self, mask: Mask, [low, high]: [__m256; 2]) -> [__m256; 2] {
        let (mask_low, mask_high) = (mask as u8, (mask >> 8) as u8);
        let mut out = [0.0; LANES + 8];
        let n_low = mask_low.count_ones() as usize;
        // SAFETY: the machine has AVX2; eight lanes from 0 and from at most 8 on lie within the array.
        unsafe {
            _mm256_storeu_ps(out.as_mut_ptr(), self.front(mask_low, low));
            _mm256_storeu_ps(out[n_low..].as_mut_ptr(), self.front(mask_high, high));
        }
        self.load(&out)
    }

    #[inline(always)]
    fn compress_u32(self, mask: Mask, [low, high]: [__m256i; 2]) -> [__m256i; 2] {
        let numbers = instruction!([_mm256_castsi256_ps(low), _mm256_castsi256_ps(high)]);
        let [low, high] = self.compress(mask, numbers);
        instruction!([_mm256_castps_si256(low), _mm256_castps_si256(high)])
    }

    #[inline(always)]
    fn zero_f64(self) -> [__m256d; 4] {
        instruction!([_mm256_setzero_pd(); 4])
    }

    #[inline(always)]
    fn add_where(self, mask: Mask, sum: [__m256d; 4], x: [__m256; 2]) -> [__m256d; 4] {
        let (low, high) = (self.expand(mask as u8), self.expand((mask >> 8) as u8));
        instruction!({
            let (low, high) = (_mm256_and_ps(x[0], low), _mm256_and_ps(x[1], high));
            [
                _mm256_add_pd(sum[0], _mm256_cvtps_pd(_mm256_castps256_ps128(low))),
                _mm256_add_pd(sum[1], _mm256_cvtps_pd(_mm256_extractf128_ps::<1>(low))),
                _mm256_add_pd(sum[2], _mm256_cvtps_pd(_mm256_castps256_ps128(high))),
                _mm256_add_pd(sum[3], _mm256_cvtps_pd(_mm256_extractf128_ps::<1>(high))),
            ]
        })
    }

    #[inline(always)]
    fn add_same_where(self, mask: Mask, sum: [__m256d; 4], x: f32) -> [__m256d; 4] {
        let (low, high) = (self.expand(mask as u8), self.expand((mask >> 8) as u8));
        instruction!({
            let x = _mm256_cvtps_pd(_mm_set1_ps(x));
            let (low, high) = (_mm256_castps_si256(low), _mm256_castps_si256(high));
            let wide = [
                _mm256_cvtepi32_epi64(_mm256_castsi256_si128(low)),
                _mm256_cvtepi32_epi64(_mm256_extracti128_si256::<1>(low)),
                _mm256_cvtepi32_epi64(_mm256_castsi256_si128(high)),
                _mm256_cvtepi32_epi64(_mm256_extracti128_si256::<1>(high)),
            ];
            [
                _mm256_add_pd(sum[0], _mm256_and_pd(x, _mm256_castsi256_pd(wide[0]))),
                _mm256_add_pd(sum[1], _mm256_and_pd(x, _mm256_castsi256_pd(wide[1]))),
                _mm256_add_pd(sum[2], _mm256_and_pd(x, _mm256_castsi256_pd(wide[2]))),
                _mm256_add_pd(sum[3], _mm256_and_pd(x, _mm256_castsi256_pd(wide[3]))),
            ]
        })
    }

    #[inline(always)]
    fn load_f64(self, from: &[f64; LANES]) -> [__m256d; 4] {
        // SAFETY: the machine has AVX2, and four numbers follow each of these places.
        unsafe {
            [
                _mm256_loadu_pd(from.as_ptr()),
                _mm256_loadu_pd(from[4..].as_ptr()),
                _mm256_loadu_pd(from[8..].as_ptr()),
                _mm256_loadu_pd(from[12..].as_ptr()),
            ]
        }
    }

    #[inline(always)]
    fn to_array_f64(self, lanes: [__m256d; 4]) -> [f64; LANES] {
        let mut out = [0.0; LANES];
        for (to, lanes) in out.chunks_exact_mut(4).zip(lanes) {
            // SAFETY: the machine has AVX2, and the chunk has room for four lanes.
            unsafe { _mm256_storeu_pd(to.as_mut_ptr(), lanes) };
        }
        out
    }

    #[inline(always)]
    fn load_u32(self, from: &[u32; LANES]) -> [__m256i; 2] {
        // SAFETY: the machine has AVX2, and the array has sixteen numbers.
        unsafe { [_mm256_loadu_si256(from.as_ptr().cast()), _mm256_loadu_si256(from[8..].as_ptr().cast())] }
    }

    #[inline(always)]
    fn store_u32(self, [low, high]: [__m256i; 2], to: &mut [u32]) {
        let (first, second) = to[..LANES].split_at_mut(8);
        // SAFETY: the machine has AVX2, and each half has room for its eight lanes.
        unsafe {
            _mm256_storeu_si256(first.as_mut_ptr().cast(), low);
            _mm256_storeu_si256(second.as_mut_ptr().cast(), high);
        }
    }

    #[inline(always)]
    fn splat_u32(self, x: u32) -> [__m256i; 2] {
        instruction!([_mm256_set1_epi32(x.cast_signed()); 2])
    }

    #[inline(always)]
    fn xor(self, a: [__m256i; 2], b: [__m256i; 2]) -> [__m256i; 2] {
        on_halves!(_mm256_xor_si256, a, b)
    }

    #[inline(always)]
    fn add_u32(self, a: [__m256i; 2], b: [__m256i; 2]) -> [__m256i; 2] {
        on_halves!(_mm256_add_epi32, a, b)
    }

    #[inline(always)]
    fn widening_mul(self, [low, high]: [__m256i; 2], b: u32) -> [[__m256i; 2]; 2] {
        let (low, high) = (self.widening_mul_half(low, b), self.widening_mul_half(high, b));
        [[low[0], high[0]], [low[1], high[1]]]
    }

    #[inline(always)]
    fn unit_f32(self, [low, high]: [__m256i; 2]) -> [__m256; 2] {
        let whole = instruction!([
            _mm256_cvtepi32_ps(_mm256_srli_epi32::<8>(low)),
            _mm256_cvtepi32_ps(_mm256_srli_epi32::<8>(high))
        ]);
        self.mul(whole, self.splat(UNIT))
    }
}
