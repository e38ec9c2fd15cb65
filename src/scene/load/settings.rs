//! The tables `[film]`, `[camera]` and `[render]`.

use super::super::{CameraDesc, FilmDesc, RenderDesc, SceneError};
use super::access::Limits;
use super::fields::{Allowed, COORDINATE, FIELD_OF_VIEW, Field, Fields, MAX_COORDINATE, Names, POSITIVE};
use crate::camera::PixelFilter;
use crate::math::Vec3;

const ALPHA: Allowed = Allowed { text: "a number above 0, up to 1", holds: |x| x > 0.0 && x <= 1.0 };
const LENS_RADIUS: Allowed =
    Allowed { text: "a number from 0, a pinhole, to 1.8e18", holds: |x| (0.0..=MAX_COORDINATE).contains(&x) };
const FOCUS_DISTANCE: Allowed =
    Allowed { text: "a number above 0, up to 1.8e18", holds: |x| x > 0.0 && x <= MAX_COORDINATE };
const U32: u64 = u32::MAX as u64;
/// TOML's largest whole number.
const LARGEST: u64 = i64::MAX as u64;

/// The most pixels of a row or a column.
pub(super) const LONGEST_SIDE: u64 = 16384;

pub(super) fn film(root: &Fields, limits: &Limits) -> Result<FilmDesc, SceneError> {
    const DEFAULT: u64 = 512;
    const SIDE: (u64, u64) = (1, LONGEST_SIDE);
    let Some(field) = root.optional("film") else {
        return Ok(FilmDesc::new(DEFAULT as u32, DEFAULT as u32));
    };
    let film = field.table(String::from("film"), &["width", "height", "filter"])?;
    Ok(FilmDesc {
        width: whole(&film, "width", DEFAULT, SIDE, limits.side)? as u32,
        height: whole(&film, "height", DEFAULT, SIDE, limits.side)? as u32,
        filter: film.optional("filter").map_or(Ok(PixelFilter::Points), |field| filter(&field))?,
    })
}

fn filter(field: &Field) -> Result<PixelFilter, SceneError> {
    let names: Names = PixelFilter::ALL.iter().map(|filter| filter.name()).collect();
    Ok(PixelFilter::ALL[field.choice(&names)?])
}

/// A whole number, or `default` where the field is absent: within `bounds` in any scene, up to `most` in a sandbox.
fn whole(table: &Fields, name: &str, default: u64, bounds: (u64, u64), most: u64) -> Result<u64, SceneError> {
    let Some(field) = table.optional(name) else { return Ok(default) };
    let number = field.integer(bounds)?;
    if number > most {
        return Err(field.wrong(&format!("up to {most} in the sandbox")));
    }
    Ok(number)
}

/// Refuses more eye samples in the whole picture than a sandbox allows.
pub(super) fn check_eye_paths(film: &FilmDesc, render: &RenderDesc, limits: &Limits) -> Result<(), String> {
    let paths = u64::from(film.width) * u64::from(film.height) * u64::from(render.samples);
    if paths <= limits.eye_paths {
        return Ok(());
    }
    Err(format!(
        ": {} x {} pixels of {} samples are {paths} eye samples; allowed in the sandbox: {}",
        film.width, film.height, render.samples, limits.eye_paths
    ))
}

pub(super) fn camera(root: &Fields) -> Result<CameraDesc, SceneError> {
    let field = root.required("camera", "a table [camera] with position, look_at and fov")?;
    let known = ["position", "look_at", "up", "fov", "lens_radius", "focus_distance"];
    let table = field.table(String::from("camera"), &known)?;
    let up = table.optional("up").map_or(Ok(Vec3::Y), |field| field.vec3(&COORDINATE))?;
    let pinhole = CameraDesc::pinhole(
        table.required("position", "three numbers")?.vec3(&COORDINATE)?,
        table.required("look_at", "three numbers")?.vec3(&COORDINATE)?,
        table.required("fov", FIELD_OF_VIEW.text)?.f32(&FIELD_OF_VIEW)?,
    );
    let number =
        |name, default, allowed| table.optional(name).map_or(Ok(default), |field| field.f32(allowed));
    let camera = CameraDesc {
        up,
        lens_radius: number("lens_radius", pinhole.lens_radius, &LENS_RADIUS)?,
        focus_distance: number("focus_distance", pinhole.focus_distance, &FOCUS_DISTANCE)?,
        ..pinhole
    };
    check_view(&table, &camera)?;
    Ok(camera)
}

