use std::arch::x86_64::*;

use super::{Kernel, LANES, Lanes, Mask, first_lanes};

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
}
