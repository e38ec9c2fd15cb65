//! The rules by which a plan leaves things out, each with the proof that nothing of the picture goes with them.
//!
//! Every path that the renderer finds leads from a light over surfaces to the eye, and all of it lies on one side of every
//! barrier. So it needs a light, a receiver and, by its kind, casters that the camera and one another can reach; what
//! [`Reach`] tells of each is necessary for such a path, and where it is known not to hold there is none.

use super::plan::{Decision, DroppedLight};
use super::reach::{Reach, Verdict, Wanted};
use super::{Effect, EffectSet, PathClass, PathClasses, declare};
use crate::scene::{Item, Scene};

const RECEIVER: Wanted =
    Wanted { effects: &[Effect::Diffuse], absent: "no surface reflects diffusely, so none shows light" };
const CASTER: Wanted = Wanted {
    effects: &[Effect::SpecularReflection, Effect::SpecularTransmission],
    absent: "no surface mirrors or refracts",
};
const MIRROR: Wanted = Wanted { effects: &[Effect::SpecularReflection], absent: "no surface mirrors" };
const GLASS: Wanted = Wanted { effects: &[Effect::SpecularTransmission], absent: "no surface refracts" };
const LAMP: Wanted = Wanted { effects: &[Effect::Emission], absent: "no surface shines" };

/// What the rules go by: for each thing what calls for it, or why it contributes nothing.
pub(super) struct Facts {
    asked: PathClasses,
    /// Some light with power.
    light: Verdict,
    points: Verdict,
    areas: Verdict,
    /// A receiver that is seen and lit.
    receiver: Verdict,
    /// A receiver that is seen.
    seen_receiver: Verdict,
    /// A caster that light reaches.
    caster: Verdict,
    mirror: Verdict,
    glass: Verdict,
    lamp: Verdict,
    lens: Verdict,
    filter: Verdict,
}

impl Facts {
    pub fn of(scene: &Scene, reach: &Reach, asked: PathClasses) -> Facts {
        let no_light = "no light has power";
        Facts {
            asked,
            light: reach.light(&[Effect::DeltaLight, Effect::AreaLight], no_light),
            points: reach.light(&[Effect::DeltaLight], "no point light has power"),
            areas: reach.light(&[Effect::AreaLight], "no surface that shines has power"),
            receiver: reach.lit(RECEIVER),
            seen_receiver: reach.seen(RECEIVER),
            caster: reach.lit(CASTER),
            mirror: reach.reached(MIRROR),
            glass: reach.reached(GLASS),
            lamp: reach.seen(LAMP),
            lens: lens(scene),
            filter: filter(scene),
        }
    }

    pub fn everything(scene: &Scene, asked: PathClasses) -> Facts {
        let on = || Ok("all is on, whether the scene calls for it or not".to_owned());
        Facts {
            asked,
            light: on(),
            points: on(),
            areas: on(),
            receiver: on(),
            seen_receiver: on(),
            caster: on(),
            mirror: on(),
            glass: on(),
            lamp: on(),
            lens: lens(scene),
            filter: filter(scene),
        }
    }
}

/// A pinhole sees along one ray what a lens sees along many.
fn lens(scene: &Scene) -> Verdict {
    let needs = declare::of_camera(scene.view());
    called_for(needs, Effect::Lens, scene.describe(Item::Camera), "is a pinhole")
}

/// The mean over fixed samples needs no weights.
fn filter(scene: &Scene) -> Verdict {
    let needs = declare::of_film(&scene.film());
    called_for(
        needs,
        Effect::AreaFilter,
        scene.describe(Item::Film),
        "takes the mean over the samples of a pixel",
    )
}

fn called_for(needs: EffectSet, effect: Effect, item: String, otherwise: &str) -> Verdict {
    if needs.contains(effect) { Ok(item) } else { Err(format!("{item} {otherwise}")) }
}

