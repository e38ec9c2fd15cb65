//! The tables `[[spot_light]]`, `[[distant_light]]` and `[environment]`.

use std::sync::Arc;

use super::super::{LightDesc, SceneError};
use super::access::Reader;
use super::fields::{Allowed, CONE_ANGLE, COORDINATE, FINITE, Fields, NON_NEGATIVE, POSITIVE};
use super::objects::each;
use crate::light::{Panorama, Spot};
use crate::math::{Rgb, Vec3};
use crate::texture::Encoding;

/// In the order of the kinds, and of the file.
pub(super) fn further_lights(root: &Fields, reader: &Reader) -> Result<Vec<LightDesc>, SceneError> {
    let mut lights =
        each(root, "spot_light", &["position", "direction", "intensity", "inner", "outer"], spot)?;
    lights.extend(each(root, "distant_light", &["direction", "irradiance"], distant)?);
    if let Some(field) = root.optional("environment") {
        let known = ["radiance", "file", "scale", "turn"];
        lights.push(environment(&field.table(String::from("environment"), &known)?, reader)?);
    }
    Ok(lights)
}

fn spot(table: &Fields) -> Result<LightDesc, SceneError> {
    let position = table.required("position", "three numbers")?.vec3(&COORDINATE)?;
    let outer = table.required("outer", CONE_ANGLE.text)?.f32(&CONE_ANGLE)?;
    let inner = table.optional("inner").map(|field| field.f32(&NON_NEGATIVE)).transpose()?;
    let inner = inner.unwrap_or(0.75 * outer);
    if inner > outer {
        return Err(table.error(format!("inner is {inner}; allowed: {outer}, which is outer, at most")));
    }
    Ok(LightDesc::Spot(Spot {
        position,
        axis: direction(table)?,
        intensity: color(table, "intensity")?,
        inner: inner.to_radians(),
        outer: outer.to_radians(),
    }))
}

fn distant(table: &Fields) -> Result<LightDesc, SceneError> {
    Ok(LightDesc::Distant { direction: direction(table)?, irradiance: color(table, "irradiance")? })
}

fn environment(table: &Fields, reader: &Reader) -> Result<LightDesc, SceneError> {
    let Some(file) = table.optional("file") else {
        return Ok(LightDesc::Sky(color(table, "radiance")?));
    };
    if table.optional("radiance").is_some() {
        return Err(table.error("has `file` and `radiance`; allowed: either of the two".into()));
    }
    let number = |name, allowed: &Allowed| table.optional(name).map(|field| field.f32(allowed)).transpose();
    let (scale, turn) = (number("scale", &POSITIVE)?.unwrap_or(1.0), number("turn", &FINITE)?.unwrap_or(0.0));
    let (path, picture) = reader.picture(&file, Encoding::Colour)?;
    let panorama = Panorama::new(picture, scale, turn.to_radians());
    let panorama =
        panorama.ok_or_else(|| file.error("is black or holds what is no number; allowed: light".into()))?;
    Ok(LightDesc::Panorama { file: path, panorama: Arc::new(panorama) })
}

fn direction(table: &Fields) -> Result<Vec3, SceneError> {
    let field = table.required("direction", "three numbers, not all 0")?;
    let direction = field.dvec3(&COORDINATE)?.normalize_or_zero().as_vec3();
    if direction == Vec3::ZERO { Err(field.wrong("three numbers, not all 0")) } else { Ok(direction) }
}

fn color(table: &Fields, name: &str) -> Result<Rgb, SceneError> {
    table.required(name, "three numbers, 0 or above")?.vec3(&NON_NEGATIVE)
}

#[cfg(test)]
mod tests {
    use super::super::testing::{BASE, fails_with, good};
    use super::*;

    const LIGHTS: &str = "[[spot_light]]\nposition = [0, 1, 0]\ndirection = [0, -2, 0]\nintensity = [1, 2, 3]\n\
        outer = 60\n[[distant_light]]\ndirection = [3, 0, 4]\nirradiance = [1, 1, 1]\n[environment]\nradiance = [1, 0, 0]\n";

    #[test]
    fn every_kind_arrives() {
        let scene = good(&format!("{BASE}{LIGHTS}"), &[]);
        let [LightDesc::Spot(spot), LightDesc::Distant { direction, .. }, LightDesc::Sky(sky)] =
            &scene.further_lights[..]
        else {
            panic!("{:?}", scene.further_lights)
        };
        assert_eq!(
            (spot.axis, spot.inner, spot.outer),
            (Vec3::NEG_Y, 45f32.to_radians(), 60f32.to_radians())
        );
        assert_eq!((*direction, *sky), (Vec3::new(0.6, 0.0, 0.8), Rgb::X));
        assert_eq!(scene.places.further_lights.len(), 3);
    }

    #[test]
    fn mistakes_are_told() {
        for (from, to, words) in [
            ("[3, 0, 4]", "[0, 0, 0]", "allowed: three numbers, not all 0"),
            ("outer = 60", "outer = 0", "allowed: degrees above 0 and up to 180"),
            ("outer = 60", "outer = 60\ninner = 61", "inner is 61; allowed: 60"),
            ("[environment]", "[environment]\nfile = \"a.exr\"", "allowed: either of the two"),
            ("radiance = [1, 0, 0]", "file = \"a.tif\"", "allowed: exr, png, jpg, jpeg"),
            ("radiance = [1, 0, 0]", "file = \"a.exr\"", "cannot be read"),
        ] {
            fails_with(&format!("{BASE}{}", LIGHTS.replace(from, to)), "s.toml", words);
        }
    }
}
