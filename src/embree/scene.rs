use std::ptr;

use super::scene_handle::SceneHandle;
use super::{GeometryId, sys};
use crate::math::{Aabb, Ray, Vec3};

/// Where a ray first meets a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The ray parameter: the distance in lengths of the ray's direction.
    pub t: f32,
    /// The barycentric weight of the triangle's second vertex; 0 on a sphere.
    pub u: f32,
    /// The barycentric weight of the triangle's third vertex; 0 on a sphere.
    pub v: f32,
    /// The geometric normal, not of unit length: `(v1 - v0) x (v2 - v0)` of a triangle, outward on a sphere.
    pub ng: Vec3,
    /// The geometry that was hit.
    pub geometry: GeometryId,
    /// The number of the triangle or sphere within its geometry.
    pub primitive: u32,
}

/// A committed scene: immutable, and free to be asked from any number of threads.
///
/// It shares nothing mutable with the device or the slices that it was made from, and outlives both.
#[derive(Debug)]
pub struct Scene {
    handle: SceneHandle,
    bounds: Aabb,
}

// SAFETY: Embree counts references atomically, and nothing else refers to the scene or its geometries.
unsafe impl Send for Scene {}
// SAFETY: a committed scene is only ever read; Embree's queries on it may run at the same time.
unsafe impl Sync for Scene {}

impl Scene {
    /// Takes a scene that has been committed.
    pub(super) fn new(handle: SceneHandle) -> Scene {
        let bounds = handle.bounds();
        Scene { handle, bounds }
    }

    /// The nearest hit with `t` in `(0, t_max)`, whichever side of the surface it is on.
    ///
    /// Nothing is hit by a ray whose origin or direction is not finite, or whose `t_max` is not positive.
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        let mut query = sys::RTCRayHit { ray: to_embree(ray)?, hit: NO_HIT };
        // SAFETY: the scene is alive and committed; the query is aligned, of the headers' size, and this thread's own.
        unsafe { sys::rtcIntersect1(self.handle.as_raw(), &raw mut query, ptr::null_mut()) };
        let sys::RTCRayHit { ray, hit } = query;
        (hit.geomID != sys::RTC_INVALID_GEOMETRY_ID).then(|| Hit {
            t: ray.tfar,
            u: hit.u,
            v: hit.v,
            ng: Vec3::new(hit.Ng_x, hit.Ng_y, hit.Ng_z),
            geometry: hit.geomID,
            primitive: hit.primID,
        })
    }

    /// Whether anything is hit with `t` in `(0, t_max)`: cheaper than [`Scene::intersect`], since any hit will do.
    ///
    /// False for a ray whose origin or direction is not finite, or whose `t_max` is not positive.
    pub fn occluded(&self, ray: &Ray) -> bool {
        let Some(mut query) = to_embree(ray) else { return false };
        // SAFETY: the scene is alive and committed; the query is aligned, of the headers' size, and this thread's own.
        unsafe { sys::rtcOccluded1(self.handle.as_raw(), &raw mut query, ptr::null_mut()) };
        query.tfar == f32::NEG_INFINITY
    }

    pub(super) fn as_raw(&self) -> sys::RTCScene {
        self.handle.as_raw()
    }

    /// The box around all geometries; [`Aabb::EMPTY`] when there are none.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }
}

const NO_HIT: sys::RTCHit = sys::RTCHit {
    Ng_x: 0.0,
    Ng_y: 0.0,
    Ng_z: 0.0,
    u: 0.0,
    v: 0.0,
    primID: u32::MAX,
    geomID: sys::RTC_INVALID_GEOMETRY_ID,
    instID: [u32::MAX],
    instPrimID: [u32::MAX],
};

/// Whether Embree may be asked: any other ray makes it walk its whole tree.
fn is_ray(ray: &Ray) -> bool {
    ray.origin.is_finite() && ray.dir.is_finite() && ray.t_max > 0.0
}

/// Embree's ends belong to the segment, those of a `Ray` do not.
pub(super) fn end_inside(t_max: f32) -> f32 {
    t_max.next_down()
}

