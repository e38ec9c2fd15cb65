//! All points against all spheres: the points descend as lists, so that nodes are read once and in order.

use std::ops::Range;

use super::gatherer::{Gatherer, Leaf, Radii};
use super::list_pool::ListPool;
use super::part::Part;
use super::point_lists::{PointLists, Points};
use crate::math::Vec3;
use crate::simd::{Isa, Kernel, Lanes};

/// A list no longer than this is one task's: what belongs to its points then fits into a core's own cache.
const TASK_POINTS: usize = 1 << 13;

/// As is one with fewer spheres times points.
const TASK_PAIRS: usize = 1 << 22;

/// See [`super::SphereBvh::gather_with`]; `part` is a whole tree, `centers` are those of its spheres.
pub(super) fn gather<G: Gatherer>(
    (part, centers): (Part<G::State>, [&[f32]; 3]),
    pool: &ListPool,
    isa: Isa,
    points: &[&[Vec3]],
    gatherer: &G,
) -> G::Tally {
    let mut list = pool.take(points.iter().map(|points| points.len()).sum());
    list.fill(points);
    Descent { gatherer, isa, centers, pool }.in_parallel(part, list).tally
}

struct Descent<'a, G> {
    gatherer: &'a G,
    isa: Isa,
    centers: [&'a [f32]; 3],
    pool: &'a ListPool,
}

/// What comes back from a subtree.
struct Outcome<T> {
    tally: T,
    radii: Radii,
}

impl<G: Gatherer> Descent<'_, G> {
    /// Descends with the points of `list`: all that are inside the box of the part's root, and maybe others.
    fn in_parallel(&self, mut part: Part<G::State>, list: PointLists) -> Outcome<G::Tally> {
        let n = list.len();
        let small = n <= TASK_POINTS || part.states.len() * n <= TASK_PAIRS;
        if part.nodes[0].is_leaf() || small {
            return self.task(&mut part, list);
        }
        let (left, right) = part.children();
        let sublist = |child: &Part<_>| {
            let mut inside = self.pool.take(n);
            inside.fill_inside(&list, &child.nodes[0].bounds, self.isa);
            inside
        };
        let (left, right) = rayon::join(
            || {
                let list = sublist(&left);
                self.in_parallel(left, list)
            },
            || {
                let list = sublist(&right);
                self.in_parallel(right, list)
            },
        );
        self.pool.give_back(list);
        let radii = part.follow_children([left.radii, right.radii]);
        Outcome { tally: left.tally + right.tally, radii }
    }

    fn task(&self, part: &mut Part<G::State>, mut lists: PointLists) -> Outcome<G::Tally> {
        let n = lists.len();
        let mut task = self.gatherer.begin(lists.renumber());
        let radii = self.alone(part, 0..n, n, &mut lists, &mut task);
        self.pool.give_back(lists);
        Outcome { tally: self.gatherer.end(task), radii }
    }

    /// Descends with one of the lists; everything from `top` on is free.
    fn alone(
        &self,
        part: &mut Part<G::State>,
        list: Range<usize>,
        top: usize,
        lists: &mut PointLists,
        task: &mut G::Task,
    ) -> Radii {
        if list.is_empty() {
            return Radii::Kept;
        }
        if part.nodes[0].is_leaf() {
            let radii = self.leaf(part, lists.get(list), task);
            return part.follow_spheres(self.centers, radii);
        }
        let (mut left, mut right) = part.children();
        let boxes = [left.nodes[0].bounds, right.nodes[0].bounds];
        let [left_list, right_list] = lists.split(&list, top, boxes, |split| self.isa.run(split));
        let top = top.max(left_list.end).max(right_list.end);
        let left = self.alone(&mut left, left_list, top, lists, task);
        let right = self.alone(&mut right, right_list, top, lists, task);
        part.follow_children([left, right])
    }

    fn leaf(&self, part: &mut Part<G::State>, points: Points, task: &mut G::Task) -> Radii {
        let first = part.nodes[0].first as usize;
        let positions = first..first + part.radii.len();
        let leaf = Leaf {
            first,
            centers: self.centers.map(|column| &column[positions.clone()]),
            radii: part.radii,
            states: part.states,
            points,
        };
        self.isa.run(Meet { gatherer: self.gatherer, task, leaf })
    }
}

