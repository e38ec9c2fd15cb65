//! What can be done with sixteen lanes, whatever the instructions are.

/// How many lanes there are, whatever the machine.
pub const LANES: usize = 16;

/// One bit a lane, the first lane in the lowest.
pub type Mask = u16;

/// The first `n` lanes; all from [`LANES`] on.
pub fn first_lanes(n: usize) -> Mask {
    if n >= LANES { Mask::MAX } else { (1 << n) - 1 }
}

/// Operations on all lanes at once. A value of such a type proves that the machine has the instructions.
pub trait Lanes: Copy {
    /// Sixteen `f32`.
    type F32: Copy;
    /// Sixteen `f64`.
    type F64: Copy;
    /// Sixteen `u32`.
    type U32: Copy;

    /// The first sixteen numbers of `from`; 0 where there are fewer.
    fn load(self, from: &[f32]) -> Self::F32;
    /// Writes all lanes to the first sixteen places of `to`, which has as many.
    fn store(self, lanes: Self::F32, to: &mut [f32]);
    /// The same number in all lanes.
    fn splat(self, x: f32) -> Self::F32;
    /// `a + b`.
    fn add(self, a: Self::F32, b: Self::F32) -> Self::F32;
    /// `a - b`.
    fn sub(self, a: Self::F32, b: Self::F32) -> Self::F32;
    /// `a · b`.
    fn mul(self, a: Self::F32, b: Self::F32) -> Self::F32;
    /// `a / b`.
    fn div(self, a: Self::F32, b: Self::F32) -> Self::F32;
    /// `√x`.
    fn sqrt(self, x: Self::F32) -> Self::F32;
    /// The larger of both; `b` if one is NaN.
    #[inline(always)]
    fn max(self, a: Self::F32, b: Self::F32) -> Self::F32 {
        self.select(self.lt(b, a), a, b)
    }
    /// `size`, with the sign bit of `sign`.
    fn copysign(self, size: Self::F32, sign: Self::F32) -> Self::F32;
    /// Where `a <= b`; never for a NaN.
    fn le(self, a: Self::F32, b: Self::F32) -> Mask;
    /// Where `a < b`; never for a NaN.
    fn lt(self, a: Self::F32, b: Self::F32) -> Mask;
    /// `yes` in the lanes of `mask`, `no` in the others.
    fn select(self, mask: Mask, yes: Self::F32, no: Self::F32) -> Self::F32;
    /// The lanes of `mask`, moved together to the front; what follows them is unspecified.
    fn compress(self, mask: Mask, lanes: Self::F32) -> Self::F32;
    /// [`Lanes::compress`] of integers.
    fn compress_u32(self, mask: Mask, lanes: Self::U32) -> Self::U32;
    /// 0 in all lanes.
    fn zero_f64(self) -> Self::F64;
    /// `sum + x` in the lanes of `mask`, `sum` in the others.
    fn add_where(self, mask: Mask, sum: Self::F64, x: Self::F32) -> Self::F64;
    /// [`Lanes::add_where`] of the same number in all lanes.
    fn add_same_where(self, mask: Mask, sum: Self::F64, x: f32) -> Self::F64;
    /// Sixteen `f64`.
    fn load_f64(self, from: &[f64; LANES]) -> Self::F64;
    /// All lanes, as an array.
    fn to_array_f64(self, lanes: Self::F64) -> [f64; LANES];
    /// Sixteen integers.
    fn load_u32(self, from: &[u32; LANES]) -> Self::U32;
    /// Writes all lanes to the first sixteen places of `to`, which has as many.
    fn store_u32(self, lanes: Self::U32, to: &mut [u32]);
    /// The same integer in all lanes.
    fn splat_u32(self, x: u32) -> Self::U32;
    /// `a ^ b`.
    fn xor(self, a: Self::U32, b: Self::U32) -> Self::U32;
    /// `a + b`, modulo 2³².
    fn add_u32(self, a: Self::U32, b: Self::U32) -> Self::U32;
    /// `a · b`, whole: the lower and the upper half.
    fn widening_mul(self, a: Self::U32, b: u32) -> [Self::U32; 2];
    /// `⌊x / 2⁸⌋ / 2²⁴`: random bits as a number in `[0, 1)`.
    fn unit_f32(self, x: Self::U32) -> Self::F32;
}

/// A computation for any instruction set.
///
/// `run` and whatever it calls on lanes are to be `#[inline(always)]`, and no closures: what is compiled on its own is
/// compiled for no instruction set, and every operation in it becomes a call.
pub trait Kernel {
    /// What it computes.
    type Output;
    /// Computes it.
    fn run<L: Lanes>(self, lanes: L) -> Self::Output;
}
