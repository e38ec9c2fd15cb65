//! From statistics to a picture: `L = emitted + Σ weight · albedo / π · (E_direct + τ / (π R² N_emitted))`.

use rayon::prelude::*;

use super::direct::reflected;
use super::{HitPoint, Render};
use crate::film::Image;
use crate::math::{DVec3, Rgb};

pub(super) fn picture(render: &Render) -> Image {
    image(render, |pixel| radiance(render, pixel))
}

pub(super) fn direct_picture(render: &Render) -> Image {
    image(render, |pixel| developed(render, pixel, |position| render.direct.irradiance(position)))
}

/// The radiance of a pixel, of all light found so far.
pub(super) fn radiance(render: &Render, pixel: usize) -> DVec3 {
    developed(render, pixel, |position| {
        render.direct.irradiance(position) + render.states[position].irradiance(render.emitted_photons)
    })
}

/// The picture of what each pixel is given, computed side by side.
pub(super) fn image(render: &Render, of: impl Fn(usize) -> DVec3 + Sync) -> Image {
    let film = render.scene.film();
    let mut image = Image::new(film.width as usize, film.height as usize);
    let pixels: &mut [Rgb] = image.pixels_mut();
    pixels.par_iter_mut().enumerate().for_each(|(number, pixel)| *pixel = of(number).as_vec3());
    image
}

fn developed(render: &Render, pixel: usize, irradiance: impl Fn(usize) -> DVec3) -> DVec3 {
    let mut sum = render.emitted_light[pixel].as_dvec3();
    for position in render.pixel_lists.of(pixel) {
        sum += seen(render, &render.hit_points[position], irradiance(position));
    }
    sum
}

/// What a pixel sees of the irradiance at one of its hit points.
fn seen(render: &Render, hit_point: &HitPoint, irradiance: DVec3) -> DVec3 {
    let albedo = render.scene.materials()[hit_point.material as usize].bsdf.albedo();
    hit_point.weight.as_dvec3() * reflected(albedo, irradiance)
}
