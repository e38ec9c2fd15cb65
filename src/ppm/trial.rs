//! A trial of aiming and guiding: what variance and rays would be for any shares of such photons.

use super::course::Course;
use super::draws::Draws;
use super::emission::Guided;
use super::guiding::{self, Learned};
use super::mixture::{Mixture, PhotonBudget};
use super::photon_pass::{CHUNK, PhotonPass};
use super::photons::{PhotonBatch, PhotonChunk};
use super::trial_points::Points;
use super::{Guiding, Render};
use crate::effects::PathClass;
use crate::light::{Aim, Guide};

/// Photons of each kind in the trial.
const PHOTONS: u64 = 8 * CHUNK;

/// The number of the trial's pass, which no other pass has.
const PASS: u32 = u32::MAX;

/// The shares of aimed photons that are compared.
const SHARES: [f64; 8] =
    [0.0, 1.0 / 16.0, 1.0 / 8.0, 1.0 / 4.0, 1.0 / 2.0, 3.0 / 4.0, 7.0 / 8.0, 15.0 / 16.0];

/// The shares of guided photons among the others. No photon carries more than four times its natural power: the trial is too short for
/// the rare ones that guiding leaves behind.
const GUIDED: [f64; 3] = [1.0 / 4.0, 1.0 / 2.0, 3.0 / 4.0];

/// Where less than this is to be gained no photon is aimed: the trial may err by as much.
const LEAST_GAIN: f64 = 1.05;

/// The part of the trial's photons that are guided.
const SHARE: f64 = 0.5;

/// The sums over the photons of a trial that predict what any mix would do.
pub(super) struct Trial {
    caustic: Vec<Brought>,
    indirect: Vec<Brought>,
    natural_rays: f64,
    guided_rays: f64,
    aimed_rays: f64,
    /// Of the trial.
    pub rays: u64,
}

/// What a photon brings.
#[derive(Clone, Copy)]
struct Brought {
    /// The squares of what it brings to the picture at its natural power, over its density in the trial.
    squares: f64,
    /// Of the density of aimed photons, by that of natural ones.
    ratio: f64,
    /// Of guided ones.
    density: f64,
}

/// Parts of the photons.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mix {
    /// Those that are aimed.
    pub aimed: f64,
    /// Of the others, those that are guided.
    pub guided: f64,
}

impl Trial {
    /// Of natural photons, half of them guided where something was learned, and of as many aimed ones where there is something to
    /// aim at.
    pub fn new(render: &Render, aim: Option<&Aim>, learned: Option<&Learned>, points: &mut Points) -> Trial {
        let budget = PhotonBudget { natural: PHOTONS, aimed: PHOTONS };
        let mixture = aim.map(|aim| Mixture { aim: aim.clone(), budget });
        let guide = learned.map(|learned| Guide::new(learned.tree.clone(), SHARE));
        let guided = guide.as_ref().map(|guide| Guided { guide, photons: PHOTONS });
        let course = Course {
            mixture: mixture.as_ref(),
            guided,
            names_paths: guided.is_some(),
            ..Course::natural(render.stage(), &render.settings, PASS)
        };
        let mut pass = PhotonPass::default();
        let batch = pass.follow(&course, PHOTONS);
        points.relate(render, batch, PHOTONS);
        let caustic = brought(&course, batch, PathClass::Caustic, points);
        let indirect = match render.plan.classes.contains(PathClass::Indirect) {
            true => brought(&course, batch, PathClass::Indirect, points),
            false => Vec::new(),
        };
        let natural_rays = batch.ledger.rays as f64 / PHOTONS as f64;
        Trial {
            caustic,
            indirect,
            natural_rays: learned.map_or(natural_rays, |learned| learned.natural_rays),
            guided_rays: learned.map_or(natural_rays, |learned| learned.guided_rays),
            aimed_rays: batch.aimed.rays as f64 / PHOTONS as f64,
            rays: batch.ledger.rays + batch.aimed.rays,
        }
    }

