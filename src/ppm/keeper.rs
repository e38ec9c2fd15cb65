use super::{EyePaths, HitPoint};

/// Whose the statistics are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Keeper {
    /// Every hit point has its own, in the order of the tree.
    HitPoints,
    /// All hit points of a pixel share those of the pixel.
    Pixels,
}

impl Keeper {
    pub fn of(eye_paths: EyePaths) -> Keeper {
        match eye_paths {
            EyePaths::Fixed => Keeper::HitPoints,
            EyePaths::Retraced => Keeper::Pixels,
        }
    }

    /// How many of them there are.
    pub fn count(self, hit_points: &[HitPoint], pixels: usize) -> usize {
        match self {
            Keeper::HitPoints => hit_points.len(),
            Keeper::Pixels => pixels,
        }
    }

    /// Where the statistics stand of the hit point at `position`.
    pub fn index(self, hit_points: &[HitPoint], position: usize) -> usize {
        match self {
            Keeper::HitPoints => position,
            Keeper::Pixels => hit_points[position].pixel as usize,
        }
    }
}
