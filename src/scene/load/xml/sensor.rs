//! `<sensor>` and its `<film>`: where the picture is taken from, and its pixels.

use super::super::super::{CameraDesc, FilmDesc, SceneError};
use super::super::fields::{COORDINATE, FIELD_OF_VIEW, FINITE, POSITIVE};
use super::super::geometry::Motion;
use super::super::settings;
use super::element::Element;
use super::object::{Context, Object};
use super::transform::{self, LookAt};
use crate::camera::{GAUSSIAN_CUT, GAUSSIAN_SIGMA, PixelFilter};
use crate::math::DVec3;

/// What Mitsuba's cameras stop seeing, which ours do not, and how it stores the picture.
const CLIPPING: [&str; 2] = ["near_clip", "far_clip"];
const STORAGE: [&str; 7] = [
    "pixel_format",
    "component_format",
    "file_format",
    "high_quality_edges",
    "sample_border",
    "banner",
    "compensate",
];

pub(super) fn read<'a>(
    element: &'a Element,
    context: &'a Context<'a>,
) -> Result<(CameraDesc, FilmDesc), SceneError> {
    let object = Object::new(element, context)?;
    let kind = object.kind()?;
    if !["perspective", "thinlens"].contains(&kind) {
        return Err(
            element.error(format!("sensor `{kind}` is not supported; allowed: `perspective`, `thinlens`"))
        );
    }
    let film_element = object.object("film")?;
    let film = film_element.map_or_else(|| Ok(default_film()), |film| read_film(film, context))?;
    let fov = field_of_view(&object, f64::from(film.width) / f64::from(film.height))?;
    let view = view(&object)?;
    let [origin, target, up] = [view.origin, view.target, view.up].map(|v| v.as_vec3());
    let mut camera = CameraDesc { up, ..CameraDesc::pinhole(origin, target, fov) };
    if kind == "thinlens" {
        lens(&object, &mut camera)?;
    }
    for name in ["principal_point_offset_x", "principal_point_offset_y"] {
        if object.f64(name, 0.0, &FINITE)? != 0.0 {
            return Err(object.error(format!("`{name}` other than 0 is not supported; allowed: 0")));
        }
    }
    if let Some(sampler) = object.object("sampler")? {
        context.has_no_use(sampler.label());
    }
    object.has_no_use_for(&CLIPPING);
    object.has_no_use_for(&["shutter_open", "shutter_close"]);
    object.finish()?;
    Ok((camera, film))
}

fn lens(object: &Object, camera: &mut CameraDesc) -> Result<(), SceneError> {
    let required = |name| {
        let missing = || object.error(format!("`{name}` is missing; allowed: {}", POSITIVE.text));
        object.optional_f64(name, &POSITIVE)?.ok_or_else(missing)
    };
    camera.lens_radius = required("aperture_radius")? as f32;
    camera.focus_distance = required("focus_distance")? as f32;
    let reach = [camera.lens_radius, camera.focus_distance].map(f64::from);
    if reach.into_iter().all(|x| (COORDINATE.holds)(x)) && camera.focus_distance > 0.0 {
        return Ok(());
    }
    Err(object.error("the lens is beyond what is traced; allowed: lengths above 0, up to 1.8e18"))
}

/// The view of `to_world`: as its one `<lookat>` says it, else as its axes do.
fn view(object: &Object) -> Result<LookAt, SceneError> {
    let sole = object.take("to_world").map(transform::sole_look_at).transpose()?.flatten();
    let view = match sole {
        Some(view) => view,
        None => {
            let to_world = object.transform("to_world")?;
            let scale = to_world.uniform_scale();
            if to_world.mirrors() || !scale.is_some_and(|scale| (scale - 1.0).abs() < 1e-3) {
                return Err(object.error(
                    "`to_world` scales, shears or mirrors, which is not supported; allowed: rotations and translations",
                ));
            }
            let (origin, up) = (to_world.map(DVec3::ZERO), to_world.vector(DVec3::Y));
            LookAt { origin, target: origin + to_world.vector(DVec3::Z), up }
        }
    };
    for p in [view.origin, view.target, view.up] {
        object.placed(p)?;
    }
    if view.origin.as_vec3() == view.target.as_vec3() {
        return Err(object
            .error("the view is too short for its place; allowed: a target that f32 tells from the origin"));
    }
    Ok(view)
}