struct Meet<'a, G: Gatherer> {
    gatherer: &'a G,
    task: &'a mut G::Task,
    leaf: Leaf<'a, G::State>,
}

impl<G: Gatherer> Kernel for Meet<'_, G> {
    type Output = Radii;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Radii {
        self.gatherer.meet(lanes, self.task, self.leaf)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::test_sets::{Layout, Radii, on_threads, points_around, sphere_set, spheres};
    use crate::bvh::{EachMeeting, Sphere, SphereBvh};
    use crate::math::{Rng, Stream};
    use proptest::prelude::*;

    type Visits = Vec<Vec<(usize, usize)>>;

    /// Of several lengths, one of them 0.
    fn in_slices(points: &[Vec3]) -> [&[Vec3]; 4] {
        let (first, rest) = points.split_at(points.len() / 3);
        let (second, last) = rest.split_at(rest.len().min(17));
        [first, &[], second, last]
    }

    fn gathered_with(isa: Isa, bvh: &mut SphereBvh, points: &[Vec3]) -> Visits {
        let mut visits = vec![Vec::new(); bvh.len()];
        let visit = |list: &mut Vec<_>, position, point| list.push((position, point));
        bvh.gather_with(isa, &in_slices(points), &mut visits, &EachMeeting::new(visit));
        visits
    }

    fn gathered(bvh: &mut SphereBvh, points: &[Vec3]) -> Visits {
        gathered_with(Isa::best(), bvh, points)
    }

    fn naive(spheres: &[Sphere], order: &[u32], points: &[Vec3]) -> Visits {
        let sphere = |position: usize| spheres[order[position] as usize];
        let inside = |position, point: &usize| sphere(position).contains(points[*point]);
        let points_of = |k| (0..points.len()).filter(|p| inside(k, p)).map(|p| (k, p)).collect();
        (0..spheres.len()).map(points_of).collect()
    }

    fn assert_matches_naive(spheres: &[Sphere], points: &[Vec3]) {
        let (mut bvh, order) = SphereBvh::build(spheres);
        let expected = naive(spheres, &order, points);
        for isa in Isa::available() {
            assert!(gathered_with(isa, &mut bvh, points) == expected, "{isa}");
        }
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
            assert!(points.len() * input.len() > 4 * TASK_PAIRS);
            assert_matches_naive(&input, &points);
        }
    }

    #[test]
    fn covering_spheres_see_every_point() {
        let input = spheres(Layout::Point, Radii::Equal(100.0), 300, 3);
        let points = points_around(&spheres(Layout::Cube, Radii::Equal(0.5), 50, 4), 500, 5);
        let real = points.iter().filter(|p| !p.is_nan()).count();
        let visits = gathered(&mut SphereBvh::build(&input).0, &points);
        assert!(visits.iter().all(|list| list.len() == real));
    }

    #[test]
    fn a_single_leaf_takes_any_number_of_points() {
        let input = spheres(Layout::Point, Radii::Equal(0.5), 5, 9);
        let points = vec![input[0].center; 1 << 20];
        let mut counts = [0; 5];
        SphereBvh::build(&input).0.gather(&points, &mut counts, |count, _, _| *count += 1);
        assert_eq!(counts, [1 << 20; 5]);
    }

    #[test]
    fn nan_points_are_nowhere() {
        let input = spheres(Layout::Cube, Radii::Equal(f32::INFINITY), 30, 6);
        let nan = f32::NAN;
        let points = [Vec3::NAN, Vec3::X * nan, Vec3::new(0.0, nan, 0.0), Vec3::new(0.0, 0.0, nan)];
        assert!(gathered(&mut SphereBvh::build(&input).0, &points).iter().all(Vec::is_empty));
    }

    #[test]
    fn sums_have_the_same_bits_on_any_number_of_threads() {
        let input = spheres(Layout::Plane, Radii::Equal(0.02), 30_000, 7);
        let points = points_around(&input, 20_000, 8);
        let (mut bvh, _) = SphereBvh::build(&input);
        let mut sums = |threads| {
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

    /// Halves every radius that a point was found in.
    struct Halve;

    impl Gatherer for Halve {
        type State = ();
        type Task = ();
        type Tally = u64;

        fn begin(&self, _: Vec<u32>) {}

        #[inline(always)]
        fn meet<L: Lanes>(&self, lanes: L, _: &mut (), leaf: Leaf<()>) -> super::Radii {
            let balls = leaf.balls(lanes);
            let met = leaf.points.iter().fold(0, |met, (p, _)| met | balls.around(lanes, p));
            for (_, radius) in leaf.radii.iter_mut().enumerate().filter(|(lane, _)| met >> lane & 1 == 1) {
                *radius *= 0.5;
            }
            if met == 0 { super::Radii::Kept } else { super::Radii::Changed }
        }

        fn end(&self, (): ()) -> u64 {
            0
        }
    }

    /// The walk must leave the tree as tight as refitting it would.
    #[test]
    fn boxes_follow_the_radii() {
        for (layout, n) in [(Layout::Plane, 30_000), (Layout::Clusters, 400), (Layout::Point, 7)] {
            let input = spheres(layout, Radii::Equal(0.02), n, 3);
            let points = points_around(&input, 2000, 4);
            let (mut bvh, _) = SphereBvh::build(&input);
            bvh.gather_with(Isa::best(), &[&points], &mut vec![(); n], &Halve);
            bvh.check_invariants().unwrap();
            let halved = bvh.radii().iter().filter(|&&radius| radius == 0.01).count();
            assert!(halved > 0, "{layout:?}");
            let mut refitted = bvh.clone();
            let radii = bvh.radii().to_vec();
            refitted.refit(|position| radii[position]);
            assert!(refitted.nodes() == bvh.nodes(), "{layout:?}");
        }
    }

    /// Counts the points of all lists that reach a leaf: the work of a walk, without its noise.
    struct CountWork;

    impl Gatherer for CountWork {
        type State = ();
        type Task = u64;
        type Tally = u64;

        fn begin(&self, _: Vec<u32>) -> u64 {
            0
        }

        #[inline(always)]
        fn meet<L: Lanes>(&self, _: L, work: &mut u64, leaf: Leaf<()>) -> super::Radii {
            *work += leaf.points.len() as u64;
            super::Radii::Kept
        }

        fn end(&self, work: u64) -> u64 {
            work
        }
    }

    /// The criterion for building anew: building takes as long as a dozen gatherings, so a render's tree is to be kept
    /// while a walk through it costs less than a fifth more than through a new one. That it does, whether all radii
    /// shrink alike or half of them stay behind: renders keep their tree.
    #[test]
    fn refitted_trees_stay_as_good_as_new_ones() {
        let work = |mut bvh: SphereBvh, points: &[Vec3]| {
            bvh.gather_with(Isa::best(), &[points], &mut vec![(); bvh.len()], &CountWork) as f64
        };
        for (layout, shrink, staying) in [
            (Layout::Plane, 0.3, 0.0),
            (Layout::Plane, 0.03, 0.0),
            (Layout::Plane, 0.3, 0.5),
            (Layout::Plane, 0.03, 0.5),
            (Layout::Cube, 0.1, 0.0),
            (Layout::Clusters, 0.1, 0.5),
        ] {
            let input = spheres(layout, Radii::Equal(0.02), 40_000, 1);
            let points = points_around(&input, 10_000, 2);
            let shrunken = |index: usize| {
                let stays = Rng::new(3, Stream::Test, 0, index as u64).next_f32() < staying;
                Sphere { radius: if stays { 0.02 } else { 0.02 * shrink }, ..input[index] }
            };
            let (mut refitted, order) = SphereBvh::build(&input);
            refitted.refit(|position| shrunken(order[position] as usize).radius);
            let (rebuilt, _) = SphereBvh::build(&(0..input.len()).map(shrunken).collect::<Vec<_>>());
            let ratio = work(refitted, &points) / work(rebuilt, &points);
            println!("{layout:?}, {shrink} of the radius, {staying} staying: {ratio:.3}");
            assert!(ratio < 1.2, "{layout:?}, {shrink}, {staying}: {ratio}");
        }
    }

    #[test]
    #[should_panic(expected = "one state for each sphere")]
    fn a_state_too_few_is_refused() {
        let (mut bvh, _) = SphereBvh::build(&[Sphere { center: Vec3::ZERO, radius: 1.0 }]);
        bvh.gather(&[Vec3::ZERO], &mut [], |_: &mut (), _, _| ());
    }
}
