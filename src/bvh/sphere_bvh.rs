//! The tree of spheres: which spheres contain a point?

use rayon::prelude::*;

use super::build::{build_boxes, build_cubes};
use super::gather::gather;
use super::gatherer::{EachMeeting, Gatherer, Radii};
use super::list_pool::ListPool;
use super::part::Part;
use super::sphere::{Sphere, common_reach};
use super::split::Weight;
use super::tree::{Node, Tree};
use crate::math::{Aabb, Vec3};
use crate::simd::{Isa, LANES};

/// Most spheres in a leaf: as many as are met at once.
pub(super) const LEAF_SIZE: usize = LANES;

/// Below this many spheres a subtree is refitted by one thread.
const PARALLEL_REFIT: usize = 8 * 1024;

/// Spheres in a tree. Apart from [`SphereBvh::build`], everything counts spheres by their position in it.
///
/// They stand in columns, so that those of a leaf fill the lanes of a register.
#[derive(Clone, Debug)]
pub struct SphereBvh {
    tree: Tree,
    centers: [Vec<f32>; 3],
    radii: Vec<f32>,
    pool: ListPool,
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
        SphereBvh::build_with(spheres, LEAF_SIZE, Weight::Area)
    }

    /// The same with at most `leaf_size` spheres in a leaf, from 1 to `LANES`, and costs by `weight`: to measure
    /// what [`SphereBvh::build`] rests on.
    pub fn build_with(spheres: &[Sphere], leaf_size: usize, weight: Weight) -> (SphereBvh, Vec<u32>) {
        let leaf_size = leaf_size.min(LANES);
        let (tree, order) = match common_reach(spheres) {
            Some(reach) => build_cubes(spheres.par_iter().map(|s| s.center), reach, leaf_size, weight),
            None => {
                let boxes: Vec<Aabb> = spheres.par_iter().map(Sphere::bounds).collect();
                build_boxes(&boxes, leaf_size, weight)
            }
        };
        let column = |of: fn(&Sphere) -> f32| order.par_iter().map(|&k| of(&spheres[k as usize])).collect();
        let centers = [column(|s| s.center.x), column(|s| s.center.y), column(|s| s.center.z)];
        let radii = column(|s| s.radius);
        (SphereBvh { tree, centers, radii, pool: ListPool::default() }, order)
    }

    /// The number of spheres.
    pub fn len(&self) -> usize {
        self.radii.len()
    }

    /// Whether there is no sphere.
    pub fn is_empty(&self) -> bool {
        self.radii.is_empty()
    }

    /// A box around all spheres, a few roundings wider than the smallest; empty without spheres.
    pub fn bounds(&self) -> Aabb {
        self.tree.bounds()
    }

    /// The sphere at a position.
    pub fn sphere(&self, position: usize) -> Sphere {
        sphere_at(&self.centers, &self.radii, position)
    }

    /// All nodes; see [`Tree::nodes`].
    pub fn nodes(&self) -> &[Node] {
        self.tree.nodes()
    }

    /// The radii, by position.
    pub fn radii(&self) -> &[f32] {
        &self.radii
    }

    /// Gives the sphere at each position the radius `radius_of(position)` and tightens all boxes.
    ///
    /// The shape of the tree stays: it suits radii that shrink or grow by about the same factor.
    pub fn refit(&mut self, radius_of: impl Fn(usize) -> f32 + Sync) {
        if !self.is_empty() {
            let mut stateless = vec![(); self.len()];
            let (mut part, centers) = self.parts(&mut stateless);
            refit_part(&mut part, centers, &radius_of);
        }
    }

    /// Calls `visit(position)` once for every sphere that contains `p`, in increasing order.
    ///
    /// The boundary belongs to the sphere; see [`Sphere::contains`]. A NaN point is nowhere.
    pub fn for_each_containing(&self, p: Vec3, mut visit: impl FnMut(usize)) {
        self.tree.for_each_leaf_around(p, |positions| {
            for position in positions {
                if self.sphere(position).contains(p) {
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
        &mut self,
        points: &[Vec3],
        states: &mut [S],
        visit: impl Fn(&mut S, usize, usize) + Sync,
    ) {
        self.gather_with(Isa::best(), &[points], states, &EachMeeting::new(visit));
    }

    /// Lets all points meet the spheres around them, leaf by leaf, in one walk that also follows the radii.
    ///
    /// The points are numbered on from slice to slice. Every leaf comes at most once for each million of points, on one thread at a time; order and result depend on
    /// neither the number of threads nor the instruction set.
    ///
    /// # Panics
    /// Where `states` has not the length of the tree.
    pub fn gather_with<G: Gatherer>(
        &mut self,
        isa: Isa,
        points: &[&[Vec3]],
        states: &mut [G::State],
        gatherer: &G,
    ) -> G::Tally {
        assert_eq!(states.len(), self.len(), "gather needs one state for each sphere");
        if self.is_empty() {
            return G::Tally::default();
        }
        let pool = std::mem::take(&mut self.pool);
        let tally = gather(self.parts(states), &pool, isa, points, gatherer);
        self.pool = pool;
        tally
    }

    /// The whole tree as a part, and the columns of all centres.
    fn parts<'a, S>(&'a mut self, states: &'a mut [S]) -> (Part<'a, S>, [&'a [f32]; 3]) {
        let part = Part { nodes: &mut self.tree.nodes, radii: &mut self.radii, states };
        (part, self.centers.each_ref().map(|column| column.as_slice()))
    }

    /// The memory that tree and spheres hold, in bytes; not what gathering works in.
    pub fn memory_bytes(&self) -> usize {
        let numbers = self.centers.iter().map(Vec::capacity).sum::<usize>() + self.radii.capacity();
        size_of::<Node>() * self.tree.nodes.capacity() + size_of::<f32>() * numbers
    }

    /// Whether every box contains what is below it and the leaves partition the positions.
    ///
    /// # Errors
    /// Names the first node that breaks a rule, and the rule.
    pub fn check_invariants(&self) -> Result<(), String> {
        if self.tree.len() != self.radii.len() {
            return Err(format!(
                "a tree over {} positions for {} spheres",
                self.tree.len(),
                self.radii.len()
            ));
        }
        self.tree.check_invariants(|position| self.sphere(position).bounds())
    }
}

fn sphere_at(centers: &[Vec<f32>; 3], radii: &[f32], position: usize) -> Sphere {
    let [x, y, z] = centers.each_ref().map(|column| column[position]);
    Sphere { center: Vec3::new(x, y, z), radius: radii[position] }
}

fn refit_part(part: &mut Part<()>, centers: [&[f32]; 3], radius_of: &(impl Fn(usize) -> f32 + Sync)) {
    if part.nodes[0].is_leaf() {
        let first = part.nodes[0].first as usize;
        part.radii.iter_mut().zip(first..).for_each(|(radius, position)| *radius = radius_of(position));
        part.follow_spheres(centers, Radii::Changed);
        return;
    }
    let parallel = part.radii.len() >= PARALLEL_REFIT;
    let (mut left, mut right) = part.children();
    let mut left = || refit_part(&mut left, centers, radius_of);
    let mut right = || refit_part(&mut right, centers, radius_of);
    if parallel {
        rayon::join(left, right);
    } else {
        left();
        right();
    }
    part.follow_children([Radii::Changed; 2]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::test_sets::{Layout, Radii, on_threads, points_around, sphere_set, spheres};
    use proptest::prelude::*;

    fn assert_matches_naive(bvh: &SphereBvh, points: &[Vec3]) {
        bvh.check_invariants().unwrap();
        for &p in points {
            let naive: Vec<usize> = (0..bvh.len()).filter(|&k| bvh.sphere(k).contains(p)).collect();
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
                prop_assert_eq!(bvh.sphere(position), input[index as usize]);
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
            prop_assert!((0..bvh.len()).all(|k| bvh.radii()[k] == radius(k)));
            let spheres: Vec<Sphere> = (0..bvh.len()).map(|k| bvh.sphere(k)).collect();
            let tight = spheres.iter().fold(Aabb::EMPTY, |bounds, sphere| bounds.union(sphere.bounds()));
            prop_assert_eq!(bvh.bounds(), tight);
            assert_matches_naive(&bvh, &points_around(&spheres, 64, seed));
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
