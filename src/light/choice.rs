//! How a number chooses among several things.

use crate::math::UNIT;

/// A number in `[0, 1)` that chooses a light: multiples of 2⁻²⁴ would choose a light of 10⁻¹² of the flux 60,000 times too
/// often, or never.
pub(super) fn choice(coarse: f32, fine: f32) -> f64 {
    f64::from(coarse) + f64::from(UNIT) * f64::from(fine)
}

/// The place that `u` in `[0, 1)` chooses, by running sums up to 1, which rounding may leave a little less.
pub(super) fn place(cumulative: &[f64], u: f64) -> usize {
    cumulative.partition_point(|&c| c <= u).min(cumulative.len() - 1)
}
