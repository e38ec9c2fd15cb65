//! The tree of triangles and spheres: what does a ray hit?

use super::prepared_ray::PreparedRay;
use super::ray_hit::RayHit;
use super::walk::{Any, Nearest, Query, stack_size, walk};
use super::wide::WideTree;
use crate::math::Ray;

/// Entries on the stack of a walk, for trees as they mostly are and for the deepest that the builder makes.
const SMALL_STACK: usize = stack_size(20);
const LARGE_STACK: usize = stack_size(72);

/// Triangles and spheres in a tree: immutable, and free to be asked from any number of threads.
#[derive(Clone, Debug)]
pub struct RayBvh {
    tree: WideTree,
    /// The largest absolute coordinate.
    extent: f32,
}

impl RayBvh {
    /// Of a tree whose largest absolute coordinate is `extent`.
    pub(super) fn new(tree: WideTree, extent: f32) -> RayBvh {
        RayBvh { tree, extent }
    }

    /// The nearest hit with `t` in `(0, t_max)`, whichever side of the surface it is on; among equals the one of
    /// the lowest geometry, and of the lowest primitive there.
    ///
    /// No ray slips through between triangles that share an edge or a vertex. Nothing is hit by a ray whose origin or
    /// direction is not finite, or whose `t_max` is not positive.
    pub fn intersect(&self, ray: &Ray) -> Option<RayHit> {
        let ray = PreparedRay::new(ray, self.extent)?;
        let mut nearest = Nearest::new(&ray);
        self.walk(&ray, &mut nearest);
        nearest.hit
    }

    /// Whether there is a hit with `t` in `(0, t_max)`.
    pub fn occluded(&self, ray: &Ray) -> bool {
        PreparedRay::new(ray, self.extent).is_some_and(|ray| {
            let mut any = Any::new(&ray);
            self.walk(&ray, &mut any);
            any.found
        })
    }

    /// The memory that the tree and its primitives hold, in bytes.
    pub fn memory_bytes(&self) -> usize {
        self.tree.memory_bytes()
    }

