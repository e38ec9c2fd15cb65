//! How many photons to aim: a trial before the first pass.

use std::f64::consts::PI;

use rayon::prelude::*;
use serde::Serialize;

use super::mixture::{Mixture, PhotonBudget};
use super::photon_pass::{PhotonBatch, PhotonPass, Photons};
use super::{Aiming, HitPoint, Render, Settings, pixels, received};
use crate::bvh::{Sphere, SphereBvh};
use crate::effects::PathClass;
use crate::light::Aim;
use crate::math::{Rgb, mean};
use crate::scene::Receiver;

/// Photons of each kind in the trial.
const PHOTONS: u64 = 8192;

/// The number of the trial's pass, which no other pass has.
const PASS: u32 = u32::MAX;

/// The shares of aimed photons that are compared.
const SHARES: [f64; 8] =
    [0.0, 1.0 / 16.0, 1.0 / 8.0, 1.0 / 4.0, 1.0 / 2.0, 3.0 / 4.0, 7.0 / 8.0, 15.0 / 16.0];

/// Where less than this is to be gained no photon is aimed: the trial may err by as much.
const LEAST_GAIN: f64 = 1.05;

/// So many hit points stand for all in the trial, about.
const POINTS: usize = 1 << 14;

/// So many photons should be found by some hit point, else the discs of the trial are widened...
const FOUND: usize = 256;

/// ... up to so many times the radius.
const WIDEST: f32 = 8.0;

/// What the set-up decided about aimed photons.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AimPlan {
    /// Balls around the casters of caustics that there are to aim at.
    pub balls: usize,
    /// The photons of every pass.
    pub budget: PhotonBudget,
    /// By how much aiming lowers variance times rays, as the trial has it; 1 where none are aimed, nothing without a trial.
    pub gain: Option<f64>,
    /// Rays of the trial.
    pub rays: u64,
}

/// The photons of every pass, where some are aimed, and how that was decided; nothing where there is nothing to aim at, or
/// where aiming provably changes nothing: all lights lie in all balls.
pub(super) fn decide(render: &Render) -> (Option<Mixture>, Option<AimPlan>) {
    let Settings { photons, caustic_photons, .. } = render.settings;
    let auto = caustic_photons == Aiming::Auto;
    if caustic_photons == Aiming::Photons(0) || !render.plan.can_aim || render.hit_points.is_empty() {
        return (None, None);
    }
    let aim = Aim::new(&render.lights, &render.scene.casters());
    let Some(aim) = aim.filter(|aim| !(auto && aim.is_natural())) else { return (None, None) };
    let plan = match caustic_photons {
        Aiming::Photons(aimed) => {
            AimPlan { balls: aim.balls(), budget: PhotonBudget::of(photons, aimed), gain: None, rays: 0 }
        }
        Aiming::Auto => {
            let trial = Trial::new(render, &aim);
            let (share, gain) = trial.best_share();
            let budget = PhotonBudget::of(photons, (share * photons as f64).round() as u64);
            AimPlan { balls: aim.balls(), budget, gain: Some(gain), rays: trial.rays }
        }
    };
    let mixture = (plan.budget.aimed > 0).then_some(Mixture { aim, budget: plan.budget });
    (mixture, Some(plan))
}

/// The sums over the photons of a trial that predict what shares of aimed photons would do.
struct Trial {
    caustic: Vec<Caustic>,
    /// Variance of indirect light times natural photons, of one photon in all.
    indirect: f64,
    natural_rays: f64,
    aimed_rays: f64,
    rays: u64,
}

/// A caustic photon.
#[derive(Clone, Copy)]
struct Caustic {
    /// The squares of what it brings to the picture at its natural power, over its density in the trial.
    squares: f64,
    ratio: f64,
}

impl Trial {
    fn new(render: &Render, aim: &Aim) -> Trial {
        let mixture = Mixture { aim: aim.clone(), budget: PhotonBudget { natural: PHOTONS, aimed: PHOTONS } };
        let mut pass = PhotonPass::default();
        let batch = pass.trace_mixed(render.stage(), &render.settings, PASS, Some(&mixture));
        let mut points = Points::new(render);
        points.relate(render, batch);
        let n = PHOTONS as f64;
        let squares = points.squares(&batch.of(PathClass::Caustic));
        let ratios = batch.chunks.iter().flat_map(|chunk| &chunk.ratios);
        let caustic = squares.iter().zip(ratios).map(|(squares, &ratio)| {
            let ratio = f64::from(ratio);
            // The photon's weight is 1 / (1 + r), its density n (1 + r).
            Caustic { squares: squares * (1.0 + ratio) / n, ratio }
        });
        let indirect = match render.plan.classes.contains(PathClass::Indirect) {
            true => points.squares(&batch.of(PathClass::Indirect)).iter().sum::<f64>() / n,
            false => 0.0,
        };
        Trial {
            caustic: caustic.collect(),
            indirect,
            natural_rays: batch.ledger.rays as f64 / n,
            aimed_rays: batch.aimed.rays as f64 / n,
            rays: batch.ledger.rays + batch.aimed.rays,
        }
    }

    /// Variance times rays of a photon in all, up to a factor: `Σ f² / (N_g + N_a r)` of caustics and `Σ f² / N_g` of indirect
    /// light.
    fn cost(&self, share: f64) -> f64 {
        let natural = 1.0 - share;
        let caustic: f64 = self.caustic.iter().map(|c| c.squares / (natural + share * c.ratio)).sum();
        (caustic + self.indirect / natural) * (natural * self.natural_rays + share * self.aimed_rays)
    }

