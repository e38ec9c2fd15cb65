//! The tree of spheres: which spheres contain a point?

use rayon::prelude::*;

use super::build::build;
use super::gather::gather;
use super::sphere::Sphere;
use super::tree::{Node, Tree};
use crate::math::{Aabb, Vec3};

/// Most spheres in a leaf.
pub(super) const LEAF_SIZE: usize = 12;

/// Below this many spheres a subtree is refitted by one thread.
const PARALLEL_REFIT: usize = 8 * 1024;

/// Spheres in a tree. Apart from [`SphereBvh::build`], everything counts spheres by their position in it.
#[derive(Clone, Debug)]
pub struct SphereBvh {
    tree: Tree,
    spheres: Vec<Sphere>,
}

impl SphereBvh {
    /// Builds the tree; `order[position]` is the index in `spheres` of the sphere at that position.
    ///
    /// The result does not depend on the number of threads.
    ///
    /// ```
    /// use caustica::{bvh::{Sphere, SphereBvh}, math::Vec3};
    /// let spheres = [5.0, 0.0, 1.0].map(|x| Sphere { center: Vec3::X * x, radius: 1.0 });
    /// let (bvh, order) = SphereBvh::build(&spheres);
    /// let mut found = Vec::new();
    /// bvh.for_each_containing(Vec3::X, |position| found.push(order[position]));
    /// found.sort();
    /// assert_eq!(found, [1, 2]);
    /// ```
    pub fn build(spheres: &[Sphere]) -> (SphereBvh, Vec<u32>) {
        let boxes: Vec<Aabb> = spheres.par_iter().map(Sphere::bounds).collect();
        let (tree, order) = build(&boxes, LEAF_SIZE);
        let spheres = order.par_iter().map(|&index| spheres[index as usize]).collect();
        (SphereBvh { tree, spheres }, order)
    }

    /// The number of spheres.
    pub fn len(&self) -> usize {
        self.spheres.len()
    }

    /// Whether there is no sphere.
    pub fn is_empty(&self) -> bool {
        self.spheres.is_empty()
    }

    /// A box around all spheres, a few roundings wider than the smallest; empty without spheres.
    pub fn bounds(&self) -> Aabb {
        self.tree.bounds()
    }

    /// Gives the sphere at each position the radius `radius_of(position)` and tightens all boxes.
    ///
    /// The shape of the tree stays: it suits radii that shrink or grow by about the same factor.
    pub fn refit(&mut self, radius_of: impl Fn(usize) -> f32 + Sync) {
        if !self.is_empty() {
            refit_subtree(&mut self.tree.nodes, &mut self.spheres, &radius_of);
        }
    }

    /// Calls `visit(position)` once for every sphere that contains `p`, in increasing order.
    ///
    /// The boundary belongs to the sphere; see [`Sphere::contains`]. A NaN point is nowhere.
    pub fn for_each_containing(&self, p: Vec3, mut visit: impl FnMut(usize)) {
        self.tree.for_each_leaf_around(p, |positions| {
            for position in positions {
                if self.spheres[position].contains(p) {
                    visit(position);
                }
            }
        });
    }

    /// Calls `visit(&mut states[position], position, point_index)` for every sphere and point inside it.
    ///
    /// To one state the points come in increasing index, on one thread at a time: whatever it sums has the same
    /// bytes with any number of threads. Different states may be visited on different threads at once.
    ///
    /// # Panics
    /// Where `states` has not the length of the tree.
    pub fn gather<S: Send>(
        &self,
        points: &[Vec3],
        states: &mut [S],
        visit: impl Fn(&mut S, usize, usize) + Sync,
    ) {
        assert_eq!(states.len(), self.len(), "gather needs one state for each sphere");
        gather(&self.tree, &self.spheres, points, states, &visit);
    }

    /// The memory that tree and spheres hold, in bytes.
    pub fn memory_bytes(&self) -> usize {
        size_of::<Node>() * self.tree.nodes.capacity() + size_of::<Sphere>() * self.spheres.capacity()
    }

    /// Whether every box contains what is below it and the leaves partition the positions.
    ///
    /// # Errors
    /// Names the first node that breaks a rule, and the rule.
    pub fn check_invariants(&self) -> Result<(), String> {
        if self.tree.len() != self.spheres.len() {
            return Err(format!(
                "a tree over {} positions for {} spheres",
                self.tree.len(),
                self.spheres.len()
            ));
        }
        self.tree.check_invariants(|position| self.spheres[position].bounds())
    }
}

/// Refits the subtree whose root is `nodes[0]` and whose spheres are `spheres`, and returns its box.
fn refit_subtree(
    nodes: &mut [Node],
    spheres: &mut [Sphere],
    radius_of: &(impl Fn(usize) -> f32 + Sync),
) -> Aabb {
    let first = nodes[0].first as usize;
    nodes[0].bounds = if nodes[0].is_leaf() {
        refit_leaf(first, spheres, radius_of)
    } else {
        let parallel = spheres.len() >= PARALLEL_REFIT;
        let size = nodes[1].size as usize;
        let (left, right) = nodes[1..].split_at_mut(size);
        let (left_spheres, right_spheres) = spheres.split_at_mut(right[0].first as usize - first);
        let mut left = || refit_subtree(left, left_spheres, radius_of);
        let mut right = || refit_subtree(right, right_spheres, radius_of);
        let (left, right) = if parallel { rayon::join(left, right) } else { (left(), right()) };
        left.union(right)
    };
    nodes[0].bounds
}

