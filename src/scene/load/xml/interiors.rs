//! `<medium name="interior">` of shapes: what absorbs light inside of them.

use super::super::super::SceneError;
use super::super::fields::{FRACTION, NON_NEGATIVE};
use super::element::Element;
use super::object::{Context, Object};
use crate::math::Rgb;

pub(super) const NO_INSIDE: &str =
    "has a medium in a bsdf without an inside; allowed: of `dielectric` and `roughdielectric`";

/// `σ` of the medium inside of a shape; 0 without one.
pub(super) fn absorption<'a>(shape: &Object<'a>, context: &'a Context<'a>) -> Result<Rgb, SceneError> {
    let is_medium = |child: &&Element| {
        let named = child.attribute("name").is_some_and(|name| name == "interior");
        named && context.resolved(child).is_ok_and(|object| object.tag == "medium")
    };
    let Some(interior) = shape.element.children.iter().find(is_medium) else { return Ok(Rgb::ZERO) };
    shape.take("interior");
    of_medium(&Object::new(context.resolved(interior)?, context)?)
}

fn of_medium(medium: &Object) -> Result<Rgb, SceneError> {
    let kind = medium.kind()?;
    if kind != "homogeneous" {
        let reason = format!("medium `{kind}` is not supported; allowed: `homogeneous`");
        medium.context.unsupported(medium.element, &reason, "the picture has clear glass instead")?;
        return Ok(Rgb::ZERO);
    }
    // As Mitsuba has it, what says nothing scatters.
    if medium.color("albedo", Rgb::splat(0.75), &FRACTION)? != Rgb::ZERO {
        let reason =
            "medium `homogeneous`: `albedo` other than 0 is not supported, as it scatters; allowed: 0";
        medium.context.unsupported(medium.element, reason, "the picture has a medium that absorbs alone")?;
    }
    medium.has_no_use_for(&["has_spectral_extinction", "sample_emitters"]);
    medium.objects("phase")?;
    let sigma = medium.color("sigma_t", Rgb::ONE, &NON_NEGATIVE)?;
    let sigma = sigma * medium.f64("scale", 1.0, &NON_NEGATIVE)? as f32;
    medium.finish()?;
    if sigma.is_finite() {
        Ok(sigma)
    } else {
        Err(medium.error(format!("absorbs {sigma}; allowed: finite numbers")))
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{fails, good};
    use super::*;

    fn sphere(medium: &str) -> String {
        format!("<shape type='sphere'><bsdf type='dielectric'/>\n{medium}</shape>")
    }

    #[test]
    fn interiors_absorb() {
        let of = |medium: &str| good(&sphere(medium), &[]).materials[0].absorption;
        let black = "<float name='albedo' value='0'/>";
        assert_eq!(of(""), Rgb::ZERO);
        assert_eq!(of(&format!("<medium type='homogeneous' name='interior'>{black}</medium>")), Rgb::ONE);
        let scaled = format!(
            "<medium type='homogeneous' name='interior'>{black}<rgb name='sigma_t' value='1 2 3'/><float name='scale' value='2'/><phase type='isotropic'/></medium>"
        );
        assert_eq!(of(&scaled), Rgb::new(2.0, 4.0, 6.0));
    }

    /// One bsdf around two media, one of which is that of two shapes: a material for each pair.
    #[test]
    fn every_pair_of_bsdf_and_medium_is_a_material() {
        let medium = |id: &str, sigma: f32| {
            format!(
                "<medium type='homogeneous' id='{id}'><float name='albedo' value='0'/><float name='sigma_t' value='{sigma}'/></medium>"
            )
        };
        let shape = |interior: &str| format!("<shape type='sphere'><ref id='g'/>{interior}</shape>");
        let [a, b] = ["a", "b"].map(|id| shape(&format!("<ref name='interior' id='{id}'/>")));
        let text = format!(
            "<bsdf type='dielectric' id='g'/>{}{}{a}{b}{}{a}",
            medium("a", 1.0),
            medium("b", 2.0),
            shape("")
        );
        let scene = good(&text, &[]);
        let absorption: Vec<f32> = scene.materials.iter().map(|material| material.absorption.x).collect();
        let of_shapes: Vec<u32> = scene.spheres.iter().map(|sphere| sphere.material).collect();
        assert_eq!((absorption, of_shapes), (vec![1.0, 2.0, 0.0], vec![0, 1, 2, 0]));
        assert_eq!(scene.materials[1].name, "g (2)");
    }

    #[test]
    fn media_that_do_more_than_absorb_are_refused() {
        for (medium, words) in [
            (
                "<medium type='heterogeneous' name='interior'/>",
                "medium `heterogeneous` is not supported; allowed: `homogeneous`",
            ),
            (
                "<medium type='homogeneous' name='interior'/>",
                "`albedo` other than 0 is not supported, as it scatters",
            ),
            (
                "<medium type='homogeneous' name='interior'><float name='albedo' value='0'/><float name='sigma_t' value='-1'/></medium>",
                "`sigma_t` is -1; allowed: a finite number, 0 or above",
            ),
            ("<medium type='homogeneous' name='exterior'/>", "<medium> `exterior` is not supported"),
            (
                "<medium type='homogeneous' name='interior'><float name='albedo' value='0'/><string name='material' value='milk'/></medium>",
                "<string> `material` is not supported",
            ),
        ] {
            fails(&sphere(medium), 8, words);
        }
        let opaque = "<shape type='sphere'><medium type='homogeneous' name='interior'><float name='albedo' value='0'/></medium></shape>";
        fails(
            opaque,
            7,
            "shape `sphere`: has a medium in a bsdf without an inside; allowed: of `dielectric`",
        );
    }
}