/// The ray in Embree's layout; none for a ray that would make it walk the whole tree.
fn to_embree(ray: &Ray) -> Option<sys::RTCRay> {
    is_ray(ray).then(|| sys::RTCRay {
        org_x: ray.origin.x,
        org_y: ray.origin.y,
        org_z: ray.origin.z,
        tnear: f32::MIN_POSITIVE,
        dir_x: ray.dir.x,
        dir_y: ray.dir.y,
        dir_z: ray.dir.z,
        time: 0.0,
        tfar: end_inside(ray.t_max),
        // Zero would see no geometry at all.
        mask: u32::MAX,
        id: 0,
        flags: 0,
    })
}

#[cfg(test)]
mod tests {
    use super::super::{Device, SceneBuilder, Sphere};
    use super::*;
    use crate::math::{Rng, Stream, warp};

    const CORNERS: [Vec3; 3] = [Vec3::ZERO, Vec3::new(2.0, 0.0, 0.0), Vec3::new(0.0, 2.0, 0.0)];
    const BALL: Sphere = Sphere { center: Vec3::new(3.0, -1.0, 2.0), radius: 0.5 };

    fn scene(add: impl FnOnce(&mut SceneBuilder)) -> Scene {
        let mut builder = SceneBuilder::new(&Device::new().unwrap()).unwrap();
        add(&mut builder);
        builder.commit().unwrap()
    }

    fn mesh_scene(vertices: &[Vec3], triangles: &[[u32; 3]]) -> Scene {
        scene(|builder| {
            builder.add_triangles(vertices, triangles).unwrap();
        })
    }

    fn one_triangle() -> Scene {
        mesh_scene(&CORNERS, &[[0, 1, 2]])
    }

    fn one_ball() -> Scene {
        scene(|builder| {
            builder.add_spheres(&[BALL]).unwrap();
        })
    }

    fn rng(index: u64) -> Rng {
        Rng::new(1, Stream::Test, 0, index)
    }