    fn walk(&self, ray: &PreparedRay, query: &mut impl Query) {
        if stack_size(self.tree.levels) <= SMALL_STACK {
            walk::<SMALL_STACK, _>(&self.tree, ray, query);
        } else {
            walk::<LARGE_STACK, _>(&self.tree, ray, query);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::primitive::Shape;
    use crate::bvh::test_sets::on_threads;
    use crate::bvh::{RayBvhBuilder, Sphere};
    use crate::math::{DVec3, Rng, Stream, Vec3, warp};
    use proptest::prelude::*;

    fn bvh(primitives: &[Shape]) -> RayBvh {
        let mut builder = RayBvhBuilder::new();
        for shape in primitives {
            match *shape {
                Shape::Triangle(corners) => builder.add_triangles(&corners, &[[0, 1, 2]]).unwrap(),
                Shape::Sphere(sphere) => builder.add_spheres(&[sphere]).unwrap(),
            };
        }
        builder.build()
    }

    fn mesh(vertices: &[Vec3], triangles: &[[u32; 3]]) -> RayBvh {
        let mut builder = RayBvhBuilder::new();
        builder.add_triangles(vertices, triangles).unwrap();
        builder.build()
    }

    /// In a plain loop: each primitive has a tree of its own.
    struct Naive(Vec<RayBvh>);

    impl Naive {
        fn new(primitives: &[Shape]) -> Naive {
            Naive(primitives.iter().map(|shape| bvh(&[*shape])).collect())
        }

        fn intersect(&self, ray: &Ray) -> Option<RayHit> {
            let numbered = (0..).zip(&self.0);
            let hits =
                numbered.filter_map(|(geometry, one)| Some(RayHit { geometry, ..one.intersect(ray)? }));
            hits.min_by(|a, b| a.t.total_cmp(&b.t).then(a.geometry.cmp(&b.geometry)))
        }
    }

    fn rng(index: u64) -> Rng {
        Rng::new(4, Stream::Test, 9, index)
    }

    fn in_cube(rng: &mut Rng) -> Vec3 {
        2.0 * Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32()) - 1.0
    }

    /// Rays among the cube's contents; every fourth along an axis, some of any length, every other one with an end.
    fn ray(index: u64) -> Ray {
        let mut rng = rng(index);
        let (origin, mut dir) = (1.5 * in_cube(&mut rng), warp::square_to_uniform_sphere(rng.next_vec2()));
        if index.is_multiple_of(4) {
            dir = Vec3::AXES[index as usize / 4 % 3] * dir.x.signum();
        }
        let length = [1.0, 1e-12, 1e12][index as usize % 3];
        let t_max = if index.is_multiple_of(2) { f32::INFINITY } else { rng.next_f32() / length };
        Ray { origin, dir: length * dir, t_max }
    }

    /// Triangles and spheres of all sizes; some twice, some on a grid, where rays meet edges and vertices exactly.
    fn shapes(n: usize, seed: u64) -> Vec<Shape> {
        let mut rng = rng(seed.wrapping_mul(1 << 32));
        let mut shapes = Vec::new();
        for _ in 0..n {
            let (center, size) = (in_cube(&mut rng), 0.7 * rng.next_f32().powi(4) + 1e-3);
            let mut corner = || center + size * in_cube(&mut rng);
            let triangle = Shape::Triangle([corner(), corner(), corner()]);
            shapes.push(match (rng.next_u32() % 5, triangle, shapes.last()) {
                (0, ..) => Shape::Sphere(Sphere { center, radius: size }),
                (1, _, Some(before)) => *before,
                (2, Shape::Triangle(corners), _) => Shape::Triangle(corners.map(|c| (4.0 * c).round() / 4.0)),
                _ => triangle,
            });
        }
        shapes
    }

    proptest! {
        #[test]
        fn rays_hit_what_the_naive_search_finds(n in 0usize..120, seed: u64, first: u32) {
            let shapes = shapes(n, seed);
            let (tree, naive) = (bvh(&shapes), Naive::new(&shapes));
            for index in 0..200 {
                let ray = ray(u64::from(first) + index);
                let hit = tree.intersect(&ray);
                prop_assert_eq!(hit, naive.intersect(&ray), "{:?}", ray);
                prop_assert_eq!(tree.occluded(&ray), hit.is_some(), "{:?}", ray);
            }
        }
    }

    /// Möller and Trumbore's test and the quadratic formula, in f64.
    fn exact_distance(ray: &Ray, shape: &Shape) -> Option<f64> {
        let (origin, dir) = (ray.origin.as_dvec3(), ray.dir.as_dvec3());
        let t = match shape {
            Shape::Triangle(corners) => {
                let [a, b, c] = corners.map(Vec3::as_dvec3);
                let (e1, e2, s) = (b - a, c - a, origin - a);
                let (p, q) = (dir.cross(e2), s.cross(e1));
                let det = e1.dot(p);
                let (u, v) = (s.dot(p) / det, dir.dot(q) / det);
                (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then(|| e2.dot(q) / det)
            }
            Shape::Sphere(Sphere { center, radius }) => {
                let f: DVec3 = origin - center.as_dvec3();
                let (a, b, c) = (dir.dot(dir), f.dot(dir), f.dot(f) - f64::from(*radius).powi(2));
                let root = (b * b - a * c).sqrt();
                [(-b - root) / a, (-b + root) / a].into_iter().find(|t| *t > 0.0)
            }
        };
        t.filter(|t| *t > 0.0 && *t < f64::from(ray.t_max))
    }

    /// On a grid rays meet edges, where two kinds of arithmetic may disagree, so all shapes are random here.
    #[test]
    fn hits_are_those_of_exact_arithmetic() {
        let shapes: Vec<Shape> = shapes(400, 1).into_iter().filter(|s| !on_grid(s)).collect();
        let tree = bvh(&shapes);
        let (n_rays, mut n_hits, mut n_disagreements) = (100_000, 0, 0);
        for ray in (0..n_rays).map(ray) {
            let exact = shapes.iter().filter_map(|shape| exact_distance(&ray, shape)).min_by(f64::total_cmp);
            let agree = match (tree.intersect(&ray), exact) {
                (Some(hit), Some(t)) => {
                    n_hits += 1;
                    (f64::from(hit.t) / t - 1.0).abs() < 1e-5
                }
                (None, None) => true,
                _ => false,
            };
            n_disagreements += u32::from(!agree);
        }
        assert!(n_hits > 30_000 && n_disagreements < 10, "{n_disagreements} of {n_hits}");
    }

    fn on_grid(shape: &Shape) -> bool {
        matches!(shape, Shape::Triangle(corners) if corners.iter().all(|c| (4.0 * *c).fract() == Vec3::ZERO))
    }

    #[test]
    fn a_hit_tells_where_on_the_triangle_it_is() {
        let shapes: Vec<Shape> = shapes(300, 2);
        let tree = bvh(&shapes);
        let mut n_triangles = 0;
        for ray in (0..100_000).map(ray) {
            let Some(hit) = tree.intersect(&ray) else { continue };
            let Shape::Triangle([a, b, c]) = shapes[hit.geometry as usize] else { continue };
            n_triangles += 1;
            let p = (1.0 - hit.u - hit.v) * a + hit.u * b + hit.v * c;
            assert!(p.distance(ray.at(hit.t)) < 1e-5, "{ray:?} {hit:?}");
            assert_eq!(hit.ng, (b - a).cross(c - a));
        }
        assert!(n_triangles > 1000, "only {n_triangles}");
    }

    /// A bumpy ball of `8 · 4ⁿ` triangles around the origin: an octahedron, subdivided.
    fn closed_mesh(subdivisions: u32, bump: f32) -> (Vec<Vec3>, Vec<[Vec3; 3]>) {
        let sign = |octant: usize, bit: usize| if octant & bit == 0 { 1.0 } else { -1.0 };
        let octant = |k| [sign(k, 1) * Vec3::X, sign(k, 2) * Vec3::Y, sign(k, 4) * Vec3::Z];
        let mut faces: Vec<[Vec3; 3]> = (0..8).map(octant).collect();
        for _ in 0..subdivisions {
            let four = |[a, b, c]: [Vec3; 3]| {
                let [ab, bc, ca] = [0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)];
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            };
            faces = faces.into_iter().flat_map(four).collect();
        }
        let radius = |p: Vec3| 1.0 + bump * (40.0 * p.x + 70.0 * p.y * p.z).sin();
        let faces: Vec<[Vec3; 3]> = faces.iter().map(|f| f.map(|p| p.normalize() * radius(p))).collect();
        (faces.concat(), faces)
    }

    fn assert_tight(tree: &RayBvh, origin: Vec3, target: Vec3) {
        let ray = Ray::new(origin, target - origin);
        assert!(tree.intersect(&ray).is_some() && tree.occluded(&ray), "leak: {ray:?}");
    }

    /// From inside at every vertex, at points on every edge, and along the axes.
    #[test]
    fn closed_meshes_do_not_leak() {
        for (scale, shift) in
            [(1.0, Vec3::ZERO), (1e6, Vec3::ZERO), (1e-6, Vec3::ZERO), (1.0, Vec3::splat(300.0))]
        {
            let (vertices, faces) = closed_mesh(4, 0.1);
            let place = |p: Vec3| scale * p + shift;
            let vertices: Vec<Vec3> = vertices.into_iter().map(place).collect();
            let triangles: Vec<[u32; 3]> =
                (0..faces.len() as u32).map(|k| [0, 1, 2].map(|i| 3 * k + i)).collect();
            let tree = mesh(&vertices, &triangles);
            for (index, face) in (0..).zip(&faces) {
                let mut rng = rng(index);
                let origins = [Vec3::ZERO, 0.4 * in_cube(&mut rng)].map(place);
                for origin in origins {
                    for k in 0..3 {
                        let (a, b) = (place(face[k]), place(face[(k + 1) % 3]));
                        assert_tight(&tree, origin, a);
                        (0..30).for_each(|_| assert_tight(&tree, origin, a.lerp(b, rng.next_f32())));
                    }
                }
            }
            let axes = [Vec3::AXES, [Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z]].concat();
            axes.into_iter().for_each(|axis| assert_tight(&tree, place(Vec3::ZERO), place(axis)));
        }
    }

    /// A flat sheet of squares on whole numbers: rays run exactly within planes, edges and boxes without thickness.
    #[test]
    fn flat_sheets_do_not_leak_at_their_lattice() {
        let n = 16;
        let at = |x: u32, y: u32| y * (n + 1) + x;
        let points = (0..=n).flat_map(|y| (0..=n).map(move |x| Vec3::new(x as f32, y as f32, 0.1)));
        let cells = (0..n).flat_map(|y| (0..n).map(move |x| (x, y)));
        let triangles = cells.flat_map(|(x, y)| {
            [[at(x, y), at(x + 1, y), at(x + 1, y + 1)], [at(x, y), at(x + 1, y + 1), at(x, y + 1)]]
        });
        let tree = mesh(&points.collect::<Vec<_>>(), &triangles.collect::<Vec<_>>());
        for k in 0..=4 * n {
            for l in 0..=4 * n {
                let target = Vec3::new(k as f32 / 4.0, l as f32 / 4.0, 0.1);
                for from in [Vec3::Z, Vec3::NEG_Z, Vec3::new(3.0, 0.0, 1.0), Vec3::new(-7.0, 5.0, -0.3)] {
                    let ray = Ray::new(target + 3.0 * from, -from);
                    let on_rim = k % (4 * n) == 0 || l % (4 * n) == 0;
                    assert!(tree.occluded(&ray) || (on_rim && from.x != 0.0), "leak: {ray:?}");
                }
            }
        }
    }

    const CORNERS: [Vec3; 3] = [Vec3::ZERO, Vec3::new(2.0, 0.0, 0.0), Vec3::new(0.0, 2.0, 0.0)];

    fn down(x: f32, y: f32) -> Ray {
        Ray::new(Vec3::new(x, y, 4.0), 2.0 * Vec3::NEG_Z)
    }

    #[test]
    fn none_one_and_two_primitives() {
        let (triangle, ball) =
            (Shape::Triangle(CORNERS), Shape::Sphere(Sphere { center: Vec3::X, radius: 0.25 }));
        assert_eq!(bvh(&[]).intersect(&down(0.5, 0.25)), None);
        assert!(!bvh(&[]).occluded(&down(0.5, 0.25)));
        let hit = |t, geometry, u, v, ng| Some(RayHit { t, u, v, ng, geometry, primitive: 0 });
        let on_triangle = |geometry| hit(2.0, geometry, 0.25, 0.125, Vec3::new(0.0, 0.0, 4.0));
        let on_ball = |geometry| hit(1.875, geometry, 0.0, 0.0, Vec3::new(0.0, 0.0, 0.25));
        assert_eq!(bvh(&[triangle]).intersect(&down(0.5, 0.25)), on_triangle(0));
        assert_eq!(bvh(&[triangle]).intersect(&down(1.5, 1.5)), None);
        assert_eq!(bvh(&[ball]).intersect(&down(1.0, 0.0)), on_ball(0));
        let (both, swapped) = (bvh(&[triangle, ball]), bvh(&[ball, triangle]));
        assert_eq!(both.intersect(&down(0.5, 0.25)), on_triangle(0));
        assert_eq!(swapped.intersect(&down(0.5, 0.25)), on_triangle(1));
        assert_eq!(
            (both.intersect(&down(1.0, 0.0)), swapped.intersect(&down(1.0, 0.0))),
            (on_ball(1), on_ball(0))
        );
    }

    #[test]
    fn both_ends_of_a_ray_are_open() {
        let tree = bvh(&[Shape::Triangle(CORNERS)]);
        let ray = |z, t_max| Ray { origin: Vec3::new(0.5, 0.25, z), dir: Vec3::NEG_Z, t_max };
        for (ray, hits) in [(ray(4.0, 4f32.next_up()), true), (ray(4.0, 4.0), false), (ray(0.0, 4.0), false)]
        {
            assert_eq!((tree.intersect(&ray).is_some(), tree.occluded(&ray)), (hits, hits), "{ray:?}");
        }
    }

    #[test]
    fn rays_that_are_no_rays_hit_nothing() {
        let tree =
            bvh(&[Shape::Triangle(CORNERS), Shape::Sphere(Sphere { center: Vec3::ZERO, radius: 2.0 })]);
        let good = down(0.5, 0.25);
        assert!(tree.occluded(&good));
        let numbers = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
        let mut bad: Vec<Ray> = numbers
            .iter()
            .flat_map(|&x| [Ray { origin: Vec3::splat(x), ..good }, Ray { dir: Vec3::splat(x), ..good }])
            .collect();
        bad.extend([0.0, -1.0, f32::NAN].map(|t_max| Ray { t_max, ..good }));
        bad.push(Ray { dir: Vec3::ZERO, ..good });
        for ray in bad {
            assert_eq!((tree.intersect(&ray), tree.occluded(&ray)), (None, false), "{ray:?}");
        }
    }

    /// Collinear corners are no longer collinear once they are sheared along a ray, so no test of a ray finds them.
    #[test]
    fn triangles_without_area_are_never_hit() {
        let mut builder = RayBvhBuilder::new();
        let direction = Vec3::new(0.3, 0.7, 0.9);
        let degenerate = |k: u64| {
            let p = in_cube(&mut rng(k));
            [[p, p, p], [p, p, direction], [p, p + direction, p + 2.0 * direction]][k as usize % 2 * 2]
        };
        let all: Vec<Vec3> = (0..200)
            .flat_map(|k| degenerate(2 * k))
            .chain([Vec3::ZERO, direction, 3.0 * direction])
            .collect();
        let triangles: Vec<[u32; 3]> =
            (0..all.len() as u32 / 3).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        builder.add_triangles(&all, &triangles).unwrap();
        let line = Shape::Triangle([Vec3::ZERO, Vec3::new(1.0, 2.0, 4.0), Vec3::new(3.0, 6.0, 12.0)]);
        let trees = [builder.build(), bvh(&[line])];
        for index in 0..20_000 {
            let mut rng = rng(index);
            let target = [direction, Vec3::new(1.0, 2.0, 4.0)].map(|d| 3.0 * rng.next_f32() * d);
            for (tree, target) in trees.iter().zip(target) {
                let origin = 3.0 * in_cube(&mut rng);
                assert_eq!(tree.intersect(&Ray::new(origin, target - origin)), None);
            }
        }
    }

    #[test]
    fn the_lowest_numbers_win_among_coplanar_duplicates() {
        for copies in [2, 5, 40] {
            let (vertices, triangles): (Vec<Vec3>, Vec<[u32; 3]>) =
                (CORNERS.to_vec(), vec![[0, 1, 2]; copies]);
            let mut builder = RayBvhBuilder::new();
            for _ in 0..3 {
                builder.add_triangles(&vertices, &triangles).unwrap();
            }
            let tree = builder.build();
            for index in 0..1000 {
                let mut rng = rng(index);
                let target = Vec3::new(rng.next_f32(), rng.next_f32(), 0.0);
                let origin = in_cube(&mut rng).with_z(2.0);
                let hit = tree.intersect(&Ray::new(origin, target - origin)).unwrap();
                assert_eq!((hit.geometry, hit.primitive), (0, 0), "{copies} copies");
            }
        }
    }

    /// Clusters at every scale: the walk keeps entries of many levels.
    #[test]
    fn trees_deeper_than_the_small_stack_are_walked_whole() {
        let cluster = |k: i32| {
            (0..24).map(move |i| {
                let at = 2f32.powi(k) * (1.0 + 0.02 * i as f32);
                Shape::Sphere(Sphere {
                    center: Vec3::new(at, 1e-3 * at * (i % 3) as f32, 0.0),
                    radius: 1e-3 * at,
                })
            })
        };
        let shapes: Vec<Shape> = (-58..58).flat_map(cluster).collect();
        let tree = bvh(&shapes);
        assert!(stack_size(tree.tree.levels) > SMALL_STACK, "only {} levels", tree.tree.levels);
        let naive = Naive::new(&shapes);
        for shape in &shapes {
            let Shape::Sphere(Sphere { center, radius }) = *shape else { continue };
            for ray in
                [Ray::new(center + 2.0 * radius * Vec3::Z, Vec3::NEG_Z), Ray::new(2.0 * center, -center)]
            {
                assert_eq!(tree.intersect(&ray), naive.intersect(&ray), "{ray:?}");
            }
        }
    }

    #[test]
    fn the_tree_is_the_same_on_any_number_of_threads() {
        let shapes = shapes(30_000, 3);
        let trees = [1, 2, 7].map(|threads| on_threads(threads, || format!("{:?}", bvh(&shapes))));
        assert!(trees[0] == trees[1] && trees[0] == trees[2]);
    }

    /// In a full block a triangle takes 36 bytes and its numbers 8; nodes come on top, and lanes left empty.
    #[test]
    fn memory_grows_with_the_primitives() {
        assert_eq!(bvh(&[]).memory_bytes(), 0);
        let (vertices, faces) = closed_mesh(5, 0.1);
        let triangles: Vec<[u32; 3]> =
            (0..faces.len() as u32).map(|k| [0, 1, 2].map(|i| 3 * k + i)).collect();
        let bytes = mesh(&vertices, &triangles).memory_bytes() as f64 / triangles.len() as f64;
        assert!((44.0..100.0).contains(&bytes), "{bytes} bytes a triangle");
    }
}
