//! All points against all spheres: the batch descends as lists, so that nodes are read once and in order.

use std::ops::Range;

use super::sphere::{Sphere, squared_distance};
use super::tree::Tree;
use crate::math::{Aabb, Vec3};

/// Most points of one descent: this bounds the scratch memory, and keeps an index's bits those of a number.
const BATCH: usize = 1 << 20;

/// Where spheres times points are fewer, one thread does the rest.
const PARALLEL_PAIRS: usize = 1 << 22;

/// A point and, in the fourth lane, the bits of its index in the batch.
#[derive(Clone, Copy, Debug)]
struct Entry([f32; 4]);

impl Entry {
    const UNUSED: Entry = Entry([0.0; 4]);

    fn new(p: Vec3, index: usize) -> Entry {
        Entry([p.x, p.y, p.z, f32::from_bits(index as u32)])
    }

    fn index(&self) -> usize {
        self.0[3].to_bits() as usize
    }

    fn point(&self) -> Vec3 {
        Vec3::from_slice(&self.0)
    }
}

/// A box whose fourth lane lets every index of the batch pass.
///
/// The bound of the indices comes from outside although infinity would do: given a constant, the compiler takes
/// the lanes apart, and the whole descent loses up to a fifth of its speed.
#[derive(Clone, Copy)]
struct Gate {
    min: [f32; 4],
    max: [f32; 4],
}

impl Gate {
    fn new(bounds: &Aabb, index_bound: f32) -> Gate {
        let (min, max) = (bounds.min, bounds.max);
        Gate { min: [min.x, min.y, min.z, -index_bound], max: [max.x, max.y, max.z, index_bound] }
    }

    fn admits(&self, entry: &Entry) -> bool {
        let inside = |k: usize| (entry.0[k] >= self.min[k]) & (entry.0[k] <= self.max[k]);
        (0..4).map(|k| u32::from(inside(k))).sum::<u32>() == 4
    }

    /// Copies the admitted entries to the front of `out`, which is as long as `list`, and returns their number.
    fn filter(&self, list: &[Entry], out: &mut [Entry]) -> usize {
        let mut n = 0;
        for entry in list {
            out[n] = *entry;
            n += usize::from(self.admits(entry));
        }
        n
    }
}

/// See [`super::SphereBvh::gather`].
pub(super) fn gather<S: Send>(
    tree: &Tree,
    spheres: &[Sphere],
    points: &[Vec3],
    states: &mut [S],
    visit: &(impl Fn(&mut S, usize, usize) + Sync),
) {
    if tree.is_empty() {
        return;
    }
    for (batch, points) in points.chunks(BATCH).enumerate() {
        let visit = |state: &mut S, position, index: usize| visit(state, position, batch * BATCH + index);
        let index_bound = f32::from_bits(points.len() as u32);
        let descent = Descent { tree, spheres, visit: &visit, index_bound };
        let root = descent.gate(0);
        let entries = points.iter().enumerate().map(|(index, &p)| Entry::new(p, index));
        descent.in_parallel(0, entries.filter(|entry| root.admits(entry)).collect(), states);
    }
}

struct Descent<'a, V> {
    tree: &'a Tree,
    spheres: &'a [Sphere],
    visit: &'a V,
    index_bound: f32,
}

