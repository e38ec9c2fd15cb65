//! `<transform>`: a chain of translations, scalings, rotations, views and matrices, the first of them applied first.

use glam::{DAffine3, DMat3, DMat4};

use super::super::super::SceneError;
use super::super::affine::Affine;
use super::element::Element;
use crate::math::DVec3;

/// The view of a `<lookat>`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LookAt {
    pub origin: DVec3,
    pub target: DVec3,
    pub up: DVec3,
}

impl LookAt {
    pub fn read(element: &Element) -> Result<LookAt, SceneError> {
        element.only(&["origin", "target", "up"])?;
        let three = |name| {
            let text = element.required(name, "three numbers")?;
            triple(element, &numbers(element, text)?)
        };
        let (origin, target) = (three("origin")?, three("target")?);
        let up = if element.attribute("up").is_some() { three("up")? } else { DVec3::ZERO };
        let view =
            LookAt { origin, target, up: if up == DVec3::ZERO { any_up(target - origin) } else { up } };
        match view.up.cross(view.forward()).length() > 1e-6 * view.up.length() {
            true => Ok(view),
            false => Err(element.error(
                "lookat: `target` equals `origin`, or `up` is parallel to the view; allowed: other ones",
            )),
        }
    }

    fn forward(&self) -> DVec3 {
        (self.target - self.origin).normalize_or_zero()
    }

    /// Columns: to the left, upward, along the view.
    fn matrix(&self) -> DAffine3 {
        let forward = self.forward();
        let left = self.up.cross(forward).normalize();
        DAffine3::from_mat3_translation(DMat3::from_cols(left, forward.cross(left), forward), self.origin)
    }
}

/// A direction across the view, where the file names none.
fn any_up(view: DVec3) -> DVec3 {
    view.normalize_or(DVec3::Z).any_orthonormal_vector()
}

/// The one `<lookat>` of a transform that holds nothing else.
pub(super) fn sole_look_at(transform: &Element) -> Result<Option<LookAt>, SceneError> {
    match &transform.children[..] {
        [only] if only.tag == "lookat" => LookAt::read(only).map(Some),
        _ => Ok(None),
    }
}

pub(super) fn read(element: &Element) -> Result<Affine, SceneError> {
    element.only(&["name"])?;
    let affine = element
        .children
        .iter()
        .try_fold(Affine::IDENTITY, |affine, step| Ok(affine.then(read_step(step)?)))?;
    let determinant = affine.0.matrix3.determinant();
    if affine.0.is_finite() && determinant != 0.0 && determinant.recip().is_finite() {
        return Ok(affine);
    }
    Err(element.error("transform flattens space or is not finite; allowed: one that can be undone"))
}

fn read_step(step: &Element) -> Result<DAffine3, SceneError> {
    let known = |names: &[&str]| step.only(&[&["value", "x", "y", "z"], names].concat());
    match step.tag.as_str() {
        "translate" => known(&[]).and(components(step, DVec3::ZERO)).map(DAffine3::from_translation),
        "scale" => known(&[]).and(components(step, DVec3::ONE)).map(DAffine3::from_scale),
        "rotate" => {
            known(&["angle"])?;
            let axis = components(step, DVec3::ZERO)?.try_normalize();
            let axis = axis.ok_or_else(|| step.error("rotate: the axis is zero; allowed: a direction"))?;
            let degrees = number(step, step.required("angle", "degrees")?)?;
            Ok(DAffine3::from_axis_angle(axis, degrees.to_radians()))
        }
        "lookat" => LookAt::read(step).map(|view| view.matrix()),
        "matrix" => matrix(step),
        other => Err(step.error(format!(
            "<{other}> in a transform; allowed: <translate>, <scale>, <rotate>, <lookat>, <matrix>"
        ))),
    }
}

/// Row by row.
fn matrix(step: &Element) -> Result<DAffine3, SceneError> {
    step.only(&["value"])?;
    let values = numbers(step, step.required("value", "16 or 9 numbers")?)?;
    if let Ok(nine) = <[f64; 9]>::try_from(&values[..]) {
        return Ok(DAffine3::from_mat3(DMat3::from_cols_array(&nine).transpose()));
    }
    let Ok(sixteen) = <[f64; 16]>::try_from(&values[..]) else {
        return Err(step.error(format!("matrix of {} numbers; allowed: 16 or 9", values.len())));
    };
    if sixteen[12..] != [0.0, 0.0, 0.0, 1.0] {
        return Err(step.error("matrix with a last row other than 0 0 0 1; allowed: affine maps"));
    }
    Ok(DAffine3::from_mat4(DMat4::from_cols_array(&sixteen).transpose()))
}

/// `value` of one or three numbers, or `x`, `y` and `z`, of which each may be absent.
pub(super) fn components(element: &Element, default: DVec3) -> Result<DVec3, SceneError> {
    let axis = |name, default| element.attribute(name).map_or(Ok(default), |text| number(element, text));
    let Some(value) = element.attribute("value") else {
        return Ok(DVec3::new(axis("x", default.x)?, axis("y", default.y)?, axis("z", default.z)?));
    };
    if ["x", "y", "z"].iter().any(|name| element.attribute(name).is_some()) {
        return Err(
            element.error(format!("<{}> has `value` and `x`, `y` or `z`; allowed: either", element.tag))
        );
    }
    match numbers(element, value)?[..] {
        [all] => Ok(DVec3::splat(all)),
        ref several => triple(element, several),
    }
}

