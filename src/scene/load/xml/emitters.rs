//! `<emitter>`: lights without a shape, and the light of shapes.

use std::sync::Arc;

use super::super::super::{LightDesc, PointLightDesc, SceneError};
use super::super::fields::{CONE_ANGLE, COORDINATE, NON_NEGATIVE, POSITIVE};
use super::super::geometry::Motion;
use super::element::Element;
use super::object::{Context, Object};
use crate::light::{Panorama, Spot};
use crate::math::{DVec3, Rgb, Vec3};
use crate::texture::Encoding;

const KINDS: &str = "`point`, `spot`, `directional`, `constant`, `envmap`, and `area` in a <shape>";

/// The lights of a scene that have no shape.
#[derive(Default)]
pub(super) struct Lights {
    pub points: Vec<PointLightDesc>,
    pub point_lines: Vec<u32>,
    spots: Vec<(LightDesc, u32)>,
    distant: Vec<(LightDesc, u32)>,
    /// At most one.
    around: Vec<(LightDesc, u32)>,
}

impl Lights {
    /// Adds the light of an emitter of the scene.
    pub fn read<'a>(&mut self, element: &'a Element, context: &'a Context<'a>) -> Result<(), SceneError> {
        let object = Object::new(element, context)?;
        let line = element.place.main_line as u32;
        match object.kind()? {
            "point" => self.point(&object)?,
            "spot" => self.spots.push((spot(&object)?, line)),
            "directional" => self.distant.push((directional(&object)?, line)),
            "constant" => self.around(&object, LightDesc::Sky(object.light("radiance", 1.0)?))?,
            "envmap" => self.around(&object, panorama(&object)?)?,
            "area" => {
                return Err(element.error("emitter `area` without a shape; allowed: inside a <shape>"));
            }
            other => {
                let reason = format!("emitter `{other}` is not supported; allowed: {KINDS}");
                return context.unsupported(element, &reason, "the picture lacks its light");
            }
        }
        object.finish()
    }

    /// The lights that are no points, in the order of their kinds, and their lines.
    pub fn further(&mut self) -> (Vec<LightDesc>, Vec<u32>) {
        let kinds = [&mut self.spots, &mut self.distant, &mut self.around];
        kinds.into_iter().flat_map(std::mem::take).unzip()
    }

    fn around(&mut self, object: &Object, light: LightDesc) -> Result<(), SceneError> {
        if let Some((_, first)) = self.around.first() {
            return Err(object.error(format!(
                "a second light from all around, beside that of line {first}; allowed: one"
            )));
        }
        self.around.push((light, object.element.place.main_line as u32));
        Ok(())
    }

    fn point(&mut self, object: &Object) -> Result<(), SceneError> {
        let position = object.vector("position", &COORDINATE)?;
        let to_world = object.transform("to_world")?;
        if position.is_some()
            && object.element.children.iter().any(|c| c.attribute("name") == Some("to_world"))
        {
            return Err(object.error("has `position` and `to_world`; allowed: either"));
        }
        let position = object.placed(position.unwrap_or_else(|| to_world.map(DVec3::ZERO)))?;
        let intensity = object.light("intensity", 1.0)?;
        if intensity == Rgb::ZERO {
            object.context.warn(object.element, "emitter `point`: intensity is zero");
        }
        self.points.push(PointLightDesc { position, intensity });
        self.point_lines.push(object.element.place.main_line as u32);
        Ok(())
    }
}

/// Shines along +z.
fn spot(object: &Object) -> Result<LightDesc, SceneError> {
    let outer = object.f64("cutoff_angle", 20.0, &CONE_ANGLE)?;
    let inner = object.f64("beam_width", 0.75 * outer, &NON_NEGATIVE)?;
    if inner > outer {
        return Err(
            object.error(format!("`beam_width` is {inner}; allowed: `cutoff_angle`, {outer}, at most"))
        );
    }
    let to_world = object.transform("to_world")?;
    Ok(LightDesc::Spot(Spot {
        position: object.placed(to_world.map(DVec3::ZERO))?,
        axis: to_world.vector(DVec3::Z).normalize_or(DVec3::Z).as_vec3(),
        intensity: object.light("intensity", 1.0)?,
        inner: (inner as f32).to_radians(),
        outer: (outer as f32).to_radians(),
    }))
}

