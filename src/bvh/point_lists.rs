//! Lists of points as columns, and the one thing that is done to them on the way down: sorting into two boxes.

use std::ops::Range;

use crate::math::{Aabb, Vec3};
use crate::simd::{Kernel, LANES, LaneVec3, Lanes, Mask, first_lanes};

/// Columns of x, y, z and the bits of the points' numbers.
type Columns<'a> = [&'a [f32]; 4];
type ColumnsMut<'a> = [&'a mut [f32]; 4];

/// Some points, in columns of equal length.
#[derive(Clone, Copy, Debug)]
pub struct Points<'a>(Columns<'a>);

impl Points<'_> {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.0[3].len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Where each lies, and its number.
    #[inline(always)]
    pub fn iter(&self) -> impl Iterator<Item = (Vec3, usize)> {
        let [x, y, z, numbers] = self.0;
        let places = x.iter().zip(y).zip(z).map(|((&x, &y), &z)| Vec3::new(x, y, z));
        places.zip(numbers.iter().map(|number| number.to_bits() as usize))
    }
}

/// Lists of points that lie one behind the other; every list is a range.
#[derive(Debug, Default)]
pub(super) struct PointLists {
    columns: [Vec<f32>; 4],
}

impl PointLists {
    /// One list: the points, numbered in their order.
    pub(super) fn of(points: &[Vec3]) -> PointLists {
        let columns = [
            points.iter().map(|p| p.x).collect(),
            points.iter().map(|p| p.y).collect(),
            points.iter().map(|p| p.z).collect(),
            (0..points.len() as u32).map(f32::from_bits).collect(),
        ];
        PointLists { columns }
    }

    pub(super) fn len(&self) -> usize {
        self.columns[3].len()
    }

    pub(super) fn get(&self, list: Range<usize>) -> Points<'_> {
        Points(self.columns.each_ref().map(|column| &column[list.clone()]))
    }

    /// The numbers of the points, which then get those from 0 on.
    pub(super) fn renumber(&mut self) -> Vec<u32> {
        let numbers = self.columns[3].iter().map(|number| number.to_bits()).collect();
        self.columns[3].iter_mut().zip(0..).for_each(|(number, k)| *number = f32::from_bits(k));
        numbers
    }

    /// The points inside one box, as lists of their own.
    pub(super) fn inside(&self, bounds: &Aabb) -> Inside<'_> {
        Inside { list: self.get(0..self.len()), bounds: *bounds }
    }

    /// Sorts the points of `list` into those inside each box; a point may be in both, or in none.
    ///
    /// The new lists lie above `top`, up to where everything is taken; a list that keeps all its points stays in place.
    pub(super) fn split(
        &mut self,
        list: &Range<usize>,
        top: usize,
        boxes: [Aabb; 2],
        run: impl FnOnce(Split) -> [usize; 2],
    ) -> [Range<usize>; 2] {
        let room = list.len() + LANES;
        let [left_at, right_at] = [top, top + room];
        if self.len() < right_at + room {
            self.columns.iter_mut().for_each(|column| column.resize(2 * (right_at + room), 0.0));
        }
        let [(a0, [l0, r0]), (a1, [l1, r1]), (a2, [l2, r2]), (a3, [l3, r3])] =
            self.columns.each_mut().map(|column| {
                let (below, above) = column.split_at_mut(top);
                let (left, right) = above[..2 * room].split_at_mut(room);
                (&below[list.clone()], [left, right])
            });
        let [n_left, n_right] =
            run(Split { list: [a0, a1, a2, a3], boxes, out: [[l0, l1, l2, l3], [r0, r1, r2, r3]] });
        let kept = |at: usize, n: usize| if n == list.len() { list.clone() } else { at..at + n };
        [kept(left_at, n_left), kept(right_at, n_right)]
    }
}

/// A box in all lanes.
struct Gate<L: Lanes> {
    min: LaneVec3<L>,
    max: LaneVec3<L>,
}

