use super::{CompareError, Estimate};
use crate::film::Image;
use crate::math::{DVec3, Rgb};
use serde::Serialize;
use std::fmt;

/// The share of a block's pixels that a mask must leave for the block to count.
const MIN_COVERAGE: f64 = 0.6;
/// The mean of the brightest channel (radiance) below which a block of the reference is too dark to count.
const MIN_RADIANCE: f64 = 1e-3;
/// The share of a block's brightest channel below which another channel is too dark to count.
const MIN_CHANNEL_SHARE: f64 = 0.05;

/// The picture in which each pixel is the mean of a block of `block × block` pixels (at least 1) of `image`.
///
/// Blocks at the right and lower edge take what there is.
pub fn block_means(image: &Image, block: usize) -> Image {
    let block = block.max(1);
    let means = blocks(image, block).map(|pixels| {
        let sum: DVec3 = pixels.indices(image).map(|pixel| image.pixels()[pixel].as_dvec3()).sum();
        (sum / pixels.len() as f64).as_vec3()
    });
    let means: Vec<Rgb> = means.collect();
    let mut picture = Image::new(image.width().div_ceil(block), image.height().div_ceil(block));
    picture.pixels_mut().copy_from_slice(&means);
    picture
}

/// A rectangle of pixels: columns `x..x_end` of rows `y..y_end`.
struct Block {
    x: usize,
    y: usize,
    x_end: usize,
    y_end: usize,
}

impl Block {
    fn len(&self) -> usize {
        (self.x_end - self.x) * (self.y_end - self.y)
    }

    fn indices(&self, image: &Image) -> impl Iterator<Item = usize> {
        let (stride, columns) = (image.width(), self.x..self.x_end);
        (self.y..self.y_end).flat_map(move |y| columns.clone().map(move |x| y * stride + x))
    }
}

fn blocks(image: &Image, block: usize) -> impl Iterator<Item = Block> {
    let (width, height) = (image.width(), image.height());
    (0..height).step_by(block).flat_map(move |y| {
        let y_end = (y + block).min(height);
        (0..width).step_by(block).map(move |x| Block { x, y, x_end: (x + block).min(width), y_end })
    })
}

/// When the means of a block agree: `|a - b| / b ≤ relative + sigmas · se / b` in every channel that counts.
#[derive(Clone, Copy, Debug)]
pub struct BlockCriterion<'a> {
    /// Side of a block in pixels, at least 1.
    pub block: usize,
    /// Relative difference that is allowed in any case.
    pub relative: f64,
    /// Number of combined standard errors of the block's mean that are allowed beyond it.
    pub sigmas: f64,
    /// Which pixels to use, row by row; `None` for all.
    pub mask: Option<&'a [bool]>,
}

impl BlockCriterion<'_> {
    /// Blocks of 32 × 32 pixels, all of them used.
    pub fn new(relative: f64, sigmas: f64) -> BlockCriterion<'static> {
        BlockCriterion { block: 32, relative, sigmas, mask: None }
    }

    fn uses(&self, pixel: usize) -> bool {
        self.mask.is_none_or(|mask| mask[pixel])
    }
}

/// How the block means of a picture differ from those of a reference.
///
/// Left out are blocks of which the mask leaves less than 0.6, blocks whose reference has a mean below 10⁻³ in its
/// brightest channel, and in each block the channels below 0.05 of the brightest. The standard error of a block's
/// mean is that of independent pixels, `√(Σ se²) / n`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BlockReport {
    /// Number of blocks that count.
    pub n_blocks: usize,
    /// Number of those that meet the criterion.
    pub n_within: usize,
    /// The block with the largest relative difference; `None` if no block counts.
    pub worst: Option<WorstBlock>,
}

/// A block and how far it is off.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct WorstBlock {
    /// Column of its upper left pixel.
    pub x: usize,
    /// Row of its upper left pixel.
    pub y: usize,
    /// Largest `|a - b| / b` of the block's means over the channels that count; infinite if one is not finite.
    pub relative_difference: f64,
}

impl BlockReport {
    /// Compares the block means of `a` with those of the reference `b`.
    ///
    /// # Errors
    /// When the pictures differ in size or are empty, or when the mask has not one entry for each pixel.
    pub fn between(
        a: Estimate,
        b: Estimate,
        criterion: &BlockCriterion,
    ) -> Result<BlockReport, CompareError> {
        a.check_sizes(b.mean)?;
        b.check_sizes(b.mean)?;
        check_mask(criterion.mask, b.mean.pixels().len())?;
        let mut report = BlockReport { n_blocks: 0, n_within: 0, worst: None };
        for block in blocks(b.mean, criterion.block.max(1)) {
            if let Some(difference) = BlockDifference::of(&block, a, b, criterion) {
                report.add(&block, &difference);
            }
        }
        Ok(report)
    }