    /// Variance times rays of a photon in all, up to a factor, with `N_g` photons of the density `q` and `N_a = ρ N_g` of the density
    /// `r`, in parts of the natural one: `Σ f² w² (1 / q + ρ r) / N_g` of caustics, with the weight `w = 1 / (1 + ρ r)`, and
    /// `Σ f² / (q N_g)` of indirect light.
    fn cost(&self, Mix { aimed, guided }: Mix) -> f64 {
        let natural = 1.0 - aimed;
        let lack = |b: &Brought| 1.0 / (1.0 - guided + guided * b.density);
        let caustic = |b: &Brought| {
            // Of the balance heuristic where no photon is guided.
            let all = natural + aimed * b.ratio;
            b.squares * (1.0 + (lack(b) - 1.0) * natural / all) / all
        };
        let caustic: f64 = self.caustic.iter().map(caustic).sum();
        let indirect: f64 = self.indirect.iter().map(|b| b.squares * lack(b)).sum();
        let rays = (1.0 - guided) * self.natural_rays + guided * self.guided_rays;
        (caustic + indirect / natural) * (natural * rays + aimed * self.aimed_rays)
    }

    /// The share of aimed photons with the least cost, and by how much that is less than without.
    pub fn best_share(&self) -> (f64, f64) {
        let cost = |aimed| self.cost(Mix { aimed, guided: 0.0 });
        let without = cost(0.0);
        let gains = SHARES.iter().map(|&share| (share, without / cost(share)));
        let best = gains.filter(|(_, gain)| gain.is_finite()).max_by(|a, b| a.1.total_cmp(&b.1));
        best.filter(|(_, gain)| *gain >= LEAST_GAIN).unwrap_or((0.0, 1.0))
    }

    /// The mix with the least cost, with so many aimed as were asked for, if they were, and by how much guiding lowers it.
    pub fn best_mix(&self, asked: Option<f64>, guiding: Guiding) -> (Mix, f64) {
        let aimed = asked.unwrap_or_else(|| self.best_share().0);
        let unguided = Mix { aimed, guided: 0.0 };
        let without = self.cost(unguided);
        let shares = match &asked {
            Some(share) => std::slice::from_ref(share),
            None => &SHARES,
        };
        let mixes = shares.iter().flat_map(|&aimed| GUIDED.map(|guided| Mix { aimed, guided }));
        let gains = mixes.map(|mix| (mix, without / self.cost(mix)));
        let best = gains.filter(|(_, gain)| gain.is_finite()).max_by(|a, b| a.1.total_cmp(&b.1));
        let pays = |gain| guiding == Guiding::On || gain >= guiding::LEAST_GAIN;
        match best {
            Some((mix, gain)) if pays(gain) => (mix, gain),
            Some((_, gain)) => (unguided, gain),
            None => (unguided, 1.0),
        }
    }

    /// By how much the aimed photons of a mix lower the cost; 1 where there are none.
    pub fn gain_of_aiming(&self, mix: Mix) -> f64 {
        if mix.aimed > 0.0 { self.cost(Mix { aimed: 0.0, ..mix }) / self.cost(mix) } else { 1.0 }
    }
}

/// What the photons of a kind bring.
fn brought(course: &Course, batch: &PhotonBatch, class: PathClass, points: &mut Points) -> Vec<Brought> {
    let squares = points.squares(&batch.of(class));
    let in_mixture = class == PathClass::Caustic && course.mixture.is_some();
    let ratios: Vec<f64> = match in_mixture {
        true => batch.chunks.iter().flat_map(|chunk| &chunk.ratios).map(|&ratio| ratio.into()).collect(),
        false => vec![0.0; squares.len()],
    };
    let chunks = batch.chunks.iter().zip(0..);
    let densities = chunks.flat_map(|(chunk, number)| densities(course, chunk, class, number));
    let each = squares.iter().zip(ratios).zip(densities);
    let brought = each.map(|((squares, ratio), density)| {
        // The photon's weight is 1 / (q (1 + r)), its density n q (1 + r).
        let q = 1.0 - SHARE + SHARE * density;
        Brought { squares: squares * q * (1.0 + ratio) / PHOTONS as f64, ratio, density }
    });
    brought.collect()
}

