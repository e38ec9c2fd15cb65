//! Which bodies that absorb light lie around a point, and how much they take.

use super::media::Media;
use super::{Scene, SurfaceHit};
use crate::light::Light;
use crate::math::{Aabb, DVec3, Ray, Rgb, Vec3};

/// Surfaces that are walked through to find out where a point is.
const LONGEST_WALK: usize = 4096;

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
