//! The photon pass: paths from the lights, which leave photons on diffuse surfaces.

use std::ops::Range;

use rayon::prelude::*;

use super::aimed_flights::AimedFlights;
use super::course::Course;
use super::emission::Guided;
use super::flights::FlightPacket;
use super::mixture::Mixture;
use super::wavefront::Wavefront;
use super::{Ledger, Settings, Stage};
use crate::effects::{PathClass, PathClasses};
use crate::light::Guide;
use crate::math::{Ray, Rgb, Vec3};
use crate::scene::Scene;

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

/// Photons of one kind of path; positions stand apart, as the gather wants them.
///
/// Bounce by bounce, and there in the order in which packets were traced.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Deposits {
    /// Where each photon lies.
    pub positions: Vec<Vec3>,
    /// The rest of each photon.
    pub photons: Vec<Photon>,
    /// The number of each photon's path in its chunk, where that was asked for.
    pub(super) paths: Vec<u32>,
}

impl Deposits {
    pub(super) fn push(&mut self, p: Vec3, photon: Photon) {
        self.positions.push(p);
        self.photons.push(photon);
    }

    fn clear(&mut self) {
        self.positions.clear();
        self.photons.clear();
        self.paths.clear();
    }

    fn memory_bytes(&self) -> usize {
        size_of::<Vec3>() * self.positions.capacity() + size_of::<Photon>() * self.photons.capacity()
    }
}

/// What a chunk of paths left behind.
#[derive(Clone, Debug, Default)]
pub struct PhotonChunk {
    /// Photons that came by specular events alone.
    pub caustic: Deposits,
    /// Photons of lights without extent that came by specular events alone, on rough surfaces.
    pub glints: Deposits,
    /// Photons that bounced off a diffuse surface before.
    pub indirect: Deposits,
    /// Of every caustic photon in a mixture, how much likelier aiming makes its start.
    pub ratios: Vec<f32>,
    /// What became of the paths.
    pub ledger: Ledger,
}

impl PhotonChunk {
    pub(super) fn of(&self, class: PathClass) -> Option<&Deposits> {
        match class {
            PathClass::Direct => None,
            PathClass::Caustic => Some(&self.caustic),
            PathClass::Indirect => Some(&self.indirect),
        }
    }

    /// Forgets everything but the memory.
    fn clear(&mut self) {
        self.caustic.clear();
        self.glints.clear();
        self.indirect.clear();
        self.ratios.clear();
        self.ledger = Ledger::default();
    }

    fn memory_bytes(&self) -> usize {
        let ratios = size_of::<f32>() * self.ratios.capacity();
        let deposits = [&self.caustic, &self.glints, &self.indirect];
        deposits.into_iter().map(Deposits::memory_bytes).sum::<usize>() + ratios
    }
}

/// The photons of a pass.
#[derive(Clone, Debug, Default)]
pub struct PhotonBatch {
    /// In the order of the paths, those of aimed photons behind the others.
    pub chunks: Vec<PhotonChunk>,
    /// What became of all paths that left the lights naturally.
    pub ledger: Ledger,
    /// What became of the aimed ones.
    pub aimed: Ledger,
}

impl PhotonBatch {
    /// The photons of one kind of path; of direct light there are none.
    pub fn of(&self, class: PathClass) -> Photons<'_> {
        self.of_any([class].into_iter().collect())
    }

    /// The photons of some kinds of paths.
    pub(super) fn of_any(&self, classes: PathClasses) -> Photons<'_> {
        let deposits = |chunk| classes.iter().filter_map(move |class| PhotonChunk::of(chunk, class));
        Photons(self.chunks.iter().flat_map(deposits).collect())
    }

    /// The caustic photons on rough surfaces.
    pub(super) fn glints(&self) -> Photons<'_> {
        Photons(self.chunks.iter().map(|chunk| &chunk.glints).collect())
    }

    /// All photons on diffuse surfaces.
    pub fn photons(&self) -> impl Iterator<Item = &Photon> {
        self.chunks.iter().flat_map(|chunk| chunk.caustic.photons.iter().chain(&chunk.indirect.photons))
    }
}

/// The photons of one kind of path, numbered on from chunk to chunk.
#[derive(Clone, Debug, Default)]
pub struct Photons<'a>(pub(super) Vec<&'a Deposits>);

impl<'a> Photons<'a> {
    /// Where the photons lie, chunk by chunk.
    pub fn positions(&self) -> Vec<&'a [Vec3]> {
        self.0.iter().map(|deposits| deposits.positions.as_slice()).collect()
    }

    /// The photons, by their numbers.
    pub fn iter(&self) -> impl Iterator<Item = &'a Photon> {
        self.0.iter().flat_map(|deposits| &deposits.photons)
    }

    /// The photons of these numbers, which increase.
    pub(super) fn pick(&self, mut numbers: &[u32]) -> Vec<Photon> {
        let mut picked = Vec::with_capacity(numbers.len());
        let mut first = 0;
        for Deposits { photons, .. } in &self.0 {
            let end = first + photons.len();
            let (here, later) = numbers.split_at(numbers.partition_point(|&number| (number as usize) < end));
            picked.extend(here.iter().map(|&number| photons[number as usize - first]));
            (numbers, first) = (later, end);
        }
        picked
    }
}

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
