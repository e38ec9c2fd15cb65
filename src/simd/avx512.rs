use std::arch::x86_64::*;

use super::{Kernel, LANES, Lanes, Mask, first_lanes};
use crate::math::UNIT;

/// One register holds all lanes; its existence proves that the machine has AVX-512F and POPCNT.
#[derive(Clone, Copy, Debug)]
pub(super) struct Avx512(());

impl Avx512 {
    pub(super) fn detect() -> Option<Avx512> {
        (is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("popcnt")).then_some(Avx512(()))
    }

    pub(super) fn run<K: Kernel>(self, kernel: K) -> K::Output {
        #[target_feature(enable = "avx512f,popcnt")]
        fn with_avx512<K: Kernel>(lanes: Avx512, kernel: K) -> K::Output {
            kernel.run(lanes)
        }
        // SAFETY: `self` proves that the machine has both.
        unsafe { with_avx512(self, kernel) }
    }
}

/// An instruction whose operands are all values.
macro_rules! instruction {
    ($call:expr) => {
        // SAFETY: a value of `Avx512` proves that the machine has AVX-512F, and no memory is touched.
        unsafe { $call }
    };
}

impl Lanes for Avx512 {
    type F32 = __m512;
    type F64 = [__m512d; 2];
    type U32 = __m512i;

    #[inline(always)]
    fn load(self, from: &[f32]) -> __m512 {
        // SAFETY: the machine has AVX-512F; of the lanes beyond the end of the slice no memory is read.
        unsafe { _mm512_maskz_loadu_ps(first_lanes(from.len()), from.as_ptr()) }
    }

    #[inline(always)]
    fn store(self, lanes: __m512, to: &mut [f32]) {
        let to = &mut to[..LANES];
        // SAFETY: the machine has AVX-512F, and the slice has room for all lanes.
        unsafe { _mm512_storeu_ps(to.as_mut_ptr(), lanes) }
    }

    #[inline(always)]
    fn splat(self, x: f32) -> __m512 {
        instruction!(_mm512_set1_ps(x))
    }

    #[inline(always)]
    fn add(self, a: __m512, b: __m512) -> __m512 {
        instruction!(_mm512_add_ps(a, b))
    }

    #[inline(always)]
    fn sub(self, a: __m512, b: __m512) -> __m512 {
        instruction!(_mm512_sub_ps(a, b))
    }

    #[inline(always)]
    fn mul(self, a: __m512, b: __m512) -> __m512 {
        instruction!(_mm512_mul_ps(a, b))
    }

    #[inline(always)]
    fn div(self, a: __m512, b: __m512) -> __m512 {
        instruction!(_mm512_div_ps(a, b))
    }

    #[inline(always)]
    fn sqrt(self, x: __m512) -> __m512 {
        instruction!(_mm512_sqrt_ps(x))
    }

    #[inline(always)]
    fn copysign(self, size: __m512, sign: __m512) -> __m512 {
        // The table of three operands: where the first is set take the second, elsewhere the third.
        const CHOOSE: i32 = 0b1100_1010;
        instruction!({
            let sign_bit = _mm512_set1_epi32(i32::MIN);
            let (size, sign) = (_mm512_castps_si512(size), _mm512_castps_si512(sign));
            _mm512_castsi512_ps(_mm512_ternarylogic_epi32::<CHOOSE>(sign_bit, sign, size))
        })
    }

    #[inline(always)]
    fn le(self, a: __m512, b: __m512) -> Mask {
        instruction!(_mm512_cmp_ps_mask::<_CMP_LE_OQ>(a, b))
    }

    #[inline(always)]
    fn lt(self, a: __m512, b: __m512) -> Mask {
        instruction!(_mm512_cmp_ps_mask::<_CMP_LT_OQ>(a, b))
    }

    #[inline(always)]
    fn select(self, mask: Mask, yes: __m512, no: __m512) -> __m512 {
        instruction!(_mm512_mask_blend_ps(mask, no, yes))
    }

    #[inline(always)]
    fn compress(self, mask: Mask, lanes: __m512) -> __m512 {
        instruction!(_mm512_maskz_compress_ps(mask, lanes))
    }

    #[inline(always)]
    fn compress_u32(self, mask: Mask, lanes: __m512i) -> __m512i {
        instruction!(_mm512_maskz_compress_epi32(mask, lanes))
    }