/// The horizontal full angle in degrees, for a picture `aspect` times as wide as high.
fn field_of_view(object: &Object, aspect: f64) -> Result<f32, SceneError> {
    let half_tangent = |degrees: f64| (0.5 * degrees).to_radians().tan();
    let fov = object.optional_f64("fov", &FIELD_OF_VIEW)?;
    let axis = object.choice("fov_axis", "x", &["x", "y", "diagonal", "smaller", "larger"])?;
    let focal_length = object.string("focal_length")?;
    let diagonal = |tangent: f64| tangent / (1.0 + 1.0 / (aspect * aspect)).sqrt();
    let tangent = match (fov, focal_length) {
        (Some(_), Some(_)) => return Err(object.error("has `fov` and `focal_length`; allowed: either")),
        (Some(degrees), None) => match axis {
            "y" => half_tangent(degrees) * aspect,
            "diagonal" => diagonal(half_tangent(degrees)),
            "smaller" if aspect > 1.0 => half_tangent(degrees) * aspect,
            "larger" if aspect <= 1.0 => half_tangent(degrees) * aspect,
            _ => return Ok(degrees as f32),
        },
        (None, length) => diagonal(36f64.hypot(24.0) / (2.0 * millimetres(object, length)?)),
    };
    Ok((2.0 * tangent.atan()).to_degrees() as f32)
}

/// A focal length of a film of 36 x 24 mm; 50 mm where the file says nothing.
fn millimetres(object: &Object, length: Option<&str>) -> Result<f64, SceneError> {
    let text = length.unwrap_or("50mm");
    let number = text.trim().trim_end_matches("mm").trim().parse::<f64>().ok();
    let wrong =
        || object.error(format!("`focal_length` is `{text}`; allowed: millimetres above 0, as in `50mm`"));
    number.filter(|&x| (POSITIVE.holds)(x)).ok_or_else(wrong)
}

const SIDES: (u64, u64) = (768, 576);

fn default_film() -> FilmDesc {
    FilmDesc { filter: PixelFilter::Gaussian, ..FilmDesc::new(SIDES.0 as u32, SIDES.1 as u32) }
}

fn read_film<'a>(element: &'a Element, context: &'a Context<'a>) -> Result<FilmDesc, SceneError> {
    let object = Object::new(element, context)?;
    let kind = object.kind()?;
    if kind != "hdrfilm" {
        return Err(element.error(format!("film `{kind}` is not supported; allowed: `hdrfilm`")));
    }
    let (width, height) = (side(&object, "width", SIDES.0)?, side(&object, "height", SIDES.1)?);
    for (name, whole) in
        [("crop_offset_x", 0), ("crop_offset_y", 0), ("crop_width", width), ("crop_height", height)]
    {
        if object.integer(name, (0, settings::LONGEST_SIDE))?.is_some_and(|part| part != whole) {
            return Err(object.error(format!(
                "`{name}`: a part of the picture is not supported; allowed: {whole}, the whole"
            )));
        }
    }
    let filter =
        match (object.own_note().and_then(|note| note.attribute("filter")), object.object("rfilter")?) {
            (Some("points"), _) => PixelFilter::Points,
            (_, Some(rfilter)) => read_filter(rfilter, context)?,
            (_, None) => PixelFilter::Gaussian,
        };
    object.has_no_use_for(&STORAGE);
    object.finish()?;
    Ok(FilmDesc { width: width as u32, height: height as u32, filter })
}

fn side(object: &Object, name: &str, default: u64) -> Result<u64, SceneError> {
    let most = object.context.reader.limits().side;
    let side = object.integer(name, (1, settings::LONGEST_SIDE))?.unwrap_or(default);
    if side > most {
        return Err(object.error(format!("`{name}` is {side}; allowed: up to {most} in the sandbox")));
    }
    Ok(side)
}