/// What each effect is because of.
pub(super) fn effects(facts: &Facts) -> Vec<Decision> {
    let verdict = |effect| match effect {
        Effect::Diffuse => &facts.seen_receiver,
        Effect::SpecularReflection => &facts.mirror,
        Effect::SpecularTransmission => &facts.glass,
        Effect::Emission => &facts.lamp,
        Effect::DeltaLight => &facts.points,
        Effect::AreaLight => &facts.areas,
        Effect::Lens => &facts.lens,
        Effect::AreaFilter => &facts.filter,
    };
    Effect::ALL.map(|effect| Decision::of(effect.name(), verdict(effect).clone())).into()
}

/// Whether paths of a kind bring any light.
///
/// Proof: each begins at a light of power (else all its samples are zero) and ends at a receiver, the `D` before the eye (else
/// there is no hit point and no photon is stored). `L S+ D` holds a specular event at some caster between the two, on their
/// side of every barrier; where no caster is, there is none. `L S* D (S | D)* D` holds no other surface than receivers for
/// certain, which may be one and the same.
pub(super) fn paths(facts: &Facts, class: PathClass) -> Verdict {
    if !facts.asked.contains(class) {
        return Err("not asked for".into());
    }
    facts.light.clone()?;
    let receiver = facts.receiver.clone()?;
    match class {
        PathClass::Direct => facts.light.clone(),
        PathClass::Caustic => facts.caster.clone(),
        PathClass::Indirect => Ok(receiver),
    }
}

/// Whether photons are traced.
///
/// Proof: shadow rays bring all of `L D`, and no other paths are left.
pub(super) fn photons(facts: &Facts, classes: PathClasses) -> Verdict {
    if classes.any_photons() {
        let brought: Vec<&str> =
            classes.iter().filter(|class| *class != PathClass::Direct).map(PathClass::name).collect();
        return Ok(format!("they bring {} light", brought.join(" and ")));
    }
    facts.light.clone()?;
    facts.receiver.clone()?;
    Err("nothing is left but direct light, which shadow rays bring".into())
}

/// Whether any path may be refracted.
///
/// Proof: paths from the eye meet only what is on the camera's side of every barrier, and photons what is on their light's; if
/// nothing refracts there, no path ever asks for the second lobe of a surface.
pub(super) fn refraction(facts: &Facts) -> Verdict {
    facts.glass.clone()
}

/// Whether photons aimed at casters could help.
///
/// Proof: they bring caustic light alone.
pub(super) fn aiming(facts: &Facts, classes: PathClasses) -> Verdict {
    match paths(facts, PathClass::Caustic) {
        Ok(caster) if classes.contains(PathClass::Caustic) => Ok(format!("{caster} is a target")),
        Ok(_) => Err("not asked for".into()),
        Err(because) => Err(because),
    }
}

/// Whether a pixel sees another point in each pass.
///
/// Proof: through a pinhole and without a filter a pixel is the mean over its samples, each of which ends at points that are
/// known once and for all.
pub(super) fn retracing(facts: &Facts) -> Verdict {
    let filter = facts.filter.clone();
    facts.lens.clone().or_else(|pinhole| filter.map_err(|points| format!("{pinhole}, and {points}")))
}

/// Lights that are left out.
///
/// Proof: what is emitted without power is zero; what is emitted on another side of a barrier than the camera's never leaves
/// that side, while every path that counts ends at the camera.
pub(super) fn dropped_lights(scene: &Scene, reach: &Reach) -> Vec<DroppedLight> {
    let shut_off = reach.shut_off.iter().map(|(source, because)| DroppedLight {
        light: scene.describe(source.item),
        numbers: source.lights.clone(),
        because: because.clone(),
    });
    let dark = reach.dark.iter().map(|number| DroppedLight {
        light: scene.describe(Item::PointLight(*number)),
        numbers: Vec::new(),
        because: "has no power".into(),
    });
    shut_off.chain(dark).collect()
}
