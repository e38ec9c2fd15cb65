//! The builder: top-down, in place, the same tree whatever the number of threads.

use rayon::prelude::*;

use super::items::{BoxItem, CubeItem, Item};
use super::split::{Bins, Weight, partition_at_median};
use super::tree::{Node, Tree};
use crate::math::{Aabb, Vec3};

/// Below this many boxes a subtree is built by one thread.
const PARALLEL_BOXES: usize = 8 * 1024;

/// Passes over more boxes than this are cut in halves.
const PASS_BOXES: usize = 32 * 1024;

/// Below this depth the median is taken: each such level halves the count, so recursion ends in time.
const MAX_HEURISTIC_DEPTH: u32 = 40;

/// A tree over `boxes` with at most `leaf_size` (at least 1) to a leaf, and the index in `boxes` of each position.
///
/// Empty boxes are allowed; boxes without a finite centre are placed anywhere; NaN corners are not allowed. At most 2³⁰ boxes are allowed.
///
/// ```
/// use caustica::{bvh::build, math::{Aabb, Vec3}};
/// let boxes = [3.0, 1.0, 2.0].map(|x| Aabb::of_sphere(Vec3::splat(x), 0.25));
/// let (tree, order) = build(&boxes, 1);
/// assert_eq!(tree.nodes().len(), 5);
/// assert_eq!(order, [1, 2, 0]);
/// ```
pub fn build(boxes: &[Aabb], leaf_size: usize) -> (Tree, Vec<u32>) {
    build_boxes(boxes, leaf_size, Weight::Area)
}

/// The same with costs by `weight`.
pub(super) fn build_boxes(boxes: &[Aabb], leaf_size: usize, weight: Weight) -> (Tree, Vec<u32>) {
    let items = boxes.par_iter().enumerate().map(|(index, b)| BoxItem::new(b, index as u32)).collect();
    Builder::<BoxItem, 3, 16> { leaf_size, weight, shared: () }.build(items)
}

/// The same over cubes around `centers`, with all sides `2 half_side` long.
///
/// Only the longest axis of a node is tried for its cut, between half as many slices: cubes of one size leave little
/// to choose.
pub(super) fn build_cubes(
    centers: impl IndexedParallelIterator<Item = Vec3>,
    half_side: f32,
    leaf_size: usize,
    weight: Weight,
) -> (Tree, Vec<u32>) {
    let items = centers.enumerate().map(|(index, center)| CubeItem::new(center, index as u32)).collect();
    Builder::<CubeItem, 1, 8> { leaf_size, weight, shared: half_side }.build(items)
}

/// Seeks cuts between `SLICES` equal slices along the `AXES` longest axes of a node.
struct Builder<I: Item, const AXES: usize, const SLICES: usize> {
    leaf_size: usize,
    weight: Weight,
    shared: I::Shared,
}

/// A set of items: what they span and, if the set is to be cut, how they are sorted into bins.
type Set<'a, I, const AXES: usize, const SLICES: usize> =
    (&'a <I as Item>::Extent, &'a Bins<I, AXES, SLICES>);

impl<I: Item, const AXES: usize, const SLICES: usize> Builder<I, AXES, SLICES> {
    fn build(&self, mut items: Vec<I>) -> (Tree, Vec<u32>) {
        let mut nodes = Vec::new();
        if !items.is_empty() {
            let extent = in_halves(&items, &I::extent_of, &|a, b| I::union(&a, &b));
            let bins = in_halves(&items, &|part: &[I]| Bins::of(part, &extent), &Bins::union);
            self.subtree(&mut items, (&extent, &bins), 0, 0, &mut nodes);
        }
        nodes.shrink_to_fit();
        let order = items.par_iter().map(Item::index).collect();
        (Tree { nodes, len: items.len() }, order)
    }

    fn is_leaf(&self, n: usize) -> bool {
        n <= self.leaf_size.max(1)
    }

    fn subtree(
        &self,
        items: &mut [I],
        set: Set<I, AXES, SLICES>,
        first: u32,
        depth: u32,
        nodes: &mut Vec<Node>,
    ) {
        let root = nodes.len();
        nodes.push(Node { bounds: I::bounds(set.0, self.shared).to_aabb(), first, size: 1 });
        if self.is_leaf(items.len()) {
            return;
        }
        let mut bins = [Bins::UNUSED; 2];
        let (n_left, extents) = self.partition(items, set, depth, &mut bins);
        let sets = [(&extents[0], &bins[0]), (&extents[1], &bins[1])];
        self.children(items, n_left, sets, first, depth + 1, nodes);
        nodes[root].size = (nodes.len() - root) as u32;
    }

    /// Moves the items of the left child to the front. Returns their number and the extents of both children, and
    /// leaves their bins in `bins`, unless both are leaves.
    fn partition(
        &self,
        items: &mut [I],
        (extent, own_bins): Set<I, AXES, SLICES>,
        depth: u32,
        bins: &mut [Bins<I, AXES, SLICES>; 2],
    ) -> (usize, [I::Extent; 2]) {
        let cut =
            if depth < MAX_HEURISTIC_DEPTH { own_bins.cheapest_cut(self.shared, self.weight) } else { None };
        let Some(cut) = cut else {
            let n_left = partition_at_median(items, I::centers(extent));
            let (left, right) = items.split_at(n_left);
            let extents = [left, right].map(I::extent_of);
            *bins = [Bins::of(left, &extents[0]), Bins::of(right, &extents[1])];
            return (n_left, extents);
        };
        let (extents, counts) = own_bins.sides(cut);
        let n_left = if counts.into_iter().all(|n| self.is_leaf(n)) {
            own_bins.partition(items, cut)
        } else {
            own_bins.partition_into(items, cut, &extents, bins)
        };
        (n_left, extents)
    }

