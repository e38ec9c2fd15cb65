//! A chunk of photons on their way, all of them one bounce at a time, so that their rays can share packets.

use std::ops::Range;

use super::{Photon, PhotonBatch, Settings};
use crate::bsdf::{Choice, Event, Scattering, Transport, sample_diffuse};
use crate::math::{Frame, Ray, Rgb, Rng, Stream, Vec3};
use crate::scene::{Coherence, Scene, SurfaceHit};

/// A closed box of albedo 1 holds a photon for ever; what is cut here is counted as terminated.
const MAX_SEGMENTS: u32 = 1000;

/// In scenes of at most so many triangles and spheres, rays of one octant mostly meet the same boxes: then packets that
/// stay together win. In larger ones they part too early.
const SMALL_SCENE: usize = 512;

/// A photon on its way.
#[derive(Clone, Debug)]
struct Flight {
    ray: Ray,
    power: Rgb,
    rng: Rng,
    /// No surface was met yet: such light is found by shadow rays.
    direct: bool,
}

/// Photons on their way, and the memory for their rays.
#[derive(Debug, Default)]
pub(super) struct Wavefront {
    flights: Vec<Flight>,
    /// Which of them still fly.
    live: Vec<u32>,
    /// The same, in the order of their rays.
    order: Vec<u32>,
    rays: Vec<Ray>,
}

impl Wavefront {
    /// Emits the photons of `paths` and follows them to their end; what they leave behind goes to `batch`, and `see` is
    /// shown the rays of every generation.
    pub(super) fn follow(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        pass: u32,
        paths: Range<u64>,
        batch: &mut PhotonBatch,
        mut see: impl FnMut(&[Ray]),
    ) {
        let small = scene.primitives() <= SMALL_SCENE;
        let coherence = if small { Coherence::Coherent } else { Coherence::Incoherent };
        self.emit(scene, settings, pass, paths);
        batch.ledger.emitted += self.flights.len() as u64;
        for _ in 0..MAX_SEGMENTS {
            batch.ledger.dropped += self.drop_dark();
            if self.live.is_empty() {
                return;
            }
            self.line_up();
            see(&self.rays);
            self.bounce(scene, settings, coherence, batch);
        }
        batch.ledger.terminated += self.live.len() as u64;
    }

    fn emit(&mut self, scene: &Scene, settings: &Settings, pass: u32, paths: Range<u64>) {
        self.flights.clear();
        self.flights.extend(paths.filter_map(|index| {
            let mut rng = Rng::new(settings.seed, Stream::Photon, pass, index);
            let emission = scene.lights().sample_emission(&mut rng)?;
            let ray = Ray::new(emission.origin, emission.dir);
            Some(Flight { ray, power: emission.power, rng, direct: true })
        }));
        self.live.clear();
        self.live.extend(0..self.flights.len() as u32);
    }

    /// Removes photons without power, or with one that is no number, and returns how many.
    fn drop_dark(&mut self) -> u64 {
        let before = self.live.len();
        let has_power = |power: Rgb| power.is_finite() && power.max_element() > 0.0;
        self.live.retain(|&k| has_power(self.flights[k as usize].power));
        (before - self.live.len()) as u64
    }

    /// Orders the rays by the octant that they point into, otherwise as they come.
    fn line_up(&mut self) {
        let octant_of = |k: u32| octant(self.flights[k as usize].ray.dir);
        let mut places = [0; 9];
        self.live.iter().for_each(|&k| places[octant_of(k) + 1] += 1);
        (1..9).for_each(|octant| places[octant] += places[octant - 1]);
        self.order.clear();
        self.order.resize(self.live.len(), 0);
        for &k in &self.live {
            let place = &mut places[octant_of(k)];
            self.order[*place] = k;
            *place += 1;
        }
        self.rays.clear();
        self.rays.extend(self.order.iter().map(|&k| self.flights[k as usize].ray));
    }

    /// Traces all rays and sends the photons on their way.
    fn bounce(&mut self, scene: &Scene, settings: &Settings, coherence: Coherence, batch: &mut PhotonBatch) {
        let Wavefront { flights, live, order, rays } = self;
        let mut hits = 0;
        live.clear();
        scene.intersect_all(rays, coherence, |k, hit| {
            hits += 1;
            let flight = &mut flights[order[k] as usize];
            let scattering = scene.scatter(hit, Transport::Power);
            deposit(batch, flight, hit, &scattering);
            if flight.go_on(hit, &scattering, settings).is_some() {
                live.push(order[k]);
            }
        });
        let ledger = &mut batch.ledger;
        ledger.rays += rays.len() as u64;
        ledger.escaped += rays.len() as u64 - hits;
        ledger.absorbed += hits - live.len() as u64;
    }
}

fn octant(dir: Vec3) -> usize {
    usize::from(dir.x > 0.0) | usize::from(dir.y > 0.0) << 1 | usize::from(dir.z > 0.0) << 2
}

/// Stores the photon where the surface has a diffuse share, before roulette decides how it goes on.
///
/// Only light straight from its source is left out, since shadow rays bring that: light that was mirrored or
/// refracted on its way (water is opaque to shadow rays) is a caustic and stays.
fn deposit(batch: &mut PhotonBatch, flight: &Flight, hit: &SurfaceHit, scattering: &Scattering) {
    if !flight.direct && scattering.albedo != Rgb::ZERO {
        batch.deposit(hit.p, Photon { wi: hit.wo, ng: hit.receiver().ng, power: flight.power });
    }
}

impl Flight {
    /// Russian roulette between reflection, refraction, diffuse bounce and absorption, which is `None`.
    fn go_on(&mut self, hit: &SurfaceHit, scattering: &Scattering, settings: &Settings) -> Option<()> {
        let (event, dir, factor) = match scattering.choose(self.rng.next_f32())? {
            Choice::Specular { event, wi, factor } => (event, hit.frame().to_world(wi), factor),
            Choice::Diffuse { factor } => {
                let (wi, cosine_factor) = sample_diffuse(settings.sampling, Vec3::Z, &mut self.rng);
                (Event::Diffuse, Frame::around(hit.receiver().ng).to_world(wi), factor * cosine_factor)
            }
        };
        self.ray = hit.continue_along(event, dir)?;
        self.power *= factor * hit.adjoint_correction(event, dir);
        self.direct = false;
        Some(())
    }
}
