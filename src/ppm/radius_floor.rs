use super::HitPoint;
use super::statistic::Statistics;
use super::statistics::RadiusRange;
use crate::bvh::SphereBvh;

/// Keeps discs wider than the grid that coordinates lie on: in smaller ones, photons fall by luck.
#[derive(Clone, Copy, Debug)]
pub(super) struct RadiusFloor {
    /// The largest of all hit points' floors: while all radii are above it, there is nothing to look at.
    largest: f64,
}

/// Least radius, in errors of the point: four to eight steps of its largest coordinate.
const FLOOR_ERRORS: f64 = 0.25;

/// The radius at which the disc of a hit point stops shrinking, in scene units.
pub fn least_radius(hit_point: &HitPoint) -> f64 {
    FLOOR_ERRORS * f64::from(hit_point.receiver.p_error)
}

impl RadiusFloor {
    pub(super) fn of(hit_points: &[HitPoint]) -> RadiusFloor {
        RadiusFloor { largest: hit_points.iter().map(least_radius).fold(0.0, f64::max) }
    }

    /// Raises radii that are below their floor, and tells what they are then.
    pub(super) fn apply(
        self,
        hit_points: &[HitPoint],
        states: &mut Statistics,
        tree: &mut SphereBvh,
    ) -> RadiusRange {
        let range = RadiusRange::of(tree.radii());
        if range.min > self.largest {
            return range;
        }
        let floored = states.raise(|position| least_radius(&hit_points[position]));
        tree.refit(|position| states.get(position).radius() as f32);
        RadiusRange { floored, ..RadiusRange::of(tree.radii()) }
    }
}
