//! All methods against pictures that an independent one made, with their standard errors.
//!
//! The pictures are not part of the project; where they are absent the tests say so and pass.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a panic is how a test fails")]

mod common;

use caustica::compare::{BlockCriterion, BlockReport, Estimate, block_means, share_within};
use caustica::film::Image;
use caustica::math::{Vec2, Vec3};
use caustica::output::read_exr;
use caustica::ppm::Settings;
use caustica::scene::Scene;
use common::{
    block_estimate, blocks_seen_diffuse, comparison_picture, light_traced, path_traced, photon_mapped, scene,
    settings,
};

/// A picture of another renderer and its standard error.
struct Reference {
    mean: Image,
    stderr: Image,
}

impl Reference {
    fn load(name: &str) -> Option<Reference> {
        let mean = read_exr(&comparison_picture(&format!("{name}.exr"))?).unwrap();
        let stderr = read_exr(&comparison_picture(&format!("{name}_stderr.exr"))?).unwrap();
        Some(Reference { mean, stderr })
    }

    fn estimate(&self) -> Estimate<'_> {
        Estimate { mean: &self.mean, stderr: Some(&self.stderr) }
    }
}

const BLOCK: usize = 32;
/// How far from an edge a pixel is away from it: more than the gather radius, in pixels.
const MARGIN: usize = 4;

/// The plane under a pixel: two pixels on one plane have no edge between them.
fn plane(scene: &Scene, x: usize, y: usize) -> Option<(Vec3, f32)> {
    let raster = Vec2::new(x as f32, y as f32) + 0.5;
    let hit = scene.intersect(&scene.camera().ray(raster))?;
    Some((hit.ng, hit.ng.dot(hit.p)))
}

fn same_plane(a: Option<(Vec3, f32)>, b: Option<(Vec3, f32)>) -> bool {
    matches!((a, b), (Some(a), Some(b)) if a.0.dot(b.0) > 0.999_99 && (a.1 - b.1).abs() < 0.05)
}

/// True for the pixels of blocks that lie, with a margin, on one plane.
fn away_from_edges(scene: &Scene) -> Vec<bool> {
    let (width, height) = (scene.film().width as usize, scene.film().height as usize);
    let inside = |block: usize, size: usize| block.saturating_sub(MARGIN)..(block + BLOCK + MARGIN).min(size);
    let mut mask = vec![false; width * height];
    for by in (0..height).step_by(BLOCK) {
        for bx in (0..width).step_by(BLOCK) {
            let first = plane(scene, bx, by);
            let flat =
                inside(by, height).all(|y| inside(bx, width).all(|x| same_plane(first, plane(scene, x, y))));
            for y in by..by + BLOCK {
                mask[y * width + bx..][..BLOCK].fill(flat);
            }
        }
    }
    mask
}

const RENDERS: u64 = 16;

/// The mean of every block and its standard error, over independent renders of other seeds.
fn photon_mapped_blocks(scene: &Scene, settings: Settings) -> (Image, Image) {
    const PASSES: u32 = 2;
    let render = |seed| photon_mapped(scene, Settings { seed, ..settings }, PASSES);
    block_estimate(&(0..RENDERS).map(render).collect::<Vec<_>>(), BLOCK)
}

/// The reference's blocks: its pixels are independent samples.
fn reference_blocks(reference: &Reference) -> (Image, Image) {
    let mut squares = reference.stderr.clone();
    squares.pixels_mut().iter_mut().for_each(|p| *p *= *p);
    let mut stderr = block_means(&squares, BLOCK);
    stderr.pixels_mut().iter_mut().for_each(|p| *p = p.map(f32::sqrt) / BLOCK as f32);
    (block_means(&reference.mean, BLOCK), stderr)
}

