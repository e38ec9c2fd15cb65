use super::super::Render;
use super::super::collector::Collector;
use super::super::develop::image;
use super::PixelError;
use crate::film::Image;
use crate::math::DVec3;

/// Pictures of what is known of the error.
#[derive(Clone, Debug)]
pub struct Layers {
    /// Standard error (radiance).
    pub stderr: Image,
    /// Bias (radiance), positive where the picture is too bright.
    pub bias: Image,
    /// Bound of the error (radiance); NaN where there are too few photons to tell.
    pub bound: Image,
    /// Photons that a pixel rests on, the same in all channels.
    pub photons: Image,
    /// Mean gather radius of a pixel's hit points and all kinds of paths in scene units, the same in all channels; 0 where there is none.
    pub radius: Image,
}

impl Layers {
    pub(super) fn of(render: &Render, errors: &[PixelError]) -> Layers {
        Layers {
            stderr: image(render, |pixel| errors[pixel].stderr),
            bias: image(render, |pixel| errors[pixel].bias),
            bound: image(render, |pixel| errors[pixel].bound),
            photons: image(render, |pixel| DVec3::splat(errors[pixel].photons)),
            radius: image(render, |pixel| DVec3::splat(mean_radius(render, pixel))),
        }
    }
}

fn mean_radius(render: &Render, pixel: usize) -> f64 {
    if render.sees_nothing(pixel) {
        return 0.0;
    }
    let seen = render.pixel_lists().of(pixel);
    let radii = |collector: &'_ Collector| -> f64 {
        seen.iter().map(|seen| collector.state(seen.position as usize).radius()).sum()
    };
    let sum: f64 = render.collectors.iter().map(radii).sum();
    sum / (seen.len() * render.collectors.len()).max(1) as f64
}
