//! How many photons to aim, and how many to guide: decided before the first pass.

use serde::Serialize;

use super::guiding::{self, GuidePlan, Learned};
use super::mixture::{Mixture, PhotonBudget};
use super::trial::Trial;
use super::trial_points::Points;
use super::{Aiming, Guiding, Render};
use crate::light::{Aim, Guide};

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

/// The photons of every pass, and how that was decided.
#[derive(Default)]
pub(super) struct Decided {
    /// Where some are aimed.
    pub mixture: Option<Mixture>,
    /// Nothing where there is nothing to aim at, or where aiming provably changes nothing: all lights lie in all balls.
    pub aim: Option<AimPlan>,
    /// Where the others are guided.
    pub guide: Option<Guide>,
    /// Nothing where that was not tried.
    pub guiding: Option<GuidePlan>,
}

/// Whether photons are aimed and whether they are guided, by a trial where either could help.
pub(super) fn decide(render: &Render) -> Decided {
    if render.hit_points.is_empty() || render.lights.is_empty() {
        return Decided::default();
    }
    let aim = targets(render);
    let may_guide = render.settings.guiding != Guiding::Off && render.plan.can_guide;
    if aim.is_none() && !may_guide {
        return Decided::default();
    }
    let mut points = Points::new(render);
    let learned = may_guide.then(|| guiding::learn(render, &points));
    match learned {
        Some(Ok(learned)) => guided(render, aim, learned, &mut points),
        Some(Err(plan)) => Decided { guiding: Some(plan), ..unguided(render, aim, &mut points) },
        None => unguided(render, aim, &mut points),
    }
}

/// What there is to aim at.
fn targets(render: &Render) -> Option<Aim> {
    let aiming = render.settings.caustic_photons;
    if aiming == Aiming::Photons(0) || !render.plan.can_aim {
        return None;
    }
    let aim = Aim::new(&render.lights, &render.scene.casters());
    aim.filter(|aim| aiming != Aiming::Auto || !aim.is_natural())
}

fn unguided(render: &Render, aim: Option<Aim>, points: &mut Points) -> Decided {
    let Some(aim) = aim else { return Decided::default() };
    match render.settings.caustic_photons {
        Aiming::Photons(_) => aimed(render, aim, 0.0, None, 0),
        Aiming::Auto => {
            let trial = Trial::new(render, Some(&aim), None, points);
            let (share, gain) = trial.best_share();
            aimed(render, aim, share, Some(gain), trial.rays)
        }
    }
}

fn guided(render: &Render, aim: Option<Aim>, learned: Learned, points: &mut Points) -> Decided {
    let trial = Trial::new(render, aim.as_ref(), Some(&learned), points);
    let photons = render.settings.photons;
    let asked = match render.settings.caustic_photons {
        Aiming::Photons(aimed) if aim.is_some() => {
            Some(PhotonBudget::of(photons, aimed).aimed as f64 / photons.max(1) as f64)
        }
        Aiming::Photons(_) => Some(0.0),
        Aiming::Auto => None,
    };
    let (mix, gain) = trial.best_mix(asked, render.settings.guiding);
    let plan = GuidePlan { share: mix.guided, gain, rays: learned.plan.rays + trial.rays, ..learned.plan };
    let guide = (mix.guided > 0.0).then(|| Guide::new(learned.tree, mix.guided));
    let aiming_gain = asked.is_none().then(|| trial.gain_of_aiming(mix));
    let aimed = aim.map(|aim| aimed(render, aim, mix.aimed, aiming_gain, trial.rays));
    Decided { guide, guiding: Some(plan), ..aimed.unwrap_or_default() }
}

/// So many photons are aimed as were asked for, or the part `share` of all.
fn aimed(render: &Render, aim: Aim, share: f64, gain: Option<f64>, rays: u64) -> Decided {
    let photons = render.settings.photons;
    let budget = match render.settings.caustic_photons {
        Aiming::Photons(aimed) => PhotonBudget::of(photons, aimed),
        Aiming::Auto => PhotonBudget::of(photons, (share * photons as f64).round() as u64),
    };
    let plan = AimPlan { balls: aim.balls(), budget, gain, rays };
    let mixture = (budget.aimed > 0).then_some(Mixture { aim, budget });
    Decided { mixture, aim: Some(plan), ..Decided::default() }
}
