//! Where to cut a set of boxes in two: binned surface area heuristic, and the median where that knows no answer.

use super::items::{Item, WideBox};

/// What a query's chance to visit a box is taken to be proportional to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weight {
    /// The surface area, the measure of the lines that meet the box.
    Area,
    /// The volume, the measure of the points inside.
    Volume,
}

impl Weight {
    fn of(self, bounds: &WideBox) -> f32 {
        match self {
            Weight::Area => bounds.surface_area(),
            Weight::Volume => (0..3).map(|axis| bounds.extent(axis).max(0.0)).product(),
        }
    }

    /// The work that a split leaves to do, up to a factor and a constant that all splits of one node share: a query
    /// visits a child with a probability proportional to its weight, and then tests its boxes.
    ///
    /// # Source
    /// MacDonald and Booth, "Heuristics for Ray Tracing Using Space Subdivision", The Visual Computer 6(3), 1990.
    fn split_cost(self, left: &WideBox, n_left: u32, right: &WideBox, n_right: u32) -> f32 {
        self.of(left) * n_left as f32 + self.of(right) * n_right as f32
    }
}

/// Maps centres to equal slices of their box, along its `AXES` longest axes.
#[derive(Clone, Copy, Debug)]
struct Slicer<const AXES: usize, const SLICES: usize> {
    axes: [usize; AXES],
    origin: [f32; AXES],
    scale: [f32; AXES],
}

impl<const AXES: usize, const SLICES: usize> Slicer<AXES, SLICES> {
    fn new(centers: &WideBox) -> Slicer<AXES, SLICES> {
        let mut axes = [0, 1, 2];
        axes.sort_by(|&a, &b| centers.extent(b).total_cmp(&centers.extent(a)));
        let axes = std::array::from_fn(|row| axes[row]);
        Slicer {
            axes,
            origin: axes.map(|axis| centers.min()[axis]),
            scale: axes.map(|axis| SLICES as f32 / centers.extent(axis)),
        }
    }

    /// The slice of an item along axis number `row`; 0 where the centres have no extent or it is not a number.
    ///
    /// Adding 2²³ leaves no bits for fractions: that rounds to the integer in the lowest bits, in fewer
    /// instructions than a conversion that has to be right for all numbers.
    #[inline(always)]
    fn slice(&self, item: &impl Item, row: usize) -> usize {
        const INTEGERS: f32 = (1u32 << 23) as f32;
        let last = (SLICES - 1) as f32;
        let offset = (item.center(self.axes[row]) - self.origin[row]) * self.scale[row] - 0.5;
        let offset = if offset > 0.0 { offset } else { 0.0 };
        let offset = if offset < last { offset } else { last };
        (offset + INTEGERS).to_bits() as usize % SLICES
    }
}

#[derive(Clone, Copy)]
struct Bin<I: Item> {
    extent: I::Extent,
    count: u32,
}

impl<I: Item> Bin<I> {
    const EMPTY: Bin<I> = Bin { extent: I::NOTHING, count: 0 };

    fn union(&self, other: &Bin<I>) -> Bin<I> {
        Bin { extent: I::union(&self.extent, &other.extent), count: self.count + other.count }
    }
}

/// A set of items, sorted by centre into equal slices of the centres' box, along its `AXES` longest axes.
pub(super) struct Bins<I: Item, const AXES: usize, const SLICES: usize> {
    slicer: Slicer<AXES, SLICES>,
    rows: [[Bin<I>; SLICES]; AXES],
}

impl<I: Item, const AXES: usize, const SLICES: usize> Bins<I, AXES, SLICES> {
    /// Bins of no set, to be filled by [`Bins::partition_into`].
    pub(super) const UNUSED: Self = Bins {
        slicer: Slicer { axes: [0; AXES], origin: [0.0; AXES], scale: [0.0; AXES] },
        rows: [[Bin::EMPTY; SLICES]; AXES],
    };

    /// The bins of items whose extent is part of `extent`, which says where the slices are.
    pub(super) fn of(items: &[I], extent: &I::Extent) -> Self {
        let mut bins = Bins::UNUSED;
        bins.restart(extent);
        items.iter().for_each(|item| bins.add(item));
        bins
    }

    fn restart(&mut self, extent: &I::Extent) {
        self.slicer = Slicer::new(I::centers(extent));
        self.rows.as_flattened_mut().fill(Bin::EMPTY);
    }

