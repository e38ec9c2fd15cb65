//! What lies inside of glass and water: media that absorb light on its way, by the law of Beer and Lambert.
//!
//! A path knows the bodies that it went into and not out of again. It absorbs by the one that it entered last, whatever lies around
//! that: so glass in water absorbs as glass, and an air bubble in water, a body of its own, as air.

use super::desc::Material;
use super::{Scene, SurfaceHit};
use crate::light::Light;
use crate::math::{Aabb, DVec3, Ray, Rgb, Vec3};

/// The media around a point of a path, innermost last: up to four, of which those entered first are forgotten beyond that.
///
/// Each takes a byte, the innermost the lowest; 0 is none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Media(u32);

impl Media {
    /// Outside of all bodies.
    pub const NONE: Media = Media(0);

    const DEPTH: u32 = 4;

    /// The number of the innermost medium.
    fn top(self) -> usize {
        (self.0 & 0xff) as usize
    }

    fn enter(self, medium: u8) -> Media {
        Media(self.0 << 8 | u32::from(medium))
    }

    /// Without the innermost one of that number, if it is there.
    fn leave(self, medium: u8) -> Media {
        let at = |level: &u32| self.0 >> (8 * level) & 0xff == u32::from(medium);
        let Some(level) = (0..Media::DEPTH).find(at) else { return self };
        let inner = self.0 & ((1 << (8 * level)) - 1);
        let outer = if level + 1 < Media::DEPTH { self.0 >> (8 * (level + 1)) } else { 0 };
        Media(outer << (8 * level) | inner)
    }
}

/// Most different absorptions of a scene: what a byte can number.
pub(super) const MOST_MEDIA: usize = 255;

/// Surfaces that are walked through to find out where a point is.
const LONGEST_WALK: usize = 4096;

/// The media of a scene; empty where nothing absorbs.
#[derive(Clone, Debug, Default)]
pub(super) struct Absorbers {
    /// The number of what lies inside of each material; 0 where it has no inside.
    of_material: Vec<u8>,
    /// `σ` by number (1 / scene unit); that of no medium is 0.
    sigmas: Vec<Rgb>,
    /// The way out, unit: see [`Scene::media_at`].
    outward: Vec3,
    /// Where the camera is.
    camera: Media,
    /// Whether some light may lie in a body that absorbs.
    hold_lights: bool,
}

impl Absorbers {
    /// Bodies that absorb alike have one number.
    pub fn of(materials: &[Material]) -> Absorbers {
        if materials.iter().all(|material| material.inside().is_none_or(|sigma| sigma == Rgb::ZERO)) {
            return Absorbers::default();
        }
        let mut sigmas = vec![Rgb::ZERO];
        let number = |material: &Material| {
            let Some(sigma) = material.inside() else { return 0 };
            let known = sigmas.iter().skip(1).position(|known| *known == sigma);
            let number = known.map_or(sigmas.len(), |known| known + 1).min(MOST_MEDIA);
            if number == sigmas.len() {
                sigmas.push(sigma);
            }
            number as u8
        };
        let of_material = materials.iter().map(number).collect();
        Absorbers { of_material, sigmas, ..Absorbers::default() }
    }

    fn are_any(&self) -> bool {
        !self.sigmas.is_empty()
    }
}

/// How many media of different absorption the materials hold, clear ones among them; none where all are clear.
pub(super) fn count(materials: &[Material]) -> usize {
    let mut insides: Vec<[u32; 3]> = materials
        .iter()
        .filter_map(Material::inside)
        .map(|sigma| (sigma + 0.0).to_array().map(f32::to_bits))
        .collect();
    insides.sort_unstable();
    insides.dedup();
    if insides == [[0; 3]] { 0 } else { insides.len() }
}

impl Scene {
    /// Whether any body absorbs light.
    pub fn absorbs(&self) -> bool {
        self.absorbers.are_any()
    }

    /// The share of light that is left behind a way through `media`: `exp(-σ d)` of the innermost one. `distance` in scene units may
    /// be infinite.
    pub fn transmittance(&self, media: Media, distance: f32) -> Rgb {
        if media == Media::NONE {
            return Rgb::ONE;
        }
        self.absorbers.sigmas[media.top()]
            .map(|sigma| if sigma > 0.0 { (-sigma * distance).exp() } else { 1.0 })
    }

    /// The media behind the surface at `hit` of a path that came there through `media`.
    pub fn crossed(&self, media: Media, hit: &SurfaceHit) -> Media {
        let Some(&medium) = self.absorbers.of_material.get(hit.material as usize) else { return media };
        match (medium, hit.is_front()) {
            (0, _) => media,
            (medium, true) => media.enter(medium),
            (medium, false) => media.leave(medium),
        }
    }

    /// The media around the camera, by its pinhole or the middle of its lens.
    pub fn camera_media(&self) -> Media {
        self.absorbers.camera
    }

    /// The media around a point from which a light shines.
    pub fn light_media(&self, p: Vec3) -> Media {
        if self.absorbers.hold_lights { self.media_at(p) } else { Media::NONE }
    }

    /// The share of light that arrives straight from a light at so far a point: the way between them crosses no surface.
    pub(super) fn direct_transmittance(&self, from: Vec3, distance: f32) -> Rgb {
        if !self.absorbers.hold_lights {
            return Rgb::ONE;
        }
        self.transmittance(self.media_at(from), distance)
    }

