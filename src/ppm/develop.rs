//! From statistics to a picture: `L = emitted + Σ weight · albedo / π · (E_direct + τ / (π R² N_emitted))`.

use std::f64::consts::PI;

use rayon::prelude::*;

use super::Render;
use super::collector::Collector;
use crate::effects::PathClass;
use crate::film::Image;
use crate::math::{DVec3, Rgb};

pub(super) fn picture(render: &Render) -> Image {
    image(render, |pixel| {
        let layers = render.plan.classes.iter().map(|class| class_radiance(render, class, pixel).as_vec3());
        layers.sum::<Rgb>().as_dvec3()
    })
}

pub(super) fn layer(render: &Render, class: PathClass) -> Image {
    image(render, |pixel| class_radiance(render, class, pixel))
}

/// The radiance of a pixel by one kind of path; zero by those that are not simulated.
fn class_radiance(render: &Render, class: PathClass, pixel: usize) -> DVec3 {
    match class {
        _ if !render.plan.classes.contains(class) => DVec3::ZERO,
        PathClass::Direct => {
            render.emitted_light[pixel].as_dvec3() + reflected(render, pixel, |p| render.direct.irradiance(p))
        }
        PathClass::Caustic | PathClass::Indirect => {
            render.collector(class).map_or(DVec3::ZERO, |collector| {
                reflected(render, pixel, |p| collector.state(p).irradiance(render.emitted_photons))
            })
        }
    }
}

/// The radiance of a pixel, of all light found so far.
pub(super) fn radiance(render: &Render, pixel: usize) -> DVec3 {
    render.plan.classes.iter().map(|class| class_radiance(render, class, pixel)).sum()
}

/// The part of [`radiance`] that changes from pass to pass.
pub(super) fn noisy_radiance(render: &Render, pixel: usize) -> DVec3 {
    let share = 1.0 / (PI * render.emitted_photons.max(1) as f64);
    let from = |collector: &Collector, p| {
        let state = collector.state(p);
        state.flux * (share / state.radius2)
    };
    let photons = |p| render.collectors.iter().map(|collector| from(collector, p)).sum::<DVec3>();
    if !render.direct.is_sampled() {
        return reflected(render, pixel, photons);
    }
    // One walk for all: estimates of the error read every hit point again and again.
    reflected(render, pixel, |p| photons(p) + render.direct.irradiance_from_areas(p))
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