    #[inline(always)]
    fn zero_f64(self) -> [__m512d; 2] {
        instruction!([_mm512_setzero_pd(); 2])
    }

    #[inline(always)]
    fn add_where(self, mask: Mask, [low, high]: [__m512d; 2], x: __m512) -> [__m512d; 2] {
        let [x_low, x_high] = instruction!({
            let upper = _mm256_castpd_ps(_mm512_extractf64x4_pd::<1>(_mm512_castps_pd(x)));
            [_mm512_cvtps_pd(_mm512_castps512_ps256(x)), _mm512_cvtps_pd(upper)]
        });
        let (mask_low, mask_high) = (mask as u8, (mask >> 8) as u8);
        instruction!([
            _mm512_mask_add_pd(low, mask_low, low, x_low),
            _mm512_mask_add_pd(high, mask_high, high, x_high)
        ])
    }

    #[inline(always)]
    fn add_same_where(self, mask: Mask, [low, high]: [__m512d; 2], x: f32) -> [__m512d; 2] {
        let (mask_low, mask_high) = (mask as u8, (mask >> 8) as u8);
        instruction!({
            let x = _mm512_cvtps_pd(_mm256_set1_ps(x));
            [_mm512_mask_add_pd(low, mask_low, low, x), _mm512_mask_add_pd(high, mask_high, high, x)]
        })
    }

    #[inline(always)]
    fn load_f64(self, from: &[f64; LANES]) -> [__m512d; 2] {
        // SAFETY: the machine has AVX-512F, and eight numbers follow each of these places.
        unsafe { [_mm512_loadu_pd(from.as_ptr()), _mm512_loadu_pd(from[8..].as_ptr())] }
    }

    #[inline(always)]
    fn to_array_f64(self, [low, high]: [__m512d; 2]) -> [f64; LANES] {
        let mut out = [0.0; LANES];
        let (first, second) = out.split_at_mut(8);
        // SAFETY: the machine has AVX-512F, and each half has room for its eight lanes.
        unsafe {
            _mm512_storeu_pd(first.as_mut_ptr(), low);
            _mm512_storeu_pd(second.as_mut_ptr(), high);
        }
        out
    }

    #[inline(always)]
    fn load_u32(self, from: &[u32; LANES]) -> __m512i {
        // SAFETY: the machine has AVX-512F, and the array has sixteen numbers.
        unsafe { _mm512_loadu_si512(from.as_ptr().cast()) }
    }

    #[inline(always)]
    fn store_u32(self, lanes: __m512i, to: &mut [u32]) {
        let to = &mut to[..LANES];
        // SAFETY: the machine has AVX-512F, and the slice has room for all lanes.
        unsafe { _mm512_storeu_si512(to.as_mut_ptr().cast(), lanes) }
    }

    #[inline(always)]
    fn splat_u32(self, x: u32) -> __m512i {
        instruction!(_mm512_set1_epi32(x.cast_signed()))
    }

    #[inline(always)]
    fn xor(self, a: __m512i, b: __m512i) -> __m512i {
        instruction!(_mm512_xor_si512(a, b))
    }

    #[inline(always)]
    fn add_u32(self, a: __m512i, b: __m512i) -> __m512i {
        instruction!(_mm512_add_epi32(a, b))
    }

    #[inline(always)]
    fn widening_mul(self, a: __m512i, b: u32) -> [__m512i; 2] {
        const ODD: Mask = 0xAAAA;
        instruction!({
            let b = _mm512_set1_epi32(b.cast_signed());
            let (even, odd) = (_mm512_mul_epu32(a, b), _mm512_mul_epu32(_mm512_srli_epi64::<32>(a), b));
            let low = _mm512_mask_blend_epi32(ODD, even, _mm512_slli_epi64::<32>(odd));
            [low, _mm512_mask_blend_epi32(ODD, _mm512_srli_epi64::<32>(even), odd)]
        })
    }

    #[inline(always)]
    fn unit_f32(self, x: __m512i) -> __m512 {
        let whole = instruction!(_mm512_cvtepi32_ps(_mm512_srli_epi32::<8>(x)));
        self.mul(whole, self.splat(UNIT))
    }
}
