use super::HitPoint;

/// How many pixels wide the automatic radius is: small enough to keep caustics sharp from the first passes on,
/// large enough that discs of neighbouring hit points overlap.
const PIXELS: f64 = 2.0;

/// The initial radius where a scene names none: two pixels at the median length of the eye paths, in scene units.
///
/// 1 where there is no hit point.
pub fn automatic_radius(hit_points: &[HitPoint]) -> f64 {
    let mut footprints: Vec<f32> = hit_points.iter().map(|h| h.footprint).collect();
    if footprints.is_empty() {
        return 1.0;
    }
    let middle = footprints.len() / 2;
    let (_, median, _) = footprints.select_nth_unstable_by(middle, f32::total_cmp);
    PIXELS * f64::from(*median)
}
