//! From which pixels the error of a picture is found.

/// Pixels that the error of the picture is found from, at least: neighbours tell nearly the same.
const SAMPLED_PIXELS: usize = 1 << 13;

/// The distance between the places of pixels that the error of a picture is found from: the tree's order takes them
/// from everywhere.
pub(super) fn sampling_step(pixels: usize) -> usize {
    (pixels / SAMPLED_PIXELS).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn enough_pixels_are_sampled_and_not_many_more() {
        for pixels in [1usize, 300, 8192, 64 * 480, 512 * 512, 1920 * 1080] {
            let sampled = pixels.div_ceil(sampling_step(pixels));
            assert!(
                (SAMPLED_PIXELS.min(pixels)..2 * SAMPLED_PIXELS).contains(&sampled),
                "{pixels}: {sampled}"
            );
        }
    }
}
