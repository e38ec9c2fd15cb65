//! Rays that Embree traces several at a time.

use std::{fmt, ptr};

use super::scene::{Hit, Scene, end_inside};
use super::sys;
use crate::math::{Ray, Vec3};

/// How many rays one call of Embree traces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PacketWidth {
    /// `rtcIntersect8`.
    Eight,
    /// `rtcIntersect16`.
    Sixteen,
}

/// What Embree may expect of the rays of a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coherence {
    /// They start and point anywhere.
    Incoherent,
    /// They start and point alike.
    Coherent,
}

/// Most rays of a packet.
pub const PACKET: usize = 16;

/// One number of each ray of a packet.
pub type Row = [f32; PACKET];

/// Up to sixteen rays, in columns.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct RayPacket {
    /// Where they start: all x, all y, all z.
    pub origin: [Row; 3],
    /// Where they go.
    pub dir: [Row; 3],
    /// Where they end.
    pub t_max: Row,
    /// How many there are; the other lanes are idle.
    pub len: usize,
}

/// What the rays of a packet meet first. It is what Embree works in, to be used again for the next packet.
#[derive(Clone, Copy)]
pub struct HitPacket(sys::RTCRayHit16);

impl RayPacket {
    /// No rays.
    pub const EMPTY: RayPacket = RayPacket {
        origin: [[0.0; PACKET]; 3],
        dir: [[0.0; PACKET]; 3],
        t_max: [f32::INFINITY; PACKET],
        len: 0,
    };

    /// The first sixteen of `rays`.
    pub fn of(rays: &[Ray]) -> RayPacket {
        let mut packet = RayPacket { len: rays.len().min(PACKET), ..RayPacket::EMPTY };
        for (lane, ray) in rays.iter().enumerate().take(PACKET) {
            for axis in 0..3 {
                packet.origin[axis][lane] = ray.origin[axis];
                packet.dir[axis][lane] = ray.dir[axis];
            }
            packet.t_max[lane] = ray.t_max;
        }
        packet
    }

    /// The ray of one lane.
    #[inline(always)]
    pub fn ray(&self, lane: usize) -> Ray {
        Ray { origin: at(&self.origin, lane), dir: at(&self.dir, lane), t_max: self.t_max[lane] }
    }
}

impl HitPacket {
    /// Nothing is met.
    pub fn none() -> HitPacket {
        // SAFETY: plain numbers, for which zero is a value.
        let mut query: sys::RTCRayHit16 = unsafe { std::mem::zeroed() };
        let sys::RTCRayHit16 { ray, hit } = &mut query;
        ray.tnear = [f32::MIN_POSITIVE; PACKET];
        ray.mask = [u32::MAX; PACKET];
        hit.geomID = [sys::RTC_INVALID_GEOMETRY_ID; PACKET];
        hit.instID = [[u32::MAX; PACKET]];
        hit.instPrimID = [[u32::MAX; PACKET]];
        HitPacket(query)
    }

    /// What the ray of one lane meets.
    #[inline(always)]
    pub fn hit(&self, lane: usize) -> Option<Hit> {
        let sys::RTCRayHit16 { ray, hit } = &self.0;
        (hit.geomID[lane] != sys::RTC_INVALID_GEOMETRY_ID).then(|| Hit {
            t: ray.tfar[lane],
            u: hit.u[lane],
            v: hit.v[lane],
            ng: Vec3::new(hit.Ng_x[lane], hit.Ng_y[lane], hit.Ng_z[lane]),
            geometry: hit.geomID[lane],
            primitive: hit.primID[lane],
        })
    }

    /// Says what the ray of one lane meets.
    pub fn set(&mut self, lane: usize, found: Option<Hit>) {
        let sys::RTCRayHit16 { ray, hit } = &mut self.0;
        hit.geomID[lane] = sys::RTC_INVALID_GEOMETRY_ID;
        if let Some(Hit { t, u, v, ng, geometry, primitive }) = found {
            (ray.tfar[lane], hit.u[lane], hit.v[lane]) = (t, u, v);
            (hit.Ng_x[lane], hit.Ng_y[lane], hit.Ng_z[lane]) = (ng.x, ng.y, ng.z);
            (hit.geomID[lane], hit.primID[lane]) = (geometry, primitive);
        }
    }
}

impl fmt::Debug for HitPacket {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_list().entries((0..PACKET).map(|lane| self.hit(lane))).finish()
    }
}

#[inline(always)]
fn at([x, y, z]: &[Row; 3], lane: usize) -> Vec3 {
    Vec3::new(x[lane], y[lane], z[lane])
}

