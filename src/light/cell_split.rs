//! Cells of the cube that emissions are drawn from, and where photons tell to split them.

use super::start::{DIMENSIONS, Start};
use super::tally::{Example, LEVELS, Tally};

/// How many parts of a cell are told apart along each axis before it is split between two of them.
const BINS: usize = 16;

/// Splits must be so many standard deviations from chance, squared: the best of [`BINS`] on five axes is taken.
const CERTAIN: f64 = 16.0;

/// So many arrivals may be chance where hardly any is expected.
const A_FEW: f64 = 2.0;

/// No fewer photons tell of a cell.
const FEWEST: u32 = 16;

/// A plane across an axis of the cube that emissions are drawn from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plane {
    pub axis: usize,
    pub at: f64,
}

/// A box in that cube.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    pub low: Start,
    pub high: Start,
}

impl Cell {
    pub const ALL: Cell = Cell { low: [0.0; DIMENSIONS], high: [1.0; DIMENSIONS] };

    pub fn volume(&self) -> f64 {
        self.low.iter().zip(&self.high).map(|(low, high)| high - low).product()
    }

    pub fn halves(&self, Plane { axis, at }: Plane) -> [Cell; 2] {
        let [mut lower, mut upper] = [*self; 2];
        (lower.high[axis], upper.low[axis]) = (at, at);
        [lower, upper]
    }
}

/// The plane between halves that differ most, if that is no matter of chance.
pub(super) fn best_split(cell: &Cell, examples: &[Example], lights: &[f64]) -> Option<Plane> {
    let (mut best, mut least) = (None, CERTAIN);
    for axis in 0..DIMENSIONS {
        let planes = planes(cell, axis, lights);
        let bins = tallies(examples, axis, &planes);
        let all = bins.iter().fold(Tally::default(), Tally::plus);
        let mut below = Tally::default();
        for (bin, &at) in bins.iter().zip(&planes) {
            below = below.plus(bin);
            let certainty = certainty(&below, &all);
            if certainty > least {
                (best, least) = (Some(Plane { axis, at }), certainty);
            }
        }
    }
    best
}

/// How many standard deviations, squared, those below a plane differ from chance on some level.
///
/// Photons count as they were drawn: weighed, few that stand for many would hide what many tell.
fn certainty(below: &Tally, all: &Tally) -> f64 {
    if below.photons.min(all.photons - below.photons) < FEWEST {
        return 0.0;
    }
    let part = f64::from(below.photons) / f64::from(all.photons);
    let on_level = |level: usize| {
        let [below, near] = [below.near[level], all.near[level]].map(f64::from);
        let chance = near * (1.0 - near / f64::from(all.photons)) * part * (1.0 - part);
        let surplus = (below - near * part).abs() - A_FEW;
        if surplus > 0.0 { surplus * surplus / chance } else { 0.0 }
    };
    (0..LEVELS).map(on_level).fold(0.0, f64::max)
}

/// Where a cell may be split across an axis, in order.
fn planes(cell: &Cell, axis: usize, lights: &[f64]) -> Vec<f64> {
    let (low, high) = (cell.low[axis], cell.high[axis]);
    if axis > 0 {
        let wide = high - low > 1e-5;
        let at = |k: usize| low + (high - low) * (k as f64 / BINS as f64);
        return (1..BINS).filter(|_| wide).map(at).collect();
    }
    let first = lights.partition_point(|&end| end <= low);
    let inside: &[f64] = &lights[first..lights.partition_point(|&end| end < high).max(first)];
    inside.iter().step_by(inside.len().div_ceil(BINS - 1).max(1)).copied().collect()
}

/// Of the examples between planes.
fn tallies(examples: &[Example], axis: usize, planes: &[f64]) -> [Tally; BINS] {
    let mut bins = [Tally::default(); BINS];
    if !planes.is_empty() {
        for example in examples {
            bins[planes.partition_point(|&at| at <= example.start[axis])].add(example);
        }
    }
    bins
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two where a sixtieth of one was expected.
    #[test]
    fn a_few_may_be_chance() {
        let tally = |photons, near| Tally { photons, near: [near; LEVELS], ..Tally::default() };
        let certain = |near| certainty(&tally(16, near), &tally(16_384, 16)) > CERTAIN;
        assert!(!certain(2) && certain(4));
    }
}
