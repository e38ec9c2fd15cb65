use std::fmt;

use serde::Serialize;

use super::decision::{Decision, DroppedLight};
use super::facts::Facts;
use super::reach::Reach;
use super::rules;
use super::surfaces::Surfaces;
use super::{Effect, PathClass, PathClasses};
use crate::scene::Scene;

/// Whether eye paths stay.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum EyePaths {
    /// They are traced once, and hit points keep statistics of their own: no eye ray is traced twice, but the picture tends to what
    /// those few paths of a pixel see.
    ///
    /// # Source
    /// Hachisuka, Ogaki and Jensen, "Progressive Photon Mapping", SIGGRAPH Asia 2008.
    Fixed,
    /// Every pass traces others, and pixels keep statistics of all that they see: the picture tends to the mean over filter and
    /// lens.
    ///
    /// # Source
    /// Hachisuka and Jensen, "Stochastic Progressive Photon Mapping", SIGGRAPH Asia 2009.
    Retraced,
}

impl fmt::Display for EyePaths {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            EyePaths::Fixed => "fixed",
            EyePaths::Retraced => "retraced",
        })
    }
}

/// What a render of a scene simulates.
///
/// Everything that is left out brings no light of the scene to the picture, or was not asked for: each rule of this module comes
/// with its proof. What gets through a wall all the same is an error, and goes, too: photons from behind it as long as discs are
/// so large that they reach there, and rays that slip through by rounding.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Plan {
    /// The kinds of paths.
    pub classes: PathClasses,
    /// Whether eye paths stay.
    pub eye_paths: EyePaths,
    /// Whether there are photon passes.
    pub photons: bool,
    /// Whether any path of light or from the eye may be refracted.
    pub refraction: bool,
    /// Whether any path of light or from the eye may meet a surface that mirrors or refracts.
    pub casters: bool,
    /// Whether caustics are collected on rough surfaces.
    pub glints: bool,
    /// Whether light reaches a specular surface, so that photons aimed at such could help.
    pub can_aim: bool,
    /// Whether photons guided to what is seen could help.
    pub can_guide: bool,
    /// Lights that are left out.
    pub dropped_lights: Vec<DroppedLight>,
    /// Every decision with its reason.
    pub decisions: Vec<Decision>,
    /// The numbers of all dropped lights, increasing.
    #[serde(skip)]
    dropped_numbers: Vec<u32>,
}

impl Plan {
    /// What a scene calls for of the kinds of paths that are `asked` for.
    ///
    /// `O(n log n)` for `n` triangles; a million take some tenths of a second.
    pub fn of(scene: &Scene, asked: PathClasses) -> Plan {
        let surfaces = Surfaces::of(scene);
        let reach = Reach::of(&surfaces);
        let facts = Facts::of(scene, &reach, asked);
        Plan::by(&facts, rules::dropped_lights(scene, &reach))
    }

    /// Everything that is `asked` for, whether the scene calls for it or not: the plan that others are held against.
    pub fn everything(scene: &Scene, asked: PathClasses) -> Plan {
        Plan::by(&Facts::everything(scene, asked), Vec::new())
    }

    fn by(facts: &Facts, dropped_lights: Vec<DroppedLight>) -> Plan {
        let mut decisions = rules::effects(facts);
        let paths = PathClass::ALL.map(|class| rules::paths(facts, class));
        let classes = PathClass::ALL.into_iter().zip(&paths).filter(|(_, verdict)| verdict.is_ok());
        let classes: PathClasses = classes.map(|(class, _)| class).collect();
        decisions.extend(
            PathClass::ALL.into_iter().zip(paths).map(|(class, v)| Decision::of(light_name(class), v)),
        );
        let mut decide = |what: &str, verdict| {
            let decision = Decision::of(what, verdict);
            let on = decision.on;
            decisions.push(decision);
            on
        };
        let photons = decide(PHOTONS, rules::photons(facts, classes));
        let glints = decide(GLINTS, rules::glints(facts));
        let refraction = decide("refraction", rules::refraction(facts));
        let can_aim = decide(AIMING, rules::aiming(facts, classes));
        let can_guide = decide(GUIDING, rules::guiding(facts, classes));
        let retraced = decide(RETRACING, rules::retracing(facts));
        let eye_paths = if retraced { EyePaths::Retraced } else { EyePaths::Fixed };
        let casters = rules::casters(facts).is_ok();
        let mut dropped_numbers: Vec<u32> =
            dropped_lights.iter().flat_map(|dropped| dropped.numbers.iter().copied()).collect();
        dropped_numbers.sort_unstable();
        Plan {
            classes,
            eye_paths,
            photons,
            refraction,
            casters,
            glints,
            can_aim,
            can_guide,
            dropped_lights,
            decisions,
            dropped_numbers,
        }
    }

