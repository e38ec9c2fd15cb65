use serde::Serialize;

use crate::effects::Plan;
use crate::film::Image;
use crate::ppm::{PhaseSeconds, Render, Settings, SetupStatistics};
use crate::scene::Scene;

/// Seconds of a render, by what they are spent on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Seconds {
    /// Deriving the plan, and deciding how many photons are aimed.
    pub planning: f64,
    /// Tracing the eye paths and building trees over what they hit.
    pub eye_paths: f64,
    /// Shadow rays.
    pub direct_light: f64,
    /// Tracing photons.
    pub photons: f64,
    /// Adding them to what is seen.
    pub gathering: f64,
}

impl Seconds {
    /// All of them.
    pub fn total(&self) -> f64 {
        self.by_name().iter().map(|(_, seconds)| seconds).sum()
    }

    /// Each with what people call it.
    pub fn by_name(&self) -> [(&'static str, f64); 5] {
        let Seconds { planning, eye_paths, direct_light, photons, gathering } = *self;
        [
            ("planning", planning),
            ("eye paths", eye_paths),
            ("shadow rays", direct_light),
            ("tracing photons", photons),
            ("gathering photons", gathering),
        ]
    }

    fn of_setup(setup: &SetupStatistics) -> Seconds {
        Seconds {
            planning: setup.plan_seconds + setup.aim_seconds,
            eye_paths: setup.eye_seconds + setup.tree_seconds,
            direct_light: setup.direct_seconds,
            ..Seconds::default()
        }
    }

    /// With a pass more.
    fn plus(self, phases: &PhaseSeconds) -> Seconds {
        Seconds {
            eye_paths: self.eye_paths + phases.eye,
            direct_light: self.direct_light + phases.direct,
            photons: self.photons + phases.trace,
            gathering: self.gathering + phases.gather,
            ..self
        }
    }
}

/// Renders so many passes, or fewer if the picture is finished before.
pub fn measured(scene: &Scene, settings: Settings, passes: u32) -> Seconds {
    rendered(scene, settings, passes).0
}

/// The same, and the picture.
pub(super) fn rendered(scene: &Scene, settings: Settings, passes: u32) -> (Seconds, Image) {
    let mut render = Render::new(scene, settings);
    let mut seconds = Seconds::of_setup(render.setup());
    while render.passes() < passes && !render.is_finished() {
        seconds = seconds.plus(&render.pass().phases);
    }
    (seconds, render.picture())
}

/// What so many passes are going to take: the set-up as it is, and passes in proportion to their photons, from two small ones.
/// With it the plan that they go by.
///
/// Gathering becomes cheaper as radii shrink, by how much a third small pass in discs of half the area tells; radii are taken to
/// shrink as [`crate::ppm::RadiusPolicy::expected_areas`] has it.
pub fn predicted(scene: &Scene, settings: Settings, passes: u32) -> (Seconds, Plan) {
    let photons = settings.photons;
    let few = (photons / 64).clamp(FEWEST.min(photons), photons);
    let more = few.saturating_mul(4).min(photons);
    let probe = |photons| {
        let mut render = Render::new(scene, Settings { photons, ..settings });
        let first = render.pass().phases;
        // Eye paths and lights are sampled anew from the second pass on.
        let PhaseSeconds { eye, direct, .. } = render.pass().phases;
        (PhaseSeconds { eye, direct, ..first }, render)
    };
    let ((a, _), (b, render)) = (probe(few), probe(more));
    let (seconds, plan) = (Seconds::of_setup(render.setup()), render.plan().clone());
    if render.is_finished() || passes == 0 {
        return (seconds, plan);
    }
    let smaller = Some(render.setup().radius * 0.5f64.sqrt());
    let half =
        Render::new(scene, Settings { photons: more, radius: smaller, ..settings }).pass().phases.gather;
    let line = |a: f64, b: f64| extrapolated([(few, a), (more, b)], photons);
    let areas = settings.policy.expected_areas(settings.alpha).take(passes as usize);
    let shrunk = cost_of_areas(if b.gather > 0.0 { half / b.gather } else { 1.0 }, areas);
    let (all, later) = (f64::from(passes), f64::from(passes - 1));
    let phases = PhaseSeconds {
        eye: later * b.eye,
        direct: later * b.direct,
        trace: all * line(a.trace, b.trace),
        gather: shrunk * line(a.gather, b.gather),
        errors: 0.0,
    };
    (seconds.plus(&phases), plan)
}

/// Photons of the smaller probe: fewer would tell of threads that start up.
const FEWEST: u64 = 4096;

/// On the line through two measurements, or through the larger one and the origin where they are alike or the wrong way
/// round.
fn extrapolated([(few, a), (more, b)]: [(u64, f64); 2], photons: u64) -> f64 {
    let [few, more, photons] = [few, more, photons].map(|n| n as f64);
    let slope = if more > few && b > a { (b - a) / (more - few) } else { 0.0 };
    b + slope.min(b / more) * (photons - more)
}

/// What passes in discs of such areas cost in units of one of area 1, on the line through that and the cost of one of area 1/2: part of a
/// pass goes with the photons in the discs, and part is the walk to them.
fn cost_of_areas(half: f64, areas: impl Iterator<Item = f64>) -> f64 {
    let share = (2.0 * (1.0 - half)).clamp(0.0, 1.0);
    areas.map(|area| 1.0 - share + share * area).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ppm::RadiusPolicy;

    #[test]
    fn extrapolation_follows_the_line_and_never_falls() {
        let at = |measurements, photons| extrapolated(measurements, photons);
        assert!((at([(10, 1.2), (40, 1.8)], 100) - 3.0).abs() < 1e-12, "1 + 0.02 n");
        assert_eq!(at([(10, 2.0), (40, 1.8)], 100), 1.8, "the wrong way round");
        assert_eq!(at([(7, 1.0), (7, 1.0)], 7), 1.0);
        assert_eq!(at([(10, 0.0), (40, 4.0)], 100), 10.0, "no more than in proportion");
    }

    /// Gathering that goes with the area costs what the radii of the schedule say; one that does not, as many passes.
    #[test]
    fn gathering_follows_the_radii() {
        let cost = |half, policy: RadiusPolicy| cost_of_areas(half, policy.expected_areas(0.5).take(3));
        assert!((cost(0.5, RadiusPolicy::Shared) - (1.0 + 0.75 + 0.625)).abs() < 1e-12);
        assert!(
            (cost(0.75, RadiusPolicy::Shared) - 0.5 * (3.0 + 2.375)).abs() < 1e-12,
            "half goes with the area"
        );
        assert_eq!((cost(1.0, RadiusPolicy::Shared), cost(1.2, RadiusPolicy::Shared)), (3.0, 3.0));
        assert_eq!((cost(0.5, RadiusPolicy::Fixed), cost(0.1, RadiusPolicy::HitPoint)), (3.0, 1.875));
    }

    #[test]
    fn a_pass_more_adds_its_phases() {
        let phases = PhaseSeconds { eye: 0.5, direct: 1.0, trace: 2.0, gather: 3.0, errors: 4.0 };
        let seconds = Seconds { planning: 10.0, ..Seconds::default() }.plus(&phases);
        assert_eq!((seconds.total(), seconds.gathering), (16.5, 3.0));
        assert_eq!(seconds.by_name()[1], ("eye paths", 0.5));
    }
}
