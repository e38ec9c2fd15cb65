use std::f32::consts::PI;

use rayon::prelude::*;

use crate::bsdf::{Choice, DiffuseSampling, Event, Transport, sample_diffuse};
use crate::film::Image;
use crate::math::{DVec3, Ray, Rgb, Rng, Stream, Vec2};
use crate::scene::{Scene, SurfaceHit};

/// A unidirectional path tracer with next-event estimation: unbiased, of unlimited depth.
///
/// It cannot find point lights through glass or water, since no sampled path hits a point: there its picture is
/// the light that does not pass such surfaces on its way to the last diffuse one.
///
/// # Source
/// Kajiya, "The Rendering Equation", SIGGRAPH 1986; Veach 1997, chapter 10, for next-event estimation.
pub struct PathTracer<'s> {
    scene: &'s Scene,
    seed: u64,
    samples: u32,
    pixels: Vec<PixelSum>,
}

/// Running mean and squared deviations of a pixel's samples (Welford's recurrence).
#[derive(Clone, Copy, Debug, Default)]
struct PixelSum {
    mean: DVec3,
    deviations: DVec3,
}

/// Longer paths than this are cut; with an albedo of .9 one in 10⁴⁵ is.
const MAX_SEGMENTS: u32 = 1000;

/// So many segments are followed for certain before roulette may end the path: in dark corners most light comes
/// late, and ending its paths early would leave a few very bright samples.
const SEGMENTS_BEFORE_ROULETTE: u32 = 5;

impl<'s> PathTracer<'s> {
    /// A picture without samples.
    pub fn new(scene: &'s Scene, seed: u64) -> PathTracer<'s> {
        let pixels = scene.film().width as usize * scene.film().height as usize;
        PathTracer { scene, seed, samples: 0, pixels: vec![PixelSum::default(); pixels] }
    }

    /// Adds one sample to every pixel.
    pub fn add_sample(&mut self) {
        let (scene, seed, sample) = (self.scene, self.seed, self.samples);
        let width = scene.film().width as usize;
        self.pixels.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
            for (x, pixel) in row.iter_mut().enumerate() {
                let mut rng = Rng::new(seed, Stream::PathTracer, sample, (y * width + x) as u64);
                let raster = Vec2::new(x as f32, y as f32) + rng.next_vec2();
                let radiance = radiance(scene, scene.camera().ray(raster), &mut rng);
                pixel.add(radiance.as_dvec3(), sample + 1);
            }
        });
        self.samples += 1;
    }

    /// Samples a pixel so far.
    pub fn samples(&self) -> u32 {
        self.samples
    }

    /// The mean of the samples (radiance).
    pub fn picture(&self) -> Image {
        self.image(|pixel| pixel.mean)
    }

    /// The standard error of [`PathTracer::picture`], estimated from the samples: `√(Σ (L - mean)² / (n (n - 1)))`.
    ///
    /// Infinite below two samples, where nothing is known of it.
    pub fn standard_error(&self) -> Image {
        let n = f64::from(self.samples);
        self.image(|pixel| {
            if n < 2.0 { DVec3::INFINITY } else { (pixel.deviations / (n * (n - 1.0))).map(f64::sqrt) }
        })
    }

    fn image(&self, value: impl Fn(&PixelSum) -> DVec3) -> Image {
        let film = self.scene.film();
        let mut image = Image::new(film.width as usize, film.height as usize);
        for (out, pixel) in image.pixels_mut().iter_mut().zip(&self.pixels) {
            *out = value(pixel).as_vec3();
        }
        image
    }
}

impl PixelSum {
    fn add(&mut self, value: DVec3, count: u32) {
        let before = value - self.mean;
        self.mean += before / f64::from(count);
        self.deviations += before * (value - self.mean);
    }
}

/// One sample of the radiance along `ray`.
fn radiance(scene: &Scene, ray: Ray, rng: &mut Rng) -> Rgb {
    let mut sum = Rgb::ZERO;
    let mut path = EyePath { ray, throughput: Rgb::ONE, transport: Transport::Camera, after: None };
    for segment in 0..MAX_SEGMENTS {
        let Some(hit) = scene.intersect(&path.ray) else { break };
        // After a diffuse bounce, light straight from its source was found by the shadow ray there.
        if path.after != Some(Event::Diffuse) {
            sum += path.throughput * scene.emission(&hit);
        }
        let scattering = scene.scatter(&hit, path.transport);
        if scattering.albedo != Rgb::ZERO {
            sum += path.throughput * scattering.albedo / PI * direct_irradiance(scene, &hit, rng);
        }
        let u = rng.next_f32();
        let survives = segment < SEGMENTS_BEFORE_ROULETTE;
        let choice = if survives { scattering.choose_any(u) } else { scattering.choose(u) };
        let Some(choice) = choice else { break };
        let Some(next) = path.scattered(choice, &hit, rng) else { break };
        path = next;
    }
    sum
}

fn direct_irradiance(scene: &Scene, hit: &SurfaceHit, rng: &mut Rng) -> Rgb {
    let receiver = hit.receiver();
    scene.direct_from_points(&receiver).irradiance + scene.direct_from_areas(&receiver, rng).irradiance
}

struct EyePath {
    ray: Ray,
    throughput: Rgb,
    transport: Transport,
    /// The last event; `None` at the camera.
    after: Option<Event>,
}

impl EyePath {
    fn scattered(&self, choice: Choice, hit: &SurfaceHit, rng: &mut Rng) -> Option<EyePath> {
        let (event, wi, factor, transport) = match choice {
            Choice::Specular { event, wi, factor } => (event, wi, factor, self.transport),
            Choice::Diffuse { factor } => {
                let (wi, _) = sample_diffuse(DiffuseSampling::Cosine, hit.wo_local(), rng);
                (Event::Diffuse, wi, factor, Transport::Radiance)
            }
        };
        let ray = hit.continue_along(event, hit.frame().to_world(wi))?;
        Some(EyePath { ray, throughput: self.throughput * factor, transport, after: Some(event) })
    }
}
