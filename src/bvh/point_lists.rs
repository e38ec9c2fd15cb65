//! Lists of points as columns, and the one thing that is done to them on the way down: sorting into two boxes.

use std::ops::Range;

use rayon::prelude::*;

use crate::math::{Aabb, Vec3};
use crate::simd::{Isa, Kernel, LANES, LaneVec3, Lanes, Mask, first_lanes};

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
    /// Longer than what is in them.
    columns: [Vec<f32>; 4],
    /// Of the first list, from which all others are split.
    len: usize,
}

impl PointLists {
    /// Becomes one list: all these points, numbered in their order. It must have room for them.
    pub(super) fn fill(&mut self, points: &[&[Vec3]]) {
        let mut free = self.columns.each_mut().map(|column| column.as_mut_slice());
        self.len = 0;
        let pieces = points.iter().map(|&points| {
            let columns =
                free.each_mut().map(|column| column.split_off_mut(..points.len()).unwrap_or_default());
            let first = self.len as u32;
            self.len += points.len();
            Piece { points, first, columns }
        });
        let pieces: Vec<Piece> = pieces.collect();
        pieces.into_par_iter().for_each(Piece::fill);
    }

    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// How many points there is room for.
    pub(super) fn room(&self) -> usize {
        // Whole registers are written, whatever is in them.
        self.columns[3].len().saturating_sub(LANES)
    }

    /// Makes room for `count` points.
    pub(super) fn make_room(&mut self, count: usize) {
        if self.room() < count {
            self.columns.iter_mut().for_each(|column| column.resize(count + LANES, 0.0));
        }
    }

    pub(super) fn get(&self, list: Range<usize>) -> Points<'_> {
        Points(self.columns.each_ref().map(|column| &column[list.clone()]))
    }

    /// The numbers of the points, which then get those from 0 on.
    pub(super) fn renumber(&mut self) -> Vec<u32> {
        let list = &mut self.columns[3][..self.len];
        let numbers = list.iter().map(|number| number.to_bits()).collect();
        list.iter_mut().zip(0..).for_each(|(number, k)| *number = f32::from_bits(k));
        numbers
    }

    /// Becomes the points of `others` inside one box. It must have room for all of `others`.
    pub(super) fn fill_inside(&mut self, others: &PointLists, bounds: &Aabb, isa: Isa) {
        let out = self.columns.each_mut().map(|column| column.as_mut_slice());
        self.len = isa.run(Inside { list: others.get(0..others.len), bounds: *bounds, out });
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
        if self.columns[3].len() < right_at + room {
            self.columns.iter_mut().for_each(|column| column.resize(2 * (right_at + room), 0.0));
        }
        let [a, b, c, d] = &mut self.columns;
        let (a, [l0, r0]) = list_and_room(a, list, top, room);
        let (b, [l1, r1]) = list_and_room(b, list, top, room);
        let (c, [l2, r2]) = list_and_room(c, list, top, room);
        let (d, [l3, r3]) = list_and_room(d, list, top, room);
        let [n_left, n_right] =
            run(Split { list: [a, b, c, d], boxes, out: [[l0, l1, l2, l3], [r0, r1, r2, r3]] });
        let kept = |at: usize, n: usize| if n == list.len() { list.clone() } else { at..at + n };
        [kept(left_at, n_left), kept(right_at, n_right)]
    }
}

/// A list in one of the columns, and the two rooms above `top`.
// Called by name and inlined: compilers that see it as a closure of `map` leave four calls here, for every node of the tree.
#[inline(always)]
fn list_and_room<'a>(
    column: &'a mut [f32],
    list: &Range<usize>,
    top: usize,
    room: usize,
) -> (&'a [f32], [&'a mut [f32]; 2]) {
    let (below, above) = column.split_at_mut(top);
    let (left, right) = above[..2 * room].split_at_mut(room);
    (&below[list.clone()], [left, right])
}

/// Points on their way into columns.
struct Piece<'a> {
    points: &'a [Vec3],
    /// The number of the first.
    first: u32,
    columns: ColumnsMut<'a>,
}

impl Piece<'_> {
    fn fill(self) {
        let [x, y, z, numbers] = self.columns;
        let places = x.iter_mut().zip(y).zip(z).zip(numbers);
        for ((((x, y), z), number), (p, k)) in places.zip(self.points.iter().zip(self.first..)) {
            (*x, *y, *z, *number) = (p.x, p.y, p.z, f32::from_bits(k));
        }
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

/// Picks the points inside a box; returns how many they are.
struct Inside<'a> {
    list: Points<'a>,
    bounds: Aabb,
    /// [`LANES`] longer than the list.
    out: ColumnsMut<'a>,
}

impl Kernel for Inside<'_> {
    type Output = usize;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> usize {
        let Inside { list, bounds, mut out } = self;
        let gate = Gate::new(lanes, &bounds);
        let mut n = 0;
        for at in (0..list.len()).step_by(LANES) {
            let lot = Lot::load(lanes, list.0, at);
            n += lot.append(lanes, gate.admits(lanes, &lot), &mut out, n);
        }
        n
    }
}