impl Scene {
    /// The nearest hit of every ray, as [`Scene::intersect`] would find it, up to ties and rounding.
    ///
    /// # Panics
    /// Where `hits` has not the length of `rays`.
    pub fn intersect_packets(
        &self,
        rays: &[Ray],
        hits: &mut [Option<Hit>],
        width: PacketWidth,
        coherence: Coherence,
    ) {
        assert_eq!(rays.len(), hits.len(), "one hit for each ray");
        let mut found = HitPacket::none();
        for (rays, hits) in rays.chunks(PACKET).zip(hits.chunks_mut(PACKET)) {
            self.intersect_packet(&RayPacket::of(rays), &mut found, width, coherence);
            for (lane, hit) in hits.iter_mut().enumerate() {
                *hit = found.hit(lane);
            }
        }
    }

    /// Leaves in `hits` the nearest hit of every ray of a packet, as [`Scene::intersect`] would find it, up to ties and rounding.
    pub fn intersect_packet(
        &self,
        rays: &RayPacket,
        hits: &mut HitPacket,
        width: PacketWidth,
        coherence: Coherence,
    ) {
        let (mut arguments, valid) = (arguments(coherence), valid(rays));
        load(&mut hits.0, rays);
        match width {
            PacketWidth::Eight => {
                for first in (0..rays.len).step_by(8) {
                    self.intersect8(&valid, &mut hits.0, first, &mut arguments);
                }
            }
            PacketWidth::Sixteen => {
                // SAFETY: the scene is alive and committed; mask, query and arguments are aligned, of the headers' size,
                // and this thread's own.
                unsafe {
                    sys::rtcIntersect16(valid.0.as_ptr(), self.as_raw(), &raw mut hits.0, &raw mut arguments);
                }
            }
        }
    }

    /// Traces eight lanes of a packet.
    fn intersect8(
        &self,
        valid: &Valid,
        packet: &mut sys::RTCRayHit16,
        first: usize,
        arguments: &mut sys::RTCIntersectArguments,
    ) {
        let lanes = first..first + 8;
        let mut mask = Valid([0; PACKET]);
        mask.0[..8].copy_from_slice(&valid.0[lanes.clone()]);
        // SAFETY: plain numbers, for which zero is a value.
        let mut query: sys::RTCRayHit8 = unsafe { std::mem::zeroed() };
        let (ray, hit) = (&mut query.ray, &mut query.hit);
        ray.org_x.copy_from_slice(&packet.ray.org_x[lanes.clone()]);
        ray.org_y.copy_from_slice(&packet.ray.org_y[lanes.clone()]);
        ray.org_z.copy_from_slice(&packet.ray.org_z[lanes.clone()]);
        ray.dir_x.copy_from_slice(&packet.ray.dir_x[lanes.clone()]);
        ray.dir_y.copy_from_slice(&packet.ray.dir_y[lanes.clone()]);
        ray.dir_z.copy_from_slice(&packet.ray.dir_z[lanes.clone()]);
        ray.tfar.copy_from_slice(&packet.ray.tfar[lanes.clone()]);
        ray.tnear = [f32::MIN_POSITIVE; 8];
        ray.mask = [u32::MAX; 8];
        hit.geomID = [sys::RTC_INVALID_GEOMETRY_ID; 8];
        (hit.instID, hit.instPrimID) = ([[u32::MAX; 8]], [[u32::MAX; 8]]);
        // SAFETY: the scene is alive and committed; mask, query and arguments are aligned, of the headers' size,
        // and this thread's own.
        unsafe { sys::rtcIntersect8(mask.0.as_ptr(), self.as_raw(), &raw mut query, arguments) };
        let (ray, hit) = (&query.ray, &query.hit);
        packet.ray.tfar[lanes.clone()].copy_from_slice(&ray.tfar);
        packet.hit.u[lanes.clone()].copy_from_slice(&hit.u);
        packet.hit.v[lanes.clone()].copy_from_slice(&hit.v);
        packet.hit.Ng_x[lanes.clone()].copy_from_slice(&hit.Ng_x);
        packet.hit.Ng_y[lanes.clone()].copy_from_slice(&hit.Ng_y);
        packet.hit.Ng_z[lanes.clone()].copy_from_slice(&hit.Ng_z);
        packet.hit.geomID[lanes.clone()].copy_from_slice(&hit.geomID);
        packet.hit.primID[lanes].copy_from_slice(&hit.primID);
    }
}

/// Puts the rays into Embree's layout, none of which has hit anything.
fn load(query: &mut sys::RTCRayHit16, rays: &RayPacket) {
    let sys::RTCRayHit16 { ray, hit } = query;
    [ray.org_x, ray.org_y, ray.org_z] = rays.origin;
    [ray.dir_x, ray.dir_y, ray.dir_z] = rays.dir;
    for (end, &t_max) in ray.tfar.iter_mut().zip(&rays.t_max) {
        *end = end_inside(t_max);
    }
    hit.geomID = [sys::RTC_INVALID_GEOMETRY_ID; PACKET];
}

/// One number a lane, as Embree wants them: -1 where it may be asked; see [`super::scene::is_ray`].
#[repr(C, align(64))]
struct Valid([i32; PACKET]);

