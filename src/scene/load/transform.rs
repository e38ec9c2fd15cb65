//! Where a mesh goes: scale, then rotation, then translation.

use super::super::SceneError;
use super::fields::{COORDINATE, FINITE, Field, Fields};
use super::geometry::Motion;
use crate::math::{DVec3, Vec3};

/// `p -> R (s p) + t`, computed in f64.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Transform {
    scale: DVec3,
    rotation: Option<Rotation>,
    translation: DVec3,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Rotation {
    /// Unit.
    axis: DVec3,
    radians: f64,
}

impl Rotation {
    /// Rodrigues' formula: counter-clockwise when the axis points at the viewer.
    fn apply(&self, v: DVec3) -> DVec3 {
        let (sin, cos) = self.radians.sin_cos();
        cos * v + sin * self.axis.cross(v) + (1.0 - cos) * self.axis.dot(v) * self.axis
    }
}

impl Transform {
    /// From the fields `scale`, `rotate` and `translate` of a table, all optional.
    pub fn read(table: &Fields) -> Result<Transform, SceneError> {
        let translation = table.optional("translate").map(|field| field.dvec3(&COORDINATE));
        Ok(Transform {
            scale: table.optional("scale").map_or(Ok(DVec3::ONE), |field| scale(&field))?,
            rotation: table.optional("rotate").map(|field| rotation(&field, &table.place)).transpose()?,
            translation: translation.unwrap_or(Ok(DVec3::ZERO))?,
        })
    }

    fn turned(&self, v: DVec3) -> DVec3 {
        self.rotation.map_or(v, |rotation| rotation.apply(v))
    }
}

impl Motion for Transform {
    fn is_identity(&self) -> bool {
        self.scale == DVec3::ONE && self.rotation.is_none() && self.translation == DVec3::ZERO
    }

    fn point(&self, p: Vec3) -> Vec3 {
        (self.turned(self.scale * p.as_dvec3()) + self.translation).as_vec3()
    }

    fn normal(&self, n: Vec3) -> Option<Vec3> {
        self.turned(n.as_dvec3() / self.scale).try_normalize().map(|n| n.as_vec3())
    }

    fn mirrors(&self) -> bool {
        self.scale.to_array().iter().filter(|s| **s < 0.0).count() % 2 == 1
    }
}

fn scale(field: &Field) -> Result<DVec3, SceneError> {
    let scale = if field.is_array() { field.dvec3(&FINITE)? } else { DVec3::splat(field.f64(&FINITE)?) };
    let inverse = scale.recip();
    if scale.cmpeq(DVec3::ZERO).any() || !inverse.is_finite() {
        return Err(field.wrong("a number or three numbers, none of them zero"));
    }
    Ok(scale)
}

fn rotation(field: &Field, place: &str) -> Result<Rotation, SceneError> {
    let table = field.table(format!("{place}, rotate"), &["axis", "degrees"])?;
    let axis_field = table.required("axis", "three numbers")?;
    let axis = axis_field.dvec3(&COORDINATE)?.try_normalize();
    let axis = axis.ok_or_else(|| axis_field.wrong("a direction that is not zero"))?;
    let degrees = table.required("degrees", FINITE.text)?.f64(&FINITE)?;
    Ok(Rotation { axis, radians: degrees.to_radians() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn transform(scale: DVec3, axis: DVec3, degrees: f64, translation: DVec3) -> Transform {
        let rotation = Some(Rotation { axis, radians: f64::to_radians(degrees) });
        Transform { scale, rotation, translation }
    }

    #[test]
    fn scale_comes_first_then_rotation_then_translation() {
        let t = transform(DVec3::new(2.0, 1.0, 1.0), DVec3::Y, 90.0, DVec3::new(10.0, 0.0, 0.0));
        assert!((t.point(Vec3::X) - Vec3::new(10.0, 0.0, -2.0)).length() < 1e-6);
    }

    #[test]
    fn normals_stay_perpendicular_where_the_scale_is_uneven() {
        let t = transform(DVec3::new(4.0, 1.0, 1.0), DVec3::Z, 30.0, DVec3::ZERO);
        let along = t.point(Vec3::new(1.0, -1.0, 0.0));
        let normal = t.normal(Vec3::new(1.0, 1.0, 0.0)).unwrap();
        assert!(along.dot(normal).abs() < 1e-6 && normal.is_normalized());
        assert_eq!([Vec3::ZERO, Vec3::NAN, Vec3::INFINITY].map(|n| t.normal(n)), [None; 3]);
    }

    #[test]
    fn an_odd_number_of_negative_scales_mirrors() {
        let mirrors = |x, y, z| transform(DVec3::new(x, y, z), DVec3::X, 0.0, DVec3::ZERO).mirrors();
        assert!(mirrors(-1.0, 1.0, 1.0) && mirrors(-1.0, -2.0, -3.0));
        assert!(!mirrors(1.0, 1.0, 1.0) && !mirrors(-1.0, 1.0, -1.0));
    }

    proptest! {
        #[test]
        fn rotation_keeps_lengths_and_its_axis(x in -1f64..1.0, y in -1f64..1.0, z in 0.1f64..1.0, degrees in -720f64..720.0) {
            let axis = DVec3::new(x, y, z).normalize();
            let rotation = Rotation { axis, radians: degrees.to_radians() };
            prop_assert!((rotation.apply(axis) - axis).length() < 1e-12);
            prop_assert!((rotation.apply(DVec3::new(z, x, y)).length() - DVec3::new(z, x, y).length()).abs() < 1e-12);
        }
    }
}
