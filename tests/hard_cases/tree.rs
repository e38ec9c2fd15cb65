//! The tree of spheres over hit points as no scene should have them.

use caustica::bvh::{Sphere, SphereBvh};
use caustica::math::{Rng, Stream, Vec3};

const MILLION: usize = 1_000_000;

/// Points of the unit cube.
fn anywhere(n: usize) -> Vec<Vec3> {
    let mut rng = Rng::new(7, Stream::Test, 0, 0);
    (0..n).map(|_| Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32())).collect()
}

fn spheres(centers: impl IntoIterator<Item = Vec3>, radius: f32) -> Vec<Sphere> {
    centers.into_iter().map(|center| Sphere { center, radius }).collect()
}

/// Every sphere that contains a point is reported once, in increasing order, by either way of asking; no other is.
fn assert_finds(spheres: &[Sphere], points: &[Vec3]) -> SphereBvh {
    let (mut tree, order) = SphereBvh::build(spheres);
    tree.check_invariants().unwrap();
    assert_eq!((tree.len(), order.len()), (spheres.len(), spheres.len()));
    let mut expected = vec![Vec::new(); tree.len()];
    for (index, &p) in points.iter().enumerate() {
        let naive: Vec<usize> = (0..tree.len()).filter(|&k| tree.sphere(k).contains(p)).collect();
        let mut found = Vec::new();
        tree.for_each_containing(p, |position| found.push(position));
        assert!(found == naive, "{p}: {} spheres instead of {}", found.len(), naive.len());
        naive.into_iter().for_each(|position| expected[position].push(index));
    }
    let mut gathered = vec![Vec::new(); tree.len()];
    tree.gather(points, &mut gathered, |points, _, index| points.push(index));
    assert!(gathered == expected, "the gathering finds others");
    tree
}

/// A million hit points in one place make a valid tree, and a photon there meets each of them once.
///
/// Breaks: no plane separates them: the builder recurs until the stack is full, or makes one leaf of a million.
///
/// Mutation: `partition_at_median` parts the first sphere from the rest: the stack overflows.
#[test]
fn a_million_coincident_spheres_make_a_valid_tree() {
    let center = Vec3::new(0.1, 0.2, 0.3);
    let tree = assert_finds(&spheres(vec![center; MILLION], 0.5), &[center, Vec3::ONE]);
    assert!(tree.nodes().len() < MILLION / 2, "{} nodes", tree.nodes().len());
}

/// A million hit points of one plane, as on a floor, are found as any others.
///
/// Breaks: boxes of no thickness have no volume and no cost: the builder divides by 0 or stops splitting.
///
/// Mutation: `Sphere::reach` 0, boxes of the centres alone: points off the plane find none.
#[test]
fn a_million_coplanar_spheres_are_found() {
    let on_plane = anywhere(MILLION).into_iter().map(|p| p.with_y(0.7));
    let points: Vec<Vec3> = anywhere(20).into_iter().map(|p| p.with_y(0.7 + 0.004 * (p.y - 0.5))).collect();
    let tree = assert_finds(&spheres(on_plane, 0.003), &points);
    let mut found = 0;
    tree.for_each_containing(points[0], |_| found += 1);
    assert!(found > 5);
}

/// A million hit points of one line are found as any others.
///
/// Breaks: two of three axes have no extent; who splits them by turns recurs without end.
///
/// Mutation: `Sphere::reach` 0: points between the centres miss some.
#[test]
fn a_million_collinear_spheres_are_found() {
    let on_line = anywhere(MILLION).into_iter().map(|p| Vec3::new(p.x, 0.2, -0.4));
    let points: Vec<Vec3> = anywhere(20).into_iter().map(|p| Vec3::new(p.x, 0.2, -0.4)).collect();
    assert_finds(&spheres(on_line, 1e-4), &points);
}

/// Spheres so large that each covers the scene all meet every photon, once.
///
/// Breaks: lists grow as photons times spheres and exhaust memory, or a sphere that straddles two children counts twice.
///
/// Mutation: `Descent::alone` lets every leaf meet its points twice.
#[test]
fn a_radius_over_the_whole_scene_meets_every_photon_once() {
    let large = spheres(anywhere(3000), 2.0);
    let points = anywhere(400);
    let mut tree = assert_finds(&large, &points);
    let mut counts = vec![0u32; tree.len()];
    tree.gather(&points, &mut counts, |count, _, _| *count += 1);
    assert!(counts.iter().all(|&count| count == 400));
}

/// At a radius of 10⁻³⁰, whose square is no number of f32, a hit point meets what lies exactly on it and nothing else.
///
/// Breaks: the squared radius underflows to 0 and `<` finds nothing, or boxes of no size are taken for empty.
///
/// Mutation: `Sphere::contains` by `<`.
#[test]
fn a_radius_of_nothing_meets_what_lies_on_the_point() {
    let centers = anywhere(3000);
    let points: Vec<Vec3> = centers.iter().take(100).flat_map(|&p| [p, p + Vec3::X * 1e-3]).collect();
    let tree = assert_finds(&spheres(centers, 1e-30), &points);
    let mut found = 0;
    points.iter().for_each(|&p| tree.for_each_containing(p, |_| found += 1));
    assert_eq!(found, 100);
}

/// No hit point and a single one make trees that answer, refit and gather.
///
/// Breaks: the root of no node is read, or a single leaf is taken for an inner node.
///
/// Mutation: `SphereBvh::refit` and `gather` without their checks for an empty tree: an index out of range.
#[test]
fn trees_of_none_and_of_one_answer() {
    let points = [Vec3::ZERO, Vec3::splat(0.5), Vec3::NAN, Vec3::INFINITY];
    for n in [0, 1] {
        let mut tree = assert_finds(&spheres(vec![Vec3::ZERO; n], 0.1), &points);
        tree.refit(|_| 2.0);
        tree.check_invariants().unwrap();
        let mut counts = vec![0; n];
        tree.gather(&points, &mut counts, |count, _, _| *count += 1);
        assert_eq!(counts, vec![2; n]);
        tree.gather(&[], &mut counts, |count, _, _| *count += 1);
        assert_eq!(counts, vec![2; n]);
    }
}