fn read_filter<'a>(element: &'a Element, context: &'a Context<'a>) -> Result<PixelFilter, SceneError> {
    let object = Object::new(element, context)?;
    let only = |name: &str, ours: f32| {
        if object.f64(name, ours.into(), &POSITIVE)? as f32 != ours {
            return Err(object.error(format!("`{name}` other than {ours} is not supported; allowed: {ours}")));
        }
        Ok(())
    };
    let filter = match object.kind()? {
        "box" => only("radius", 0.5).map(|()| PixelFilter::Box)?,
        "tent" => only("radius", 1.0).map(|()| PixelFilter::Tent)?,
        "gaussian" => {
            only("stddev", GAUSSIAN_SIGMA)?;
            only("radius", GAUSSIAN_CUT)?;
            PixelFilter::Gaussian
        }
        other => {
            let reason = format!("rfilter `{other}` is not supported; allowed: `box`, `tent`, `gaussian`");
            context.unsupported(element, &reason, "the picture has `gaussian` instead")?;
            return Ok(PixelFilter::Gaussian);
        }
    };
    object.finish()?;
    Ok(filter)
}

#[cfg(test)]
mod tests {
    use super::super::testing::{SENSOR, read_text};
    use super::*;
    use crate::math::Vec3;

    const LENS: &str = "<float name='aperture_radius' value='0.5'/>";

    fn sensor(text: &str) -> Result<(CameraDesc, FilmDesc), String> {
        let scene = read_text(&format!("<scene version='3.0.0'>\n{text}\n</scene>"), &[], &[])?;
        Ok((scene.camera, scene.film))
    }

    fn camera(inside: &str) -> CameraDesc {
        sensor(&format!("<sensor type='perspective'>{inside}</sensor>")).unwrap().0
    }

    #[test]
    fn the_default_sensor_is_that_of_a_small_picture_camera() {
        let (camera, film) = sensor("<sensor type='perspective'/>").unwrap();
        assert_eq!(film, FilmDesc { width: 768, height: 576, filter: PixelFilter::Gaussian });
        assert_eq!((camera.position, camera.look_at, camera.up), (Vec3::ZERO, Vec3::Z, Vec3::Y));
        // A diagonal of 43.27 mm in front of 50 mm, of which 4/5 is the width.
        let expected = 2.0 * (0.8f64 * 43.266_615 / 100.0).atan().to_degrees();
        assert!((f64::from(camera.fov_degrees) - expected).abs() < 1e-5, "{}", camera.fov_degrees);
    }

    #[test]
    fn the_field_of_view_is_along_the_axis_that_is_named() {
        let film = |w, h| {
            format!(
                "<film type='hdrfilm'><integer name='width' value='{w}'/><integer name='height' value='{h}'/></film>"
            )
        };
        let fov = |axis: &str, w, h| {
            camera(&format!(
                "<float name='fov' value='60'/><string name='fov_axis' value='{axis}'/>{}",
                film(w, h)
            ))
            .fov_degrees
        };
        let wide = 2.0 * (2.0 * 30f32.to_radians().tan()).atan().to_degrees();
        assert_eq!([fov("x", 200, 100), fov("larger", 200, 100), fov("smaller", 100, 200)], [60.0; 3]);
        assert!((fov("y", 200, 100) - wide).abs() < 1e-4 && (fov("smaller", 200, 100) - wide).abs() < 1e-4);
        let narrow = 2.0 * (0.5 * 30f32.to_radians().tan()).atan().to_degrees();
        assert!(
            (fov("y", 100, 200) - narrow).abs() < 1e-4 && (fov("larger", 100, 200) - narrow).abs() < 1e-4
        );
        let diagonal = 2.0 * (30f32.to_radians().tan() / 2f32.sqrt()).atan().to_degrees();
        assert!((fov("diagonal", 99, 99) - diagonal).abs() < 1e-4);
    }

