//! Variance and bias, told apart by pictures that differ in their seeds alone.

use serde::{Deserialize, Serialize};

use super::reference::Reference;
use crate::compare::REL_MSE_EPSILON;
use crate::film::Image;
use crate::math::DVec3;

/// What the mean square error of a region's pixels consists of: `E[(x - r)²] = Var(x) + (E[x] - r)²`, each difference weighed by
/// `1 / (r² + ε)` as in [`crate::compare::Metrics::rel_mse`], and averaged over pixels and channels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parts {
    /// The share of all pixels that is in the region.
    pub share: f64,
    /// Variance of one picture: the sample variance across repetitions.
    pub variance: f64,
    /// Squared bias: what is left of the mean square error without the variance and, where it is known, that of the reference. It is unbiased,
    /// and therefore negative at times where there is none.
    pub bias2: f64,
    /// Standard error of the squared bias, by the repetitions and by the reference's own; parts of the picture count as independent.
    pub bias2_error: f64,
}

/// So many standard errors tell a squared bias from 0.
const TOLD_APART: f64 = 2.0;

impl Parts {
    /// Whether the squared bias is more than chance.
    pub fn has_bias(&self) -> bool {
        self.bias2 > TOLD_APART * self.bias2_error
    }
}

/// [`Parts`] of the pictures that some repetitions had at one look.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Separation {
    /// Pictures; at least 2.
    pub repetitions: u32,
    /// Of all pixels.
    pub all: Parts,
    /// Of those alone whose discs lie flat; none where there are no such pixels.
    pub flat: Option<Parts>,
}

impl Separation {
    /// Tells apart what `count` pictures hold, all as large as the reference; `None` unless `picture` has all of them, and two at least.
    ///
    /// No more than one picture is asked for at a time. Of the mean over `K` pictures `x̄`, `(x̄ - r)²` exceeds the squared bias by a `K`-th of the
    /// variance and by that of the reference.
    pub fn of(
        count: u32,
        picture: impl Fn(u32) -> Option<Image>,
        reference: &Reference,
        flat: Option<&[bool]>,
    ) -> Option<Separation> {
        if count < 2 {
            return None;
        }
        let mean = mean(count, &picture)?;
        let mut all = Region::new(&mean, reference, None);
        let mut flat = flat.map(|flat| Region::new(&mean, reference, Some(flat)));
        for k in 0..count {
            let picture = picture(k)?;
            [Some(&mut all), flat.as_mut()].into_iter().flatten().for_each(|region| region.add(&picture));
        }
        let flat = flat.and_then(|flat| flat.parts(count));
        Some(Separation { repetitions: count, all: all.parts(count)?, flat })
    }
}

fn mean(count: u32, picture: &impl Fn(u32) -> Option<Image>) -> Option<Vec<DVec3>> {
    let mut sum: Vec<DVec3> = Vec::new();
    for k in 0..count {
        let picture = picture(k)?;
        sum.resize(picture.pixels().len(), DVec3::ZERO);
        sum.iter_mut().zip(picture.pixels()).for_each(|(sum, pixel)| *sum += pixel.as_dvec3());
    }
    sum.iter_mut().for_each(|sum| *sum /= f64::from(count));
    Some(sum)
}

/// Parts of a picture along each side: discs of one hardly reach the next but one.
const PARTS: usize = 8;

/// Sums over some pixels.
struct Region<'a> {
    mean: &'a [DVec3],
    reference: &'a Reference,
    is_in: Option<&'a [bool]>,
    /// `Σ w (x - x̄)²`.
    spread: f64,
    /// Over pictures and parts, the sum of `(Σ w (x̄ - r)(x - x̄))²`.
    leverage: f64,
}

impl<'a> Region<'a> {
    fn new(mean: &'a [DVec3], reference: &'a Reference, is_in: Option<&'a [bool]>) -> Region<'a> {
        Region { mean, reference, is_in, spread: 0.0, leverage: 0.0 }
    }

    fn pixels(&self) -> impl Iterator<Item = usize> + use<'a> {
        let is_in = self.is_in;
        (0..self.mean.len()).filter(move |&pixel| is_in.is_none_or(|is_in| is_in[pixel]))
    }

