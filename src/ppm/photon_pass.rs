//! The photon pass: paths from the lights, which leave photons on diffuse surfaces.

use std::ops::Range;

use rayon::prelude::*;

use super::wavefront::{Course, Wavefront};
use super::{Ledger, Settings, Stage};
use crate::effects::PathClass;
use crate::math::{Ray, Rgb, Vec3};
use crate::scene::{RayPacket, Scene};
use crate::simd::Isa;

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
}

impl Deposits {
    fn clear(&mut self) {
        self.positions.clear();
        self.photons.clear();
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
    /// Photons that bounced off a diffuse surface before.
    pub indirect: Deposits,
    /// What became of the paths.
    pub ledger: Ledger,
}

impl PhotonChunk {
    /// Forgets everything but the memory.
    fn clear(&mut self) {
        self.caustic.clear();
        self.indirect.clear();
        self.ledger = Ledger::default();
    }

    fn memory_bytes(&self) -> usize {
        self.caustic.memory_bytes() + self.indirect.memory_bytes()
    }
}

/// The photons of a pass.
#[derive(Clone, Debug, Default)]
pub struct PhotonBatch {
    /// In the order of the paths.
    pub chunks: Vec<PhotonChunk>,
    /// What became of all paths.
    pub ledger: Ledger,
}

impl PhotonBatch {
    /// The photons of one kind of path; of direct light there are none.
    pub fn of(&self, class: PathClass) -> Photons<'_> {
        Photons(match class {
            PathClass::Direct => Vec::new(),
            PathClass::Caustic => self.chunks.iter().map(|chunk| &chunk.caustic).collect(),
            PathClass::Indirect => self.chunks.iter().map(|chunk| &chunk.indirect).collect(),
        })
    }

    /// All photons.
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
const CHUNK: u64 = 1024;

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
        let course = Course { isa: Isa::best(), stage: stage.into(), settings, pass };
        let PhotonBatch { chunks, ledger } = &mut self.batch;
        chunks.resize_with(chunk_count(&course), PhotonChunk::default);
        chunks.par_iter_mut().enumerate().for_each_init(Wavefront::default, |wavefront, (number, chunk)| {
            chunk.clear();
            wavefront.follow(&course, paths_of(number, settings), chunk, |_| ());
        });
        *ledger = chunks.iter().fold(Ledger::default(), |sum, chunk| sum.plus(chunk.ledger));
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

/// The rays that [`PhotonPass::trace`] sends through the scene, in the order in which it traces them.
pub fn record_rays(scene: &Scene, settings: &Settings, pass: u32) -> Vec<Ray> {
    let course = Course { isa: Isa::best(), stage: scene.into(), settings, pass };
    let rays_of = |chunk: usize| {
        let (mut rays, mut photons) = (Vec::new(), PhotonChunk::default());
        let see = |packet: &RayPacket| rays.extend((0..packet.len).map(|lane| packet.ray(lane)));
        Wavefront::default().follow(&course, paths_of(chunk, settings), &mut photons, see);
        rays
    };
    let recorded: Vec<Vec<Ray>> = (0..chunk_count(&course)).into_par_iter().map(rays_of).collect();
    recorded.concat()
}

fn chunk_count(course: &Course) -> usize {
    if course.stage.lights.is_empty() { 0 } else { course.settings.photons.div_ceil(CHUNK) as usize }
}

fn paths_of(chunk: usize, settings: &Settings) -> Range<u64> {
    let chunk = chunk as u64;
    chunk * CHUNK..((chunk + 1) * CHUNK).min(settings.photons)
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
