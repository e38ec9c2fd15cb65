//! Gathering where eye paths are retraced: hit points sum what they find, pixels keep it.
//!
//! A pixel has one radius `R`, one count `N` and one `τ`, in units of radiance: with the hit points `h` that it sees in a pass,
//! `M = Σ_h M_h` and `Φ = Σ_h weight_h · albedo_h / π · Φ_h`, it goes on as a hit point does.
//!
//! # Source
//! Hachisuka and Jensen, "Stochastic Progressive Photon Mapping", SIGGRAPH Asia 2009, section 3: shared statistics.

use rayon::prelude::*;

use super::evenness::PartSums;
use super::gather::{Receivers, gather_into};
use super::pixel_lists::PixelLists;
use super::statistic::{Gathers, Statistic, Statistics};
use super::{Found, PassSum, Photons};
use crate::bvh::SphereBvh;
use crate::math::mean;

/// One pass: the hit points of `tree` sum the photons within their radii, then the pixels of `lists` take them together and
/// shrink their radii by `alpha`. The tree stays as it is.
///
/// A pixel sums its hit points in the order of its list.
pub(super) fn gather_by_pixel(
    tree: &mut SphereBvh,
    receivers: Receivers,
    photons: &Photons,
    alpha: f64,
    lists: &PixelLists,
    pixels: &mut Statistics,
) -> Found {
    match pixels {
        Statistics::Double(pixels) => fold::<_, Sum>(tree, receivers, photons, alpha, lists, pixels),
        Statistics::Single(pixels) => fold::<_, Sum>(tree, receivers, photons, alpha, lists, pixels),
        Statistics::Tested(pixels) => fold::<_, SumInParts>(tree, receivers, photons, alpha, lists, pixels),
    }
}

fn fold<S: Statistic, R: Record>(
    tree: &mut SphereBvh,
    receivers: Receivers,
    photons: &Photons,
    alpha: f64,
    lists: &PixelLists,
    pixels: &mut [S],
) -> Found {
    let mut records: Vec<R> = tree.radii().par_iter().map(|&radius| R::new(radius.into())).collect();
    let found = gather_into(tree, receivers, photons, alpha, &mut records);
    pixels.par_iter_mut().enumerate().for_each(|(pixel, state)| {
        let (mut sum, mut parts) = (PassSum::default(), PartSums::default());
        for seen in lists.of(pixel) {
            let record = &records[seen.position as usize];
            sum.flux += seen.factor.as_dvec3() * record.sum().flux;
            sum.accepted += record.sum().accepted;
            if S::WANTS_PARTS {
                parts.add_times(mean(seen.factor).into(), &record.parts());
            }
        }
        if sum.accepted > 0 {
            state.after_pass(&sum, &parts, alpha);
        }
    });
    found
}

/// What a hit point holds for its pixel until the pass is over.
trait Record: Gathers {
    fn sum(&self) -> PassSum;

    fn parts(&self) -> PartSums;
}

/// A hit point that only sums.
#[derive(Clone, Copy, Debug)]
struct Sum {
    radius: f64,
    sum: PassSum,
}

impl Gathers for Sum {
    const WANTS_PARTS: bool = false;

    fn new(radius: f64) -> Sum {
        Sum { radius, sum: PassSum::default() }
    }

    #[inline]
    fn radius(&self) -> f64 {
        self.radius
    }

    #[inline]
    fn after_pass(&mut self, pass: &PassSum, _: &PartSums, _: f64) {
        self.sum = *pass;
    }
}

impl Record for Sum {
    fn sum(&self) -> PassSum {
        self.sum
    }

    fn parts(&self) -> PartSums {
        PartSums::default()
    }
}

/// One that sums the parts of its disc, too.
#[derive(Clone, Copy, Debug)]
struct SumInParts {
    sum: Sum,
    parts: PartSums,
}

impl Gathers for SumInParts {
    const WANTS_PARTS: bool = true;

    fn new(radius: f64) -> SumInParts {
        SumInParts { sum: Sum::new(radius), parts: PartSums::default() }
    }

    #[inline]
    fn radius(&self) -> f64 {
        self.sum.radius
    }

    #[inline]
    fn after_pass(&mut self, pass: &PassSum, parts: &PartSums, alpha: f64) {
        self.sum.after_pass(pass, parts, alpha);
        self.parts = *parts;
    }
}

impl Record for SumInParts {
    fn sum(&self) -> PassSum {
        self.sum.sum
    }

    fn parts(&self) -> PartSums {
        self.parts
    }
}

