use std::fmt;

use serde::Serialize;

use super::Seconds;
use super::seconds::rendered;
use crate::bsdf::{Bsdf, Interface, RoughSurface, fresnel_reflectance, pane_reflectance};
use crate::compare::Metrics;
use crate::effects::{Effect, PathClass, Plan};
use crate::math::Rgb;
use crate::ppm::Settings;
use crate::scene::{PixelFilter, Scene, SceneDesc, Traversal, TraversalError};

/// What a render does without.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LeftOut {
    /// Nothing: the render that the others are held against.
    Nothing,
    /// A kind of path.
    Paths(PathClass),
    /// Mirrors: their share is absorbed. What refracts mirrors only where it cannot refract.
    Reflection,
    /// Refraction: its share is absorbed. Of an interface, what it mirrors head-on stays, in all directions.
    Transmission,
    /// Roughness: facets lie flat.
    Roughness,
    /// The lens: a pinhole sees.
    Lens,
    /// The filter: a pixel is the mean over its samples.
    Filter,
}

impl LeftOut {
    /// What can be left out of a render by this plan, after nothing.
    fn all(plan: &Plan) -> Vec<LeftOut> {
        let paths = plan.classes.iter().map(LeftOut::Paths);
        let effects = [
            (Effect::SpecularReflection, LeftOut::Reflection),
            (Effect::SpecularTransmission, LeftOut::Transmission),
            (Effect::Glossy, LeftOut::Roughness),
            (Effect::Lens, LeftOut::Lens),
            (Effect::AreaFilter, LeftOut::Filter),
        ];
        let simulated = effects.into_iter().filter(|(effect, _)| plan.simulates(*effect));
        [LeftOut::Nothing].into_iter().chain(paths).chain(simulated.map(|(_, left_out)| left_out)).collect()
    }

    fn without(self, settings: Settings) -> Settings {
        match self {
            LeftOut::Paths(class) => Settings { transport: settings.transport.without(class), ..settings },
            _ => settings,
        }
    }

    fn without_in(self, desc: &SceneDesc) -> SceneDesc {
        let mut desc = desc.clone();
        let mut change = |change: fn(Bsdf) -> Bsdf| {
            desc.materials.iter_mut().for_each(|material| material.bsdf = change(material.bsdf));
        };
        match self {
            LeftOut::Nothing | LeftOut::Paths(_) => (),
            LeftOut::Reflection => change(without_reflection),
            LeftOut::Transmission => change(without_transmission),
            LeftOut::Roughness => change(smooth),
            LeftOut::Lens => desc.camera.lens_radius = 0.0,
            LeftOut::Filter => desc.film.filter = PixelFilter::Points,
        }
        desc
    }
}

impl fmt::Display for LeftOut {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            LeftOut::Nothing => f.write_str("nothing"),
            LeftOut::Paths(class) => write!(f, "{class} light"),
            LeftOut::Reflection => f.write_str(Effect::SpecularReflection.name()),
            LeftOut::Transmission => f.write_str(Effect::SpecularTransmission.name()),
            LeftOut::Roughness => f.write_str("roughness"),
            LeftOut::Lens => f.write_str(Effect::Lens.name()),
            LeftOut::Filter => f.write_str(Effect::AreaFilter.name()),
        }
    }
}

fn without_reflection(bsdf: Bsdf) -> Bsdf {
    match bsdf {
        Bsdf::Diffuse { .. } | Bsdf::Rough(_) => bsdf,
        Bsdf::Plastic(plastic) => Bsdf::Diffuse { albedo: bsdf.diffuse_share(1.0).min(plastic.base) },
        Bsdf::Mirror { .. } | Bsdf::Conductor { .. } => Bsdf::Mirror { reflectance: Rgb::ZERO },
        Bsdf::ThinDielectric { ior } => fixed(Rgb::ZERO, 0.0, 1.0 - pane_reflectance(1.0, ior), 1.0),
        Bsdf::Dielectric { ior } => fixed(Rgb::ZERO, 0.0, 1.0, ior),
        Bsdf::FixedWeight { transparency, ior, .. } => fixed(bsdf.albedo(1.0), 0.0, transparency, ior),
    }
}

fn smooth(bsdf: Bsdf) -> Bsdf {
    match bsdf {
        Bsdf::Rough(RoughSurface { interface: Interface::Conductor { eta, k, reflectance }, .. }) => {
            Bsdf::Conductor { eta, k, reflectance }
        }
        Bsdf::Rough(RoughSurface { interface: Interface::Dielectric { ior }, .. }) => {
            Bsdf::Dielectric { ior }
        }
        smooth => smooth,
    }
}