/// Goes along `direction`, or along +z of `to_world`.
fn directional(object: &Object) -> Result<LightDesc, SceneError> {
    let given = object.vector("direction", &COORDINATE)?;
    let has_place = object.element.children.iter().any(|child| child.attribute("name") == Some("to_world"));
    if given.is_some() && has_place {
        return Err(object.error("has `direction` and `to_world`; allowed: either"));
    }
    let along = object.transform("to_world")?.vector(DVec3::Z);
    let direction = given.unwrap_or(along).normalize_or_zero().as_vec3();
    if direction == Vec3::ZERO {
        return Err(object.error("`direction` is zero; allowed: any other"));
    }
    Ok(LightDesc::Distant { direction, irradiance: object.light("irradiance", 1.0)? })
}

/// The middle of the picture lies along +z for Mitsuba, and along -z here.
fn panorama(object: &Object) -> Result<LightDesc, SceneError> {
    let missing = || object.error("`filename` is missing; allowed: the path of an EXR, PNG or JPEG");
    let name = object.string("filename")?.ok_or_else(missing)?;
    let scale = object.f64("scale", 1.0, &POSITIVE)? as f32;
    let to_world = object.transform("to_world")?;
    let (x, up) = (to_world.vector(DVec3::X), to_world.vector(DVec3::Y).normalize_or_zero());
    let is_turn = to_world.uniform_scale().is_some() && !to_world.mirrors() && up.y > 1.0 - 1e-9;
    if !is_turn {
        return Err(object.error("`to_world` does more than turn it about y, which is not supported; allowed: <rotate y=\"1\" .../>"));
    }
    let path = object.context.reader.beside_scene(name);
    let picture = object.context.reader.picture_at(&path, Encoding::Colour);
    let picture = picture.map_err(|reason| object.error(format!("`{name}`: {reason}")))?;
    let turn = x.z.atan2(-x.x);
    let panorama = Panorama::new(picture, scale, turn as f32);
    let black = || object.error(format!("`{name}` is black or holds what is no number; allowed: light"));
    Ok(LightDesc::Panorama { file: path, panorama: Arc::new(panorama.ok_or_else(black)?) })
}

/// The radiance of a shape, by its `<emitter type="area">`; zero without one.
pub(super) fn radiance<'a>(shape: &Object<'a>, context: &'a Context<'a>) -> Result<Rgb, SceneError> {
    let Some(element) = shape.object("emitter")? else { return Ok(Rgb::ZERO) };
    let object = Object::new(element, context)?;
    if object.kind()? != "area" {
        return Err(element.error(format!("{} in a <shape>; allowed: emitter `area`", element.label())));
    }
    let radiance = object.light("radiance", 1.0)?;
    object.finish()?;
    if radiance == Rgb::ZERO {
        context.warn(element, "emitter `area`: radiance is zero");
    }
    Ok(radiance)
}

#[cfg(test)]
mod tests {
    use super::super::testing::{fails, good};
    use super::*;

    #[test]
    fn lights_of_other_kinds_arrive_in_the_order_of_kinds() {
        let sky = "<emitter type='constant'><rgb name='radiance' value='1,2,3'/></emitter>";
        let sun = "<emitter type='directional'><vector name='direction' x='3' z='4'/></emitter>";
        let spot = "<emitter type='spot'><float name='cutoff_angle' value='40'/><transform name='to_world'>\
            <lookat origin='0,3,0' target='0,0,0' up='1,0,0'/></transform></emitter>";
        let scene = good(&format!("{sky}\n{sun}\n{spot}"), &[]);
        let [LightDesc::Spot(spot), LightDesc::Distant { direction, irradiance }, LightDesc::Sky(sky)] =
            &scene.further_lights[..]
        else {
            panic!("{:?}", scene.further_lights)
        };
        assert_eq!((spot.position, spot.axis), (Vec3::new(0.0, 3.0, 0.0), Vec3::NEG_Y));
        assert_eq!((spot.inner, spot.outer), (30f32.to_radians(), 40f32.to_radians()));
        assert_eq!(
            (*direction, *irradiance, *sky),
            (Vec3::new(0.6, 0.0, 0.8), Rgb::ONE, Rgb::new(1.0, 2.0, 3.0))
        );
        assert_eq!(scene.places.further_lights, [9, 8, 7]);
    }

