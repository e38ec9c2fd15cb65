//! From statistics to a picture: `L = emitted + Σ weight · albedo / π · (E_direct + τ / (π R² N_emitted))`.

use super::direct::reflected;
use super::{HitPoint, Render};
use crate::film::Image;
use crate::math::DVec3;

pub(super) fn picture(render: &Render) -> Image {
    develop(render, |index| {
        render.direct.irradiance(index) + render.states[index].irradiance(render.emitted_photons)
    })
}

pub(super) fn direct_picture(render: &Render) -> Image {
    develop(render, |index| render.direct.irradiance(index))
}

fn develop(render: &Render, irradiance: impl Fn(usize) -> DVec3) -> Image {
    let mut pixels: Vec<DVec3> = render.emitted_light.iter().map(|e| e.as_dvec3()).collect();
    for (index, hit_point) in render.hit_points.iter().enumerate() {
        pixels[hit_point.pixel as usize] += radiance(render, hit_point, irradiance(index));
    }
    let film = render.scene.film();
    let mut image = Image::new(film.width as usize, film.height as usize);
    for (pixel, sum) in image.pixels_mut().iter_mut().zip(pixels) {
        *pixel = sum.as_vec3();
    }
    image
}

fn radiance(render: &Render, hit_point: &HitPoint, irradiance: DVec3) -> DVec3 {
    let albedo = render.scene.materials()[hit_point.material as usize].bsdf.albedo();
    hit_point.weight.as_dvec3() * reflected(albedo, irradiance)
}
