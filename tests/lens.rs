//! Thin lens and pixel filters: every method against closed forms, and the two references against each other.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a panic is how a test fails")]

mod common;

use std::f64::consts::PI;

use caustica::film::Image;
use caustica::ppm::{Render, Settings};
use caustica::reference::Method;
use caustica::scene::{PixelFilter, Scene, SceneDesc};
use common::{desc_of, estimated, settings};

const WIDTH: usize = 16;
const HEIGHT: usize = 4;
const FOCUS: f32 = 5.0;

/// Pixels at unit distance are 1/16 wide.
const CAMERA: &str = "\
[film]
width = 16
height = 4
[camera]
position = [0, 0, 0]
look_at = [0, 0, -5]
fov = 53.13010235
[render]
samples = 400
photons = 1
[material.lamp]
diffuse = { albedo = [0, 0, 0] }
emission = [1, 1, 1]
[material.paper]
diffuse = { albedo = [0.5, 0.5, 0.5] }
";

fn desc(objects: &str, filter: PixelFilter, lens_radius: f32) -> SceneDesc {
    let mut desc = desc_of(&format!("{CAMERA}{objects}"));
    assert!((desc.camera.focus_distance - FOCUS).abs() < 1e-6);
    (desc.film.filter, desc.camera.lens_radius) = (filter, lens_radius);
    desc
}

/// A half-plane that faces the camera at that depth; its edge is the middle of the picture.
fn half_plane(material: &str, depth: f32) -> String {
    format!(
        "[[quad]]\ncorners = [[0, -99, -{depth}], [99, -99, -{depth}], [99, 99, -{depth}], [0, 99, -{depth}]]\n\
         material = \"{material}\"\n"
    )
}

/// The share of a pixel that a half-plane covers whose edge is `x` pixels away: filter and disc of confusion as sums of
/// two independent numbers, each with the distribution of its density along an axis.
fn coverage(x: f64, filter: PixelFilter, disc_radius: f64) -> f64 {
    const STEPS: u32 = 2000;
    let steps =
        |reach: f64| (0..STEPS).map(move |k| reach * (2.0 * (f64::from(k) + 0.5) / f64::from(STEPS) - 1.0));
    let reach = f64::from(filter.reach());
    let density = |t: f64| match filter {
        PixelFilter::Points | PixelFilter::Box => 1.0,
        PixelFilter::Tent => 1.0 - t.abs(),
        PixelFilter::Gaussian => (-2.0 * t * t).exp(),
    };
    let (total, covered) = steps(reach).fold((0.0, 0.0), |(total, covered), t| {
        (total + density(t), covered + density(t) * disc_share(x + t, disc_radius))
    });
    covered / total
}

/// The share of a disc about `x` that lies above 0.
fn disc_share(x: f64, radius: f64) -> f64 {
    let s = x / radius;
    if s.abs() >= 1.0 || radius == 0.0 {
        return if x > 0.0 { 1.0 } else { 0.0 };
    }
    0.5 + (s * (1.0 - s * s).sqrt() + s.asin()) / PI
}

/// The mean of each column, of the red channel.
fn columns(image: &Image) -> Vec<f64> {
    let column = |x| (0..HEIGHT).map(|y| f64::from(image.get(x, y).x)).sum::<f64>() / HEIGHT as f64;
    (0..WIDTH).map(column).collect()
}

/// Sharp in the plane of focus, a disc of confusion of diameter `2 r |1 / z - 1 / f|` elsewhere.
#[test]
fn an_edge_is_as_blurred_as_lens_and_filter_say() {
    for filter in PixelFilter::ALL {
        for (radius, depth) in [(0.0, 2.0), (0.5, 5.0), (0.5, 2.5), (0.4, 20.0)] {
            let scene = Scene::new(desc(&half_plane("lamp", depth), filter, radius)).unwrap();
            let disc = f64::from(radius * (1.0 / depth - 1.0 / FOCUS).abs()) * 16.0;
            let path = columns(&estimated(&scene, Method::Path, 4000, 1).0);
            let eye = columns(&Render::new(&scene, settings(&scene)).direct_picture());
            for x in 0..WIDTH {
                let expected = coverage(x as f64 + 0.5 - 8.0, filter, disc);
                let what = format!("{filter}, lens {radius}, depth {depth}, column {x}: {expected}");
                assert!((path[x] - expected).abs() < 0.02, "{what}, path tracer {}", path[x]);
                assert!((eye[x] - expected).abs() < 0.02, "{what}, eye pass {}", eye[x]);
            }
        }
    }
}

/// Light tracing connects to points of the lens and spreads its splats by the filter; path tracing does neither.
#[test]
fn light_tracing_sees_through_lens_and_filter_what_path_tracing_sees() {
    let light = "[[point_light]]\nposition = [0.3, 0, -2.2]\nintensity = [1, 1, 1]\n";
    for (filter, radius) in [(PixelFilter::Tent, 0.0), (PixelFilter::Gaussian, 0.5), (PixelFilter::Box, 0.5)]
    {
        let objects = half_plane("paper", 2.5) + &half_plane("paper", 3.5).replace("[0,", "[-99,") + light;
        let scene = Scene::new(desc(&objects, filter, radius)).unwrap();
        let pictures = [(Method::Path, 2000), (Method::Light, 20_000)]
            .map(|(method, n)| estimated(&scene, method, n, 1));
        let [path, traced] = pictures.each_ref().map(|(mean, _)| columns(mean));
        // Splats of a path are correlated within a column.
        let [of_path, of_light] = pictures.each_ref().map(|(_, stderr)| columns(stderr));
        for x in 0..WIDTH {
            let doubt = 5.0 * of_path[x].hypot(of_light[x]);
            assert!(doubt < 0.12 * path[8], "nothing is known of column {x}: {doubt}");
            let difference = traced[x] - path[x];
            assert!(
                difference.abs() < doubt,
                "{filter}, lens {radius}, column {x}: {} for {}",
                traced[x],
                path[x]
            );
        }
    }
}

/// In a closed room of even light every ray sees the same: `E / (1 - albedo)`.
#[test]
fn a_furnace_knows_no_lens() {
    let walls: String =
        ["x", "y", "z"].iter().flat_map(|axis| [-1, 1].map(|side| wall(axis, side))).collect();
    let room = walls.replace("lamp", "wall")
        + "[material.wall]\ndiffuse = { albedo = [0.5, 0.5, 0.5] }\nemission = [1, 1, 1]\n";
    for (filter, radius) in [(PixelFilter::Gaussian, 0.0), (PixelFilter::Box, 0.9)] {
        let scene = Scene::new(desc(&room, filter, radius)).unwrap();
        let path = estimated(&scene, Method::Path, 4000, 1).0;
        let settings = Settings { samples: 16, photons: 20_000, radius: Some(0.3), ..settings(&scene) };
        let mapped = common::photon_mapped(&scene, settings, 40);
        for image in [path, mapped] {
            let mean = columns(&image).iter().sum::<f64>() / WIDTH as f64;
            assert!((mean / 2.0 - 1.0).abs() < 0.02, "{filter}, lens {radius}: {mean}");
        }
    }
}

/// Of a cube with half edges of 8 about the camera, seen from within.
fn wall(axis: &str, side: i32) -> String {
    let corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(|[u, v]| {
        let (u, v) = (8 * u * -side, 8 * v);
        match axis {
            "x" => [8 * side, u, v],
            "y" => [v, 8 * side, u],
            _ => [u, v, 8 * side],
        }
    });
    format!("[[quad]]\ncorners = {corners:?}\nmaterial = \"lamp\"\n")
}