impl<V> Descent<'_, V> {
    /// Descends with the points `list`, all inside the box of `node`, whose states are `states`.
    fn in_parallel<S: Send>(&self, node: usize, list: Vec<Entry>, states: &mut [S])
    where
        V: Fn(&mut S, usize, usize) + Sync,
    {
        if self.tree.nodes[node].is_leaf() || states.len() * list.len() < PARALLEL_PAIRS {
            let n = list.len();
            return self.alone(node, 0..n, n, states, &mut { list });
        }
        let (left, right) = self.tree.children(node);
        let (left_states, right_states) = self.split_states(node, right, states);
        rayon::join(
            || self.in_parallel(left, self.sublist(&list, left), left_states),
            || self.in_parallel(right, self.sublist(&list, right), right_states),
        );
    }

    /// The same on one thread: the list is a range of `scratch`, of which everything from `top` on is free.
    fn alone<S>(
        &self,
        node: usize,
        list: Range<usize>,
        top: usize,
        states: &mut [S],
        scratch: &mut Vec<Entry>,
    ) where
        V: Fn(&mut S, usize, usize),
    {
        if list.is_empty() {
            return;
        }
        if self.tree.nodes[node].is_leaf() {
            let (list, inside, _) = list_and_room(&list, top, scratch);
            return self.leaf(node, list, inside, states);
        }
        let (left, right) = self.tree.children(node);
        let (left_list, right_list) = self.sublists([left, right], &list, top, scratch);
        let (left_states, right_states) = self.split_states(node, right, states);
        let top = top.max(left_list.end).max(right_list.end);
        self.alone(left, left_list, top, left_states, scratch);
        self.alone(right, right_list, top, right_states, scratch);
    }

    fn gate(&self, node: usize) -> Gate {
        Gate::new(&self.tree.nodes[node].bounds, self.index_bound)
    }

    fn sublist(&self, list: &[Entry], node: usize) -> Vec<Entry> {
        let mut out = vec![Entry::UNUSED; list.len()];
        let n = self.gate(node).filter(list, &mut out);
        out.truncate(n);
        out
    }

    /// The points of `list` inside each child: new lists above `top`, or `list` itself where all are inside.
    fn sublists(
        &self,
        children: [usize; 2],
        list: &Range<usize>,
        top: usize,
        scratch: &mut Vec<Entry>,
    ) -> (Range<usize>, Range<usize>) {
        let n = list.len();
        let (points, left_out, right_out) = list_and_room(list, top, scratch);
        let [left_gate, right_gate] = children.map(|child| self.gate(child));
        let (mut n_left, mut n_right) = (0, 0);
        for entry in points {
            left_out[n_left] = *entry;
            right_out[n_right] = *entry;
            n_left += usize::from(left_gate.admits(entry));
            n_right += usize::from(right_gate.admits(entry));
        }
        let shared = |out: Range<usize>| if out.len() == n { list.clone() } else { out };
        (shared(top..top + n_left), shared(top + n..top + n + n_right))
    }

    fn split_states<'s, S>(
        &self,
        node: usize,
        right: usize,
        states: &'s mut [S],
    ) -> (&'s mut [S], &'s mut [S]) {
        let nodes = &self.tree.nodes;
        states.split_at_mut((nodes[right].first - nodes[node].first) as usize)
    }

    /// Finds the points inside a sphere without a branch, then visits them: whether a point is inside cannot be
    /// predicted, how many are inside nearly can.
    fn leaf<S>(&self, node: usize, list: &[Entry], inside: &mut [Entry], states: &mut [S])
    where
        V: Fn(&mut S, usize, usize),
    {
        for (state, position) in states.iter_mut().zip(self.tree.positions(node)) {
            let sphere = &self.spheres[position];
            let squared_radius = sphere.squared_radius();
            let mut n = 0;
            for entry in list {
                inside[n] = *entry;
                n += usize::from(squared_distance(sphere.center, entry.point()) <= squared_radius);
            }
            inside[..n].iter().for_each(|entry| (self.visit)(state, position, entry.index()));
        }
    }
}

