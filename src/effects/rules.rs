//! The rules by which a plan leaves things out, each with the proof that nothing of the picture goes with them.
//!
//! Every path that the renderer finds leads from a light over surfaces to the eye, and all of it lies on one side of every
//! barrier. So it needs a light, a receiver and, by its kind, casters that the camera and one another can reach; what
//! [`Reach`] tells of each is necessary for such a path, and where it is known not to hold there is none.

use super::decision::{Decision, DroppedLight};
use super::facts::Facts;
use super::reach::{Reach, Verdict};
use super::{Effect, PathClass, PathClasses};
use crate::scene::Scene;

/// What each effect is because of.
pub(super) fn effects(facts: &Facts) -> Vec<Decision> {
    let verdict = |effect| match effect {
        Effect::Diffuse => &facts.seen_receiver,
        Effect::SpecularReflection => &facts.mirror,
        Effect::SpecularTransmission => &facts.glass,
        Effect::Glossy => &facts.rough,
        Effect::Mask => &facts.mask,
        Effect::Absorption => &facts.absorber,
        Effect::Texture => &facts.texture,
        Effect::Emission => &facts.lamp,
        Effect::DeltaLight => &facts.points,
        Effect::AreaLight => &facts.areas,
        Effect::Environment => &facts.environment,
        Effect::Lens => &facts.lens,
        Effect::AreaFilter => &facts.filter,
    };
    Effect::ALL.map(|effect| Decision::of(effect.name(), verdict(effect).clone())).into()
}

/// Whether paths of a kind bring any light. Lamps and an environment that are seen go with direct light.
///
/// Proof: each begins at a light of power (else all its samples are zero) and ends at a receiver, the `D` before the eye (else
/// there is no hit point and no photon is stored). `L S+ D` holds a specular event at some caster between the two, on their
/// side of every barrier; where no caster is, there is none. `L S* D (S | D)* D` holds no other surface than receivers for
/// certain, which may be one and the same.
pub(super) fn paths(facts: &Facts, class: PathClass) -> Verdict {
    if !facts.asked.contains(class) {
        return Err("not asked for".into());
    }
    let light = facts.light.clone()?;
    match (class, facts.receiver.clone()) {
        (PathClass::Direct, Ok(_)) => Ok(light),
        (PathClass::Direct, Err(because)) => {
            let seen = facts.lamp.clone().or_else(|_| facts.environment.clone());
            seen.or_else(|_| facts.any_rough.clone()).map_err(|_| because)
        }
        (PathClass::Caustic, receiver) => receiver.and_then(|_| facts.caster.clone()),
        (PathClass::Indirect, receiver) => receiver,
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
    if glints(facts).is_ok() {
        return Ok("they bring caustics on rough surfaces".into());
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

/// Whether any path may meet a surface that mirrors or refracts, be it rough, or a mask.
///
/// Proof: as that of [`refraction`].
pub(super) fn casters(facts: &Facts) -> Verdict {
    let specular = facts.mirror.clone().or_else(|_| facts.glass.clone());
    specular.or_else(|_| facts.rough.clone()).or_else(|_| facts.mask.clone())
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

/// Whether photons guided to what is seen could help.
///
/// Proof: they bring what photons bring.
pub(super) fn guiding(facts: &Facts, classes: PathClasses) -> Verdict {
    photons(facts, classes).map(|_| "where light hardly reaches what is seen, by a trial".into())
}

/// Whether a pixel sees another point in each pass.
///
/// Proof: through a pinhole and without a filter a pixel is the mean over its samples, each of which ends at points that are
/// known once and for all: where all surfaces on its way are smooth, no direction is drawn.
pub(super) fn retracing(facts: &Facts) -> Verdict {
    let otherwise = |verdict: &Verdict, why: String| verdict.clone().map_err(|also| format!("{why}, {also}"));
    let filter = |pinhole| otherwise(&facts.filter, pinhole);
    facts.lens.clone().or_else(filter).or_else(|why| otherwise(&facts.any_rough, why))
}

/// Whether caustics are collected on rough surfaces.
///
/// Proof: facets find whatever has an extent, and shadow rays what was neither mirrored nor refracted. What is left on the way to the eye
/// over a rough surface, `L S+ G (S | G)* E`, begins at a light without extent and meets a caster; where there is none of the three, no
/// such path is.
pub(super) fn glints(facts: &Facts) -> Verdict {
    if !facts.asked.contains(PathClass::Caustic) {
        return Err("not asked for".into());
    }
    let (rough, _) = (facts.rough.clone()?, facts.caster.clone()?);
    let points = facts.points.clone()?;
    Ok(format!("{rough} shows the light of {points} that was mirrored or refracted before"))
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
    let dark = reach.dark.iter().map(|item| DroppedLight {
        light: scene.describe(*item),
        numbers: Vec::new(),
        because: "has no power".into(),
    });
    shut_off.chain(dark).collect()
}

#[cfg(test)]
mod tests;
