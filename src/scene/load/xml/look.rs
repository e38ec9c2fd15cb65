//! What a shape looks like, and where pictures lie on it.

use std::f64::consts::{PI, TAU};

use glam::{DAffine2, DVec2};

use super::super::super::Textures;
use super::super::super::surface::geographic;
use super::super::affine::Affine;
use super::super::geometry::Geometry;
use super::super::pictures::UPRIGHT;
use super::bsdfs::Surface;
use crate::math::{DVec3, Rgb, Vec2};

/// What a shape looks like.
pub(super) struct Look {
    pub material: u32,
    pub surface: Surface,
    pub emission: Rgb,
}

impl Look {
    pub fn has_pictures(&self) -> bool {
        self.surface.textures != Textures::NONE
    }

    /// The coordinates that show the same part of the pictures here. Where they are the same, and without pictures, they stay as
    /// they are, bit by bit. Mitsuba turns those of OBJ files over by itself.
    pub fn upright(&self, geometry: Geometry, kind: &str) -> Geometry {
        let turned = if kind == "obj" { UPRIGHT } else { DAffine2::IDENTITY };
        let map = UPRIGHT * self.surface.to_uv * turned;
        if !self.has_pictures() || map == DAffine2::IDENTITY {
            return geometry;
        }
        let mapped = |uv: Vec2| map.transform_point2(uv.as_dvec2()).as_vec2();
        Geometry { uvs: geometry.uvs.map(|uvs| uvs.into_iter().map(mapped).collect()), ..geometry }
    }

    /// Whether pictures lie on a sphere in `to_world` as they do here.
    pub fn lies_as_here(&self, to_world: &Affine) -> bool {
        let is_same = |dir: DVec3| {
            let local = to_world.0.matrix3.inverse() * dir;
            let theirs = DVec2::new(local.y.atan2(local.x) / TAU, (local.normalize_or_zero().z).acos() / PI);
            let theirs = (UPRIGHT * self.surface.to_uv).transform_point2(theirs);
            let apart = theirs - geographic(dir.normalize().as_vec3()).as_dvec2();
            (apart - apart.round()).abs().max_element() < 1e-4
        };
        let signs = [-1.0, 1.0];
        let octants = signs.iter().flat_map(|x| signs.iter().flat_map(move |y| signs.map(|z| (*x, *y, z))));
        octants.map(|(x, y, z)| DVec3::new(0.3 * x, 0.5 * y, 0.8 * z)).all(is_same)
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::super::{SceneDesc, load};
    use super::super::testing::with_sensor;
    use super::*;
    use crate::film::Image;
    use crate::output::{Metadata, write_exr};

    /// A bsdf with a picture of one pixel, with more in its `<texture>`.
    fn pictured(more: &str) -> String {
        let file = "<string name='filename' value='a.exr'/>";
        format!(
            "<bsdf type='diffuse'><texture name='reflectance' type='bitmap'>{file}{more}</texture></bsdf>"
        )
    }

    fn read_pictured(shape: &str) -> Result<SceneDesc, String> {
        let folder = tempfile::tempdir().unwrap();
        let image = Image::from_pixels(1, 1, vec![Rgb::splat(0.5)]).unwrap();
        write_exr(&folder.path().join("a.exr"), &image, &Metadata::default()).unwrap();
        std::fs::write(folder.path().join("s.xml"), with_sensor(shape)).unwrap();
        load(&folder.path().join("s.xml")).map_err(|e| e.to_string())
    }

    #[test]
    fn pictures_lie_on_rectangles_as_in_mitsuba() {
        let uvs = |more: &str| {
            let shape = format!("<shape type='rectangle'>{}</shape>", pictured(more));
            read_pictured(&shape).unwrap().meshes[0].uvs.clone().unwrap()
        };
        assert_eq!(uvs(""), [(0., 1.), (1., 1.), (1., 0.), (0., 0.)].map(Vec2::from));
        let twice = "<transform name='to_uv'><scale x='2' y='-3'/><translate y='1'/></transform>";
        assert_eq!(uvs(twice), [(0., 0.), (2., 0.), (2., 3.), (0., 3.)].map(Vec2::from));
    }

    #[test]
    fn pictures_lie_on_spheres_as_in_mitsuba_or_are_refused() {
        let upright =
            "<transform name='to_world'><rotate x='1' angle='-90'/><rotate y='1' angle='180'/></transform>";
        let ball = |place: &str, more: &str| {
            read_pictured(&format!("<shape type='sphere'>{}{place}</shape>", pictured(more)))
        };
        assert!(ball(upright, "").is_ok());
        let half_turned = upright.replace("180", "0");
        let to_uv = "<transform name='to_uv'><translate x='0.5' y='2'/></transform>";
        assert!(ball(&half_turned, to_uv).is_ok());
        for (place, more) in [("", ""), (upright, to_uv), (half_turned.as_str(), "")] {
            let error = ball(place, more).unwrap_err();
            assert!(error.contains("s.xml:7: shape `sphere`: a picture on a sphere whose poles"), "{error}");
        }
    }

    #[test]
    fn shapes_without_coordinates_take_no_picture() {
        let error = read_pictured(&format!("<shape type='disk'>{}</shape>", pictured(""))).unwrap_err();
        assert!(error.contains("shape `disk`: has a picture, but no texture coordinates here"), "{error}");
    }
}