    #[inline(always)]
    fn add(&mut self, item: &I) {
        for (row, bins) in self.rows.iter_mut().enumerate() {
            let bin = &mut bins[self.slicer.slice(item, row)];
            bin.extent = item.join(&bin.extent);
            bin.count += 1;
        }
    }

    /// All items of two sets with the same slices.
    pub(super) fn union(mut self, other: Self) -> Self {
        for (mine, theirs) in self.rows.as_flattened_mut().iter_mut().zip(other.rows.as_flattened()) {
            *mine = mine.union(theirs);
        }
        self
    }

    /// The cheapest cut with items on both sides; `None` where all share one slice or no cost is finite.
    pub(super) fn cheapest_cut(&self, shared: I::Shared, weight: Weight) -> Option<Cut> {
        (0..AXES)
            .flat_map(|row| self.cuts_along(row, shared, weight))
            .filter(|(price, _)| price.0 < f32::INFINITY)
            .min_by(|(a, _), (b, _)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
            .map(|(_, cut)| cut)
    }

    fn cuts_along(
        &self,
        row: usize,
        shared: I::Shared,
        weight: Weight,
    ) -> impl Iterator<Item = ((f32, u32), Cut)> {
        let bins = self.rows[row].map(|bin| (I::bounds(&bin.extent, shared), bin.count));
        let mut above = [(WideBox::EMPTY, 0); SLICES];
        for k in (1..SLICES).rev() {
            above[k - 1] = (above[k].0.union(&bins[k].0), above[k].1 + bins[k].1);
        }
        let mut below = (WideBox::EMPTY, 0);
        (0..SLICES - 1).filter_map(move |last| {
            below = (below.0.union(&bins[last].0), below.1 + bins[last].1);
            let rest = &above[last];
            let cost = weight.split_cost(&below.0, below.1, &rest.0, rest.1);
            let balance = below.1.abs_diff(rest.1);
            (below.1 > 0 && rest.1 > 0).then_some(((cost, balance), Cut { row, last }))
        })
    }

    /// The extents and the numbers of the items left and right of a cut.
    pub(super) fn sides(&self, cut: Cut) -> ([I::Extent; 2], [usize; 2]) {
        let (left, right) = self.rows[cut.row].split_at(cut.last + 1);
        let sides =
            [left, right].map(|bins| bins.iter().fold(Bin::EMPTY, |all, bin: &Bin<I>| all.union(bin)));
        (sides.map(|side| side.extent), sides.map(|side| side.count as usize))
    }

    /// Moves the items left of the cut to the front, and returns their number.
    pub(super) fn partition(&self, items: &mut [I], cut: Cut) -> usize {
        self.partition_and(items, cut, |_, _| ())
    }

    /// The same, and fills `bins` with both sides, whose extents are `sides`: this way every level of the tree is
    /// one pass over the items.
    pub(super) fn partition_into(
        &self,
        items: &mut [I],
        cut: Cut,
        sides: &[I::Extent; 2],
        bins: &mut [Self; 2],
    ) -> usize {
        for (bins, side) in bins.iter_mut().zip(sides) {
            bins.restart(side);
        }
        self.partition_and(items, cut, |side, item| bins[side].add(item))
    }

    #[inline(always)]
    fn partition_and(&self, items: &mut [I], cut: Cut, mut then: impl FnMut(usize, &I)) -> usize {
        let (slicer, mut n_left) = (self.slicer, 0);
        for k in 0..items.len() {
            let goes_right = slicer.slice(&items[k], cut.row) > cut.last;
            then(usize::from(goes_right), &items[k]);
            items.swap(k, n_left);
            n_left += usize::from(!goes_right);
        }
        n_left
    }
}

/// Everything up to slice `last` along axis number `row` goes left.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cut {
    row: usize,
    last: usize,
}

