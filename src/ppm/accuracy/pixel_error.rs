use crate::math::DVec3;

/// What is known of the error of one pixel, channel by channel.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PixelError {
    /// The standard error of the estimate (radiance).
    pub stderr: DVec3,
    /// Its bias, the blur by the gather radius, as far as it stands out of the noise (radiance).
    pub bias: DVec3,
    /// The error stays below it with the confidence asked for; NaN where that cannot be told.
    pub bound: DVec3,
    /// Photons that the pixel rests on: the reduced counts `N` of its hit points.
    pub photons: f64,
}