    /// The share of the blocks that count which meet the criterion; 0 if none counts.
    pub fn share_within(&self) -> f64 {
        self.n_within as f64 / self.n_blocks.max(1) as f64
    }

    fn add(&mut self, block: &Block, difference: &BlockDifference) {
        self.n_blocks += 1;
        self.n_within += usize::from(difference.within);
        let worst_yet = self.worst.map_or(-1.0, |worst| worst.relative_difference);
        if difference.relative > worst_yet {
            self.worst =
                Some(WorstBlock { x: block.x, y: block.y, relative_difference: difference.relative });
        }
    }
}

impl fmt::Display for BlockReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "blocks      {} of {} agree", self.n_within, self.n_blocks)?;
        let Some(WorstBlock { x, y, relative_difference }) = self.worst else { return Ok(()) };
        write!(f, "; the worst, at ({x}, {y}), differs by {relative_difference:.6e}")
    }
}

fn check_mask(mask: Option<&[bool]>, pixels: usize) -> Result<(), CompareError> {
    match mask {
        Some(mask) if mask.len() != pixels => Err(CompareError::MaskLength { mask: mask.len(), pixels }),
        _ => Ok(()),
    }
}

struct BlockDifference {
    relative: f64,
    within: bool,
}

impl BlockDifference {
    /// `None` if the block does not count.
    fn of(block: &Block, a: Estimate, b: Estimate, criterion: &BlockCriterion) -> Option<BlockDifference> {
        let pixels: Vec<usize> = block.indices(b.mean).filter(|&pixel| criterion.uses(pixel)).collect();
        if pixels.is_empty() || (pixels.len() as f64) < MIN_COVERAGE * block.len() as f64 {
            return None;
        }
        let n = pixels.len() as f64;
        let mean =
            |image: &Image| pixels.iter().map(|&pixel| image.pixels()[pixel].as_dvec3()).sum::<DVec3>() / n;
        let variance: DVec3 = pixels.iter().map(|&pixel| a.variance(pixel) + b.variance(pixel)).sum();
        BlockDifference::of_means(mean(a.mean), mean(b.mean), variance.map(f64::sqrt) / n, criterion)
    }