fn without_transmission(bsdf: Bsdf) -> Bsdf {
    match bsdf {
        Bsdf::Diffuse { .. }
        | Bsdf::Mirror { .. }
        | Bsdf::Conductor { .. }
        | Bsdf::Plastic(_)
        | Bsdf::Rough(_) => bsdf,
        Bsdf::ThinDielectric { ior } => Bsdf::Mirror { reflectance: Rgb::splat(pane_reflectance(1.0, ior)) },
        Bsdf::Dielectric { ior } => {
            Bsdf::Mirror { reflectance: Rgb::splat(fresnel_reflectance(1.0, 1.0, ior)) }
        }
        Bsdf::FixedWeight { reflectivity, ior, .. } => fixed(bsdf.albedo(1.0), reflectivity, 0.0, ior),
    }
}

/// With its own diffuse share, whatever the specular shares leave to it.
fn fixed(albedo: Rgb, reflectivity: f32, transparency: f32, ior: f32) -> Bsdf {
    let rest = 1.0 - reflectivity - transparency;
    let color = if albedo == Rgb::ZERO { Rgb::ZERO } else { albedo / rest };
    Bsdf::FixedWeight { color, reflectivity, transparency, ior }
}

/// A render without one thing, against that with everything.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Ablation {
    /// What is left out.
    pub without: String,
    /// What the render took.
    pub seconds: Seconds,
    /// Difference of the pictures, as `caustica compare` has it.
    pub rel_mse: f64,
    /// Difference of the pictures (W/m²/sr).
    pub rmse: f64,
}

/// Renders `passes` passes with everything that the plan has, then without one thing after the other, all by the same random
/// numbers.
///
/// # Errors
/// Whatever the ray tracer refuses: see [`Scene::with_traversal`].
pub fn ablate(
    desc: &SceneDesc,
    traversal: Traversal,
    settings: Settings,
    passes: u32,
    plan: &Plan,
) -> Result<Vec<Ablation>, TraversalError> {
    let mut whole = None;
    let mut found = Vec::new();
    for left_out in LeftOut::all(plan) {
        let scene = Scene::with_traversal(left_out.without_in(desc), traversal)?;
        let (seconds, picture) = rendered(&scene, left_out.without(settings), passes);
        let whole = whole.get_or_insert_with(|| picture.clone());
        // They are of one size.
        let Ok(metrics) = Metrics::between(&picture, whole) else { continue };
        let Metrics { rel_mse, rmse, .. } = metrics;
        found.push(Ablation { without: left_out.to_string(), seconds, rel_mse, rmse });
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::{Event, Transport};
    use crate::math::Vec3;

    const WATER: Bsdf =
        Bsdf::FixedWeight { color: Rgb::new(0.6, 0.6, 0.7), reflectivity: 0.2, transparency: 0.5, ior: 1.33 };

    fn shares(bsdf: Bsdf, event: Event) -> f32 {
        let scattering = bsdf.scatter(Vec3::new(0.6, 0.0, 0.8), Transport::Power);
        scattering.specular().filter(|lobe| lobe.event == event).map(|lobe| lobe.share.x).sum()
    }

    #[test]
    fn what_is_left_out_is_absorbed_and_the_rest_stays() {
        let close = |a: f32, b: f32| (a - b).abs() < 1e-6;
        let still = |bsdf: Bsdf| (bsdf.albedo(1.0) - WATER.albedo(1.0)).abs().max_element() < 1e-6;
        let unmirrored = without_reflection(WATER);
        assert!(still(unmirrored) && close(shares(unmirrored, Event::Transmission), 0.5));
        assert_eq!(shares(unmirrored, Event::Reflection), 0.0);
        let opaque = without_transmission(WATER);
        assert!(still(opaque) && close(shares(opaque, Event::Reflection), 0.2));
        assert_eq!(shares(opaque, Event::Transmission), 0.0);
        let glass = Bsdf::Dielectric { ior: 1.5 };
        assert!(close(shares(without_transmission(glass), Event::Reflection), 0.04));
        assert!(close(shares(without_reflection(glass), Event::Transmission), 1.0));
        let mirror = Bsdf::Mirror { reflectance: Rgb::ONE };
        assert_eq!(
            (shares(without_reflection(mirror), Event::Reflection), without_transmission(mirror)),
            (0.0, mirror)
        );
    }
}
