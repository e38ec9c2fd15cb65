//! From statistics to a picture: `L = emitted + Σ weight · albedo / π · (E_direct + τ / (π R² N_emitted))`.

use std::f64::consts::PI;

use rayon::prelude::*;

use super::Render;
use crate::film::Image;
use crate::math::DVec3;

pub(super) fn picture(render: &Render) -> Image {
    image(render, |pixel| radiance(render, pixel))
}

pub(super) fn direct_picture(render: &Render) -> Image {
    image(render, |pixel| {
        render.emitted_light[pixel].as_dvec3() + reflected(render, pixel, |p| render.direct.irradiance(p))
    })
}

/// The radiance of a pixel, of all light found so far.
pub(super) fn radiance(render: &Render, pixel: usize) -> DVec3 {
    render.emitted_light[pixel].as_dvec3()
        + reflected(render, pixel, |p| render.direct.irradiance(p) + from_photons(render, p))
}

/// The part of [`radiance`] that changes from pass to pass.
pub(super) fn noisy_radiance(render: &Render, pixel: usize) -> DVec3 {
    let share = 1.0 / (PI * render.emitted_photons as f64);
    let photons = |p| {
        let state = render.states.get(p);
        state.flux * (share / state.radius2)
    };
    if !render.direct.is_sampled() {
        return reflected(render, pixel, photons);
    }
    // One walk for both: estimates of the error read every hit point again and again.
    reflected(render, pixel, |p| photons(p) + render.direct.irradiance_from_areas(p))
}

fn from_photons(render: &Render, position: usize) -> DVec3 {
    render.states.get(position).irradiance(render.emitted_photons)
}

/// What a pixel sees of the irradiance at its hit points.
fn reflected(render: &Render, pixel: usize, irradiance: impl Fn(usize) -> DVec3) -> DVec3 {
    let seen = render.pixel_lists().of(pixel).iter();
    seen.map(|seen| seen.factor.as_dvec3() * irradiance(seen.position as usize)).sum()
}

/// The picture of what each pixel is given, computed side by side.
pub(super) fn image(render: &Render, of: impl Fn(usize) -> DVec3 + Sync) -> Image {
    let film = render.scene.film();
    let mut image = Image::new(film.width as usize, film.height as usize);
    image.pixels_mut().par_iter_mut().enumerate().for_each(|(pixel, to)| *to = of(pixel).as_vec3());
    image
}
