//! Up to four spheres that share a leaf, and where a ray meets one.

use super::primitive::PrimitiveId;
use super::sphere::Sphere;
use crate::math::{DVec3, Ray, Vec3};

/// The spheres of a leaf. Where there are fewer than four, NaN fills up, which no ray meets.
#[derive(Clone, Debug)]
pub(super) struct SphereBlock {
    spheres: [(Sphere, PrimitiveId); 4],
}

impl SphereBlock {
    pub const EMPTY: SphereBlock =
        SphereBlock { spheres: [(Sphere { center: Vec3::NAN, radius: f32::NAN }, PrimitiveId::NONE); 4] };

    pub fn set(&mut self, lane: usize, sphere: Sphere, id: PrimitiveId) {
        self.spheres[lane] = (sphere, id);
    }

    /// Calls `visit(t, normal, id)` for every sphere that the ray meets.
    pub fn for_each_meeting(&self, ray: &Ray, mut visit: impl FnMut(f32, Vec3, PrimitiveId)) {
        for (sphere, id) in &self.spheres {
            if let Some((t, normal)) = intersect(ray, sphere) {
                visit(t, normal, *id);
            }
        }
    }
}

/// The nearest parameter `t > 0` at which the ray's line meets the sphere, and the outward normal there (not unit).
///
/// ```text
/// f = o - c,  b = -f·d / d·d,  l = f + b d,  Δ = (r² - l²) / d·d
/// q = b + sign(b) √Δ,  t = (f² - r²) / (q d·d)  and  t = q
/// ```
/// `l` reaches from the center to the point of the line that is nearest to it: its length loses nothing by a far
/// origin, unlike `b² - 4ac`. The two roots never subtract numbers of the same size. In f64, of which f32 sees
/// the correctly rounded `t` almost always.
///
/// # Source
/// Haines, Günther and Akenine-Möller, "Precision Improvements for Ray/Sphere Intersection", Ray Tracing Gems,
/// 2019, chapter 7.
fn intersect(ray: &Ray, sphere: &Sphere) -> Option<(f32, Vec3)> {
    let (dir, from_center) = (ray.dir.as_dvec3(), ray.origin.as_dvec3() - sphere.center.as_dvec3());
    let radius = f64::from(sphere.radius);
    let [first, second] = roots(from_center, dir, radius)?;
    let t = if first as f32 > 0.0 { first } else { second };
    let hit = t as f32;
    (hit > 0.0).then(|| (hit, (from_center + t * dir).as_vec3()))
}

fn roots(from_center: DVec3, dir: DVec3, radius: f64) -> Option<[f64; 2]> {
    let squared_length = dir.length_squared();
    let b = -from_center.dot(dir) / squared_length;
    let to_line = from_center + b * dir;
    let squared_half_chord = (radius * radius - to_line.length_squared()) / squared_length;
    (squared_half_chord >= 0.0).then(|| {
        let q = b + squared_half_chord.sqrt().copysign(b);
        let distance = from_center.length();
        let other = (distance - radius) * (distance + radius) / (q * squared_length);
        if other < q { [other, q] } else { [q, other] }
    })
}
