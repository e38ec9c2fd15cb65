//! Scenes of any size, anywhere.

use caustica::bsdf::DiffuseSampling;
use caustica::compare::Metrics;
use caustica::effects::PathClass;
use caustica::film::Image;
use caustica::math::Vec3;
use caustica::ppm::{Render, Settings};
use caustica::scene::{Scene, SceneDesc, Traversal};

use crate::rooms::{TRAVERSALS, furnished_box, lit_box, moved, rendered};

const SAMPLINGS: [DiffuseSampling; 2] = [DiffuseSampling::Cosine, DiffuseSampling::Uniform];

fn picture(desc: &SceneDesc, traversal: Traversal, sampling: DiffuseSampling) -> Image {
    let scene = Scene::with_traversal(desc.clone(), traversal).unwrap();
    let settings = Settings { sampling, ..Settings::of_scene(scene.render()) };
    let image = rendered(&scene, settings).0.picture();
    assert_eq!(image.count_non_finite(), 0);
    image
}

/// Calls `check` with the pictures of the scene as it is and moved, by every traversal and sampling.
fn against_moved(scale: f32, shift: Vec3, check: impl Fn(&Image, &Image)) {
    for traversal in TRAVERSALS {
        for sampling in SAMPLINGS {
            let [here, there] = [furnished_box(), moved(furnished_box(), scale, shift)]
                .map(|desc| picture(&desc, traversal, sampling));
            check(&here, &there);
        }
    }
}

fn relative_error(a: &Image, b: &Image, pixel: usize) -> f32 {
    let [a, b] = [a, b].map(|image| image.pixels()[pixel]);
    ((a - b).abs() / b.abs().max(Vec3::splat(1e-3))).max_element()
}

/// A scene scaled by a power of two, from 1e-4 to 1e6, gives the very same picture.
///
/// Breaks: an absolute epsilon swallows small scenes, and in large ones surfaces shade themselves.
/// Mutation: `offset_origin` with 1e-4 in place of the error of the point.
#[test]
fn powers_of_two_change_no_bit() {
    for exponent in [-13, -7, 11, 20] {
        against_moved(2f32.powi(exponent), Vec3::ZERO, |here, there| {
            assert_eq!(here, there, "2^{exponent}");
        });
    }
}

/// At any other scale rounding moves a photon in a million across the rim of a disc; all else stays within 1e-4.
///
/// Breaks: as above; thresholds compared with lengths or areas.
/// Mutation: `offset_origin` with 1e-4 in place of the error of the point; random numbers of direct light keyed by the
/// place in the tree.
#[test]
fn any_scale_gives_the_same_picture() {
    for scale in [1e-4, 1e-2, 7.0, 1e3, 1e6] {
        against_moved(scale, Vec3::ZERO, |here, there| {
            let pixels = here.pixels().len();
            let beyond = (0..pixels).filter(|&pixel| relative_error(there, here, pixel) > 1e-4).count();
            assert!(beyond * 50 < pixels, "{scale}: {beyond} of {pixels} pixels");
            let error = Metrics::between(there, here).unwrap().rel_mse.sqrt();
            assert!(error < 2e-3, "{scale}: {error}");
        });
    }
}

/// 1000 and 100,000 box sizes from the origin, where floats are up to .008 apart, the picture keeps its brightness.
///
/// Breaks: self-shadowing, black or speckled pictures, endless bounces between a surface and itself.
/// Mutation: `RELATIVE_POSITION_ERROR` a thousandth of what it is.
#[test]
fn far_from_the_origin_the_picture_fades_gracefully() {
    for (distance, tolerance) in [(1e3, 0.01), (1e5, 0.1)] {
        against_moved(1.0, distance * Vec3::new(1.0, -1.0, 1.0), |here, there| {
            let ratio = Metrics::between(there, here).unwrap().mean_ratio_overall;
            assert!((ratio - 1.0).abs() < tolerance, "{distance}: {ratio}");
        });
    }
}

/// Where floats are .06 apart, a radius of .05 stops shrinking at a few of these steps, and it is told.
///
/// Breaks: discs smaller than the grid of coordinates hold a photon by luck: noise without end, or black.
/// Mutation: `RadiusFloor::apply` returning at once.
#[test]
fn radii_do_not_shrink_below_the_grid_of_coordinates() {
    let far = moved(lit_box(), 1.0, Vec3::splat(1e6));
    for traversal in TRAVERSALS {
        let scene = Scene::with_traversal(far.clone(), traversal).unwrap();
        let mut render = Render::new(&scene, Settings::of_scene(scene.render()));
        let pass = render.pass();
        assert_eq!(pass.radius.floored, render.hit_points().len() as u64);
        let smallest =
            render.states(PathClass::Indirect).iter().map(|s| s.radius()).fold(f64::INFINITY, f64::min);
        assert!(smallest >= 4.0 * 0.0625, "{smallest}");
        assert_eq!(render.picture().count_non_finite(), 0);
    }
}
