//! The rival of many photon mappers: spheres in a grid of cells, of which only hashes are kept.

use std::sync::atomic::{AtomicU32, Ordering};

use rayon::prelude::*;

use crate::bvh::Sphere;
use crate::math::{Aabb, Vec3};

/// Spheres listed in every grid cell that their box touches; a point looks into the one cell that it lies in.
///
/// Cells are as wide as the largest sphere; cell (x, y, z) shares list `(73856093 x ⊕ 19349663 y ⊕ 83492791 z) mod m`
/// with others, where `m` is the number of spheres rounded up to a power of two. The lists lie one behind the other.
///
/// # Source
/// Teschner, Heidelberger, Müller, Pomerantes and Gross, "Optimized Spatial Hashing for Collision Detection of
/// Deformable Objects", VMV 2003, for the hash; Hachisuka and Jensen, "Stochastic Progressive Photon Mapping",
/// SIGGRAPH Asia 2009, for its use with hit points.
#[derive(Clone, Debug)]
pub struct HashGrid {
    cells: Cells,
    /// List `k` is `entries[starts[k]..starts[k + 1]]`.
    starts: Vec<u32>,
    entries: Vec<u32>,
    spheres: Vec<Sphere>,
}

/// Where the cells lie, and which list each one shares.
#[derive(Clone, Copy, Debug)]
struct Cells {
    origin: Vec3,
    per_unit: f32,
    lists: u32,
}

impl HashGrid {
    /// Lists the spheres; on all threads of the pool.
    pub fn build(spheres: &[Sphere]) -> HashGrid {
        let cells = Cells::around(spheres);
        let counts: Vec<AtomicU32> = (0..cells.lists).map(|_| AtomicU32::new(0)).collect();
        spheres.par_iter().for_each(|sphere| {
            cells.for_each_list(sphere, |list| {
                counts[list].fetch_add(1, Ordering::Relaxed);
            });
        });
        let (starts, total) = starts(&counts);
        let ends: Vec<AtomicU32> = starts.iter().map(|&start| AtomicU32::new(start)).collect();
        let entries: Vec<AtomicU32> = (0..total).map(|_| AtomicU32::new(0)).collect();
        spheres.par_iter().zip(0..spheres.len() as u32).for_each(|(sphere, index)| {
            cells.for_each_list(sphere, |list| {
                let slot = ends[list].fetch_add(1, Ordering::Relaxed);
                entries[slot as usize].store(index, Ordering::Relaxed);
            });
        });
        let entries = entries.into_iter().map(AtomicU32::into_inner).collect();
        HashGrid { cells, starts, entries, spheres: spheres.to_vec() }
    }

    /// Calls `visit(index)` once for every sphere that contains `p`, in no particular order.
    pub fn for_each_containing(&self, p: Vec3, mut visit: impl FnMut(usize)) {
        let list = self.cells.list(self.cells.cell(p));
        let range = self.starts[list] as usize..self.starts[list + 1] as usize;
        for &index in &self.entries[range] {
            if self.spheres[index as usize].contains(p) {
                visit(index as usize);
            }
        }
    }

    /// The memory that lists and spheres hold, in bytes.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&*self.starts) + size_of_val(&*self.entries) + size_of_val(&*self.spheres)
    }
}

/// Where each list starts, with the end of the last behind them, and how long all are together.
fn starts(counts: &[AtomicU32]) -> (Vec<u32>, u32) {
    let mut total = 0;
    let mut starts = Vec::with_capacity(counts.len() + 1);
    for count in counts {
        starts.push(total);
        total += count.load(Ordering::Relaxed);
    }
    starts.push(total);
    (starts, total)
}

impl Cells {
    fn around(spheres: &[Sphere]) -> Cells {
        let bounds = spheres.iter().fold(Aabb::EMPTY, |all, sphere| all.union(sphere.bounds()));
        let widest = spheres.iter().fold(0f32, |widest, sphere| widest.max(2.0 * sphere.radius));
        // A million cells along each side are enough, and fit into 32 bits.
        let width = widest.max(bounds.extent().max_element() / (1 << 20) as f32).max(f32::MIN_POSITIVE);
        let lists = spheres.len().next_power_of_two() as u32;
        Cells { origin: bounds.min, per_unit: 1.0 / width, lists }
    }

    /// Grows with every coordinate, however it was rounded: no point inside a box lies in a cell outside it.
    fn cell(&self, p: Vec3) -> [i32; 3] {
        ((p - self.origin) * self.per_unit).floor().to_array().map(|c| c as i32)
    }

    fn list(&self, [x, y, z]: [i32; 3]) -> usize {
        let hash = (x as u32).wrapping_mul(73_856_093)
            ^ (y as u32).wrapping_mul(19_349_663)
            ^ (z as u32).wrapping_mul(83_492_791);
        (hash & (self.lists - 1)) as usize
    }

    /// Every list once that a cell under the sphere's box shares, although several of the cells may share it.
    fn for_each_list(&self, sphere: &Sphere, mut visit: impl FnMut(usize)) {
        let bounds = sphere.bounds();
        if bounds.is_empty() {
            return;
        }
        let ([x0, y0, z0], [x1, y1, z1]) = (self.cell(bounds.min), self.cell(bounds.max));
        let mut seen = [0; 27];
        let mut n = 0;
        for x in x0..=x1 {
            for y in y0..=y1 {
                for z in z0..=z1 {
                    let list = self.list([x, y, z]);
                    if !seen[..n].contains(&list) {
                        seen[n] = list;
                        n += 1;
                        visit(list);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn found(grid: &HashGrid, p: Vec3) -> Vec<usize> {
        let mut found = Vec::new();
        grid.for_each_containing(p, |index| found.push(index));
        found.sort_unstable();
        found
    }

    fn point() -> impl Strategy<Value = Vec3> {
        (-2f32..2.0, -2f32..2.0, -2f32..2.0).prop_map(Vec3::from)
    }

    fn sphere() -> impl Strategy<Value = Sphere> {
        let radius = prop_oneof![1e-3f32..1.0, Just(0.0), Just(-1.0), Just(f32::NAN)];
        (point(), radius).prop_map(|(center, radius)| Sphere { center, radius })
    }

    proptest! {
        #[test]
        fn points_find_what_the_naive_search_finds(
            spheres in prop::collection::vec(sphere(), 1..200),
            mut points in prop::collection::vec(point(), 1..50),
        ) {
            points.extend(spheres.iter().map(|s| s.center - Vec3::Y * s.radius));
            points.extend([Vec3::NAN, Vec3::splat(1e30), Vec3::splat(-1e30)]);
            let grid = HashGrid::build(&spheres);
            for p in points {
                let naive: Vec<usize> = (0..spheres.len()).filter(|&k| spheres[k].contains(p)).collect();
                prop_assert_eq!(found(&grid, p), naive);
            }
        }
    }

    #[test]
    fn no_sphere_is_found_in_no_grid() {
        assert!(found(&HashGrid::build(&[]), Vec3::ZERO).is_empty());
        assert!(HashGrid::build(&[]).memory_bytes() > 0);
    }

    #[test]
    fn cells_that_share_a_list_list_a_sphere_once() {
        let spheres = [Sphere { center: Vec3::ZERO, radius: 1.0 }];
        let grid = HashGrid::build(&spheres);
        assert_eq!((grid.cells.lists, grid.entries.len()), (1, 1));
    }
}