    #[test]
    fn point_lights_stand_where_they_are_put() {
        let by_transform =
            "<emitter type='point'><transform name='to_world'><translate x='1' z='3'/></transform></emitter>";
        assert_eq!(good(by_transform, &[]).point_lights[0].position, Vec3::new(1.0, 0.0, 3.0));
    }

    #[test]
    fn radiance_belongs_to_shapes() {
        let lamp = |e| format!("<shape type='rectangle'><ref id='a'/>{e}</shape>");
        let emitter = |l| format!("<emitter type='area'><rgb name='radiance' value='{l}'/></emitter>");
        let text = format!(
            "<bsdf type='diffuse' id='a'/>{}{}{}{}",
            lamp(emitter(3)),
            lamp(String::new()),
            lamp(emitter(3)),
            lamp(emitter(4))
        );
        let scene = good(&text, &[]);
        let materials: Vec<_> = scene.materials.iter().map(|m| (m.name.as_str(), m.emission.x)).collect();
        assert_eq!(materials, [("a", 3.0), ("a (2)", 0.0), ("a (3)", 4.0)]);
        assert_eq!(scene.meshes.iter().map(|m| m.materials[0]).collect::<Vec<_>>(), [0, 1, 0, 2]);
    }

    #[test]
    fn what_shines_reflects_nothing_unless_it_says_so() {
        let materials =
            good("<shape type='cube'><emitter type='area'/></shape><shape type='cube'/>", &[]).materials;
        let albedos: Vec<f32> = materials.iter().map(|material| material.bsdf.albedo(1.0).x).collect();
        assert_eq!(albedos, [0.0, 0.5]);
    }

    #[test]
    fn what_has_no_counterpart_is_refused_by_name() {
        for (text, words) in [
            ("<emitter type='sunsky'/>", "emitter `sunsky` is not supported; allowed: `point`, `spot`"),
            ("<emitter type='area'/>", "emitter `area` without a shape"),
            (
                "<emitter type='constant'/><emitter type='constant'/>",
                "a second light from all around, beside that of line 7",
            ),
            ("<emitter type='envmap'/>", "`filename` is missing"),
            (
                "<emitter type='envmap'><string name='filename' value='no.exr'/></emitter>",
                "`no.exr`: cannot be read",
            ),
            (
                "<emitter type='envmap'><string name='filename' value='a'/><transform name='to_world'><rotate x='1' angle='9'/></transform></emitter>",
                "does more than turn it about y",
            ),
            (
                "<emitter type='spot'><float name='beam_width' value='21'/></emitter>",
                "`beam_width` is 21; allowed: `cutoff_angle`, 20",
            ),
            ("<emitter type='directional'><vector name='direction' x='0'/></emitter>", "`direction` is zero"),
            ("<shape type='cube'><emitter type='point'/></shape>", "emitter `point` in a <shape>"),
            ("<shape type='cube'><emitter type='area'/><emitter type='area'/></shape>", "a second <emitter>"),
            (
                "<emitter type='point'><point name='position' x='1'/><transform name='to_world'/></emitter>",
                "allowed: either",
            ),
            ("<emitter type='point'><point name='position' x='1e30'/></emitter>", "`position` is [1"),
            (
                "<emitter type='point'><string name='position' value='1'/></emitter>",
                "`position` is a <string> of value `1`; allowed: <point>",
            ),
        ] {
            fails(text, 7, words);
        }
    }
}