/// `list` and twice as many free entries from `top` on.
fn list_and_room<'s>(
    list: &Range<usize>,
    top: usize,
    scratch: &'s mut Vec<Entry>,
) -> (&'s [Entry], &'s mut [Entry], &'s mut [Entry]) {
    let n = list.len();
    if scratch.len() < top + 2 * n {
        scratch.resize(top + 2 * n, Entry::UNUSED);
    }
    let (below, above) = scratch.split_at_mut(top);
    let (first, second) = above[..2 * n].split_at_mut(n);
    (&below[list.clone()], first, second)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::SphereBvh;
    use crate::bvh::test_sets::{Layout, Radii, on_threads, points_around, sphere_set, spheres};
    use proptest::prelude::*;

    type Visits = Vec<Vec<(usize, usize)>>;

    fn gathered(bvh: &SphereBvh, points: &[Vec3]) -> Visits {
        let mut visits = vec![Vec::new(); bvh.len()];
        bvh.gather(points, &mut visits, |list, position, point| list.push((position, point)));
        visits
    }

    fn naive(spheres: &[Sphere], order: &[u32], points: &[Vec3]) -> Visits {
        let sphere = |position: usize| spheres[order[position] as usize];
        let inside = |position, point: &usize| sphere(position).contains(points[*point]);
        let points_of = |k| (0..points.len()).filter(|p| inside(k, p)).map(|p| (k, p)).collect();
        (0..spheres.len()).map(points_of).collect()
    }

    fn assert_matches_naive(spheres: &[Sphere], points: &[Vec3]) {
        let (bvh, order) = SphereBvh::build(spheres);
        assert_eq!(gathered(&bvh, points), naive(spheres, &order, points));
    }

    proptest! {
        #[test]
        fn gathers_what_the_naive_loops_gather(input in sphere_set(), n in 0usize..300, seed: u64) {
            assert_matches_naive(&input, &points_around(&input, n, seed));
        }
    }

    #[test]
    fn shared_subtrees_gather_what_the_naive_loops_gather() {
        for radii in [Radii::Mixed, Radii::Equal(0.02)] {
            let input = spheres(Layout::Cube, radii, 5000, 1);
            let points = points_around(&input, 4000, 2);
            assert!(points.len() * input.len() > 4 * PARALLEL_PAIRS);
            assert_matches_naive(&input, &points);
        }
    }

    #[test]
    fn covering_spheres_see_every_point() {
        let input = spheres(Layout::Point, Radii::Equal(100.0), 300, 3);
        let points = points_around(&spheres(Layout::Cube, Radii::Equal(0.5), 50, 4), 500, 5);
        let real = points.iter().filter(|p| !p.is_nan()).count();
        let visits = gathered(&SphereBvh::build(&input).0, &points);
        assert!(visits.iter().all(|list| list.len() == real));
    }

    #[test]
    fn a_single_leaf_takes_any_number_of_points() {
        let input = spheres(Layout::Point, Radii::Equal(0.5), 5, 9);
        let points = vec![input[0].center; BATCH];
        let mut counts = [0; 5];
        SphereBvh::build(&input).0.gather(&points, &mut counts, |count, _, _| *count += 1);
        assert_eq!(counts, [BATCH; 5]);
    }

    #[test]
    fn nan_points_are_nowhere() {
        let input = spheres(Layout::Cube, Radii::Equal(f32::INFINITY), 30, 6);
        let nan = f32::NAN;
        let points = [Vec3::NAN, Vec3::X * nan, Vec3::new(0.0, nan, 0.0), Vec3::new(0.0, 0.0, nan)];
        assert!(gathered(&SphereBvh::build(&input).0, &points).iter().all(Vec::is_empty));
    }

    #[test]
    fn indices_go_on_over_the_batches() {
        let input = [Sphere { center: Vec3::ZERO, radius: 1.0 }];
        let mut points = vec![Vec3::ONE; BATCH + 3];
        points[BATCH - 1] = Vec3::ZERO;
        points[BATCH + 1] = Vec3::ZERO;
        let visits = gathered(&SphereBvh::build(&input).0, &points);
        assert_eq!(visits, [[(0, BATCH - 1), (0, BATCH + 1)]]);
    }

    #[test]
    fn sums_have_the_same_bits_on_any_number_of_threads() {
        let input = spheres(Layout::Plane, Radii::Equal(0.02), 30_000, 7);
        let points = points_around(&input, 20_000, 8);
        let (bvh, _) = SphereBvh::build(&input);
        let sums = |threads| {
            let mut sums = vec![(0f32, 0usize); input.len()];
            let add = |sum: &mut (f32, usize), _, point: usize| {
                assert!(sum.1 <= point, "points came in decreasing order");
                *sum = (sum.0 + points[point].x * 1e3, point);
            };
            on_threads(threads, || bvh.gather(&points, &mut sums, add));
            sums.into_iter().map(|sum| sum.0.to_bits()).collect::<Vec<u32>>()
        };
        let one = sums(1);
        assert!(one.iter().any(|&bits| bits != 0));
        assert!(one == sums(2) && one == sums(7));
    }

    #[test]
    #[should_panic(expected = "one state for each sphere")]
    fn a_state_too_few_is_refused() {
        let (bvh, _) = SphereBvh::build(&[Sphere { center: Vec3::ZERO, radius: 1.0 }]);
        bvh.gather(&[Vec3::ZERO], &mut [], |_: &mut (), _, _| ());
    }
}