/// Half a percent in every block away from edges, beyond four combined standard errors.
fn assert_blocks_agree(scene: &Scene, settings: Settings, reference: &Reference) {
    let pixels = away_from_edges(scene);
    let (width, blocks) = (scene.film().width as usize, scene.film().width as usize / BLOCK);
    let mask: Vec<bool> =
        (0..blocks * blocks).map(|b| pixels[b / blocks * BLOCK * width + b % blocks * BLOCK]).collect();
    let (ours, theirs) = (photon_mapped_blocks(scene, settings), reference_blocks(reference));
    let criterion = BlockCriterion { block: 1, mask: Some(&mask), ..BlockCriterion::new(0.005, 4.0) };
    let report = BlockReport::between(
        Estimate { mean: &ours.0, stderr: Some(&ours.1) },
        Estimate { mean: &theirs.0, stderr: Some(&theirs.1) },
        &criterion,
    )
    .unwrap();
    eprintln!("{report:?}");
    assert!(report.n_blocks >= 60, "only {} blocks are away from edges", report.n_blocks);
    assert_eq!(report.n_within, report.n_blocks, "{report:?}");
}

fn photons(scene: &Scene, radius: f64) -> Settings {
    Settings { photons: 1_000_000, samples: 1, radius: Some(radius), ..settings(scene) }
}

/// Catches a lost cosine, roulette that is not compensated, photons normalised by the wrong count.
#[test]
fn photon_mapping_of_the_diffuse_box() {
    let Some(reference) = Reference::load("cornell_a_ref") else { return };
    let scene = scene("cornell_a.toml");
    assert_blocks_agree(&scene, photons(&scene, 3.0), &reference);
}

/// Catches caustics lost to the first-bounce rule, and energy lost in glass.
#[test]
fn photon_mapping_of_mirror_glass_and_area_light() {
    let Some(reference) = Reference::load("cornell_b_ptracer_ref") else { return };
    let scene = scene("cornell_b.toml");
    assert_blocks_agree(&scene, photons(&scene, 2.0), &reference);
}

/// One long render with the scene's own settings: only the reference's standard errors are allowed for.
#[test]
#[ignore = "takes minutes; the tests above allow for their own noise instead"]
fn long_renders() {
    for (name, picture) in [("cornell_a", "cornell_a_ref"), ("cornell_b", "cornell_b_ptracer_ref")] {
        let Some(reference) = Reference::load(picture) else { return };
        let scene = scene(&format!("{name}.toml"));
        let image = photon_mapped(&scene, settings(&scene), scene.render().passes);
        let mask = away_from_edges(&scene);
        let criterion = BlockCriterion { mask: Some(&mask), ..BlockCriterion::new(0.005, 3.0) };
        let report = BlockReport::between(Estimate::exact(&image), reference.estimate(), &criterion).unwrap();
        eprintln!("{name}: {report:?}");
        assert!(report.share_within() > 0.97, "{report:?}");
    }
}

/// Pixel by pixel: both standard errors must explain the difference.
#[test]
fn path_tracing_of_the_diffuse_box() {
    let Some(reference) = Reference::load("cornell_a_ref") else { return };
    let scene = scene("cornell_a.toml");
    let (image, stderr) = path_traced(&scene, 384);
    let ours = Estimate { mean: &image, stderr: Some(&stderr) };
    let share = share_within(ours, reference.estimate(), 3.0).unwrap();
    assert!(share > 0.99, "{share} of the pixels are within three standard errors");
}

/// Block by block: both standard errors must explain the difference where light tracing finds everything.
fn assert_light_traced_blocks(scene: &Scene, reference: &Reference, blocks: usize) {
    let mask = blocks_seen_diffuse(scene, BLOCK);
    let (image, stderr) = light_traced(scene, 48);
    let ours = Estimate { mean: &image, stderr: Some(&stderr) };
    let criterion = BlockCriterion { mask: Some(&mask), ..BlockCriterion::new(0.001, 4.0) };
    let report = BlockReport::between(ours, reference.estimate(), &criterion).unwrap();
    eprintln!("{report:?}");
    assert!(report.n_blocks >= blocks, "{report:?}");
    assert_eq!(report.n_within, report.n_blocks, "{report:?}");
}

/// Catches a wrong cosine, pixel area or number of paths.
#[test]
fn light_tracing_of_the_diffuse_box() {
    let Some(reference) = Reference::load("cornell_a_ref") else { return };
    assert_light_traced_blocks(&scene("cornell_a.toml"), &reference, 240);
}

/// Soft shadows and the caustic, but neither the balls nor the lamp.
#[test]
fn light_tracing_of_mirror_glass_and_area_light() {
    let Some(reference) = Reference::load("cornell_b_ptracer_ref") else { return };
    assert_light_traced_blocks(&scene("cornell_b.toml"), &reference, 180);
}
