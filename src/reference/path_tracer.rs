use std::f32::consts::PI;

use crate::bsdf::{Choice, Coat, DiffuseSampling, Event, Transport, sample_diffuse};
use crate::math::{Ray, Rgb, Rng, Stream, Vec2};
use crate::scene::{Media, Scene, SurfaceHit};

/// Longer paths than this are cut; with an albedo of .9 one in 10⁴⁵ is.
pub const MAX_SEGMENTS: u32 = 1000;

/// So many segments are followed for certain before roulette may end the path: in dark corners most light comes
/// late, and ending its paths early would leave a few very bright samples.
const SEGMENTS_BEFORE_ROULETTE: u32 = 5;

/// Sample number `sample` of the radiance in pixel number `pixel`.
pub fn pixel_radiance(scene: &Scene, seed: u64, sample: u32, pixel: usize) -> Rgb {
    let mut rng = Rng::new(seed, Stream::PathTracer, sample, pixel as u64);
    let ray = random_ray(scene, pixel, &mut rng);
    radiance(scene, ray, &mut rng)
}

/// A ray through pixel number `pixel`, distributed by its filter, and through the lens, uniform over that.
pub fn random_ray(scene: &Scene, pixel: usize, rng: &mut Rng) -> Ray {
    let width = scene.film().width as usize;
    let corner = Vec2::new((pixel % width) as f32, (pixel / width) as f32);
    let raster = corner + scene.film().filter.sample(rng.next_vec2());
    scene.camera().ray_through_lens(raster, random_lens_sample(scene, rng))
}

/// A point of the unit square for the lens; nothing is drawn for a pinhole.
pub fn random_lens_sample(scene: &Scene, rng: &mut Rng) -> Vec2 {
    if scene.camera().has_lens() { rng.next_vec2() } else { Vec2::ZERO }
}

/// One sample of the radiance along `ray`.
fn radiance(scene: &Scene, ray: Ray, rng: &mut Rng) -> Rgb {
    let mut sum = Rgb::ZERO;
    let mut path = EyePath {
        ray,
        throughput: Rgb::ONE,
        transport: Transport::Camera,
        after: None,
        pdf_w: f32::INFINITY,
        media: scene.camera_media(),
    };
    for segment in 0..MAX_SEGMENTS {
        let Some(hit) = scene.intersect(&path.ray) else {
            sum += path.throughput * path.sky(scene);
            break;
        };
        path.throughput *= scene.transmittance(path.media, hit.t);
        // After a diffuse bounce, light straight from its source was found by the shadow ray there.
        if path.after != Some(Event::Diffuse) {
            sum += path.throughput * scene.found_emission(scene.lights(), &hit, path.pdf_w);
        }
        if scene.passes(&hit, rng) {
            path = path.straight_on(scene, &hit);
            continue;
        }
        let scattering = scene.scatter_by(&hit, path.transport, || rng.next_vec2());
        if let Some(glossy) = scene.glossy(&hit, path.transport) {
            sum += path.throughput * scene.direct_on_rough(scene.lights(), &hit, &glossy, rng).0;
        }
        if scattering.albedo != Rgb::ZERO {
            sum += path.throughput * scattering.albedo / PI * direct_irradiance(scene, &hit, rng);
        }
        let u = rng.next_f32();
        let survives = segment < SEGMENTS_BEFORE_ROULETTE;
        let choice = if survives { scattering.choose_any(u) } else { scattering.choose(u) };
        let Some(choice) = choice else { break };
        let Some(next) = path.scattered(scene, choice, scattering.coat, &hit, rng) else { break };
        path = next;
    }
    sum
}

fn direct_irradiance(scene: &Scene, hit: &SurfaceHit, rng: &mut Rng) -> Rgb {
    let receiver = scene.receiver(hit);
    let lights = scene.lights();
    scene.direct_from_points(lights, &receiver).irradiance
        + scene.direct_from_areas(lights, &receiver, rng).irradiance
}

struct EyePath {
    ray: Ray,
    throughput: Rgb,
    transport: Transport,
    /// The last event; `None` at the camera.
    after: Option<Event>,
    /// See [`crate::bsdf::SpecularLobe::pdf_w`]; infinite at the camera.
    pdf_w: f32,
    /// What the ray goes through.
    media: Media,
}

impl EyePath {
    /// Of light from all around what shadow rays did not find before.
    fn sky(&self, scene: &Scene) -> Rgb {
        match scene.lights().environment() {
            Some(around) if self.after != Some(Event::Diffuse) => {
                let left = scene.transmittance(self.media, f32::INFINITY);
                left * scene.found_sky(scene.lights(), around, &self.ray, self.pdf_w)
            }
            _ => Rgb::ZERO,
        }
    }

    /// Through a mask, which no light was sampled through.
    fn straight_on(&self, scene: &Scene, hit: &SurfaceHit) -> EyePath {
        let media = scene.crossed(self.media, hit);
        EyePath { ray: hit.pass(), after: Some(Event::Transmission), pdf_w: f32::INFINITY, media, ..*self }
    }

    fn scattered(
        &self,
        scene: &Scene,
        choice: Choice,
        coat: Coat,
        hit: &SurfaceHit,
        rng: &mut Rng,
    ) -> Option<EyePath> {
        let (event, wi, factor, transport, pdf_w) = match choice {
            Choice::Specular { event, wi, factor, pdf_w } => (event, wi, factor, self.transport, pdf_w),
            Choice::Diffuse { factor } => {
                let (wi, _) = sample_diffuse(DiffuseSampling::Cosine, hit.wo_local(), rng);
                let factor = factor * coat.transmittance(wi.z);
                (Event::Diffuse, wi, factor, Transport::Radiance, f32::INFINITY)
            }
        };
        let ray = hit.continue_along(event, hit.frame().to_world(wi))?;
        let media = if event.crosses() { scene.crossed(self.media, hit) } else { self.media };
        let throughput = self.throughput * factor;
        Some(EyePath { ray, throughput, transport, after: Some(event), pdf_w, media })
    }
}