    fn point_in_cube(rng: &mut Rng) -> Vec3 {
        2.0 * Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32()) - 1.0
    }

    fn random_mesh(n_triangles: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let mut rng = rng(1 << 40);
        let vertices = (0..3 * n_triangles).map(|_| point_in_cube(&mut rng)).collect();
        (vertices, (0..n_triangles).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
    }

    fn random_ray(index: u64) -> Ray {
        let mut rng = rng(index);
        Ray::new(1.5 * point_in_cube(&mut rng), warp::square_to_uniform_sphere(rng.next_vec2()))
    }

    #[test]
    fn a_triangle_is_hit_from_both_sides_with_the_normal_of_its_winding() {
        let scene = one_triangle();
        for (origin, dir) in [(Vec3::new(0.5, 0.25, 4.0), Vec3::NEG_Z), (Vec3::new(0.5, 0.25, -4.0), Vec3::Z)]
        {
            let hit = scene.intersect(&Ray::new(origin, 2.0 * dir)).unwrap();
            assert_eq!((hit.t, hit.geometry, hit.primitive), (2.0, 0, 0));
            assert_eq!((hit.u, hit.v), (0.25, 0.125));
            assert_eq!(hit.ng, Vec3::new(0.0, 0.0, 4.0));
        }
        assert_eq!(scene.intersect(&Ray::new(Vec3::new(1.5, 1.5, 4.0), Vec3::NEG_Z)), None);
        assert_eq!(scene.intersect(&Ray::new(Vec3::new(0.5, 0.25, 4.0), Vec3::Z)), None);
    }

    #[test]
    fn both_ends_of_a_ray_are_open() {
        let scene = one_triangle();
        let ray = |z, t_max| Ray { origin: Vec3::new(0.5, 0.25, z), dir: Vec3::NEG_Z, t_max };
        assert!(scene.occluded(&ray(4.0, 4.0_f32.next_up())));
        assert!(!scene.occluded(&ray(4.0, 4.0)));
        assert!(scene.intersect(&ray(4.0, 4.0)).is_none());
        assert!(scene.intersect(&ray(0.0, 4.0)).is_none());
        let on_the_ball = BALL.center + Vec3::new(0.0, 0.0, BALL.radius);
        let through = one_ball().intersect(&Ray::new(on_the_ball, Vec3::NEG_Z)).unwrap();
        assert!((through.t - 1.0).abs() < 1e-6, "{through:?}");
    }

    /// The exact hit distance along a unit direction, nearest first; in f64 on the f32 numbers that Embree sees.
    fn ball_distance(ray: &Ray) -> f64 {
        let (from_center, dir) = ((ray.origin.as_dvec3() - BALL.center.as_dvec3()), ray.dir.as_dvec3());
        let (a, b) = (dir.length_squared(), from_center.dot(dir));
        let c = from_center.length_squared() - f64::from(BALL.radius).powi(2);
        let root = (b * b - a * c).sqrt();
        let near = (-b - root) / a;
        if near > 0.0 { near } else { (-b + root) / a }
    }

    /// Rays from `distance` radii away at points well inside the ball, so that no rounding decides on a miss.
    fn ray_at_ball(index: u64, distance: f32) -> Ray {
        let mut rng = rng(index);
        let mut offset = |length| length * BALL.radius * warp::square_to_uniform_sphere(rng.next_vec2());
        let origin = BALL.center + offset(distance);
        Ray::new(origin, (BALL.center + offset(0.9) - origin).normalize())
    }

    #[test]
    fn sphere_hits_are_accurate_from_outside_and_inside() {
        let scene = one_ball();
        for (distance, tolerance) in [(3.0, 6e-6), (0.95, 2e-6), (0.3, 1e-6)] {
            for ray in (0..100_000).map(|index| ray_at_ball(index, distance)) {
                let hit = scene.intersect(&ray).unwrap();
                let error = (f64::from(hit.t) - ball_distance(&ray)).abs() / f64::from(BALL.radius);
                assert!(error < tolerance, "{ray:?} {hit:?} is off by {error} radii");
                let outward = (ray.at(hit.t) - BALL.center).normalize();
                assert!(hit.ng.normalize().dot(outward) > 0.99999, "{ray:?} {hit:?}");
                assert_eq!((hit.u, hit.v), (0.0, 0.0));
                assert!(scene.occluded(&ray));
            }
        }
    }

    #[test]
    fn rays_past_a_sphere_miss_it() {
        let scene = one_ball();
        let past = |offset| Ray::new(BALL.center + Vec3::new(offset, 0.0, 9.0), Vec3::NEG_Z);
        assert!(scene.occluded(&past(0.499)) && !scene.occluded(&past(0.501)));
        let away = Ray::new(BALL.center + Vec3::new(0.0, 0.0, 9.0), Vec3::Z);
        assert_eq!(scene.intersect(&away), None);
    }

    #[test]
    fn rays_that_are_no_rays_hit_nothing() {
        let scene = scene(|builder| {
            builder.add_triangles(&CORNERS, &[[0, 1, 2]]).unwrap();
            builder.add_spheres(&[Sphere { center: Vec3::ZERO, radius: 2.0 }]).unwrap();
        });
        let good = Ray::new(Vec3::new(0.5, 0.25, 1.0), Vec3::NEG_Z);
        assert!(scene.occluded(&good));
        let mut bad: Vec<Ray> = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY]
            .into_iter()
            .flat_map(|x| {
                [Ray { origin: Vec3::splat(x), ..good }, Ray { dir: Vec3::new(0.0, x, 1.0), ..good }]
            })
            .collect();
        bad.extend([0.0, -1.0, f32::NAN].map(|t_max| Ray { t_max, ..good }));
        assert!(bad.iter().all(|ray| to_embree(ray).is_none()), "Embree would walk its whole tree");
        bad.push(Ray { dir: Vec3::ZERO, ..good });
        for ray in bad {
            assert_eq!(scene.intersect(&ray), None, "{ray:?}");
            assert!(!scene.occluded(&ray), "{ray:?}");
        }
    }

    /// Möller and Trumbore's test against one triangle, in f64.
    fn naive_distance(ray: &Ray, [a, b, c]: [Vec3; 3]) -> Option<f64> {
        let (a, b, c) = (a.as_dvec3(), b.as_dvec3(), c.as_dvec3());
        let (origin, dir) = (ray.origin.as_dvec3(), ray.dir.as_dvec3());
        let (e1, e2) = (b - a, c - a);
        let p = dir.cross(e2);
        let s = origin - a;
        let q = s.cross(e1);
        let det = e1.dot(p);
        let (u, v, t) = (s.dot(p) / det, dir.dot(q) / det, e2.dot(q) / det);
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0).then_some(t)
    }

    fn naive_hit(ray: &Ray, vertices: &[Vec3], triangles: &[[u32; 3]]) -> Option<(u32, f64)> {
        let distances = (0u32..).zip(triangles).filter_map(|(number, corners)| {
            Some((number, naive_distance(ray, corners.map(|corner| vertices[corner as usize]))?))
        });
        distances.min_by(|a, b| a.1.total_cmp(&b.1))
    }

    #[test]
    fn random_rays_hit_what_a_naive_search_finds() {
        let (vertices, triangles) = random_mesh(200);
        let scene = mesh_scene(&vertices, &triangles);
        let n_rays = 100_000;
        let (mut n_hits, mut n_disagreements) = (0, 0);
        for ray in (0..n_rays).map(random_ray) {
            let hit = scene.intersect(&ray);
            assert_eq!(scene.occluded(&ray), hit.is_some(), "{ray:?}");
            let agree = match (hit, naive_hit(&ray, &vertices, &triangles)) {
                (Some(hit), Some((primitive, t))) => {
                    n_hits += 1;
                    hit.primitive == primitive && (f64::from(hit.t) - t).abs() < 1e-4
                }
                (None, None) => true,
                _ => false,
            };
            n_disagreements += u32::from(!agree);
        }
        println!("{n_disagreements} of {n_rays} rays disagree, {n_hits} hit");
        assert!(n_hits > 25_000 && n_disagreements < 10, "{n_disagreements} of {n_hits}");
    }

    #[test]
    fn the_point_of_a_hit_follows_from_its_barycentric_weights() {
        let (vertices, triangles) = random_mesh(50);
        let scene = mesh_scene(&vertices, &triangles);
        for ray in (0..1000).map(random_ray) {
            let Some(hit) = scene.intersect(&ray) else { continue };
            let [a, b, c] = triangles[hit.primitive as usize].map(|corner| vertices[corner as usize]);
            let on_triangle = (1.0 - hit.u - hit.v) * a + hit.u * b + hit.v * c;
            assert!(on_triangle.distance(ray.at(hit.t)) < 1e-4, "{ray:?} {hit:?}");
            let normal = (b - a).cross(c - a);
            assert!(hit.ng.distance(normal) < 1e-5, "{ray:?} {hit:?} {normal}");
        }
    }

    #[test]
    fn geometries_of_both_kinds_are_told_apart() {
        let scene = scene(|builder| {
            builder.add_triangles(&CORNERS, &[[0, 1, 2]]).unwrap();
            builder.add_spheres(&[Sphere { center: Vec3::NEG_Z * 50.0, radius: 1.0 }, BALL]).unwrap();
        });
        let down = |x, y| scene.intersect(&Ray::new(Vec3::new(x, y, 9.0), Vec3::NEG_Z));
        let numbers = |hit: Option<Hit>| hit.map(|hit| (hit.geometry, hit.primitive));
        assert_eq!(numbers(down(0.5, 0.5)), Some((0, 0)));
        assert_eq!(numbers(down(BALL.center.x, BALL.center.y)), Some((1, 1)));
        assert_eq!(numbers(down(-0.5, 0.0)), Some((1, 0)));
        assert_eq!(numbers(down(-5.0, 0.0)), None);
    }

    #[test]
    fn bounds_enclose_everything_tightly() {
        assert_eq!(scene(|_| ()).bounds(), Aabb::EMPTY);
        assert_eq!(one_triangle().bounds(), Aabb::of_points(CORNERS));
        assert_eq!(one_ball().bounds(), Aabb::of_sphere(BALL.center, BALL.radius));
    }

    #[test]
    fn an_empty_scene_is_missed() {
        assert_eq!(scene(|_| ()).intersect(&Ray::new(Vec3::ZERO, Vec3::X)), None);
    }

    #[test]
    fn scenes_outlive_their_device_and_each_other() {
        let device = Device::new().unwrap();
        let build = || {
            let mut builder = SceneBuilder::new(&device).unwrap();
            builder.add_spheres(&[BALL]).unwrap();
            builder.commit().unwrap()
        };
        let (first, second) = (build(), build());
        drop(device);
        let expected = first.intersect(&ray_at_ball(0, 3.0));
        assert!(expected.is_some());
        drop(first);
        assert_eq!(second.intersect(&ray_at_ball(0, 3.0)), expected);
    }

    #[test]
    fn threads_get_the_same_answers() {
        fn crosses<T: Send + Sync>() {}
        crosses::<Scene>();
        let (vertices, triangles) = random_mesh(200);
        let scene = mesh_scene(&vertices, &triangles);
        let ask = || (0..20_000).map(|index| scene.intersect(&random_ray(index))).collect::<Vec<_>>();
        let expected = ask();
        std::thread::scope(|scope| {
            let answers: Vec<_> = (0..4).map(|_| scope.spawn(ask)).collect();
            assert!(answers.into_iter().all(|answer| answer.join().unwrap() == expected));
        });
    }

    /// A bumpy square of `n` by `n` vertices and twice as many triangles.
    fn height_field(n: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let height = |x: f32, y: f32| (0.5 * x).sin() * (0.3 * y).cos();
        let grid = || (0..n).flat_map(|y| (0..n).map(move |x| (x, y)));
        let vertices = grid().map(|(x, y)| (x as f32, y as f32)).map(|(x, y)| Vec3::new(x, y, height(x, y)));
        let cells = grid().filter(|&(x, y)| x + 1 < n && y + 1 < n).map(|(x, y)| y * n + x);
        let triangles = cells.flat_map(|a| [[a, a + 1, a + n], [a + 1, a + n + 1, a + n]]);
        (vertices.collect(), triangles.collect())
    }

    /// Rays down onto inner vertices tie between six triangles: the structure decides.
    #[test]
    fn ties_are_broken_alike_by_every_build() {
        let (vertices, triangles) = height_field(200);
        let answers = || {
            let scene = mesh_scene(&vertices, &triangles);
            let down = |v: &Vec3| scene.intersect(&Ray::new(v.with_z(9.0), Vec3::NEG_Z));
            vertices.iter().map(down).collect::<Vec<_>>()
        };
        let expected = answers();
        assert!(expected.iter().flatten().count() > 198 * 198);
        assert!((0..3).all(|_| answers() == expected));
    }

    #[test]
    fn no_ray_slips_through_between_adjacent_triangles() {
        let n = 20;
        let (vertices, triangles) = height_field(n);
        let scene = mesh_scene(&vertices, &triangles);
        let is_inner = |c: u32| (1..n - 1).contains(&(c % n)) && (1..n - 1).contains(&(c / n));
        let edges: Vec<_> =
            triangles.iter().map(|&[a, b, _]| [a, b]).filter(|e| e.map(is_inner) == [true; 2]).collect();
        for index in 0..100_000 {
            let mut rng = rng(index);
            let [a, b] = edges[index as usize % edges.len()].map(|corner| vertices[corner as usize]);
            let target = a.lerp(b, rng.next_f32());
            let origin = target + Vec3::new(rng.next_f32(), rng.next_f32(), 3.0);
            let ray = Ray::new(origin, target - origin);
            assert!(scene.occluded(&ray), "{ray:?}");
        }
    }
}