    /// Of a pixel: the weights of its channels and the mean error.
    fn error(&self, pixel: usize) -> (DVec3, DVec3) {
        let reference = self.reference.image.pixels()[pixel].as_dvec3();
        (1.0 / (reference * reference + REL_MSE_EPSILON), self.mean[pixel] - reference)
    }

    fn part(&self, pixel: usize) -> usize {
        let (width, height) = (self.reference.image.width(), self.reference.image.height());
        (pixel / width * PARTS / height) * PARTS + pixel % width * PARTS / width
    }

    fn add(&mut self, picture: &Image) {
        let mut of_parts = [0.0; PARTS * PARTS];
        for pixel in self.pixels() {
            let (weight, error) = self.error(pixel);
            let deviation = picture.pixels()[pixel].as_dvec3() - self.mean[pixel];
            self.spread += (weight * deviation * deviation).element_sum();
            of_parts[self.part(pixel)] += (weight * error * deviation).element_sum();
        }
        self.leverage += of_parts.iter().map(|sum| sum * sum).sum::<f64>();
    }

    /// Sums over the region: of the weighed squares of the mean error, without those of the reference's own; and of `(Σ w (x̄ - r) s)²` by the
    /// reference's standard error `s`, as if its pixels were independent.
    fn squares(&self) -> (f64, f64) {
        let noise = self.reference.standard_error.as_ref();
        let squares = |pixel: usize| {
            let (weight, error) = self.error(pixel);
            let noise = noise.map_or(DVec3::ZERO, |noise| noise.pixels()[pixel].as_dvec3());
            let leverage = (weight * error * noise).element_sum();
            ((weight * (error * error - noise * noise)).element_sum(), leverage * leverage)
        };
        self.pixels().map(squares).fold((0.0, 0.0), |sum, of| (sum.0 + of.0, sum.1 + of.1))
    }

