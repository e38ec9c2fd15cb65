//! Where to cut a set of boxes in two: binned surface area heuristic, and the median where that knows no answer.

use super::items::{Extent, Item, WideBox};
use crate::math::Aabb;

const BINS: usize = 16;

/// The work that a split leaves to do, up to a factor and a constant that all splits of one node share.
///
/// A query visits a child with a probability proportional to the child's weight, and then tests its boxes. The
/// weight is the surface area, the measure of the lines that meet the box.
///
/// # Source
/// MacDonald and Booth, "Heuristics for Ray Tracing Using Space Subdivision", The Visual Computer 6(3), 1990.
fn split_cost(left: &Aabb, n_left: u32, right: &Aabb, n_right: u32) -> f32 {
    left.surface_area() * n_left as f32 + right.surface_area() * n_right as f32
}

#[derive(Clone, Copy, Debug)]
struct Bin {
    bounds: WideBox,
    count: u32,
}

impl Bin {
    const EMPTY: Bin = Bin { bounds: WideBox::EMPTY, count: 0 };

    fn union(&self, other: &Bin) -> Bin {
        Bin { bounds: self.bounds.union(&other.bounds), count: self.count + other.count }
    }
}

/// Items sorted by centre into equal slices of the centres' box, along each axis.
#[derive(Clone, Debug)]
pub(super) struct Bins([[Bin; BINS]; 3]);

impl Bins {
    pub(super) fn of(items: &[Item], slicer: &Slicer) -> Bins {
        let mut bins = [[Bin::EMPTY; BINS]; 3];
        for item in items {
            for (axis, row) in bins.iter_mut().enumerate() {
                let bin = &mut row[slicer.slice(item, axis)];
                bin.bounds = bin.bounds.union(item.bounds());
                bin.count += 1;
            }
        }
        Bins(bins)
    }

    pub(super) fn union(mut self, other: Bins) -> Bins {
        for (mine, theirs) in self.0.as_flattened_mut().iter_mut().zip(other.0.as_flattened()) {
            *mine = mine.union(theirs);
        }
        self
    }

    /// The cheapest cut with items on both sides; `None` where all share one slice or no cost is finite.
    pub(super) fn cheapest_cut(&self) -> Option<Cut> {
        (0..3)
            .flat_map(|axis| self.cuts_along(axis))
            .filter(|(price, _)| price.0 < f32::INFINITY)
            .min_by(|(a, _), (b, _)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
            .map(|(_, cut)| cut)
    }

    fn cuts_along(&self, axis: usize) -> impl Iterator<Item = ((f32, u32), Cut)> {
        let row = &self.0[axis];
        let mut above = [Bin::EMPTY; BINS];
        for k in (1..BINS).rev() {
            above[k - 1] = above[k].union(&row[k]);
        }
        let mut below = Bin::EMPTY;
        (0..BINS - 1).filter_map(move |last| {
            below = below.union(&row[last]);
            let rest = &above[last];
            let cost = split_cost(&below.bounds.to_aabb(), below.count, &rest.bounds.to_aabb(), rest.count);
            let balance = below.count.abs_diff(rest.count);
            (below.count > 0 && rest.count > 0).then_some(((cost, balance), Cut { axis, last }))
        })
    }
}

/// Everything up to slice `last` along `axis` goes left.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cut {
    axis: usize,
    last: usize,
}

/// Maps centres to slices.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slicer {
    origin: [f32; 4],
    scale: [f32; 3],
}

impl Slicer {
    pub(super) fn new(extent: &Extent) -> Slicer {
        let scale = std::array::from_fn(|axis| BINS as f32 / extent.centers.extent(axis));
        Slicer { origin: extent.centers.min(), scale }
    }

    /// The slice of an item; 0 where the centres have no extent or it is not a number.
    fn slice(&self, item: &Item, axis: usize) -> usize {
        let offset = (item.center()[axis] - self.origin[axis]) * self.scale[axis];
        (offset as usize).min(BINS - 1)
    }

    /// Moves the items left of the cut to the front and returns their number.
    pub(super) fn partition(&self, items: &mut [Item], cut: Cut) -> usize {
        let mut n_left = 0;
        for k in 0..items.len() {
            let goes_left = self.slice(&items[k], cut.axis) <= cut.last;
            items.swap(k, n_left);
            n_left += usize::from(goes_left);
        }
        n_left
    }
}

/// Halves the items by centre along the longest axis of the centres' box.
pub(super) fn partition_at_median(items: &mut [Item], extent: &Extent) -> usize {
    let longest = |a: &usize, b: &usize| extent.centers.extent(*a).total_cmp(&extent.centers.extent(*b));
    let axis = (0..3).max_by(longest).unwrap_or(0);
    let middle = items.len() / 2;
    items.select_nth_unstable_by(middle, |a, b| a.center()[axis].total_cmp(&b.center()[axis]));
    middle
}