    /// The media around `p`: what a ray outward leaves without having entered it on the way, the first as the innermost.
    ///
    /// Out of closed bodies every way leads. An open sheet has its medium behind it, so rays go along the mean normal of all that absorbs.
    pub fn media_at(&self, p: Vec3) -> Media {
        if !self.absorbs() {
            return Media::NONE;
        }
        let (mut entered, mut left) = (Vec::new(), Vec::new());
        let mut ray = Ray::new(p, self.absorbers.outward);
        for _ in 0..LONGEST_WALK {
            let Some(hit) = self.intersect(&ray) else { break };
            let medium = self.absorbers.of_material[hit.material as usize];
            if medium > 0 && hit.is_front() {
                entered.push(medium);
            } else if medium > 0 {
                match entered.iter().rposition(|known| *known == medium) {
                    Some(at) => drop(entered.remove(at)),
                    None => left.push(medium),
                }
            }
            ray = hit.pass();
        }
        left.iter().take(Media::DEPTH as usize).rev().fold(Media::NONE, |media, &medium| media.enter(medium))
    }

    /// Finds out where the camera and the lights are.
    pub(super) fn find_media(&mut self) {
        if self.absorbs() {
            self.absorbers.outward = self.way_out();
            self.absorbers.camera = self.media_at(self.view.position);
            self.absorbers.hold_lights = self.bodies_hold_lights();
        }
    }

    /// Along the mean normal of triangles that absorb, weighed by their areas; upward where they are closed, and it vanishes.
    fn way_out(&self) -> Vec3 {
        /// Off the directions along which walls stand, so that edges are not met.
        const ASKEW: Vec3 = Vec3::new(0.0123, 0.0071, -0.0097);
        /// Of all areas together: less is rounding.
        const LEAST: f64 = 1e-3;
        let normals = self.meshes().flat_map(|mesh| {
            let absorbing = (0..mesh.triangles.len()).filter(|&k| self.has_absorber(mesh.materials[k]));
            absorbing.map(|k| {
                let [a, b, c] = mesh.corners(k).map(|corner| corner.as_dvec3());
                (b - a).cross(c - a)
            })
        });
        let (sum, areas) = normals.fold((DVec3::ZERO, 0.0), |(sum, areas), n| (sum + n, areas + n.length()));
        let open = sum.length() > LEAST * areas;
        let out = if open { sum.normalize_or(DVec3::Y).as_vec3() } else { Vec3::Y };
        (out + ASKEW).normalize()
    }

    fn has_absorber(&self, material: u32) -> bool {
        self.materials[material as usize].inside().is_some_and(|sigma| sigma != Rgb::ZERO)
    }

    /// Whether the box of a light meets that of a body, or a light is seen to be in one whose surface is open.
    fn bodies_hold_lights(&self) -> bool {
        let bodies = self.absorbing_boxes();
        let is_held = |light: &Light| {
            let points = points_before(light);
            let bounds = Aabb::of_points(points.iter().copied());
            !points.is_empty()
                && (bodies.iter().any(|body| body.overlaps(&bounds))
                    || points.iter().any(|p| self.media_at(*p) != Media::NONE))
        };
        self.lights.iter().any(is_held)
    }

    /// Of the parts of meshes that absorb, and of spheres.
    fn absorbing_boxes(&self) -> Vec<Aabb> {
        let meshes = self.meshes().map(|mesh| {
            let triangles = (0..mesh.triangles.len()).filter(|&k| self.has_absorber(mesh.materials[k]));
            Aabb::of_points(triangles.flat_map(|k| mesh.corners(k)))
        });
        let spheres = self.spheres().iter().filter(|sphere| self.has_absorber(sphere.material));
        let spheres = spheres.map(|sphere| Aabb::of_sphere(sphere.center, sphere.radius));
        meshes.filter(|bounds| !bounds.is_empty()).chain(spheres).collect()
    }
}

/// Points from which a light shines; none of light from afar, which comes from outside.
fn points_before(light: &Light) -> Vec<Vec3> {
    /// How far before their surface, of its size.
    const BEFORE: f32 = 1e-4;
    match light {
        Light::Point { position, .. } => vec![*position],
        Light::Spot(spot) => vec![spot.position],
        Light::Triangle { corners, .. } => {
            let [a, b, c] = *corners;
            let (middle, size) = ((a + b + c) / 3.0, (b - a).length().max((c - a).length()));
            let shift = BEFORE * size * (b - a).cross(c - a).normalize_or_zero();
            let near = corners.map(|corner| corner.lerp(middle, BEFORE) + shift);
            [&near[..], &[middle + shift]].concat()
        }
        Light::Sphere { center, radius, .. } => {
            let reach = (1.0 + BEFORE) * radius;
            [Vec3::X, Vec3::Y, Vec3::Z]
                .into_iter()
                .flat_map(|axis| [*center + reach * axis, *center - reach * axis])
                .collect()
        }
        Light::Distant(_) | Light::Environment(_) => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entered(media: &[u8]) -> Media {
        media.iter().fold(Media::NONE, |all, &medium| all.enter(medium))
    }

    #[test]
    fn the_last_one_entered_counts_until_it_is_left() {
        let both = entered(&[1, 2]);
        assert_eq!((both.top(), both.leave(2).top(), both.leave(2).leave(1)), (2, 1, Media::NONE));
        assert_eq!(both.leave(1), entered(&[2]), "bodies that overlap");
        assert_eq!(both.leave(3), both, "a body that was not entered");
        assert_eq!(Media::NONE.leave(7), Media::NONE);
        assert_eq!(entered(&[3, 3]).leave(3), entered(&[3]), "bodies of one kind in each other");
    }

    /// Beyond four the outermost is forgotten.
    #[test]
    fn four_media_are_known() {
        let five = entered(&[1, 2, 3, 4, 255]);
        assert_eq!(five, entered(&[2, 3, 4, 255]));
        assert_eq!(five.leave(2), entered(&[3, 4, 255]));
        assert_eq!(five.leave(255).leave(4).leave(3).leave(2).leave(1), Media::NONE);
    }
}