    fn parts(&self, count: u32) -> Option<Parts> {
        let (pixels, k) = (self.pixels().count(), f64::from(count));
        let n = (3 * pixels) as f64;
        let variance = self.spread / (k - 1.0) / n;
        let (squares, of_reference) = self.squares();
        (pixels > 0).then(|| Parts {
            share: pixels as f64 / self.mean.len() as f64,
            variance,
            bias2: squares / n - variance / k,
            // The squared mean error changes by twice it times the change of the mean.
            bias2_error: 2.0 * (self.leverage / (k * (k - 1.0)) + of_reference).sqrt() / n,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Rgb, Rng, Stream};

    const SIDE: usize = 48;
    const VARIANCE: f64 = 0.01;
    const BIAS: f64 = 0.05;
    const TRIALS: u32 = 200;

    /// Of variance 1, alike in blocks of `block` pixels.
    fn noise(rng: &mut Rng, block: usize) -> Vec<Rgb> {
        let mut normal = || (0..12).map(|_| rng.next_f32()).sum::<f32>() - 6.0;
        let coarse: Vec<Rgb> = (0..SIDE * SIDE).map(|_| Rgb::new(normal(), normal(), normal())).collect();
        (0..SIDE * SIDE).map(|p| coarse[p / SIDE / block * block * SIDE + p % SIDE / block * block]).collect()
    }

    fn image(of: impl Fn(usize) -> Rgb) -> Image {
        Image::from_pixels(SIDE, SIDE, (0..SIDE * SIDE).map(of).collect()).unwrap()
    }

    fn is_left(pixel: usize) -> bool {
        pixel % SIDE < SIDE / 2
    }

    /// Of a grey ramp: pictures that are too dark in their left half, and a reference that is noisy as its standard error says.
    fn separated(trial: u32, count: u32, bias: f64, block: usize) -> Separation {
        let mut rng = Rng::new(3, Stream::Test, trial, 0);
        let ramp = |pixel: usize| 0.2 + (pixel / SIDE) as f32 / SIDE as f32;
        // What is weighed by 1 / (r² + ε) is relative to its root.
        let unit = |pixel: usize| (ramp(pixel).powi(2) + REL_MSE_EPSILON as f32).sqrt();
        let pictures: Vec<Image> = (0..count)
            .map(|_| {
                let noise = noise(&mut rng, block);
                let bias = |pixel| if is_left(pixel) { bias as f32 } else { 0.0 };
                let error = |pixel: usize| noise[pixel] * VARIANCE.sqrt() as f32 - bias(pixel);
                image(|pixel| Rgb::splat(ramp(pixel)) + error(pixel) * unit(pixel))
            })
            .collect();
        let noise = noise(&mut rng, 1);
        let reference = Reference {
            standard_error: Some(image(|_| Rgb::splat(0.004))),
            ..Reference::given(
                image(|pixel| Rgb::splat(ramp(pixel)) + 0.004 * noise[pixel]),
                "r.exr".as_ref(),
            )
        };
        let right: Vec<bool> = (0..SIDE * SIDE).map(|pixel| !is_left(pixel)).collect();
        Separation::of(count, |k| Some(pictures[k as usize].clone()), &reference, Some(&right)).unwrap()
    }

    /// Means over many trials of variance and squared bias: of all pixels, and of those without bias.
    #[test]
    fn known_variance_and_bias_are_told_apart() {
        for count in [2, 3, 5] {
            let trials: Vec<Separation> = (0..TRIALS).map(|trial| separated(trial, count, BIAS, 1)).collect();
            let mean = |of: fn(&Separation) -> f64| trials.iter().map(of).sum::<f64>() / f64::from(TRIALS);
            let flat = |s: &Separation| s.flat.unwrap();
            for variance in [mean(|s| s.all.variance), mean(|s| s.flat.unwrap().variance)] {
                assert!((variance / VARIANCE - 1.0).abs() < 0.02, "{count}: variance {variance}");
            }
            let bias2 = mean(|s| s.all.bias2);
            assert!((bias2 / (0.5 * BIAS * BIAS) - 1.0).abs() < 0.03, "{count}: squared bias {bias2}");
            let none = trials.iter().map(|s| flat(s).bias2).sum::<f64>() / f64::from(TRIALS);
            assert!(none.abs() < 0.03 * BIAS * BIAS, "{count}: squared bias {none} of none");
            assert!(trials.iter().all(|s| s.all.has_bias() && s.all.share == 1.0 && flat(s).share == 0.5));
        }
    }

    /// 95 of a hundred intervals of two standard errors are to hold the truth, whether noise is alike from pixel to pixel or not; those
    /// for pictures without bias are a little too wide.
    #[test]
    fn standard_errors_are_what_they_say() {
        for (bias, block) in [(0.0, 1), (0.0, 3), (BIAS, 1), (BIAS, 3), (3.0 * BIAS, 6)] {
            let holds = |trial: &u32| {
                let all = separated(1000 + trial, 3, bias, block).all;
                (all.bias2 - 0.5 * bias * bias).abs() < 2.0 * all.bias2_error
            };
            let share = (0..200).filter(holds).count() as f64 / 200.0;
            assert!((0.9..1.0).contains(&share), "bias {bias} in blocks of {block}: {share}");
        }
    }

    #[test]
    fn without_bias_nothing_is_claimed() {
        let claims = (0..200).filter(|&trial| separated(trial, 3, 0.0, 3).all.has_bias()).count();
        assert!(claims < 14, "{claims} of 200");
    }

    /// What is not known of a reference is taken for bias.
    #[test]
    fn an_unknown_reference_adds_its_noise() {
        let picture = |_| Some(image(|_| Rgb::ONE));
        let mut reference = Reference::given(image(|_| Rgb::splat(0.9)), "r.exr".as_ref());
        let bias2 = |reference: &Reference| Separation::of(2, picture, reference, None).unwrap().all.bias2;
        let weight = 1.0 / (0.81 + REL_MSE_EPSILON);
        assert!((bias2(&reference) - 0.01 * weight).abs() < 1e-6);
        reference.standard_error = Some(image(|_| Rgb::splat(0.06)));
        assert!((bias2(&reference) - 0.0064 * weight).abs() < 1e-6);
    }

    #[test]
    fn what_is_missing_is_not_guessed() {
        let reference = Reference::given(image(|_| Rgb::ONE), "r.exr".as_ref());
        let of = |count, there| {
            Separation::of(count, |k| (k < there).then(|| image(|_| Rgb::ONE)), &reference, None)
        };
        assert_eq!((of(1, 1), of(3, 2)), (None, None));
        let nowhere = vec![false; SIDE * SIDE];
        let found = Separation::of(2, |_| Some(image(|_| Rgb::ONE)), &reference, Some(&nowhere)).unwrap();
        assert_eq!((found.flat, found.all.variance), (None, 0.0));
    }
}