    /// Whether an effect is simulated.
    pub fn simulates(&self, effect: Effect) -> bool {
        self.decisions.iter().any(|decision| decision.on && decision.what == effect.name())
    }

    /// Whether a light is part of the render, by its number in the order of [`crate::light::Lights::iter`].
    pub fn keeps_light(&self, number: u32) -> bool {
        self.dropped_numbers.binary_search(&number).is_err()
    }

    /// The same with eye paths as they were asked for, if they were.
    #[must_use]
    pub fn with_eye_paths(mut self, asked: Option<EyePaths>) -> Plan {
        let Some(asked) = asked else { return self };
        self.eye_paths = asked;
        for decision in self.decisions.iter_mut().filter(|decision| decision.what == RETRACING) {
            decision.on = asked == EyePaths::Retraced;
            decision.because = "asked for".into();
        }
        self
    }

    /// Notes what a trial of guiding photons found: whether they are, and why.
    pub fn tell_of_guiding(&mut self, guided: bool, because: String) {
        if let Some(decision) = self.decisions.iter_mut().find(|decision| decision.what == GUIDING) {
            (decision.on, decision.because) = (guided, because);
        }
    }

    /// What is left after an eye pass that left so many hit points: without any, lamps that are seen and nothing more, so that the
    /// picture is finished.
    ///
    /// Proof: light is collected at hit points alone, so each sum over them is empty and stays so. Eye paths that are traced
    /// anew may find some later, so there nothing changes.
    #[must_use]
    pub fn finish_if_blind(mut self, hit_points: u64) -> Plan {
        if hit_points > 0 || self.eye_paths == EyePaths::Retraced {
            return self;
        }
        self.classes = self.classes.and([PathClass::Direct].into_iter().collect());
        (self.photons, self.glints, self.can_aim, self.can_guide) = (false, false, false, false);
        let by_photons = [
            PHOTONS,
            GLINTS,
            AIMING,
            GUIDING,
            light_name(PathClass::Caustic),
            light_name(PathClass::Indirect),
        ];
        for decision in self.decisions.iter_mut().filter(|d| d.on && by_photons.contains(&d.what.as_str())) {
            decision.on = false;
            decision.because = "the eye paths found no surface that reflects diffusely".into();
        }
        self
    }
}

const GLINTS: &str = "caustics on rough surfaces";
const RETRACING: &str = "eye paths anew in each pass";
const PHOTONS: &str = "photon passes";
const AIMING: &str = "aimed photons";
const GUIDING: &str = "guided photons";

fn light_name(class: PathClass) -> &'static str {
    match class {
        PathClass::Direct => "direct light",
        PathClass::Caustic => "caustics",
        PathClass::Indirect => "indirect light",
    }
}

impl Decision {
    pub(super) fn of(what: &str, verdict: Result<String, String>) -> Decision {
        let on = verdict.is_ok();
        let (Ok(because) | Err(because)) = verdict;
        Decision { what: what.into(), on, because }
    }
}

/// In columns: what, on or off, because of what.
impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let width = self.decisions.iter().map(|decision| decision.what.len()).max().unwrap_or(0);
        for Decision { what, on, because } in &self.decisions {
            writeln!(f, "{what:<width$}  {}  {because}", if *on { "on " } else { "off" })?;
        }
        const SHOWN: usize = 8;
        for DroppedLight { light, because, .. } in self.dropped_lights.iter().take(SHOWN) {
            writeln!(f, "{:<width$}  off  {light} {because}", "a light")?;
        }
        match self.dropped_lights.len().saturating_sub(SHOWN) {
            0 => Ok(()),
            more => writeln!(f, "{:<width$}  off  and {more} more", "lights"),
        }
    }
}