    fn children(
        &self,
        items: &mut [I],
        n_left: usize,
        sets: [Set<I, AXES, SLICES>; 2],
        first: u32,
        depth: u32,
        nodes: &mut Vec<Node>,
    ) {
        let parallel = items.len() >= PARALLEL_BOXES;
        let (left, right) = items.split_at_mut(n_left);
        let middle = first + n_left as u32;
        if parallel {
            let mut right_nodes = Vec::new();
            rayon::join(
                || self.subtree(left, sets[0], first, depth, nodes),
                || self.subtree(right, sets[1], middle, depth, &mut right_nodes),
            );
            nodes.append(&mut right_nodes);
        } else {
            self.subtree(left, sets[0], first, depth, nodes);
            self.subtree(right, sets[1], middle, depth, nodes);
        }
    }
}

/// `of(items)`, in parallel; `union` must be exact, so that it does not matter where the halves meet.
fn in_halves<I: Item, T: Send>(
    items: &[I],
    of: &(impl Fn(&[I]) -> T + Sync),
    union: &(impl Fn(T, T) -> T + Sync),
) -> T {
    if items.len() <= PASS_BOXES {
        return of(items);
    }
    let (left, right) = items.split_at(items.len() / 2);
    let (left, right) = rayon::join(|| in_halves(left, of, union), || in_halves(right, of, union));
    union(left, right)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::test_sets::{Layout, Radii, spheres};
    use crate::math::Vec3;
    use proptest::prelude::*;

    fn depth(tree: &Tree, node: usize) -> u32 {
        if tree.nodes[node].is_leaf() {
            return 0;
        }
        let (left, right) = tree.children(node);
        1 + depth(tree, left).max(depth(tree, right))
    }

    fn valid(boxes: &[Aabb], leaf_size: usize) -> Tree {
        let (tree, order) = build(boxes, leaf_size);
        tree.check_invariants(|position| boxes[order[position] as usize]).unwrap();
        tree
    }

    #[test]
    fn leaves_hold_at_most_what_is_asked_for() {
        for leaf_size in [0, 1, 4, 12] {
            for n in 0..30 {
                let boxes: Vec<Aabb> =
                    spheres(Layout::Cube, Radii::Mixed, n, 5).iter().map(|s| s.bounds()).collect();
                let tree = valid(&boxes, leaf_size);
                let leaves = (0..tree.nodes.len()).filter(|&k| tree.nodes[k].is_leaf());
                let largest = leaves.map(|k| tree.positions(k).len()).max();
                assert!(largest.is_none_or(|n| n <= leaf_size.max(1)), "{largest:?} > {leaf_size}");
            }
        }
    }

    #[test]
    fn boxes_of_doubling_size_and_distance_do_not_deepen_the_tree_without_bound() {
        let diagonal = |k: i32| Aabb::of_sphere(Vec3::splat(2f32.powi(k)), 0.0);
        let boxes: Vec<Aabb> = (-62..62).map(diagonal).collect();
        let deep = depth(&valid(&boxes, 1), 0);
        assert!(deep > MAX_HEURISTIC_DEPTH, "only {deep} levels: not the case that this test is for");
        assert!(deep <= MAX_HEURISTIC_DEPTH + 4, "{deep} levels");
    }

    #[test]
    fn coplanar_collinear_and_coincident_boxes_make_shallow_trees() {
        for layout in [Layout::Plane, Layout::Line, Layout::Point] {
            for radii in [Radii::Equal(0.0), Radii::Equal(1e-30), Radii::Equal(100.0)] {
                let set = spheres(layout, radii, 50_000, 6);
                let boxes: Vec<Aabb> = set.iter().map(|s| s.bounds()).collect();
                let deep = depth(&valid(&boxes, 4), 0);
                assert!(deep < 32, "{layout:?} {radii:?}: {deep} levels");
            }
        }
    }

    #[test]
    fn the_first_split_parts_two_clusters_whatever_empty_boxes_are_among_them() {
        let near = spheres(Layout::Cube, Radii::Equal(0.1), 200, 7);
        let apart = |k: usize| near[k].center + Vec3::Y * (10 * (k % 2)) as f32;
        let mut boxes: Vec<Aabb> = (0..200).map(|k| Aabb::of_sphere(apart(k), 0.1)).collect();
        boxes.push(Aabb::EMPTY);
        let tree = valid(&boxes, 4);
        let (left, right) = tree.children(0);
        assert!(tree.positions(left).len().abs_diff(100) <= 1);
        assert!(tree.nodes[left].bounds.max.y < tree.nodes[right].bounds.min.y);
    }

    proptest! {
        #[test]
        fn any_boxes_make_a_valid_tree(
            corners in prop::collection::vec(prop::array::uniform6(any::<f32>()), 0..200),
            leaf_size in 1usize..6,
        ) {
            let boxes: Vec<Aabb> = corners
                .iter()
                .map(|c| [Vec3::from_slice(&c[..3]), Vec3::from_slice(&c[3..])])
                .filter(|corners| !corners.iter().any(|c| c.is_nan()))
                .map(Aabb::of_points)
                .collect();
            valid(&boxes, leaf_size);
        }
    }
}
