//! The photon pass: paths from the lights, which leave photons on diffuse surfaces.

use std::ops::Range;

use rayon::prelude::*;

use super::aimed_flights::AimedFlights;
use super::course::Course;
use super::emission::Guided;
use super::flights::FlightPacket;
use super::mixture::Mixture;
use super::photons::{PhotonBatch, PhotonChunk};
use super::wavefront::Wavefront;
use super::{Ledger, Settings, Stage};
use crate::light::Guide;
use crate::math::Ray;
use crate::scene::Scene;

/// Paths that one task follows together: enough to fill packets, few enough to stay in a core's own cache; fixed, so
/// that the order of the photons is; a power of two, as [`Draws::first`] asks.
pub(super) const CHUNK: u64 = 1024;

/// A photon pass and the memory that it works in, which the next pass uses again.
#[derive(Debug, Default)]
pub struct PhotonPass {
    batch: PhotonBatch,
}

impl PhotonPass {
    /// Emits `settings.photons` photons and follows each to its end; those of `settings.transport` are stored.
    ///
    /// Path `i` draws from the generator keyed by (seed, pass, i), and chunks of paths are of a fixed size: the result
    /// depends on no thread.
    pub fn trace<'a>(&mut self, stage: impl Into<Stage<'a>>, settings: &Settings, pass: u32) -> &PhotonBatch {
        self.trace_mixed(stage, settings, pass, None)
    }

    /// The same with the photons of a mixture in place of `settings.photons`, where there is one.
    pub fn trace_mixed<'a>(
        &mut self,
        stage: impl Into<Stage<'a>>,
        settings: &Settings,
        pass: u32,
        mixture: Option<&Mixture>,
    ) -> &PhotonBatch {
        self.trace_guided(stage, settings, pass, mixture, None)
    }

    /// The same with photons that `guide` lets start, where there is one, in place of natural ones.
    pub(super) fn trace_guided<'a>(
        &mut self,
        stage: impl Into<Stage<'a>>,
        settings: &Settings,
        pass: u32,
        mixture: Option<&Mixture>,
        guide: Option<&Guide>,
    ) -> &PhotonBatch {
        let photons = mixture.map_or(settings.photons, |mixture| mixture.budget.natural);
        let guided = guide.map(|guide| Guided { guide, photons });
        let course = Course { mixture, guided, ..Course::natural(stage.into(), settings, pass) };
        self.follow(&course, photons)
    }

    /// Follows so many photons along a course, and those that are aimed.
    pub(super) fn follow(&mut self, course: &Course, photons: u64) -> &PhotonBatch {
        let mixture = course.mixture;
        let natural = chunk_count(course, photons);
        let aimed = mixture.map_or(0, |mixture| chunk_count(course, mixture.budget.aimed));
        let PhotonBatch { chunks, ledger, aimed: aimed_ledger } = &mut self.batch;
        chunks.resize_with(natural + aimed, PhotonChunk::default);
        chunks.par_iter_mut().enumerate().for_each_init(Memory::default, |memory, (number, chunk)| {
            chunk.clear();
            match mixture.filter(|_| number >= natural) {
                Some(mixture) => {
                    let paths = paths_of(number - natural, mixture.budget.aimed);
                    memory.aimed.follow(course, mixture, paths, chunk);
                }
                None => memory.natural.follow(course, paths_of(number, photons), chunk, |_| ()),
            }
        });
        *ledger = sum(&chunks[..natural]);
        *aimed_ledger = sum(&chunks[natural..]);
        &self.batch
    }

    /// The photons of the last pass.
    pub(super) fn batch(&self) -> &PhotonBatch {
        &self.batch
    }

    /// A pass without photons.
    pub(super) fn skip(&mut self) -> &PhotonBatch {
        self.batch = PhotonBatch::default();
        &self.batch
    }

    /// The memory that it keeps, in bytes.
    pub fn memory_bytes(&self) -> usize {
        self.batch.chunks.iter().map(PhotonChunk::memory_bytes).sum()
    }
}

/// What a thread works in.
#[derive(Default)]
struct Memory {
    natural: Wavefront,
    aimed: AimedFlights,
}

fn sum(chunks: &[PhotonChunk]) -> Ledger {
    chunks.iter().fold(Ledger::default(), |sum, chunk| sum.plus(chunk.ledger))
}

/// The rays that [`PhotonPass::trace`] sends through the scene, in the order in which it traces them.
pub fn record_rays(scene: &Scene, settings: &Settings, pass: u32) -> Vec<Ray> {
    let course = Course::natural(scene.into(), settings, pass);
    let rays_of = |chunk: usize| {
        let (mut rays, mut photons) = (Vec::new(), PhotonChunk::default());
        let see = |FlightPacket { rays: packet, .. }: &FlightPacket| {
            rays.extend((0..packet.len).map(|lane| packet.ray(lane)));
        };
        Wavefront::default().follow(&course, paths_of(chunk, settings.photons), &mut photons, see);
        rays
    };
    let recorded: Vec<Vec<Ray>> =
        (0..chunk_count(&course, settings.photons)).into_par_iter().map(rays_of).collect();
    recorded.concat()
}

fn chunk_count(course: &Course, photons: u64) -> usize {
    if course.stage.lights.is_empty() { 0 } else { photons.div_ceil(CHUNK) as usize }
}

pub(super) fn paths_of(chunk: usize, photons: u64) -> Range<u64> {
    let chunk = chunk as u64;
    chunk * CHUNK..((chunk + 1) * CHUNK).min(photons)
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
        let (batch, rays) =
            (PhotonPass::default().trace(&scene, &settings, 3).clone(), record_rays(&scene, &settings, 3));
        assert_eq!(rays.len() as u64, batch.ledger.rays);
        let escaped = rays.iter().filter(|ray| scene.distance(ray).is_none()).count();
        assert_eq!(escaped as u64, batch.ledger.escaped);
        assert_ne!(rays, record_rays(&scene, &settings, 4), "every pass has its own");
    }
}
