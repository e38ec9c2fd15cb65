//! From statistics to a picture: `L = emitted + Σ weight · albedo / π · (E_direct + τ / (π R² N_emitted))`.

use std::f64::consts::PI;

use rayon::prelude::*;

use super::Render;
use super::collector::Collector;
use super::direct_light::DirectLight;
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
        PathClass::Direct => render.direct.radiance(render.pixel_lists(), pixel),
        PathClass::Caustic | PathClass::Indirect => {
            render.collector(class).map_or(DVec3::ZERO, |collector| {
                let irradiance = |p| collector.state(p).irradiance(render.emitted_photons);
                render.pixel_lists().reflected(pixel, irradiance)
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
    let lists = render.pixel_lists();
    match &render.direct {
        DirectLight::Retraced { light, .. } => light.radiance(pixel) + lists.reflected(pixel, photons),
        DirectLight::Fixed { pass, .. } if !pass.is_sampled() => lists.reflected(pixel, photons),
        // One walk for all: estimates of the error read every hit point again and again.
        DirectLight::Fixed { pass, .. } => {
            lists.reflected(pixel, |p| photons(p) + pass.irradiance_from_areas(p))
        }
    }
}

/// The picture of what each pixel is given, computed side by side.
pub(super) fn image(render: &Render, of: impl Fn(usize) -> DVec3 + Sync) -> Image {
    let film = render.scene.film();
    let mut image = Image::new(film.width as usize, film.height as usize);
    image.pixels_mut().par_iter_mut().enumerate().for_each(|(pixel, to)| *to = of(pixel).as_vec3());
    image
}
