use super::HitPoint;
use super::keeper::Keeper;
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

/// Whose discs one size must do for all that a pixel sees: the largest floor there.
fn floors_of_pixels(hit_points: &[HitPoint], pixels: usize) -> Vec<f64> {
    let mut floors = vec![0.0f64; pixels];
    for hit_point in hit_points {
        let floor = &mut floors[hit_point.pixel as usize];
        *floor = floor.max(least_radius(hit_point));
    }
    floors
}

impl RadiusFloor {
    pub(super) fn of(hit_points: &[HitPoint]) -> RadiusFloor {
        RadiusFloor { largest: hit_points.iter().map(least_radius).fold(0.0, f64::max) }
    }

    /// Raises radii that are below their floor, and tells what they are then.
    pub(super) fn apply(
        self,
        hit_points: &[HitPoint],
        keeper: Keeper,
        states: &mut Statistics,
        tree: &mut SphereBvh,
    ) -> RadiusRange {
        let range = RadiusRange::of(tree.radii());
        if range.min > self.largest {
            return range;
        }
        let floored = match keeper {
            Keeper::HitPoints => states.raise(|position| least_radius(&hit_points[position])),
            Keeper::Pixels => {
                let floors = floors_of_pixels(hit_points, states.len());
                states.raise(|pixel| floors[pixel])
            }
        };
        tree.refit(|position| states.get(keeper.index(hit_points, position)).radius() as f32);
        RadiusRange { floored, ..RadiusRange::of(tree.radii()) }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Precision, RadiusPolicy};
    use super::*;
    use crate::bsdf::Coat;
    use crate::bvh::Sphere;
    use crate::math::{Rgb, Vec3};
    use crate::scene::Receiver;

    #[test]
    fn a_pixel_keeps_clear_of_the_coarsest_of_its_hit_points() {
        let hit_point = |pixel, p_error| {
            let receiver = Receiver { p: Vec3::ZERO, p_error, ng: Vec3::Y, ns: Vec3::Y, coat: Coat::NONE };
            HitPoint { receiver, reflectance: Rgb::ONE, pixel, footprint: 0.0 }
        };
        let hit_points = [hit_point(1, 8.0), hit_point(1, 40.0), hit_point(0, 4.0), hit_point(1, 16.0)];
        let (mut tree, order) = SphereBvh::build(&[Sphere { center: Vec3::ZERO, radius: 3.0 }; 4]);
        let ordered: Vec<HitPoint> = order.iter().map(|&k| hit_points[k as usize]).collect();
        let mut states = Statistics::new(3, 3.0, RadiusPolicy::HitPoint, Precision::Double);
        let range = RadiusFloor::of(&ordered).apply(&ordered, Keeper::Pixels, &mut states, &mut tree);
        let radii: Vec<f64> = (0..3).map(|pixel| states.get(pixel).radius()).collect();
        assert_eq!((radii, range.floored, range.max), (vec![3.0, 10.0, 3.0], 1, 10.0));
        assert!(
            tree.radii().iter().zip(&ordered).all(|(&radius, h)| radius == [3.0, 10.0][h.pixel as usize])
        );
    }
}