impl<L: Lanes> Gate<L> {
    #[inline(always)]
    fn new(lanes: L, bounds: &Aabb) -> Gate<L> {
        Gate { min: LaneVec3::splat(lanes, bounds.min), max: LaneVec3::splat(lanes, bounds.max) }
    }

    #[inline(always)]
    fn admits(&self, lanes: L, lot: &Lot<L>) -> Mask {
        let Gate { min, max } = self;
        let above = lanes.le(min.x, lot.x) & lanes.le(min.y, lot.y) & lanes.le(min.z, lot.z);
        above & lanes.le(lot.x, max.x) & lanes.le(lot.y, max.y) & lanes.le(lot.z, max.z) & lot.valid
    }
}

/// Up to sixteen points.
struct Lot<L: Lanes> {
    x: L::F32,
    y: L::F32,
    z: L::F32,
    numbers: L::F32,
    valid: Mask,
}

impl<L: Lanes> Lot<L> {
    /// Those from `at` on.
    #[inline(always)]
    fn load(lanes: L, [x, y, z, numbers]: Columns, at: usize) -> Lot<L> {
        let end = x.len().min(at + LANES);
        Lot {
            x: lanes.load(&x[at..end]),
            y: lanes.load(&y[at..end]),
            z: lanes.load(&z[at..end]),
            numbers: lanes.load(&numbers[at..end]),
            valid: first_lanes(end - at),
        }
    }

    /// Writes the points of `mask` to `out` from `at` on, and returns how many they are.
    #[inline(always)]
    fn append(&self, lanes: L, mask: Mask, [x, y, z, numbers]: &mut ColumnsMut, at: usize) -> usize {
        lanes.store(lanes.compress(mask, self.x), &mut x[at..]);
        lanes.store(lanes.compress(mask, self.y), &mut y[at..]);
        lanes.store(lanes.compress(mask, self.z), &mut z[at..]);
        lanes.store(lanes.compress(mask, self.numbers), &mut numbers[at..]);
        mask.count_ones() as usize
    }
}

/// Sorts points into two boxes; returns how many went into each.
pub(super) struct Split<'a> {
    list: Columns<'a>,
    boxes: [Aabb; 2],
    /// [`LANES`] longer than the list, since all lanes are written at once.
    out: [ColumnsMut<'a>; 2],
}

impl Kernel for Split<'_> {
    type Output = [usize; 2];

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> [usize; 2] {
        let Split { list, boxes: [left, right], out: [mut to_left, mut to_right] } = self;
        let (left, right) = (Gate::new(lanes, &left), Gate::new(lanes, &right));
        let (mut n_left, mut n_right) = (0, 0);
        for at in (0..list[3].len()).step_by(LANES) {
            let lot = Lot::load(lanes, list, at);
            n_left += lot.append(lanes, left.admits(lanes, &lot), &mut to_left, n_left);
            n_right += lot.append(lanes, right.admits(lanes, &lot), &mut to_right, n_right);
        }
        [n_left, n_right]
    }
}

/// The points inside a box, as lists of their own.
pub(super) struct Inside<'a> {
    list: Points<'a>,
    bounds: Aabb,
}

impl Kernel for Inside<'_> {
    type Output = PointLists;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> PointLists {
        let gate = Gate::new(lanes, &self.bounds);
        let mut columns = [(); 4].map(|()| vec![0.0; self.list.len() + LANES]);
        let mut out = columns.each_mut().map(|column| column.as_mut_slice());
        let mut n = 0;
        for at in (0..self.list.len()).step_by(LANES) {
            let lot = Lot::load(lanes, self.list.0, at);
            n += lot.append(lanes, gate.admits(lanes, &lot), &mut out, n);
        }
        columns.iter_mut().for_each(|column| column.truncate(n));
        PointLists { columns }
    }
}