#[cfg(test)]
mod tests {
    use super::super::photons::Deposits;
    use super::super::{Facets, HitPoint, Photon, Precision, RadiusPolicy, received};
    use super::*;
    use crate::bsdf::Coat;
    use crate::bvh::Sphere;
    use crate::math::{DVec3, Rgb, Rng, Stream, Vec3, warp};
    use crate::scene::Receiver;

    const PIXELS: usize = 40;

    fn hit_point(rng: &mut Rng) -> HitPoint {
        let p = Vec3::new(rng.next_f32(), 0.0, rng.next_f32());
        let receiver = Receiver { p, p_error: 0.0, ng: Vec3::Y, ns: Vec3::Y, coat: Coat::NONE };
        let weight = Rgb::new(rng.next_f32(), rng.next_f32(), 0.5);
        // The last pixel sees nothing.
        let pixel = (rng.next_f32() * (PIXELS - 1) as f32) as u32;
        HitPoint { receiver, reflectance: weight, pixel, footprint: 0.0 }
    }

    fn deposits(rng: &mut Rng) -> Deposits {
        let mut deposits = Deposits::default();
        for _ in 0..2000 {
            let wi = warp::square_to_uniform_sphere(rng.next_vec2());
            deposits.positions.push(Vec3::new(rng.next_f32(), 0.0, rng.next_f32()));
            deposits.photons.push(Photon { wi, ng: Vec3::Y, power: Rgb::new(rng.next_f32(), 1e-9, 3e4) });
        }
        deposits
    }

    /// Hit point by hit point and photon by photon.
    fn naive(
        hit_points: &[HitPoint],
        radius_of: impl Fn(usize) -> f32,
        photons: &Deposits,
        pixel: usize,
    ) -> PassSum {
        let (mut sum, radius) = (PassSum::default(), radius_of(pixel));
        for h in hit_points.iter().filter(|h| h.pixel as usize == pixel) {
            let sphere = Sphere { center: h.receiver.p, radius };
            for (p, photon) in photons.positions.iter().zip(&photons.photons) {
                if let Some(flux) = received(&h.receiver, photon).filter(|_| sphere.contains(*p)) {
                    sum.flux += h.reflectance.as_dvec3() * flux.as_dvec3();
                    sum.accepted += 1;
                }
            }
        }
        sum
    }

    /// Of two passes with other hit points, so that radii differ in the second.
    #[test]
    fn pixels_take_together_what_their_hit_points_find() {
        let mut rng = Rng::new(5, Stream::Test, 0, 0);
        let mut pixels = Statistics::new(PIXELS, 0.1, RadiusPolicy::HitPoint, Precision::Double);
        for _ in 0..2 {
            let before: Vec<_> = (0..PIXELS).map(|pixel| pixels.get(pixel)).collect();
            let hit_points: Vec<HitPoint> = (0..300).map(|_| hit_point(&mut rng)).collect();
            let radius_of = |pixel: usize| before[pixel].radius() as f32;
            let sphere = |h: &HitPoint| Sphere { center: h.receiver.p, radius: radius_of(h.pixel as usize) };
            let (mut tree, order) = SphereBvh::build(&hit_points.iter().map(sphere).collect::<Vec<_>>());
            let ordered: Vec<HitPoint> = order.iter().map(|&k| hit_points[k as usize]).collect();
            let lists = PixelLists::new(&ordered, PIXELS, |h| h.reflectance);
            let (deposits, facets) = (deposits(&mut rng), Facets::of(&ordered));
            let photons = Photons(vec![&deposits]);
            let found =
                gather_by_pixel(&mut tree, Receivers::Diffuse(&facets), &photons, 0.7, &lists, &mut pixels);
            let mut accepted = 0;
            for (pixel, before) in before.iter().enumerate() {
                let (mut expected, sum) = (*before, naive(&hit_points, radius_of, &deposits, pixel));
                expected.after_pass(&sum, 0.7);
                let state = pixels.get(pixel);
                assert_eq!(
                    (state.radius2, state.photons),
                    (expected.radius2, expected.photons),
                    "pixel {pixel}"
                );
                let difference = (state.flux - expected.flux).abs();
                assert!(
                    difference.cmple(1e-12 * expected.flux.abs() + DVec3::splat(1e-300)).all(),
                    "pixel {pixel}"
                );
                accepted += u64::from(sum.accepted);
            }
            assert_eq!(found.accepted, accepted);
            assert!(accepted > 5000 && pixels.get(PIXELS - 1).photons == 0.0, "{accepted}");
        }
    }
}