    #[test]
    fn views_are_those_of_lookat_or_of_the_axes() {
        let view = camera(
            "<transform name='to_world'><lookat origin='1,2,3' target='4,5,6' up='0,0,1'/></transform>",
        );
        assert_eq!(
            (view.position, view.look_at, view.up),
            (Vec3::new(1., 2., 3.), Vec3::new(4., 5., 6.), Vec3::Z)
        );
        let turned =
            camera("<transform name='to_world'><rotate y='1' angle='180'/><translate z='5'/></transform>");
        assert!((turned.look_at - Vec3::new(0., 0., 4.)).length() < 1e-6);
        let lens = format!("<sensor type='thinlens'>{LENS}<float name='focus_distance' value='3'/></sensor>");
        let lens = sensor(&lens).unwrap().0;
        assert_eq!((lens.lens_radius, lens.focus_distance), (0.5, 3.0));
    }

    #[test]
    fn filters_are_those_that_the_core_has() {
        let filter = |inside: &str| {
            sensor(&format!("<sensor type='perspective'>\n<film type='hdrfilm'>\n{inside}</film></sensor>"))
                .map(|(_, film)| film.filter)
        };
        assert_eq!(filter("<rfilter type='box'/>"), Ok(PixelFilter::Box));
        assert_eq!(filter("<rfilter type='tent'/>"), Ok(PixelFilter::Tent));
        assert_eq!(filter("<?caustica filter='points'?><rfilter type='box'/>"), Ok(PixelFilter::Points));
        assert!(filter("<rfilter type='lanczos'/>").unwrap_err().starts_with("s.xml:4: rfilter `lanczos`"));
        assert!(
            filter("<rfilter type='tent'><float name='radius' value='2'/></rfilter>")
                .unwrap_err()
                .contains("`radius` other than 1")
        );
    }

    #[test]
    fn mistakes_in_sensors_are_told() {
        for (text, words) in [
            ("<sensor type='orthographic'/>", "s.xml:2: sensor `orthographic` is not supported"),
            (
                "<sensor type='perspective'><float name='fov' value='180'/></sensor>",
                "value `180`; allowed: <float>, degrees",
            ),
            (
                "<sensor type='perspective'><float name='fov' value='18'/><string name='focal_length' value='5mm'/></sensor>",
                "allowed: either",
            ),
            (
                "<sensor type='perspective'><string name='focal_length' value='5cm'/></sensor>",
                "`focal_length` is `5cm`",
            ),
            (
                "<sensor type='perspective'><string name='fov_axis' value='z'/></sensor>",
                "`fov_axis`: unknown name `z`",
            ),
            ("<sensor type='thinlens'/>", "`aperture_radius` is missing"),
            (
                "<sensor type='perspective'><transform name='to_world'><scale x='-1'/></transform></sensor>",
                "scales, shears or mirrors",
            ),
            (
                "<sensor type='perspective'><transform name='to_world'><scale value='3'/></transform></sensor>",
                "scales, shears or mirrors",
            ),
            (
                "<sensor type='perspective'><film type='hdrfilm'><integer name='width' value='16385'/></film></sensor>",
                "allowed: <integer>, from 1 to 16384",
            ),
            (
                "<sensor type='perspective'><film type='hdrfilm'><integer name='crop_width' value='8'/></film></sensor>",
                "`crop_width`: a part of the picture",
            ),
            ("<sensor type='perspective'><film type='ldrfilm'/></sensor>", "film `ldrfilm` is not supported"),
            (
                "<sensor type='perspective'><float name='focus' value='1'/></sensor>",
                "sensor `perspective`: <float> `focus` is not supported",
            ),
            ("", "s.xml:1: has no <sensor>"),
        ] {
            let error = sensor(text).unwrap_err();
            assert!(error.contains(words), "{text}: {error}");
        }
        let second = sensor(&format!("{SENSOR}{SENSOR}"));
        assert!(second.is_ok(), "the first sensor counts");
    }
}
