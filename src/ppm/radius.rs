use super::HitPoints;

/// How many pixels wide the automatic radius is: small enough to keep caustics sharp from the first passes on,
/// large enough that discs of neighbouring hit points overlap.
const PIXELS: f64 = 2.0;

/// The initial radius where a scene names none: two pixels at the median length of the eye paths, in scene units.
///
/// 1 where there is no hit point.
pub fn automatic_radius(hit_points: &HitPoints) -> f64 {
    let mut footprints = hit_points.map(|h| h.footprint);
    if footprints.is_empty() {
        return 1.0;
    }
    let middle = footprints.len() / 2;
    let (_, median, _) = footprints.select_nth_unstable_by(middle, f32::total_cmp);
    PIXELS * f64::from(*median)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::Coat;
    use crate::math::{Rgb, Vec3};
    use crate::ppm::HitPoint;
    use crate::scene::Receiver;

    fn at_footprint(footprint: f32) -> HitPoint {
        let receiver = Receiver { p: Vec3::ZERO, p_error: 0.0, ng: Vec3::Y, ns: Vec3::Y, coat: Coat::NONE };
        HitPoint { receiver, reflectance: Rgb::ONE, pixel: 0, footprint }
    }

    #[test]
    fn radius_is_two_median_pixels_wide() {
        let hit_points = HitPoints::new(vec![[9.0, 0.1, 0.25, 0.3, 0.2].map(at_footprint).to_vec()]);
        assert_eq!(automatic_radius(&hit_points), 0.5);
    }

    #[test]
    fn nothing_seen_needs_no_radius_but_gets_a_valid_one() {
        assert_eq!(automatic_radius(&HitPoints::default()), 1.0);
    }
}
