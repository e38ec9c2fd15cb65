use super::colour::ColourSpaces;
use super::convolve::{Plane, convolve};
use crate::math::{Rgb, Vec4};
use rayon::prelude::*;
use std::f32::consts::PI;

/// Pixels per degree of vision that FLIP takes by default: 3840 pixels over 0.7 m, seen from 0.7 m.
pub const PIXELS_PER_DEGREE: f32 = 0.7 * 3840.0 / 0.7 * PI / 180.0;

/// Width in degrees of the features that the eye is most sensitive to.
const FEATURE_WIDTH: f32 = 0.082;
/// The sensitivity to contrast of each opponent channel as Gaussians `a √(π/b) exp(-π² x² / b)`, with `(a, b)`.
const ACHROMATIC: (f32, f32) = (1.0, 0.0047);
const RED_GREEN: (f32, f32) = (1.0, 0.0053);
const BLUE_YELLOW: [(f32, f32); 2] = [(34.1, 0.04), (13.5, 0.025)];

/// LDR-FLIP between pictures of linear colours in `[0, 1]`: how different two pictures look to who flips between them.
///
/// # Source
/// Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild, "FLIP: A Difference Evaluator for Alternating
/// Images", Proc. ACM Comput. Graph. Interact. Tech. 3(2), 2020; the filters' separable form and scale are those of the
/// authors' C++ source.
pub(super) struct LdrFlip {
    spaces: ColourSpaces,
    sensitivity: Vec<Vec4>,
    /// A Gaussian and its first two derivatives, as the first and the second pass of the convolution need them.
    feature_x: Vec<Vec4>,
    feature_y: Vec<Vec4>,
}

/// What FLIP sees in one picture.
struct Seen {
    colours: Vec<Rgb>,
    /// Strength of edges and of points.
    features: Vec<(f32, f32)>,
}

impl LdrFlip {
    pub(super) fn new() -> LdrFlip {
        let feature = feature_kernel();
        LdrFlip {
            spaces: ColourSpaces::new(),
            sensitivity: sensitivity_kernel(),
            feature_x: feature.iter().map(|&[g, d, dd]| Vec4::new(d, dd, g, g)).collect(),
            feature_y: feature.iter().map(|&[g, d, dd]| Vec4::new(g, g, d, dd)).collect(),
        }
    }

    /// The FLIP error of each pixel, from 0 to 1.
    pub(super) fn map(&self, width: usize, test: &[Rgb], reference: &[Rgb]) -> Vec<f32> {
        let (a, b) = (self.see(width, test), self.see(width, reference));
        (0..test.len()).into_par_iter().map(|pixel| self.error(&a, &b, pixel)).collect()
    }

    fn see(&self, width: usize, colours: &[Rgb]) -> Seen {
        // The blue-yellow channel comes twice, once for each of its Gaussians.
        let opponents: Vec<Vec4> = colours
            .par_iter()
            .map(|&rgb| self.spaces.ycxcz(rgb))
            .map(|opponent| opponent.extend(opponent.z))
            .collect();
        let luminances = opponents.iter().map(|opponent| Vec4::splat((opponent.x + 16.0) / 116.0)).collect();
        let features = convolve(&Plane { width, pixels: luminances }, &self.feature_x, &self.feature_y);
        let blurred = convolve(&Plane { width, pixels: opponents }, &self.sensitivity, &self.sensitivity);
        let displayed = |p: &Vec4| self.spaces.displayed(Rgb::new(p.x, p.y, p.z + p.w));
        Seen {
            colours: blurred.pixels.par_iter().map(displayed).collect(),
            features: features.pixels.iter().map(|f| (f.x.hypot(f.z), f.y.hypot(f.w))).collect(),
        }
    }

    fn error(&self, a: &Seen, b: &Seen, pixel: usize) -> f32 {
        let colour = self.spaces.difference(a.colours[pixel], b.colours[pixel]);
        let ((edge_a, point_a), (edge_b, point_b)) = (a.features[pixel], b.features[pixel]);
        let feature = (edge_a - edge_b).abs().max((point_a - point_b).abs()) / 2f32.sqrt();
        colour.powf(1.0 - feature.sqrt())
    }
}

