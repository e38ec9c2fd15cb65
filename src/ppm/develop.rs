//! From statistics to a picture: `L = emitted + Σ weight · albedo / π · (E_direct + τ / (π R² N_emitted))`.

use std::f64::consts::PI;
use std::iter;

use rayon::prelude::*;

use super::Render;
use super::collector::Collector;
use super::direct_light::DirectLight;
use crate::effects::PathClass;
use crate::film::Image;
use crate::math::{DVec3, Rgb};

pub(super) fn picture(render: &Render) -> Image {
    image(render, |pixel| {
        let layers = iter::once(direct(render, pixel)).chain(by_photons(render, pixel));
        layers.map(DVec3::as_vec3).sum::<Rgb>().as_dvec3()
    })
}

pub(super) fn direct_picture(render: &Render) -> Image {
    image(render, |pixel| direct(render, pixel))
}

pub(super) fn layer(render: &Render, class: PathClass) -> Option<Image> {
    if class == PathClass::Direct {
        return Some(direct_picture(render));
    }
    match render.collector(class) {
        Some(collector) if collector.classes.iter().count() > 1 => None,
        Some(collector) => Some(image(render, |pixel| from_photons(render, collector, pixel))),
        None if class == PathClass::Caustic => Some(image(render, |pixel| from_glints(render, pixel))),
        None => Some(image(render, |_| DVec3::ZERO)),
    }
}

/// The radiance of a pixel by direct light; zero if that is not simulated.
fn direct(render: &Render, pixel: usize) -> DVec3 {
    match render.plan.classes.contains(PathClass::Direct) {
        true => render.direct.radiance(render.pixel_lists(), pixel),
        false => DVec3::ZERO,
    }
}

/// The radiance of a pixel by photons, collector by collector; that of rough surfaces goes with the other caustics.
fn by_photons(render: &Render, pixel: usize) -> impl Iterator<Item = DVec3> {
    let alone = render.collector(PathClass::Caustic).is_none();
    let collected = render.collectors.iter().map(move |collector| from_photons(render, collector, pixel));
    collected.chain(alone.then(|| from_glints(render, pixel)))
}

/// The radiance of a pixel by the photons of one collector.
fn from_photons(render: &Render, collector: &Collector, pixel: usize) -> DVec3 {
    let irradiance = |p| collector.state(p).irradiance(render.emitted_photons);
    let reflected = render.pixel_lists().reflected(pixel, irradiance);
    match collector.classes.contains(PathClass::Caustic) {
        true => reflected + from_glints(render, pixel),
        false => reflected,
    }
}

/// The radiance of a pixel by caustics on rough surfaces.
fn from_glints(render: &Render, pixel: usize) -> DVec3 {
    render.glints.as_ref().map_or(DVec3::ZERO, |glints| glints.radiance(pixel, render.emitted_photons))
}

/// The radiance of a pixel, of all light found so far.
pub(super) fn radiance(render: &Render, pixel: usize) -> DVec3 {
    direct(render, pixel) + by_photons(render, pixel).sum::<DVec3>()
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
    let glints = from_glints(render, pixel);
    glints
        + match &render.direct {
            _ if !render.plan.classes.contains(PathClass::Direct) => lists.reflected(pixel, photons),
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
