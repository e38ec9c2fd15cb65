//! Photons where they arrived, by kinds of paths and chunks.

use super::Ledger;
use crate::effects::{PathClass, PathClasses};
use crate::math::{Rgb, Vec3};

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
    pub(super) fn clear(&mut self) {
        self.caustic.clear();
        self.glints.clear();
        self.indirect.clear();
        self.ratios.clear();
        self.ledger = Ledger::default();
    }

    pub(super) fn memory_bytes(&self) -> usize {
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
