//! The photon pass: paths from the lights, which leave photons on diffuse surfaces.

use rayon::prelude::*;

use super::{Ledger, Settings};
use crate::bsdf::{Choice, Event, Scattering, Transport, sample_diffuse};
use crate::math::{Frame, Ray, Rgb, Rng, Stream, Vec3};
use crate::scene::{Scene, SurfaceHit};

/// A photon stored on a diffuse surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Photon {
    /// Where it came from, unit.
    pub wi: Vec3,
    /// Geometric normal of the surface, unit, on the side of `wi`.
    pub ng: Vec3,
    /// Its power (W), not yet divided by the number of photons emitted.
    pub power: Rgb,
}

/// The photons of a pass, in the order of their paths; positions stand apart, as the gather wants them.
#[derive(Clone, Debug, Default)]
pub struct PhotonBatch {
    /// Where each photon lies.
    pub positions: Vec<Vec3>,
    /// The rest of each photon.
    pub photons: Vec<Photon>,
    /// What became of all paths.
    pub ledger: Ledger,
}

/// A closed box of albedo 1 holds a photon for ever; what is cut here is counted as terminated.
const MAX_SEGMENTS: u32 = 1000;

/// Paths that one task traces: enough to outweigh a task's cost, and fixed, so that the order of the photons is.
const CHUNK: u64 = 1024;

/// Emits `settings.photons` photons and follows each to its end.
///
/// Path `i` draws from the generator keyed by (seed, pass, i): the result depends on no thread.
pub fn trace(scene: &Scene, settings: &Settings, pass: u32) -> PhotonBatch {
    let chunks = follow_paths(scene, settings, pass, |batch: &mut PhotonBatch, rng| {
        batch.trace_path(scene, settings, rng, |_| ());
    });
    PhotonBatch::concatenate(&chunks)
}

/// The rays that [`trace`] sends through the scene, in the order of their paths.
pub fn record_rays(scene: &Scene, settings: &Settings, pass: u32) -> Vec<Ray> {
    let chunks = follow_paths(scene, settings, pass, |rays: &mut Vec<Ray>, rng| {
        PhotonBatch::default().trace_path(scene, settings, rng, |ray| rays.push(*ray));
    });
    chunks.concat()
}

/// Hands the generator of each path to `follow`, together with what its chunk of paths collects.
fn follow_paths<C: Default + Send>(
    scene: &Scene,
    settings: &Settings,
    pass: u32,
    follow: impl Fn(&mut C, Rng) + Sync,
) -> Vec<C> {
    if scene.lights().is_empty() {
        return Vec::new();
    }
    let chunk = |chunk: u64| {
        let mut collected = C::default();
        for index in chunk * CHUNK..((chunk + 1) * CHUNK).min(settings.photons) {
            follow(&mut collected, Rng::new(settings.seed, Stream::Photon, pass, index));
        }
        collected
    };
    (0..settings.photons.div_ceil(CHUNK)).into_par_iter().map(chunk).collect()
}

/// A photon on its way.
struct PhotonPath {
    ray: Ray,
    power: Rgb,
    /// No surface was met yet: such light is found by shadow rays.
    direct: bool,
}

/// How a path ends at a surface, or goes on from it.
enum Step {
    Absorbed,
    Bounced(PhotonPath),
}

impl PhotonBatch {
    fn concatenate(chunks: &[PhotonBatch]) -> PhotonBatch {
        let count = chunks.iter().map(|c| c.photons.len()).sum();
        let mut all = PhotonBatch {
            positions: Vec::with_capacity(count),
            photons: Vec::with_capacity(count),
            ledger: Ledger::default(),
        };
        for chunk in chunks {
            all.positions.extend_from_slice(&chunk.positions);
            all.photons.extend_from_slice(&chunk.photons);
            all.ledger = all.ledger.plus(chunk.ledger);
        }
        all
    }

    /// Shows every ray to `see` before it is traced.
    fn trace_path(&mut self, scene: &Scene, settings: &Settings, mut rng: Rng, mut see: impl FnMut(&Ray)) {
        let Some(emission) = scene.lights().sample_emission(&mut rng) else { return };
        self.ledger.emitted += 1;
        let ray = Ray::new(emission.origin, emission.dir);
        let mut path = PhotonPath { ray, power: emission.power, direct: true };
        for _ in 0..MAX_SEGMENTS {
            if !path.power.is_finite() || path.power.max_element() <= 0.0 {
                self.ledger.dropped += 1;
                return;
            }
            self.ledger.rays += 1;
            see(&path.ray);
            let Some(hit) = scene.intersect(&path.ray) else {
                self.ledger.escaped += 1;
                return;
            };
            let scattering = scene.scatter(&hit, Transport::Power);
            self.deposit(&path, &hit, &scattering);
            match step(&path, &hit, &scattering, settings, &mut rng) {
                Step::Absorbed => {
                    self.ledger.absorbed += 1;
                    return;
                }
                Step::Bounced(next) => path = next,
            }
        }
        self.ledger.terminated += 1;
    }

    /// Stores the photon where the surface has a diffuse share, before roulette decides how it goes on.
    ///
    /// Only light straight from its source is left out, since shadow rays bring that: light that was mirrored or
    /// refracted on its way (water is opaque to shadow rays) is a caustic and stays.
    fn deposit(&mut self, path: &PhotonPath, hit: &SurfaceHit, scattering: &Scattering) {
        if path.direct || scattering.albedo == Rgb::ZERO {
            return;
        }
        self.ledger.deposited += 1;
        self.positions.push(hit.p);
        self.photons.push(Photon { wi: hit.wo, ng: hit.receiver().ng, power: path.power });
    }
}

/// Russian roulette between reflection, refraction, diffuse bounce and absorption.
fn step(
    path: &PhotonPath,
    hit: &SurfaceHit,
    scattering: &Scattering,
    settings: &Settings,
    rng: &mut Rng,
) -> Step {
    let Some(choice) = scattering.choose(rng.next_f32()) else { return Step::Absorbed };
    let (event, dir, factor) = match choice {
        Choice::Specular { event, wi, factor } => (event, hit.frame.to_world(wi), factor),
        Choice::Diffuse { factor } => {
            let (wi, cosine_factor) = sample_diffuse(settings.sampling, Vec3::Z, rng);
            (Event::Diffuse, Frame::around(hit.receiver().ng).to_world(wi), factor * cosine_factor)
        }
    };
    let Some(ray) = hit.continue_along(event, dir) else { return Step::Absorbed };
    let power = path.power * factor * hit.adjoint_correction(event, dir);
    Step::Bounced(PhotonPath { ray, power, direct: false })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene;
    use std::path::Path;

    #[test]
    fn recorded_rays_are_those_of_the_pass() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/cornell_b.toml");
        let scene = Scene::new(scene::load(&path).unwrap()).unwrap();
        let settings = Settings { photons: 5000, ..Settings::of_scene(scene.render()) };
        let (batch, rays) = (trace(&scene, &settings, 3), record_rays(&scene, &settings, 3));
        assert_eq!(rays.len() as u64, batch.ledger.rays);
        let escaped = rays.iter().filter(|ray| scene.distance(ray).is_none()).count();
        assert_eq!(escaped as u64, batch.ledger.escaped);
        assert_ne!(rays, record_rays(&scene, &settings, 4), "every pass has its own");
    }
}