/// Halves the items by centre along the longest axis of `centers`, the centres' box.
pub(super) fn partition_at_median(items: &mut [impl Item], centers: &WideBox) -> usize {
    let longest = |a: &usize, b: &usize| centers.extent(*a).total_cmp(&centers.extent(*b));
    let axis = (0..3).max_by(longest).unwrap_or(0);
    let middle = items.len() / 2;
    items.select_nth_unstable_by(middle, |a, b| a.center(axis).total_cmp(&b.center(axis)));
    middle
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::items::{BoxItem, CubeItem};
    use crate::bvh::test_sets::{Layout, Radii, spheres};
    use crate::math::Aabb;
    use proptest::prelude::*;

    fn boxes(boxes: impl IntoIterator<Item = Aabb>) -> Vec<BoxItem> {
        boxes.into_iter().zip(0..).map(|(b, index)| BoxItem::new(&b, index)).collect()
    }

    fn seen<I: Item>(extent: &I::Extent, shared: I::Shared) -> [Aabb; 2] {
        [I::bounds(extent, shared), *I::centers(extent)].map(WideBox::to_aabb)
    }

    fn check_partition<I: Item, const AXES: usize, const SLICES: usize>(mut set: Vec<I>, shared: I::Shared) {
        let extent = I::extent_of(&set);
        let bins = Bins::<I, AXES, SLICES>::of(&set, &extent);
        let Some(cut) = bins.cheapest_cut(shared, Weight::Area) else { return };
        let (sides, counts) = bins.sides(cut);
        let mut filled = [Bins::UNUSED; 2];
        let n_left = bins.partition_into(&mut set, cut, &sides, &mut filled);
        let (left, right) = set.split_at(n_left);
        assert_eq!([left.len(), right.len()], counts);
        for (side, (part, filled)) in [left, right].into_iter().zip(&filled).enumerate() {
            let naive = I::extent_of(part);
            assert_eq!(seen::<I>(&sides[side], shared), seen::<I>(&naive, shared));
            let naive = Bins::<I, AXES, SLICES>::of(part, &naive);
            for (bin, naive) in filled.rows.as_flattened().iter().zip(naive.rows.as_flattened()) {
                assert_eq!(bin.count, naive.count);
                assert_eq!(seen::<I>(&bin.extent, shared), seen::<I>(&naive.extent, shared));
            }
        }
        let mut indices: Vec<u32> = set.iter().map(Item::index).collect();
        indices.sort();
        assert!(indices.into_iter().eq(0..set.len() as u32));
    }

    proptest! {
        /// What the pass over a node leaves behind is what passes over its children would find.
        #[test]
        fn partitions_leave_the_bins_of_both_sides(n in 2usize..200, seed: u64, mixed: bool) {
            let radii = if mixed { Radii::Mixed } else { Radii::Equal(0.1) };
            for layout in [Layout::Cube, Layout::Clusters, Layout::Plane, Layout::Line] {
                let set = spheres(layout, radii, n, seed);
                check_partition::<_, 3, 16>(boxes(set.iter().map(|s| s.bounds())), ());
                let cubes = set.iter().zip(0..).map(|(s, index)| CubeItem::new(s.center, index));
                check_partition::<_, 1, 8>(cubes.collect(), 0.1);
            }
        }
    }

    #[test]
    fn slices_are_equal_and_take_every_number() {
        let line = boxes([0.0, 16.0].map(|x| Aabb::of_sphere([x, 0.5 * x, 0.25 * x].into(), 0.0)));
        let slicer = Slicer::<2, 8>::new(BoxItem::centers(&BoxItem::extent_of(&line)));
        let slice = |x: f32, row| slicer.slice(&boxes([Aabb::of_sphere([x; 3].into(), 0.0)])[0], row);
        let inner = [0.5, 1.5, 2.5, 5.0, 9.0, 13.9, 15.9].map(|x| slice(x, 0));
        assert_eq!(inner, [0, 0, 1, 2, 4, 6, 7]);
        assert_eq!([0.5, 1.5, 2.5, 5.1, 7.9].map(|x| slice(x, 1)), [0, 1, 2, 5, 7]);
        assert_eq!([-1e30, f32::NEG_INFINITY, f32::NAN].map(|x| slice(x, 0)), [0; 3]);
        assert_eq!([16.0, 1e30, f32::INFINITY].map(|x| slice(x, 0)), [7; 3]);
    }

    /// Two flat boxes have no volume, but area; and of two others the one may be larger by area, the other by volume.
    #[test]
    fn weights_are_areas_and_volumes() {
        let boxed = |x: f32, y: f32, z: f32| WideBox::EMPTY.with_point([0.0; 4]).with_point([x, y, z, 0.0]);
        assert_eq!(Weight::Volume.of(&boxed(2.0, 3.0, 4.0)), 24.0);
        assert_eq!(Weight::Area.of(&boxed(2.0, 3.0, 4.0)), 52.0);
        assert_eq!(Weight::Volume.of(&boxed(2.0, 0.0, 4.0)), 0.0);
        assert_eq!(Weight::Volume.of(&WideBox::EMPTY), 0.0);
        assert_eq!(Weight::Volume.split_cost(&boxed(1.0, 1.0, 2.0), 3, &boxed(1.0, 1.0, 1.0), 5), 11.0);
    }
}
