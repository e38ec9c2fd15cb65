//! What the rules of a plan go by, gathered from the scene.

use super::reach::{Reach, Verdict, Wanted};
use super::{Effect, EffectSet, PathClasses, declare};
use crate::scene::{Item, Scene};

const RECEIVER: Wanted =
    Wanted { effects: &[Effect::Diffuse], absent: "no surface reflects diffusely, so none shows light" };
const CASTER: Wanted = Wanted {
    effects: &[Effect::SpecularReflection, Effect::SpecularTransmission, Effect::Mask],
    absent: "no surface mirrors or refracts",
};
const MIRROR: Wanted = Wanted { effects: &[Effect::SpecularReflection], absent: "no surface mirrors" };
const GLASS: Wanted = Wanted { effects: &[Effect::SpecularTransmission], absent: "no surface refracts" };
const ROUGH: Wanted = Wanted { effects: &[Effect::Glossy], absent: "no surface is rough" };
const MASK: Wanted =
    Wanted { effects: &[Effect::Mask], absent: "no surface lets light pass as if nothing were there" };
const ABSORBER: Wanted = Wanted { effects: &[Effect::Absorption], absent: "no body absorbs" };
const PICTURED: Wanted = Wanted { effects: &[Effect::Texture], absent: "no surface has a picture" };
const LAMP: Wanted = Wanted { effects: &[Effect::Emission], absent: "no surface shines" };

/// What the rules go by: for each thing what calls for it, or why it contributes nothing.
pub(super) struct Facts {
    pub asked: PathClasses,
    /// Some light with power.
    pub light: Verdict,
    pub points: Verdict,
    pub areas: Verdict,
    pub environment: Verdict,
    /// A receiver that is seen and lit.
    pub receiver: Verdict,
    /// A receiver that is seen.
    pub seen_receiver: Verdict,
    /// A caster that light reaches.
    pub caster: Verdict,
    pub mirror: Verdict,
    pub glass: Verdict,
    /// A rough surface that light or the camera reaches.
    pub rough: Verdict,
    /// Any that there is.
    pub any_rough: Verdict,
    pub mask: Verdict,
    pub absorber: Verdict,
    pub texture: Verdict,
    pub lamp: Verdict,
    pub lens: Verdict,
    pub filter: Verdict,
}

impl Facts {
    pub fn of(scene: &Scene, reach: &Reach, asked: PathClasses) -> Facts {
        let no_light = "no light has power";
        Facts {
            asked,
            light: reach.light(&[Effect::DeltaLight, Effect::AreaLight, Effect::Environment], no_light),
            points: reach.light(&[Effect::DeltaLight], "no light without extent has power"),
            areas: reach.light(&[Effect::AreaLight], "no surface that shines has power"),
            environment: reach.light(&[Effect::Environment], "nothing shines from all around"),
            receiver: reach.lit(RECEIVER),
            seen_receiver: reach.seen(RECEIVER),
            caster: reach.lit(CASTER),
            mirror: reach.reached(MIRROR),
            glass: reach.reached(GLASS),
            rough: reach.reached(ROUGH),
            any_rough: any_rough(scene),
            mask: reach.reached(MASK),
            absorber: reach.reached(ABSORBER),
            texture: reach.reached(PICTURED),
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
            environment: on(),
            receiver: on(),
            seen_receiver: on(),
            caster: on(),
            mirror: on(),
            glass: on(),
            rough: on(),
            any_rough: any_rough(scene),
            mask: on(),
            absorber: on(),
            texture: on(),
            lamp: on(),
            lens: lens(scene),
            filter: filter(scene),
        }
    }
}

/// Without looking at barriers: what asks for other eye paths asks for another picture.
fn any_rough(scene: &Scene) -> Verdict {
    if scene.any_glossy() { Ok("some surface is rough".into()) } else { Err(ROUGH.absent.into()) }
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