fn check_view(table: &Fields, camera: &CameraDesc) -> Result<(), SceneError> {
    const PARALLEL: f64 = 1e-6;
    let view = camera.look_at.as_dvec3() - camera.position.as_dvec3();
    let up = camera.up.as_dvec3();
    let about = |name, wrong: &str| match table.optional(name) {
        Some(field) => field.error(format!(" {wrong}")),
        None => table.error(format!("field `{name}` (0, 1, 0 by default) {wrong}")),
    };
    if view.length() == 0.0 {
        return Err(about("look_at", "equals `position`; allowed: any other point"));
    }
    if up.cross(view).length() <= PARALLEL * up.length() * view.length() {
        return Err(about("up", "is zero or parallel to the view; allowed: any other direction"));
    }
    Ok(())
}

pub(super) fn render(root: &Fields, limits: &Limits) -> Result<RenderDesc, SceneError> {
    let mut render = RenderDesc::default();
    let Some(field) = root.optional("render") else { return Ok(render) };
    let known = ["passes", "photons", "samples", "alpha", "radius", "depth"];
    let table = field.table(String::from("render"), &known)?;
    let count = |name, default, bounds, most| whole(&table, name, default, bounds, most);
    render.passes = count("passes", u64::from(render.passes), (1, U32), limits.passes)? as u32;
    render.photons = count("photons", render.photons, (1, LARGEST), limits.photons)?;
    render.samples = count("samples", u64::from(render.samples), (1, 4096), limits.samples)? as u32;
    render.depth = count("depth", u64::from(render.depth), (0, 1024), limits.depth)? as u32;
    render.alpha = table.optional("alpha").map_or(Ok(render.alpha), |field| field.f64(&ALPHA))?;
    render.radius = table.optional("radius").map(|field| field.f64(&POSITIVE)).transpose()?;
    Ok(render)
}

#[cfg(test)]
mod tests {
    use super::super::testing::{BASE, added_fails_with, changed_fails_with, good};
    use super::*;

    #[test]
    fn defaults_are_the_documented_ones() {
        let scene = good(BASE, &[]);
        assert_eq!((scene.name.as_str(), scene.film.width, scene.film.height), ("s", 512, 512));
        let r = scene.render;
        assert_eq!(
            (r.passes, r.photons, r.samples, r.alpha, r.radius, r.depth),
            (64, 100_000, 4, 0.7, None, 12)
        );
        assert_eq!((scene.camera.up, scene.camera.fov_degrees), (Vec3::Y, 40.0));
        assert_eq!((scene.camera.lens_radius, scene.camera.focus_distance), (0.0, 5.0));
        assert_eq!(scene.film.filter, PixelFilter::Points);
        assert!(scene.warnings.is_empty());
    }

    #[test]
    fn every_setting_arrives() {
        let film = "[film]\nwidth = 3\nheight = 0x10\nfilter = \"tent\"\n";
        let render = "[render]\npasses = 1\nphotons = 5_000_000_000\nsamples = 9\nalpha = 1\nradius = 1e-3\ndepth = 0\n";
        let scene = good(&format!("{film}{render}{BASE}"), &[]);
        assert_eq!(scene.film, FilmDesc { width: 3, height: 16, filter: PixelFilter::Tent });
        let photons = 5_000_000_000;
        let expected =
            RenderDesc { passes: 1, photons, samples: 9, alpha: 1.0, radius: Some(1e-3), depth: 0 };
        assert_eq!(scene.render, expected);
    }

    #[test]
    fn a_lens_is_sharp_where_it_is_told_or_where_it_looks_at() {
        let lens = |fields: &str| {
            let camera = good(&BASE.replace("fov = 40", &format!("fov = 40\n{fields}")), &[]).camera;
            (camera.lens_radius, camera.focus_distance)
        };
        assert_eq!(lens("lens_radius = 0.25"), (0.25, 5.0));
        assert_eq!(lens("lens_radius = 1\nfocus_distance = 3"), (1.0, 3.0));
        assert_eq!(lens("lens_radius = 0"), (0.0, 5.0));
    }

    #[test]
    fn every_filter_has_a_name() {
        for filter in PixelFilter::ALL {
            let scene = good(&format!("[film]\nfilter = \"{filter}\"\n{BASE}"), &[]);
            assert_eq!(scene.film.filter, filter);
        }
    }