/// By how much likelier guiding makes the start of every photon of a kind in a chunk. What it is of an aimed photon is not known, so
/// that is left as likely: there natural photons are few beside the aimed.
fn densities(course: &Course, chunk: &PhotonChunk, class: PathClass, number: u64) -> Vec<f64> {
    let Some(deposits) = chunk.of(class) else { return Vec::new() };
    let Some(guided) = course.guided.filter(|_| !deposits.paths.is_empty()) else {
        return vec![1.0; deposits.photons.len()];
    };
    let draws = Draws { seed: course.settings.seed, pass: course.pass, first: number * CHUNK, segment: 0 };
    let density = |&path| guided.guide.tree().densities()[guided.cell_of(draws, path)];
    deposits.paths.iter().map(density).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trial(caustic: &[(f64, f64)], indirect: f64, aimed_rays: f64) -> Trial {
        let caustic =
            caustic.iter().map(|&(squares, ratio)| Brought { squares, ratio, density: 1.0 }).collect();
        let indirect = vec![Brought { squares: indirect, ratio: 0.0, density: 1.0 }];
        Trial { caustic, indirect, natural_rays: 4.0, guided_rays: 4.0, aimed_rays, rays: 0 }
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

    /// `caustic` photons of one ratio and density, or indirect light of one density: eight rays a guided photon, four a natural one.
    fn guided_trial(caustic: Option<(f64, f64)>, indirect: Option<f64>) -> Trial {
        let brought = |(ratio, density)| Brought { squares: 1.0, ratio, density };
        Trial {
            caustic: caustic.map(brought).into_iter().collect(),
            indirect: indirect.map(|density| brought((0.0, density))).into_iter().collect(),
            natural_rays: 4.0,
            guided_rays: 8.0,
            aimed_rays: 2.0,
            rays: 0,
        }
    }

    /// Of indirect light `(4 + 4 g) / (1 - g + g q)`; guided photons cost more and bring more.
    #[test]
    fn guiding_pays_by_what_is_left_of_the_variance() {
        let trial = guided_trial(None, Some(5.0));
        for guiding in [Guiding::Auto, Guiding::On] {
            let (mix, gain) = trial.best_mix(None, guiding);
            assert_eq!(mix, Mix { aimed: 0.0, guided: 0.75 });
            assert!((gain - 4.0 / 1.75).abs() < 1e-12, "{gain}");
        }
        let (mix, gain) = guided_trial(None, Some(1.0)).best_mix(None, Guiding::Auto);
        assert_eq!(mix, Mix { aimed: 0.0, guided: 0.0 });
        assert!((gain - 4.0 / 5.0).abs() < 1e-12, "{gain}");
        assert_eq!(trial.best_mix(Some(0.5), Guiding::On).0.aimed, 0.5);
        assert_eq!(
            guided_trial(None, None).best_mix(None, Guiding::On),
            (Mix { aimed: 0.0, guided: 0.0 }, 1.0)
        );
    }

    /// With half of the photons aimed, at ten times the density: `(1 / 5.5) (2 + 1)` instead of 4. With half of the others guided
    /// as well, `(1 - 2/3 · 1/11) / 5.5 · (3 + 1)` instead of 6/3.
    #[test]
    fn aiming_gains_what_it_takes_from_variance_and_rays() {
        let trial = guided_trial(Some((10.0, 5.0)), None);
        let gain = |aimed, guided| trial.gain_of_aiming(Mix { aimed, guided });
        assert!((gain(0.5, 0.0) - 4.0 * 5.5 / 3.0).abs() < 1e-12, "{}", gain(0.5, 0.0));
        let both = (1.0 - 2.0 / 33.0) / 5.5 * 4.0;
        assert!((gain(0.5, 0.5) - 2.0 / both).abs() < 1e-12, "{}", gain(0.5, 0.5));
        assert_eq!(gain(0.0, 0.5), 1.0);
    }
}
