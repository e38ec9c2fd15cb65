//! What the eye first sees of each pixel: for denoisers, and for putting pictures together.

use rayon::prelude::*;

use super::{Render, Settings, camera_pass};
use crate::bsdf::Transport;
use crate::effects::EyePaths;
use crate::film::Image;
use crate::math::{DVec3, Rgb, Vec2};
use crate::scene::{Coherence, Scene, SurfaceHit};

/// The surfaces that eye paths meet first, averaged over the samples of each pixel by its filter. Nothing is followed through mirrors
/// and glass: they count for themselves.
#[derive(Clone, Debug, PartialEq)]
pub struct Features {
    /// The share of the light from where the eye is that a surface does not absorb: reflected, mirrored or let through. So glass
    /// is white. Samples that meet nothing count as 0.
    pub albedo: Image,
    /// The mean of the shading normals in world space, unit and on the side that is seen; shorter than 1 where they differ, and
    /// samples that meet nothing count as 0.
    pub normal: Image,
    /// The mean depth along the axis of view, in scene units, of the samples that meet something; infinite where none does.
    pub depth: Image,
}

/// Enough samples a pixel where every pass has others.
const ENOUGH_SAMPLES: u32 = 64;

/// Rays that one task traces at a time, if that is not less than those of a pixel.
const BATCH: u32 = 4096;

/// Sums over the samples of a pixel.
#[derive(Clone, Copy, Debug, Default)]
struct Seen {
    samples: u32,
    hits: u32,
    albedo: DVec3,
    normal: DVec3,
    depth: f64,
}

impl Features {
    /// By the render's own eye paths: where they are retraced, those of its first passes.
    pub(super) fn of(render: &Render) -> Features {
        let (scene, settings) = (render.scene, &render.settings);
        let passes = match render.eye_paths() {
            EyePaths::Fixed => 1,
            EyePaths::Retraced => ENOUGH_SAMPLES.div_ceil(settings.samples).min(render.passes.max(1)),
        };
        let film = scene.film();
        let mut seen = vec![Seen::default(); film.pixels()];
        let block = (BATCH / settings.samples).max(1) as usize;
        seen.par_chunks_mut(block).enumerate().for_each(|(k, seen)| {
            (0..passes).for_each(|pass| look(scene, settings, pass, (k * block) as u32, seen));
        });
        Features::developed(film.width as usize, &seen)
    }

    fn developed(width: usize, seen: &[Seen]) -> Features {
        let image = |of: fn(&Seen) -> Rgb| {
            let mut image = Image::new(width, seen.len() / width);
            image.pixels_mut().iter_mut().zip(seen).for_each(|(to, seen)| *to = of(seen));
            image
        };
        Features {
            albedo: image(|seen| (seen.albedo / f64::from(seen.samples)).as_vec3()),
            normal: image(|seen| (seen.normal / f64::from(seen.samples)).as_vec3()),
            depth: image(|seen| {
                Rgb::splat(match seen.hits {
                    0 => f32::INFINITY,
                    hits => (seen.depth / f64::from(hits)) as f32,
                })
            }),
        }
    }
}

/// Adds the eye paths of a pass to the pixels from number `first` on.
fn look(scene: &Scene, settings: &Settings, pass: u32, first: u32, seen: &mut [Seen]) {
    let mut rays = Vec::with_capacity(seen.len() * settings.samples as usize);
    for (pixel, seen) in (first..).zip(seen.iter_mut()) {
        camera_pass::first_rays(scene, settings, pass, pixel, |ray| rays.push(ray));
        seen.samples += settings.samples;
    }
    scene.intersect_all(&rays, Coherence::Coherent, |k, hit| {
        seen[k / settings.samples as usize].add(scene, hit);
    });
}

impl Seen {
    fn add(&mut self, scene: &Scene, hit: &SurfaceHit) {
        self.hits += 1;
        self.albedo += kept_share(scene, hit).as_dvec3();
        self.normal += hit.receiver().ns.as_dvec3();
        self.depth += f64::from(scene.camera().depth(hit.p));
    }
}

/// What is not absorbed of light that comes along the line of sight; by a middling facet of what is rough.
fn kept_share(scene: &Scene, hit: &SurfaceHit) -> Rgb {
    let scattering = scene.scatter_by(hit, Transport::Power, || Vec2::splat(0.5));
    let kept = scattering.specular().fold(scattering.diffuse_share(), |sum, lobe| sum + lobe.share);
    match scene.opacity(hit) {
        1.0 => kept,
        opacity => kept * opacity + Rgb::splat(1.0 - opacity),
    }
}
