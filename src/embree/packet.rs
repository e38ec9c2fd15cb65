//! Rays that Embree traces several at a time.

use std::ptr;

use super::scene::{Hit, Scene, end_inside, is_ray};
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
        let mut arguments = arguments(coherence);
        match width {
            PacketWidth::Eight => {
                for (rays, hits) in rays.chunks(8).zip(hits.chunks_mut(8)) {
                    intersect8(self.as_raw(), rays, hits, &mut arguments);
                }
            }
            PacketWidth::Sixteen => {
                for (rays, hits) in rays.chunks(16).zip(hits.chunks_mut(16)) {
                    intersect16(self.as_raw(), rays, hits, &mut arguments);
                }
            }
        }
    }
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

/// One call of Embree for up to as many rays as it has lanes; the rest of the lanes stay idle.
macro_rules! intersect_packet {
    ($name:ident, $lanes:literal, $query:ident, $call:ident) => {
        fn $name(
            scene: sys::RTCScene,
            rays: &[Ray],
            hits: &mut [Option<Hit>],
            arguments: &mut sys::RTCIntersectArguments,
        ) {
            #[repr(C, align(64))]
            struct Valid([i32; $lanes]);
            let mut valid = Valid([0; $lanes]);
            // SAFETY: plain numbers, for which zero is a value.
            let mut query: sys::$query = unsafe { std::mem::zeroed() };
            for (lane, ray) in rays.iter().enumerate() {
                valid.0[lane] = -i32::from(is_ray(ray));
                query.ray.org_x[lane] = ray.origin.x;
                query.ray.org_y[lane] = ray.origin.y;
                query.ray.org_z[lane] = ray.origin.z;
                query.ray.tnear[lane] = f32::MIN_POSITIVE;
                query.ray.dir_x[lane] = ray.dir.x;
                query.ray.dir_y[lane] = ray.dir.y;
                query.ray.dir_z[lane] = ray.dir.z;
                query.ray.tfar[lane] = end_inside(ray);
            }
            query.ray.mask = [u32::MAX; $lanes];
            query.hit.geomID = [sys::RTC_INVALID_GEOMETRY_ID; $lanes];
            query.hit.instID = [[u32::MAX; $lanes]];
            query.hit.instPrimID = [[u32::MAX; $lanes]];
            // SAFETY: the scene is alive and committed; mask, query and arguments are aligned, of the headers' size,
            // and this thread's own.
            unsafe { sys::$call(valid.0.as_ptr(), scene, &raw mut query, arguments) };
            let (ray, hit) = (&query.ray, &query.hit);
            for (lane, found) in hits.iter_mut().enumerate() {
                *found = (hit.geomID[lane] != sys::RTC_INVALID_GEOMETRY_ID).then(|| Hit {
                    t: ray.tfar[lane],
                    u: hit.u[lane],
                    v: hit.v[lane],
                    ng: Vec3::new(hit.Ng_x[lane], hit.Ng_y[lane], hit.Ng_z[lane]),
                    geometry: hit.geomID[lane],
                    primitive: hit.primID[lane],
                });
            }
        }
    };
}

intersect_packet!(intersect8, 8, RTCRayHit8, rtcIntersect8);
intersect_packet!(intersect16, 16, RTCRayHit16, rtcIntersect16);

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