/// Weights along one axis of the sensitivities: achromatic, red-green, and the two parts of blue-yellow, of which the
/// two-dimensional kernels add up to 1 together.
fn sensitivity_kernel() -> Vec<Vec4> {
    let [first, second] = BLUE_YELLOW;
    let widest = first.1;
    let radius = (3.0 * (widest / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE).ceil() as i32;
    let gaussian = |b: f32, x: f32| (-PI * PI * x * x / b).exp();
    // A part is the product of its weights along both axes, so each takes the root of the part's factor.
    let part = |(a, b): (f32, f32), x: f32| (a * (PI / b).sqrt()).sqrt() * gaussian(b, x);
    let weights: Vec<Vec4> = (-radius..=radius)
        .map(|offset| offset as f32 / PIXELS_PER_DEGREE)
        .map(|x| {
            let chromatic = Vec4::new(0.0, gaussian(RED_GREEN.1, x), part(first, x), part(second, x));
            chromatic.with_x(gaussian(ACHROMATIC.1, x))
        })
        .collect();
    let sum: Vec4 = weights.iter().sum();
    let blue_yellow = sum.z.hypot(sum.w);
    weights.into_iter().map(|weight| weight / Vec4::new(sum.x, sum.y, blue_yellow, blue_yellow)).collect()
}

/// A Gaussian that adds up to 1 and its first and second derivative, scaled so that their positive weights add up to 1
/// and their negative ones to -1.
fn feature_kernel() -> Vec<[f32; 3]> {
    let sigma = 0.5 * FEATURE_WIDTH * PIXELS_PER_DEGREE;
    let radius = (3.0 * sigma).ceil() as i32;
    let derivatives = |offset: i32| {
        let t = offset as f32 / sigma;
        let g = (-0.5 * t * t).exp();
        [g, -t * g, (t * t - 1.0) * g]
    };
    let kernel: Vec<[f32; 3]> = (-radius..=radius).map(derivatives).collect();
    let sum = |order: usize, sign: f32| kernel.iter().map(|w| (sign * w[order]).max(0.0)).sum::<f32>();
    let sums = [0, 1, 2].map(|order| (sum(order, 1.0), sum(order, -1.0)));
    let scaled = |weight: f32, (positive, negative): (f32, f32)| {
        if weight > 0.0 { weight / positive } else { weight / negative.max(f32::MIN_POSITIVE) }
    };
    kernel.iter().map(|w| [0, 1, 2].map(|order| scaled(w[order], sums[order]))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn black_against_white_and_green_against_blue_are_as_published() {
        // flip-evaluator 1.7, `evaluate(reference, test, "LDR")` of uniform pictures of 8 x 8 pixels.
        let flip = LdrFlip::new();
        let uniform = |a: Rgb, b: Rgb| flip.map(8, &[a; 64], &[b; 64])[27];
        assert!((uniform(Rgb::ONE, Rgb::ZERO) - 0.967_388).abs() < 1e-5);
        assert!((uniform(Rgb::Z, Rgb::Y) - 1.0).abs() < 1e-5);
        assert_eq!(uniform(Rgb::X, Rgb::X), 0.0);
    }

    #[test]
    fn kernels_keep_uniform_pictures_and_find_no_feature_in_them() {
        let kernel = sensitivity_kernel();
        let sum: Vec4 = kernel.iter().sum();
        assert_eq!(kernel.len(), 21);
        assert!((sum.x - 1.0).abs() < 1e-5 && (sum.y - 1.0).abs() < 1e-5);
        assert!((sum.z * sum.z + sum.w * sum.w - 1.0).abs() < 1e-5);
        let feature = feature_kernel();
        let sums = [0, 1, 2].map(|order| feature.iter().map(|w| w[order]).sum::<f32>());
        assert_eq!(feature.len(), 2 * 9 + 1);
        assert!((sums[0] - 1.0).abs() < 1e-5 && sums[1].abs() < 1e-5 && sums[2].abs() < 1e-5, "{sums:?}");
    }
}