/// Numbers between blanks and commas.
pub(super) fn numbers(element: &Element, text: &str) -> Result<Vec<f64>, SceneError> {
    let words = text.split(|c: char| c == ',' || c.is_whitespace()).filter(|word| !word.is_empty());
    words.map(|word| number(element, word)).collect()
}

fn number(element: &Element, text: &str) -> Result<f64, SceneError> {
    let parsed = text.trim().parse::<f64>().ok().filter(|x| x.is_finite());
    parsed.ok_or_else(|| element.error(format!("<{}>: `{text}`; allowed: a finite number", element.tag)))
}

fn triple(element: &Element, values: &[f64]) -> Result<DVec3, SceneError> {
    let three = <[f64; 3]>::try_from(values).map(DVec3::from);
    three.map_err(|_| element.error(format!("<{}> of {} numbers; allowed: 3", element.tag, values.len())))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::super::geometry::Motion;
    use super::super::element::parse;
    use super::*;
    use crate::math::Vec3;

    fn affine(steps: &str) -> Result<Affine, String> {
        let element =
            parse(Path::new("s.xml"), &format!("<transform name='to_world'>\n{steps}</transform>")).unwrap();
        read(&element).map_err(|e| e.to_string())
    }

    fn maps(steps: &str, from: [f64; 3], to: [f64; 3]) {
        let mapped = affine(steps).unwrap().map(DVec3::from(from));
        assert!((mapped - DVec3::from(to)).length() < 1e-12, "{steps}: {mapped}");
    }

    #[test]
    fn steps_are_applied_in_their_order() {
        maps("<scale value='2'/><translate x='1'/>", [1., 1., 1.], [3., 2., 2.]);
        maps("<translate x='1'/><scale value='2, 1 1'/>", [1., 1., 1.], [4., 1., 1.]);
        maps("<rotate y='1' angle='90'/>", [1., 0., 0.], [0., 0., -1.]);
        maps("<matrix value='1 0 0 5, 0 2 0 6, 0 0 3 7, 0 0 0 1'/>", [1., 1., 1.], [6., 8., 10.]);
        maps("<matrix value='0 -1 0 1 0 0 0 0 1'/>", [1., 0., 0.], [0., 1., 0.]);
    }

    /// The camera of a Mitsuba scene looks along its z; x points to the left of the picture.
    #[test]
    fn views_have_left_up_and_forward_as_their_axes() {
        let view = "<lookat origin='1,2,3' target='1,2,9' up='0,5,0'/>";
        maps(view, [0., 0., 2.], [1., 2., 5.]);
        maps(view, [0., 1., 0.], [1., 3., 3.]);
        maps(view, [1., 0., 0.], [2., 2., 3.]);
        assert_eq!(affine(view).unwrap().uniform_scale(), Some(1.0));
    }

    #[test]
    fn normals_stay_perpendicular_and_are_mirrored() {
        let t = affine("<scale x='4'/><rotate z='1' angle='30'/>").unwrap();
        let along = t.vector(DVec3::new(1.0, -1.0, 0.0)).as_vec3();
        assert!(along.dot(t.normal(Vec3::new(1.0, 1.0, 0.0)).unwrap()).abs() < 1e-6);
        let mirror = affine("<scale x='-1'/>").unwrap();
        assert!(
            mirror.mirrors()
                && mirror.normal(Vec3::X) == Some(Vec3::NEG_X)
                && mirror.normal(Vec3::Y) == Some(Vec3::Y)
        );
        assert_eq!(t.uniform_scale(), None);
        assert_eq!(t.normal(Vec3::ZERO), None);
    }

    #[test]
    fn mistakes_are_told_with_their_line() {
        for (steps, words) in [
            ("<scale x='0'/>", "s.xml:1: transform flattens space"),
            ("<shear x='1'/>", "s.xml:2: <shear> in a transform; allowed: <translate>"),
            ("<scale value='1 2'/>", "s.xml:2: <scale> of 2 numbers; allowed: 3"),
            ("<scale value='1' x='3'/>", "has `value` and `x`"),
            ("<translate x='one'/>", "s.xml:2: <translate>: `one`; allowed: a finite number"),
            ("<translate x='inf'/>", "`inf`; allowed: a finite number"),
            ("<rotate angle='3'/>", "rotate: the axis is zero"),
            ("<rotate x='1'/>", "<rotate> has no attribute `angle`"),
            (
                "<rotate x='1' angles='3'/>",
                "unknown attribute `angles`; allowed: `value`, `x`, `y`, `z`, `angle`",
            ),
            ("<matrix value='1 2 3'/>", "matrix of 3 numbers"),
            ("<matrix value='1 0 0 0 0 1 0 0 0 0 1 0 1 0 0 1'/>", "last row other than 0 0 0 1"),
            ("<lookat origin='0,0,0' target='0,0,0' up='0,1,0'/>", "`target` equals `origin`"),
            ("<lookat origin='0,0,0' target='0,2,0' up='0,1,0'/>", "parallel to the view"),
            ("<lookat origin='0,0,0' up='0,1,0'/>", "no attribute `target`"),
        ] {
            let error = affine(steps).unwrap_err();
            assert!(error.contains(words), "{steps}: {error}");
        }
    }
}
