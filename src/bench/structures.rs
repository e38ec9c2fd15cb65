//! What answers which spheres contain which photons, brought under one interface.

use std::sync::atomic::{AtomicU32, Ordering};

use rayon::prelude::*;

use super::{BenchError, HashGrid, KdTree};
use crate::bvh::{EachMeeting, Sphere, SphereBvh, Weight};
use crate::embree::{self, SphereQuery};
use crate::math::Vec3;
use crate::simd::{Isa, LANES};

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

/// Other sphere trees than the program's: built in other ways, and gathered in the lanes of all instruction sets that the
/// machine has.
pub fn variants() -> Vec<Rival> {
    let is_there = |rival: &Rival| Isa::available().any(|isa| rival.name == lanes_of(isa));
    SHAPES.into_iter().chain(LANES_OF_ISAS.into_iter().filter(is_there)).collect()
}

const SHAPES: [Rival; 4] = [
    Rival { name: "by volume", photons: PhotonOrder::Sorted, build: |s| shaped(s, LANES, Weight::Volume) },
    Rival { name: "leaves of 4", photons: PhotonOrder::Sorted, build: |s| shaped(s, 4, Weight::Area) },
    Rival { name: "leaves of 8", photons: PhotonOrder::Sorted, build: |s| shaped(s, 8, Weight::Area) },
    Rival { name: "leaves of 12", photons: PhotonOrder::Sorted, build: |s| shaped(s, 12, Weight::Area) },
];

const LANES_OF_ISAS: [Rival; 3] = [
    Rival { name: "portable lanes", photons: PhotonOrder::Sorted, build: |s| in_lanes(s, "portable lanes") },
    Rival { name: "AVX2 lanes", photons: PhotonOrder::Sorted, build: |s| in_lanes(s, "AVX2 lanes") },
    Rival { name: "AVX-512 lanes", photons: PhotonOrder::Sorted, build: |s| in_lanes(s, "AVX-512 lanes") },
];

fn lanes_of(isa: Isa) -> String {
    format!("{isa} lanes")
}

fn shaped(spheres: &[Sphere], leaf_size: usize, weight: Weight) -> Built {
    let (tree, order) = SphereBvh::build_with(spheres, leaf_size, weight);
    Ok(Box::new(OrderedTree { tree, order, isa: Isa::best() }))
}

/// Without such lanes, in portable ones.
fn in_lanes(spheres: &[Sphere], name: &str) -> Built {
    let isa = Isa::available().find(|&isa| lanes_of(isa) == name).unwrap_or(Isa::portable());
    Ok(Box::new(OrderedTree { isa, ..OrderedTree::build(spheres) }))
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

/// The tree, what its positions stand for, and how it is walked.
struct OrderedTree {
    tree: SphereBvh,
    order: Vec<u32>,
    isa: Isa,
}

impl OrderedTree {
    fn build(spheres: &[Sphere]) -> OrderedTree {
        let (tree, order) = SphereBvh::build(spheres);
        OrderedTree { tree, order, isa: Isa::best() }
    }
}

impl Structure for OrderedTree {
    fn memory_bytes(&self) -> Option<usize> {
        Some(self.tree.memory_bytes())
    }

    fn count(&mut self, photons: &[Vec3], counts: &mut [AtomicU32]) {
        let count = EachMeeting::new(|count: &mut AtomicU32, _, _| *count.get_mut() += 1);
        self.tree.gather_with(self.isa, &[photons], counts, &count);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_of_every_instruction_set_of_the_machine_take_part() {
        let names: Vec<&str> = variants().iter().map(|rival| rival.name).collect();
        let lanes: Vec<String> = Isa::available().map(lanes_of).collect();
        assert_eq!(names[SHAPES.len()..], lanes);
    }
}