fn valid(rays: &RayPacket) -> Valid {
    let RayPacket { origin: [ox, oy, oz], dir: [dx, dy, dz], t_max, len } = rays;
    let mut valid = Valid([0; PACKET]);
    for (lane, valid) in valid.0.iter_mut().enumerate() {
        // 0 unless one of them is infinite or no number: then it is NaN.
        let origin = 0.0 * ox[lane] + 0.0 * oy[lane] + 0.0 * oz[lane];
        let finite = origin + 0.0 * dx[lane] + 0.0 * dy[lane] + 0.0 * dz[lane];
        *valid = -i32::from((finite == 0.0) & (t_max[lane] > 0.0) & (lane < *len));
    }
    valid
}

fn arguments(coherence: Coherence) -> sys::RTCIntersectArguments {
    let flags = match coherence {
        Coherence::Incoherent => sys::RTC_RAY_QUERY_FLAG_INCOHERENT,
        Coherence::Coherent => sys::RTC_RAY_QUERY_FLAG_COHERENT,
    };
    let feature_mask = sys::RTC_FEATURE_FLAG_ALL;
    sys::RTCIntersectArguments {
        flags,
        feature_mask,
        context: ptr::null_mut(),
        filter: None,
        intersect: None,
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Device, SceneBuilder, Sphere};
    use super::*;
    use crate::math::{Rng, Stream, warp};

    const KINDS: [(PacketWidth, Coherence); 4] = [
        (PacketWidth::Eight, Coherence::Incoherent),
        (PacketWidth::Eight, Coherence::Coherent),
        (PacketWidth::Sixteen, Coherence::Incoherent),
        (PacketWidth::Sixteen, Coherence::Coherent),
    ];

    fn point_in_cube(rng: &mut Rng) -> Vec3 {
        2.0 * Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32()) - 1.0
    }

    fn triangles_and_balls() -> Scene {
        let mut rng = Rng::new(2, Stream::Test, 0, 0);
        let vertices: Vec<Vec3> = (0..300).map(|_| point_in_cube(&mut rng)).collect();
        let triangles: Vec<[u32; 3]> = (0..100).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        let balls: Vec<Sphere> =
            (0..9).map(|_| Sphere { center: point_in_cube(&mut rng), radius: 0.1 }).collect();
        let mut builder = SceneBuilder::new(&Device::new().unwrap()).unwrap();
        builder.add_triangles(&vertices, &triangles).unwrap();
        builder.add_spheres(&balls).unwrap();
        builder.commit().unwrap()
    }

    fn random_rays(count: u64) -> Vec<Ray> {
        let ray = |index| {
            let mut rng = Rng::new(3, Stream::Test, 0, index);
            Ray::new(1.5 * point_in_cube(&mut rng), warp::square_to_uniform_sphere(rng.next_vec2()))
        };
        (0..count).map(ray).collect()
    }

    fn numbers(hits: &[Option<Hit>]) -> Vec<Option<(u32, u32)>> {
        hits.iter().map(|hit| hit.map(|hit| (hit.geometry, hit.primitive))).collect()
    }

    /// Every length of the last packet, from nothing to a full one.
    #[test]
    fn packets_hit_what_single_rays_hit() {
        let scene = triangles_and_balls();
        for count in (0..=17).chain([20_000]) {
            let rays = random_rays(count);
            let single: Vec<Option<Hit>> = rays.iter().map(|ray| scene.intersect(ray)).collect();
            for (width, coherence) in KINDS {
                let mut hits = vec![None; rays.len()];
                scene.intersect_packets(&rays, &mut hits, width, coherence);
                assert_eq!(numbers(&hits), numbers(&single), "{width:?} {coherence:?}");
                for (a, b) in hits.iter().flatten().zip(single.iter().flatten()) {
                    assert!((a.t - b.t).abs() < 1e-5 && (a.u - b.u).abs() < 1e-4, "{a:?} {b:?}");
                    assert!((a.v - b.v).abs() < 1e-4 && a.ng.distance(b.ng) < 1e-4, "{a:?} {b:?}");
                }
            }
        }
    }

    /// What a lane held before must not show: a ray that is none leaves no hit in its lane.
    #[test]
    fn rays_that_are_no_rays_hit_nothing_and_leave_their_neighbours_alone() {
        let scene = triangles_and_balls();
        let mut rays = random_rays(64);
        for ray in rays.iter_mut().step_by(3) {
            ray.dir.y = f32::NAN;
        }
        rays[1].t_max = 0.0;
        let single: Vec<Option<Hit>> = rays.iter().map(|ray| scene.intersect(ray)).collect();
        assert!(single.iter().flatten().count() > 5);
        for (width, coherence) in KINDS {
            let mut hits = single.iter().rev().copied().collect::<Vec<_>>();
            scene.intersect_packets(&rays, &mut hits, width, coherence);
            assert_eq!(numbers(&hits), numbers(&single), "{width:?} {coherence:?}");
        }
    }
}