    fn of_means(a: DVec3, b: DVec3, stderr: DVec3, criterion: &BlockCriterion) -> Option<BlockDifference> {
        if !(a.is_finite() && b.is_finite() && stderr.is_finite()) {
            return Some(BlockDifference { relative: f64::INFINITY, within: false });
        }
        let brightest = b.max_element();
        if brightest < MIN_RADIANCE {
            return None;
        }
        let counts = |&channel: &usize| b[channel] >= MIN_CHANNEL_SHARE * brightest;
        let relative = |channel: usize| (a[channel] - b[channel]).abs() / b[channel];
        let allowed = |channel: usize| criterion.relative + criterion.sigmas * stderr[channel] / b[channel];
        Some(BlockDifference {
            relative: (0..3).filter(counts).map(relative).fold(0.0, f64::max),
            within: (0..3).filter(counts).all(|channel| relative(channel) <= allowed(channel)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn uniform(width: usize, height: usize, value: Rgb) -> Image {
        Image::from_pixels(width, height, vec![value; width * height]).unwrap()
    }

    #[test]
    fn block_means_cover_ragged_edges() {
        let pixels = (0..15).map(|i| Rgb::splat(i as f32)).collect();
        let image = Image::from_pixels(5, 3, pixels).unwrap();
        let means = block_means(&image, 2);
        let expected = [3.0, 5.0, 6.5, 10.5, 12.5, 14.0].map(Rgb::splat);
        assert_eq!((means.width(), means.height(), means.pixels()), (3, 2, &expected[..]));
        assert_eq!(block_means(&image, 0), image);
    }

    fn report(a: &Image, b: &Image, criterion: &BlockCriterion) -> BlockReport {
        BlockReport::between(Estimate::exact(a), Estimate::exact(b), criterion).unwrap()
    }

    #[test]
    fn the_worst_block_is_found_and_counted() {
        let b = uniform(96, 64, Rgb::ONE);
        let mut a = b.clone();
        a.pixels_mut()[40 * 96 + 70].y += 0.02 * 1024.0;
        a.pixels_mut()[0].x -= 0.005 * 1024.0;
        let report = report(&a, &b, &BlockCriterion::new(0.01, 3.0));
        assert_eq!((report.n_blocks, report.n_within), (6, 5));
        let worst = report.worst.unwrap();
        assert_eq!((worst.x, worst.y), (64, 32));
        assert!((worst.relative_difference - 0.02).abs() < 1e-5);
        assert_eq!(report.share_within(), 5.0 / 6.0);
    }

    #[test]
    fn standard_errors_widen_the_bound_by_the_root_of_the_count() {
        let (a, b) = (uniform(32, 32, Rgb::splat(1.03)), uniform(32, 32, Rgb::ONE));
        // The combined standard error of a pixel is 0.5, that of the block 0.5 / 32 = 0.0156.
        let (se_a, se_b) = (uniform(32, 32, Rgb::splat(0.3)), uniform(32, 32, Rgb::splat(0.4)));
        let share = |sigmas, stderr_a| {
            let a = Estimate { mean: &a, stderr: stderr_a };
            let b = Estimate { mean: &b, stderr: Some(&se_b) };
            BlockReport::between(a, b, &BlockCriterion::new(0.01, sigmas)).unwrap().share_within()
        };
        assert_eq!((share(1.27, Some(&se_a)), share(1.29, Some(&se_a))), (0.0, 1.0));
        // Without that of `a` it is 0.4 / 32 = 0.0125.
        assert_eq!((share(1.59, None), share(1.61, None)), (0.0, 1.0));
    }

    #[test]
    fn dark_blocks_and_dark_channels_do_not_count() {
        let criterion = BlockCriterion::new(0.01, 0.0);
        let dark = report(&uniform(32, 32, Rgb::ONE), &uniform(32, 32, Rgb::splat(9e-4)), &criterion);
        assert_eq!((dark.n_blocks, dark.worst, dark.share_within()), (0, None, 0.0));
        let b = uniform(32, 32, Rgb::new(1.0, 0.049, 0.051));
        let dark_channel = report(&uniform(32, 32, Rgb::new(1.0, 7.0, 0.051)), &b, &criterion);
        assert_eq!(dark_channel.share_within(), 1.0);
        let dim_channel = report(&uniform(32, 32, Rgb::new(1.0, 0.049, 0.052)), &b, &criterion);
        assert_eq!(dim_channel.share_within(), 0.0);
    }

    #[test]
    fn masked_pixels_do_not_count_nor_do_blocks_with_too_few_others() {
        let b = uniform(20, 10, Rgb::ONE);
        let mut a = b.clone();
        let mut mask = vec![true; 200];
        for row in 0..4 {
            a.pixels_mut()[row * 20..row * 20 + 10].fill(Rgb::NAN);
            mask[row * 20..row * 20 + 10].fill(false);
        }
        let criterion = BlockCriterion { block: 10, ..BlockCriterion::new(0.0, 0.0) };
        let masked = |mask: &[bool]| report(&a, &b, &BlockCriterion { mask: Some(mask), ..criterion });
        assert_eq!((masked(&mask).n_blocks, masked(&mask).n_within), (2, 2));
        mask[9 * 20] = false;
        assert_eq!(masked(&mask).n_blocks, 1);
        let unmasked = report(&a, &b, &criterion);
        assert_eq!((unmasked.n_blocks, unmasked.n_within), (2, 1));
        assert_eq!(unmasked.worst.unwrap().relative_difference, f64::INFINITY);
    }

    #[test]
    fn a_reference_that_is_not_finite_never_passes() {
        let a = uniform(32, 32, Rgb::ONE);
        let mut b = a.clone();
        b.pixels_mut()[3].z = f32::NAN;
        assert_eq!(report(&a, &b, &BlockCriterion::new(1e9, 1e9)).share_within(), 0.0);
    }

    #[test]
    fn sizes_and_masks_are_checked() {
        let (small, large) = (Image::new(2, 2), Image::new(3, 2));
        let between = |a: &Image, b: &Image, criterion| {
            BlockReport::between(Estimate::exact(a), Estimate::exact(b), criterion).unwrap_err()
        };
        let short = BlockCriterion { mask: Some(&[true; 3]), ..BlockCriterion::new(0.1, 1.0) };
        assert_eq!(between(&small, &small, &short), CompareError::MaskLength { mask: 3, pixels: 4 });
        let error = between(&small, &large, &BlockCriterion::new(0.1, 1.0));
        assert_eq!(error, CompareError::SizeMismatch { image: (2, 2), reference: (3, 2) });
    }
}
