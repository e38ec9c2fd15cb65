//! What answers which spheres contain which photons, brought under one interface.

use std::sync::atomic::{AtomicU32, Ordering};

use rayon::prelude::*;

use super::{BenchError, HashGrid, KdTree};
use crate::bvh::{Sphere, SphereBvh, Weight};
use crate::embree::{self, SphereQuery};
use crate::math::Vec3;
use crate::simd::LANES;

/// A search structure over spheres that can be measured.
pub trait Structure {
    /// The memory that it holds, in bytes; `None` where it cannot be told.
    fn memory_bytes(&self) -> Option<usize>;

    /// Adds one to a sphere's count for every photon inside it, on all threads of the pool.
    fn count(&mut self, photons: &[Vec3], counts: &mut [AtomicU32]);

    /// `order[k]` is the sphere that count `k` belongs to; `None` where it is sphere `k`.
    fn order(&self) -> Option<&[u32]> {
        None
    }
}

/// The order in which photons come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PhotonOrder {
    /// Along a Morton curve; the time of sorting is not counted.
    Sorted,
    /// As a photon pass leaves them; at random on walls.
    AsTraced,
}

/// A structure, or why there is none.
pub type Built = Result<Box<dyn Structure>, BenchError>;

/// A structure that takes part in a measurement.
#[derive(Clone, Copy)]
pub struct Rival {
    /// Its name in reports.
    pub name: &'static str,
    /// How it wants its photons.
    pub photons: PhotonOrder,
    /// Builds it, on all threads of the pool.
    pub build: fn(&[Sphere]) -> Built,
}

/// The rivals that the program brings along; the first is the one that others are held against.
pub const RIVALS: [Rival; 6] = [
    Rival { name: "sphere tree", photons: PhotonOrder::Sorted, build: build_tree },
    Rival { name: "sphere tree (photons as traced)", photons: PhotonOrder::AsTraced, build: build_tree },
    Rival { name: "sphere tree (one by one)", photons: PhotonOrder::Sorted, build: build_walked_tree },
    Rival { name: "Embree point query", photons: PhotonOrder::Sorted, build: build_point_query },
    Rival { name: "hash grid", photons: PhotonOrder::Sorted, build: build_hash_grid },
    Rival { name: "k-d tree (kiddo)", photons: PhotonOrder::Sorted, build: build_kd_tree },
];

/// Other ways to build the sphere tree than the program's.
pub const VARIANTS: [Rival; 4] = [
    Rival { name: "by volume", photons: PhotonOrder::Sorted, build: |s| shaped(s, LANES, Weight::Volume) },
    Rival { name: "leaves of 4", photons: PhotonOrder::Sorted, build: |s| shaped(s, 4, Weight::Area) },
    Rival { name: "leaves of 8", photons: PhotonOrder::Sorted, build: |s| shaped(s, 8, Weight::Area) },
    Rival { name: "leaves of 12", photons: PhotonOrder::Sorted, build: |s| shaped(s, 12, Weight::Area) },
];

fn shaped(spheres: &[Sphere], leaf_size: usize, weight: Weight) -> Built {
    let (tree, order) = SphereBvh::build_with(spheres, leaf_size, weight);
    Ok(Box::new(OrderedTree { tree, order }))
}

/// A structure that is asked about one point after the other.
pub trait PointSearch: Sync {
    /// Calls `visit` with the number of every sphere that contains `p`.
    fn for_each_containing(&self, p: Vec3, visit: impl FnMut(usize));

    /// As [`Structure::memory_bytes`].
    fn memory_bytes(&self) -> Option<usize>;

    /// As [`Structure::order`].
    fn order(&self) -> Option<&[u32]> {
        None
    }
}

/// Asks about photon after photon, in parallel. Two threads may find the same sphere: its count is then atomic.
pub struct OneByOne<S>(pub S);

/// Photons that one task asks about at least.
const CHUNK: usize = 512;

impl<S: PointSearch> Structure for OneByOne<S> {
    fn memory_bytes(&self) -> Option<usize> {
        self.0.memory_bytes()
    }

    fn count(&mut self, photons: &[Vec3], counts: &mut [AtomicU32]) {
        if rayon::current_num_threads() == 1 {
            for &p in photons {
                self.0.for_each_containing(p, |sphere| *counts[sphere].get_mut() += 1);
            }
            return;
        }
        let counts = &*counts;
        photons.par_iter().with_min_len(CHUNK).for_each(|&p| {
            self.0.for_each_containing(p, |sphere| {
                counts[sphere].fetch_add(1, Ordering::Relaxed);
            });
        });
    }

    fn order(&self) -> Option<&[u32]> {
        self.0.order()
    }
}

/// The tree, and what its positions stand for.
struct OrderedTree {
    tree: SphereBvh,
    order: Vec<u32>,
}

impl OrderedTree {
    fn build(spheres: &[Sphere]) -> OrderedTree {
        let (tree, order) = SphereBvh::build(spheres);
        OrderedTree { tree, order }
    }
}

impl Structure for OrderedTree {
    fn memory_bytes(&self) -> Option<usize> {
        Some(self.tree.memory_bytes())
    }

    fn count(&mut self, photons: &[Vec3], counts: &mut [AtomicU32]) {
        self.tree.gather(photons, counts, |count, _, _| *count.get_mut() += 1);
    }

    fn order(&self) -> Option<&[u32]> {
        Some(&self.order)
    }
}

impl PointSearch for OrderedTree {
    fn for_each_containing(&self, p: Vec3, visit: impl FnMut(usize)) {
        self.tree.for_each_containing(p, visit);
    }

    fn memory_bytes(&self) -> Option<usize> {
        Some(self.tree.memory_bytes())
    }

    fn order(&self) -> Option<&[u32]> {
        Some(&self.order)
    }
}

impl PointSearch for SphereQuery {
    fn for_each_containing(&self, p: Vec3, visit: impl FnMut(usize)) {
        self.for_each_containing(p, visit);
    }

    fn memory_bytes(&self) -> Option<usize> {
        Some(self.memory_bytes())
    }
}

impl PointSearch for HashGrid {
    fn for_each_containing(&self, p: Vec3, visit: impl FnMut(usize)) {
        self.for_each_containing(p, visit);
    }

    fn memory_bytes(&self) -> Option<usize> {
        Some(self.memory_bytes())
    }
}

impl PointSearch for KdTree {
    fn for_each_containing(&self, p: Vec3, visit: impl FnMut(usize)) {
        self.for_each_containing(p, visit);
    }

    fn memory_bytes(&self) -> Option<usize> {
        Some(self.memory_bytes())
    }
}

fn build_tree(spheres: &[Sphere]) -> Built {
    Ok(Box::new(OrderedTree::build(spheres)))
}

fn build_walked_tree(spheres: &[Sphere]) -> Built {
    Ok(Box::new(OneByOne(OrderedTree::build(spheres))))
}

fn build_hash_grid(spheres: &[Sphere]) -> Built {
    Ok(Box::new(OneByOne(HashGrid::build(spheres))))
}

fn build_kd_tree(spheres: &[Sphere]) -> Built {
    Ok(Box::new(OneByOne(KdTree::build(spheres)?)))
}

fn build_point_query(spheres: &[Sphere]) -> Built {
    let of_embree = |s: &Sphere| embree::Sphere { center: s.center, radius: s.radius };
    let spheres: Vec<embree::Sphere> = spheres.iter().map(of_embree).collect();
    Ok(Box::new(OneByOne(SphereQuery::build(&spheres, rayon::current_num_threads())?)))
}
