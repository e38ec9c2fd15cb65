//! The photon pass: paths from the lights, which leave photons on diffuse surfaces.

use std::ops::Range;

use rayon::prelude::*;

use super::wavefront::{Course, Wavefront};
use super::{Ledger, Settings};
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

impl Photon {
    const NONE: Photon = Photon { wi: Vec3::ZERO, ng: Vec3::ZERO, power: Rgb::ZERO };
}

/// The photons of a pass; positions stand apart, as the gather wants them.
///
/// Chunk of paths by chunk, within each bounce by bounce, and there in the order in which packets were traced.
#[derive(Clone, Debug, Default)]
pub struct PhotonBatch {
    /// Where each photon lies.
    pub positions: Vec<Vec3>,
    /// The rest of each photon.
    pub photons: Vec<Photon>,
    /// What became of all paths.
    pub ledger: Ledger,
}

impl PhotonBatch {
    /// Forgets everything but the memory.
    fn clear(&mut self) {
        self.positions.clear();
        self.photons.clear();
        self.ledger = Ledger::default();
    }

    fn memory_bytes(&self) -> usize {
        size_of::<Vec3>() * self.positions.capacity() + size_of::<Photon>() * self.photons.capacity()
    }

    /// Becomes the photons of all chunks, in their order.
    fn collect(&mut self, chunks: &[PhotonBatch]) {
        let count = chunks.iter().map(|chunk| chunk.photons.len()).sum();
        self.positions.resize(count, Vec3::ZERO);
        self.photons.resize(count, Photon::NONE);
        let (mut positions, mut photons) = (self.positions.as_mut_slice(), self.photons.as_mut_slice());
        let places = chunks.iter().map(|chunk| {
            let n = chunk.photons.len();
            (positions.split_off_mut(..n).unwrap_or_default(), photons.split_off_mut(..n).unwrap_or_default())
        });
        let places: Vec<(&mut [Vec3], &mut [Photon])> = places.collect();
        places.into_par_iter().zip(chunks).for_each(|((positions, photons), chunk)| {
            positions.copy_from_slice(&chunk.positions);
            photons.copy_from_slice(&chunk.photons);
        });
        self.ledger = chunks.iter().fold(Ledger::default(), |sum, chunk| sum.plus(chunk.ledger));
    }
}

/// Paths that one task follows together: enough to fill packets, few enough to stay in a core's own cache; fixed, so
/// that the order of the photons is; a power of two, as [`Draws::first`] asks.
const CHUNK: u64 = 1024;

/// A photon pass and the memory that it works in, which the next pass uses again.
#[derive(Debug, Default)]
pub struct PhotonPass {
    chunks: Vec<PhotonBatch>,
    batch: PhotonBatch,
}

impl PhotonPass {
    /// Emits `settings.photons` photons and follows each to its end.
    ///
    /// Path `i` draws from the generator keyed by (seed, pass, i), and chunks of paths are of a fixed size: the result
    /// depends on no thread.
    pub fn trace(&mut self, scene: &Scene, settings: &Settings, pass: u32) -> &PhotonBatch {
        let course = Course { isa: Isa::best(), scene, settings, pass };
        self.chunks.resize_with(chunks(scene, settings), PhotonBatch::default);
        self.chunks.par_iter_mut().enumerate().for_each_init(
            Wavefront::default,
            |wavefront, (chunk, batch)| {
                batch.clear();
                wavefront.follow(&course, paths_of(chunk, settings), batch, |_| ());
            },
        );
        self.batch.collect(&self.chunks);
        &self.batch
    }

    /// The memory that it keeps, in bytes.
    pub fn memory_bytes(&self) -> usize {
        self.chunks.iter().chain([&self.batch]).map(PhotonBatch::memory_bytes).sum()
    }
}

/// The rays that [`PhotonPass::trace`] sends through the scene, in the order in which it traces them.
pub fn record_rays(scene: &Scene, settings: &Settings, pass: u32) -> Vec<Ray> {
    let course = Course { isa: Isa::best(), scene, settings, pass };
    let rays_of = |chunk: usize| {
        let (mut rays, mut batch) = (Vec::new(), PhotonBatch::default());
        let see = |packet: &RayPacket| rays.extend((0..packet.len).map(|lane| packet.ray(lane)));
        Wavefront::default().follow(&course, paths_of(chunk, settings), &mut batch, see);
        rays
    };
    let recorded: Vec<Vec<Ray>> = (0..chunks(scene, settings)).into_par_iter().map(rays_of).collect();
    recorded.concat()
}

fn chunks(scene: &Scene, settings: &Settings) -> usize {
    if scene.lights().is_empty() { 0 } else { settings.photons.div_ceil(CHUNK) as usize }
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