    /// The share of aimed photons with the least cost, and by how much that is less than without.
    fn best_share(&self) -> (f64, f64) {
        let without = self.cost(0.0);
        let gains = SHARES.iter().map(|&share| (share, without / self.cost(share)));
        let best = gains.filter(|(_, gain)| gain.is_finite()).max_by(|a, b| a.1.total_cmp(&b.1));
        best.filter(|(_, gain)| *gain >= LEAST_GAIN).unwrap_or((0.0, 1.0))
    }
}

/// Some of the hit points, each for as many of its neighbours.
struct Points {
    points: Vec<Point>,
    tree: SphereBvh,
    radius: f32,
    each_for: usize,
}

#[derive(Clone, Copy)]
struct Point {
    receiver: Receiver,
    pixel: u32,
    /// From irradiance to the radiance of its pixel; once related to the picture, in parts of that.
    factor: Rgb,
}

impl Points {
    fn new(render: &Render) -> Points {
        let each_for = render.hit_points.len().div_ceil(POINTS);
        // As many hit points are around a photon as would be.
        let radius = render.setup.radius as f32 * (each_for as f32).sqrt();
        let point = |h: &HitPoint| Point { receiver: h.receiver, pixel: h.pixel, factor: h.reflectance };
        let points: Vec<Point> = render.hit_points.iter().step_by(each_for).map(point).collect();
        let spheres: Vec<Sphere> =
            points.iter().map(|point| Sphere { center: point.receiver.p, radius }).collect();
        let (tree, order) = SphereBvh::build(&spheres);
        let points = order.iter().map(|&k| points[k as usize]).collect();
        Points { points, tree, radius, each_for }
    }

    /// Divides all factors by the radiance of the pixel without photons and the mean one of the picture, as far as the trial
    /// knows it.
    fn relate(&mut self, render: &Render, batch: &PhotonBatch) {
        let classes = [PathClass::Caustic, PathClass::Indirect].map(|class| batch.of(class));
        let by_photons: f64 = classes.iter().flat_map(|photons| self.each(photons, |x| x)).sum();
        let disc = PI * f64::from(self.radius).powi(2);
        let lists = render.pixel_lists();
        let pixels = (0..pixels(render.scene)).into_par_iter();
        let without: Vec<f32> =
            pixels.map(|pixel| mean(render.direct.radiance(lists, pixel).as_vec3())).collect();
        let direct: f64 = without.iter().map(|&radiance| f64::from(radiance)).sum();
        let all = self.each_for as f64 * by_photons / (disc * PHOTONS as f64) + direct;
        let mean = (all / without.len() as f64) as f32;
        for point in &mut self.points {
            point.factor /= without[point.pixel as usize] + mean;
        }
    }

    /// For every photon the sum of the squares of what it brings to pixels. Discs are widened where few photons are found: by
    /// photons around them, which are about as many and as bright.
    fn squares(&mut self, photons: &Photons) -> Vec<f64> {
        let mut widening = 1.0;
        loop {
            let radius = widening * self.radius;
            self.tree.refit(|_| radius);
            let squares = self.each(photons, |x| x * x);
            let found = squares.iter().filter(|&&square| square > 0.0).count();
            if found >= FOUND || widening >= WIDEST {
                let disc = PI * f64::from(radius).powi(2);
                return squares.iter().map(|square| square / disc).collect();
            }
            widening *= 2.0;
        }
    }

    /// For every photon the sum over the hit points that gather it of `of` the flux that it brings.
    fn each(&self, photons: &Photons, of: impl Fn(f64) -> f64 + Sync) -> Vec<f64> {
        let positions = photons.positions().concat();
        let photons: Vec<_> = photons.iter().collect();
        let sum = |(&position, photon)| {
            let mut sum = 0.0;
            self.tree.for_each_containing(position, |place| {
                let Point { receiver, factor, .. } = &self.points[place];
                let flux = received(receiver, photon).unwrap_or(Rgb::ZERO);
                sum += of(f64::from(mean(*factor * flux)));
            });
            sum
        };
        positions.par_iter().zip(photons).map(sum).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trial(caustic: &[(f64, f64)], indirect: f64, aimed_rays: f64) -> Trial {
        let caustic = caustic.iter().map(|&(squares, ratio)| Caustic { squares, ratio }).collect();
        Trial { caustic, indirect, natural_rays: 4.0, aimed_rays, rays: 0 }
    }

    #[test]
    fn nothing_is_aimed_for_nothing() {
        for nothing in [
            trial(&[], 0.0, 2.0),
            trial(&[], 1.0, 2.0),
            // As likely by nature, or less so by aiming.
            trial(&[(1.0, 1.0)], 1.0, 4.0),
            trial(&[(1.0, 0.1)], 0.0, 4.0),
        ] {
            assert_eq!(nothing.best_share(), (0.0, 1.0));
        }
    }

    /// With as many rays for either kind `V / (1 - s) + 1 / (1 - s + s r)`: the less indirect light matters the more are aimed.
    #[test]
    fn the_rarer_caustics_are_the_more_photons_are_aimed() {
        assert_eq!(trial(&[(1.0, 1e6)], 0.0, 4.0).best_share().0, 15.0 / 16.0);
        assert_eq!(trial(&[(1.0, 100.0)], 1.0, 4.0).best_share().0, 1.0 / 16.0);
        assert_eq!(trial(&[(1.0, 10.0)], 1.0, 4.0).best_share().0, 1.0 / 8.0);
        assert_eq!(trial(&[(10.0, 10.0)], 1.0, 4.0).best_share().0, 1.0 / 2.0);
        let (_, gain) = trial(&[(1.0, 1e6)], 0.0, 4.0).best_share();
        assert!((gain / (1e6 * 15.0 / 16.0) - 1.0).abs() < 1e-3);
    }
}