    #[test]
    fn mistakes_in_the_camera_are_told() {
        for (old, new, place, words) in [
            (
                "fov = 40",
                "fov = 0",
                "s.toml:4:7: camera: field `fov` is 0",
                "allowed: degrees above 0 and below 180",
            ),
            ("fov = 40", "fov = 180", "s.toml:4:7", "is 180; allowed: degrees"),
            ("fov = 40", "fov = nan", "s.toml:4:7", "is nan; allowed: degrees"),
            ("fov = 40", "fov = \"wide\"", "s.toml:4:7", "is \"wide\"; allowed: degrees"),
            (
                "fov = 40",
                "fvo = 40",
                "s.toml:4:1",
                "unknown field `fvo`; did you mean `fov`? allowed: `position`, `look_at`",
            ),
            ("fov = 40", "", "s.toml:1:1", "camera: field `fov` is missing; allowed: degrees"),
            ("look_at = [0, 0, 0]", "look_at = [0, 0, 5]", "s.toml:3:11", "equals `position`"),
            (
                "look_at = [0, 0, 0]",
                "look_at = [0, 9, 5]",
                "s.toml:1:1",
                "field `up` (0, 1, 0 by default) is zero or parallel",
            ),
            ("fov = 40", "fov = 40\nup = [0, 0, -3]", "s.toml:5:6", "field `up` is zero or parallel"),
            ("fov = 40", "fov = 40\nup = [0, 0, 0]", "s.toml:5:6", "field `up` is zero or parallel"),
            (
                "position = [0, 0, 5]",
                "position = [0, 0]",
                "s.toml:2:12",
                "is [0, 0]; allowed: an array of 3 numbers",
            ),
            (
                "position = [0, 0, 5]",
                "position = [0, inf, 5]",
                "s.toml:2:16",
                "field `position[1]` is inf; allowed: a number from",
            ),
            ("position = [0, 0, 5]", "position = 7", "s.toml:2:12", "is 7; allowed: an array of 3 numbers"),
            (
                "position = [0, 0, 5]",
                "position = [0, 2e18, 5]",
                "s.toml:2:16",
                "is 2e18; allowed: a number from -1.8e18",
            ),
            ("position = [0, 0, 5]", "", "s.toml:1:1", "field `position` is missing"),
            ("look_at = [0, 0, 0]", "", "s.toml:1:1", "field `look_at` is missing"),
        ] {
            changed_fails_with(old, new, place, words);
        }
    }

    #[test]
    fn mistakes_in_the_lens_are_told() {
        for (old, new, place, words) in [
            (
                "fov = 40",
                "fov = 40\nlens_radius = -1",
                "s.toml:5:15",
                "camera: field `lens_radius` is -1; allowed: a number from 0, a pinhole, to 1.8e18",
            ),
            ("fov = 40", "fov = 40\nlens_radius = inf", "s.toml:5:15", "is inf; allowed: a number from 0"),
            (
                "fov = 40",
                "fov = 40\nlens_radius = 1\nfocus_distance = 0",
                "s.toml:6:18",
                "camera: field `focus_distance` is 0; allowed: a number above 0, up to 1.8e18",
            ),
            ("fov = 40", "fov = 40\nfocus_distnce = 3", "s.toml:5:1", "did you mean `focus_distance`?"),
        ] {
            changed_fails_with(old, new, place, words);
        }
    }

    #[test]
    fn mistakes_in_film_and_render_are_told() {
        for (tables, line, words) in [
            ("[film]\nwidth = 0", 11, "film: field `width` is 0; allowed: a whole number from 1 to 16384"),
            ("[film]\nheight = 16385", 11, "is 16385; allowed: a whole number"),
            ("[film]\nheight = 1.5", 11, "is 1.5; allowed: a whole number"),
            ("[film]\nheight = -1", 11, "is -1; allowed: a whole number"),
            (
                "[film]\nfilter = \"gauss\"",
                11,
                "film: field `filter`: unknown name `gauss`; did you mean `gaussian`? allowed: `points`, `box`, `tent`",
            ),
            ("[film]\nfilter = 2", 11, "field `filter` is 2; allowed: a text in quotes"),
            ("[render]\nphotons = 0", 11, "is 0; allowed: a whole number from 1 to"),
            ("[render]\nphotons = 99999999999999999999", 11, "allowed: a whole number from 1 to"),
            ("[render]\npasses = 0", 11, "is 0; allowed: a whole number from 1 to"),
            ("[render]\npasses = 4294967296", 11, "allowed: a whole number from 1 to 4294967295"),
            ("[render]\nsamples = 4097", 11, "allowed: a whole number from 1 to 4096"),
            ("[render]\ndepth = 1025", 11, "allowed: a whole number from 0 to 1024"),
            ("[render]\nalpha = 0", 11, "is 0; allowed: a number above 0, up to 1"),
            ("[render]\nalpha = 1.01", 11, "is 1.01; allowed: a number above 0, up to 1"),
            ("[render]\nradius = 0", 11, "is 0; allowed: a finite number above 0"),
            ("[render]\nradius = inf", 11, "is inf; allowed: a finite number above 0"),
            ("[render]\nradii = 1", 11, "unknown field `radii`; did you mean `radius`?"),
        ] {
            added_fails_with(tables, line, words);
        }
    }
}
