//! Whether estimates of a picture agree, block by block.

use caustica::compare::{BlockCriterion, BlockReport, Estimate, block_means};
use caustica::film::Image;
use caustica::math::Rgb;
use caustica::ppm::{Render, Settings};
use caustica::scene::Scene;

use super::{block_estimate, settings};

pub const BLOCK: usize = 8;

/// The mean over independent renders of few passes, block by block.
pub fn photon_mapped(scene: &Scene) -> (Image, Image) {
    photon_mapped_by(scene, settings(scene))
}

/// The same by settings of which number and radius of the photons are set here.
pub fn photon_mapped_by(scene: &Scene, settings: Settings) -> (Image, Image) {
    let render = |seed| {
        let settings = Settings { photons: 100_000, radius: Some(1.5), seed, ..settings };
        let mut render = Render::new(scene, settings);
        for _ in 0..12 {
            let pass = render.pass();
            assert!(pass.photons.is_balanced(), "photons unaccounted for: {:?}", pass.photons.flux);
        }
        render.picture()
    };
    block_estimate(&(0..12).map(render).collect::<Vec<Image>>(), BLOCK)
}

/// Every block agrees to `relative` of its brightness and five standard errors: those of a dozen renders have heavy tails, of which one
/// block in some thousands is beyond.
pub fn assert_agree(
    a: &(Image, Image),
    b: &(Image, Image),
    block: usize,
    relative: f64,
    mask: Option<&[bool]>,
) {
    let criterion = BlockCriterion { block, mask, ..BlockCriterion::new(relative, 5.0) };
    let [a, b] = [a, b].map(|(mean, stderr)| Estimate { mean, stderr: Some(stderr) });
    let report = BlockReport::between(a, b, &criterion).unwrap();
    eprintln!("{} of {} blocks, worst {:?}", report.n_within, report.n_blocks, report.worst);
    assert!(report.n_blocks >= 12 && report.n_within == report.n_blocks, "worst {:?}", report.worst);
}

/// The mean of every block, and its standard error.
pub fn in_blocks(estimate: &(Image, Image)) -> (Image, Image) {
    // Pixels are independent: the error of a mean of n is that of their squares over n.
    let squares: Vec<Rgb> = estimate.1.pixels().iter().map(|e| *e * *e).collect();
    let (width, height) = (estimate.1.width(), estimate.1.height());
    let squares = block_means(&Image::from_pixels(width, height, squares).unwrap(), BLOCK);
    let n = (BLOCK * BLOCK) as f32;
    let pixels = squares.pixels().iter().map(|square| (*square / n).map(f32::sqrt)).collect();
    let stderr = Image::from_pixels(squares.width(), squares.height(), pixels).unwrap();
    (block_means(&estimate.0, BLOCK), stderr)
}
