//! What is done where points meet the spheres of a leaf.

use std::marker::PhantomData;
use std::ops::Add;

use super::point_lists::Points;
use crate::math::Vec3;
use crate::simd::{LaneVec3, Lanes, Mask, first_lanes};

/// What is done where points meet spheres.
pub trait Gatherer: Sync {
    /// What every sphere carries.
    type State: Send;
    /// What a task carries from leaf to leaf.
    type Task;
    /// What is left of all tasks.
    type Tally: Add<Output = Self::Tally> + Default + Send;

    /// Begins with some of the points, given by their numbers in increasing order. From here on the task knows them
    /// by their places in that list.
    fn begin(&self, points: Vec<u32>) -> Self::Task;

    /// Meets the spheres of one leaf with the points in its box, in increasing order. It may give the spheres new radii.
    fn meet<L: Lanes>(&self, lanes: L, task: &mut Self::Task, leaf: Leaf<Self::State>) -> Radii;

    /// Ends a task.
    fn end(&self, task: Self::Task) -> Self::Tally;
}

/// What [`Gatherer::meet`] did to the radii of a leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Radii {
    /// They are as they were.
    Kept,
    /// The tree has to follow them.
    Changed,
}

/// The spheres of a leaf, at most `simd::LANES`, and the points in its box.
#[derive(Debug)]
pub struct Leaf<'a, S> {
    /// The position of the first sphere.
    pub first: usize,
    /// Columns of the centres.
    pub centers: [&'a [f32]; 3],
    /// Their radii.
    pub radii: &'a mut [f32],
    /// Their states.
    pub states: &'a mut [S],
    /// The points, by their places in the task's list.
    pub points: Points<'a>,
}

impl<S> Leaf<'_, S> {
    /// The spheres in lanes, as they are now.
    #[inline(always)]
    pub fn balls<L: Lanes>(&self, lanes: L) -> Balls<L> {
        let radius = lanes.load(self.radii);
        let valid = lanes.le(lanes.splat(0.0), radius) & first_lanes(self.radii.len());
        let squared_radius = lanes.select(valid, lanes.mul(radius, radius), lanes.splat(-1.0));
        Balls { centers: LaneVec3::load(lanes, self.centers), squared_radius }
    }
}

/// Up to sixteen spheres; [`super::Sphere::contains`] for all of them at once.
#[derive(Clone, Copy)]
pub struct Balls<L: Lanes> {
    centers: LaneVec3<L>,
    squared_radius: L::F32,
}

impl<L: Lanes> Balls<L> {
    /// Which of the spheres contain `p`.
    #[inline(always)]
    pub fn around(&self, lanes: L, p: Vec3) -> Mask {
        let offset = self.offset(lanes, p);
        lanes.le(offset.dot(lanes, offset), self.squared_radius)
    }

    /// From `p` to their centres.
    #[inline(always)]
    pub fn offset(&self, lanes: L, p: Vec3) -> LaneVec3<L> {
        self.centers.sub(lanes, LaneVec3::splat(lanes, p))
    }

    /// Which of the spheres contain the point at `offset` in the inner half of their discs' area.
    #[inline(always)]
    pub fn around_half(&self, lanes: L, offset: LaneVec3<L>) -> Mask {
        let half = lanes.mul(self.squared_radius, lanes.splat(0.5));
        lanes.le(offset.dot(lanes, offset), half)
    }
}

/// Hands every meeting of a point and a sphere to a closure.
pub struct EachMeeting<S, V> {
    visit: V,
    state: PhantomData<fn(S)>,
}

impl<S, V> EachMeeting<S, V> {
    /// `visit(&mut state, position, point_index)` sees every meeting; the point by its number among all.
    pub fn new(visit: V) -> EachMeeting<S, V> {
        EachMeeting { visit, state: PhantomData }
    }
}

impl<S: Send, V: Fn(&mut S, usize, usize) + Sync> Gatherer for EachMeeting<S, V> {
    type State = S;
    type Task = Vec<u32>;
    type Tally = u64;

    fn begin(&self, points: Vec<u32>) -> Vec<u32> {
        points
    }

    #[inline(always)]
    fn meet<L: Lanes>(&self, lanes: L, numbers: &mut Vec<u32>, leaf: Leaf<S>) -> Radii {
        let balls = leaf.balls(lanes);
        for (p, place) in leaf.points.iter() {
            let mut around = balls.around(lanes, p);
            while around != 0 {
                let lane = around.trailing_zeros() as usize;
                around &= around - 1;
                (self.visit)(&mut leaf.states[lane], leaf.first + lane, numbers[place] as usize);
            }
        }
        Radii::Kept
    }

    fn end(&self, _: Vec<u32>) -> u64 {
        0
    }
}