fn refit_leaf(first: usize, spheres: &mut [Sphere], radius_of: &impl Fn(usize) -> f32) -> Aabb {
    spheres.iter_mut().zip(first..).fold(Aabb::EMPTY, |bounds, (sphere, position)| {
        sphere.radius = radius_of(position);
        bounds.union(sphere.bounds())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::test_sets::{Layout, Radii, on_threads, points_around, sphere_set, spheres};
    use proptest::prelude::*;

    fn assert_matches_naive(bvh: &SphereBvh, points: &[Vec3]) {
        bvh.check_invariants().unwrap();
        for &p in points {
            let naive: Vec<usize> = (0..bvh.len()).filter(|&k| bvh.spheres[k].contains(p)).collect();
            let mut found = Vec::new();
            bvh.for_each_containing(p, |position| found.push(position));
            assert_eq!(found, naive, "around {p}");
        }
    }

    proptest! {
        #[test]
        fn points_find_what_the_naive_search_finds(input in sphere_set(), seed: u64) {
            let (bvh, order) = SphereBvh::build(&input);
            for (position, &index) in order.iter().enumerate() {
                prop_assert_eq!(bvh.spheres[position], input[index as usize]);
            }
            let mut sorted = order.clone();
            sorted.sort();
            prop_assert!(sorted.into_iter().eq(0..input.len() as u32));
            assert_matches_naive(&bvh, &points_around(&input, 64, seed));
        }

        #[test]
        fn refitted_trees_match_too(input in sphere_set(), seed: u64, factor in 0f32..4.0) {
            let (mut bvh, order) = SphereBvh::build(&input);
            let radius = |position: usize| input[order[position] as usize].radius * factor;
            bvh.refit(radius);
            prop_assert!((0..bvh.len()).all(|k| bvh.spheres[k].radius == radius(k)));
            let (small, all) = (bvh.bounds(), Aabb::EMPTY);
            let tight = bvh.spheres.iter().fold(all, |bounds, sphere| bounds.union(sphere.bounds()));
            prop_assert_eq!(small, tight);
            assert_matches_naive(&bvh, &points_around(&bvh.spheres, 64, seed));
        }
    }

    #[test]
    fn large_trees_refit_in_parallel() {
        let input = spheres(Layout::Cube, Radii::Equal(0.1), 20_000, 1);
        let (mut bvh, _) = SphereBvh::build(&input);
        for factor in [3.0, 0.2] {
            bvh.refit(|position| 0.1 * factor + 1e-6 * position as f32);
            assert_matches_naive(&bvh, &points_around(&input, 50, 2));
        }
    }

    #[test]
    fn the_tree_is_the_same_on_any_number_of_threads() {
        let input = spheres(Layout::Clusters, Radii::Mixed, 100_000, 3);
        let (one, order) = on_threads(1, || SphereBvh::build(&input));
        for threads in [2, 7] {
            let (other, other_order) = on_threads(threads, || SphereBvh::build(&input));
            assert!(one.tree == other.tree && order == other_order, "{threads} threads");
        }
    }

    #[test]
    fn a_million_coincident_spheres_make_a_valid_tree() {
        let sphere = Sphere { center: Vec3::new(0.1, 0.2, 0.3), radius: 0.5 };
        let (bvh, _) = SphereBvh::build(&vec![sphere; 1_000_000]);
        bvh.check_invariants().unwrap();
        let mut next = 0;
        bvh.for_each_containing(sphere.center, |position| {
            assert_eq!(position, next);
            next += 1;
        });
        assert_eq!(next, bvh.len());
    }

    #[test]
    fn trees_stay_small() {
        let input = spheres(Layout::Plane, Radii::Equal(0.01), 100_000, 4);
        assert!(SphereBvh::build(&input).0.memory_bytes() < 32 * input.len());
        assert_eq!(SphereBvh::build(&[]).0.memory_bytes(), 0);
    }

    #[test]
    fn spheres_of_no_size_or_endless_size_keep_their_word() {
        let radii = [0.0, -0.0, -1.0, f32::NAN, 1e-30, 1e19, 1e30, f32::INFINITY];
        let centers = [Vec3::ZERO, Vec3::ONE, Vec3::NAN, Vec3::INFINITY, Vec3::splat(1e30)];
        let input: Vec<Sphere> =
            radii.iter().flat_map(|&radius| centers.map(|center| Sphere { center, radius })).collect();
        let points = [centers.as_slice(), &[Vec3::splat(1e-25), Vec3::splat(3e38)]].concat();
        assert_matches_naive(&SphereBvh::build(&input).0, &points);
        assert!(!input.iter().any(|sphere| sphere.contains(Vec3::NAN)));
        assert!(!Sphere { center: Vec3::ZERO, radius: -1.0 }.contains(Vec3::ZERO));
    }
}
