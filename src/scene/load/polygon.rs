//! Cuts the faces of a mesh into triangles.

use crate::math::{DVec3, Vec3};

/// The most corners a concave polygon may have: the time to clip ears grows with their square or faster.
pub(super) const MAX_CONCAVE: usize = 1024;

/// Why [`triangulate`] refuses a polygon.
pub(super) fn too_concave() -> String {
    format!("concave face of more than {MAX_CONCAVE} vertices; allowed: cut it into smaller ones")
}

/// The triangles of a polygon as indices into `corners`, wound as it is; none for a concave polygon of more than
/// [`MAX_CONCAVE`] corners.
///
/// Seen along the polygon's area vector (Newell), a strictly convex one becomes a fan from its first corner.
/// Otherwise ears are clipped: a triangle of three corners in a row that turns left and holds no other corner.
/// Where a polygon crosses itself and has no ear left, the rest becomes a fan. Above [`MAX_CONCAVE`] corners a
/// polygon counts as convex if no corner turns right by more than a millionth of the area, which rounding does.
///
/// # Source
/// Meisters, "Polygons Have Ears", American Mathematical Monthly 82(6), 1975.
pub(super) fn triangulate(corners: &[Vec3]) -> Option<Vec<[usize; 3]>> {
    let n = corners.len();
    if n <= 3 {
        return Some(fan(&Vec::from_iter(0..n)));
    }
    let flat = flattened(corners);
    let large = n > MAX_CONCAVE;
    let tolerance = if large { 1e-6 * area(&flat) } else { -f64::MIN_POSITIVE };
    let is_left_turn = |i: usize| turn(flat[i], flat[(i + 1) % n], flat[(i + 2) % n]) >= -tolerance;
    if (0..n).all(is_left_turn) {
        return Some(fan(&Vec::from_iter(0..n)));
    }
    (!large).then(|| clip_ears(&flat))
}

fn fan(ring: &[usize]) -> Vec<[usize; 3]> {
    (2..ring.len()).map(|i| [ring[0], ring[i - 1], ring[i]]).collect()
}

type Point = (f64, f64);

/// The polygon seen along the axis closest to its area vector, so that it runs counter-clockwise.
fn flattened(corners: &[Vec3]) -> Vec<Point> {
    let from_first: Vec<DVec3> = corners.iter().map(|c| c.as_dvec3() - corners[0].as_dvec3()).collect();
    let n: DVec3 = from_first.windows(2).map(|pair| pair[0].cross(pair[1])).sum();
    let seen = |p: &DVec3| match n.abs() {
        a if a.x >= a.y && a.x >= a.z => (p.y, p.z, n.x),
        a if a.y >= a.z => (p.z, p.x, n.y),
        _ => (p.x, p.y, n.z),
    };
    let upright = |(u, v, facing): (f64, f64, f64)| if facing < 0.0 { (v, u) } else { (u, v) };
    from_first.iter().map(|p| upright(seen(p))).collect()
}

/// Twice the signed area of a triangle; positive where it turns left.
fn turn(a: Point, b: Point, c: Point) -> f64 {
    (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0)
}

fn area(ring: &[Point]) -> f64 {
    0.5 * ring.windows(2).map(|pair| turn(ring[0], pair[0], pair[1])).sum::<f64>()
}

/// How often corners that were no ears are all looked at again. In a polygon that does not cross itself, clipping an
/// ear makes ears of its neighbours alone, so that never helps; in others it must end.
const MOST_ROUNDS: usize = 8;

fn clip_ears(points: &[Point]) -> Vec<[usize; 3]> {
    let mut ring = Vec::from_iter(0..points.len());
    let mut no_ear = vec![false; points.len()];
    let mut triangles = Vec::new();
    let (mut cursor, mut rounds) = (0, 0);
    while ring.len() > 3 {
        let n = ring.len();
        let ear = (cursor..cursor + n).map(|i| i % n).find(|&i| {
            no_ear[ring[i]] = no_ear[ring[i]] || !is_ear(points, &ring, i);
            !no_ear[ring[i]]
        });
        let Some(ear) = ear else {
            rounds += 1;
            if rounds > MOST_ROUNDS {
                break;
            }
            no_ear.fill(false);
            continue;
        };
        let (before, after) = (ring[(ear + n - 1) % n], ring[(ear + 1) % n]);
        triangles.push([before, ring[ear], after]);
        (no_ear[before], no_ear[after]) = (false, false);
        ring.remove(ear);
        cursor = ear;
    }
    triangles.extend(fan(&ring));
    triangles
}

fn is_ear(points: &[Point], ring: &[usize], i: usize) -> bool {
    let n = ring.len();
    let corners = [(i + n - 1) % n, i, (i + 1) % n].map(|k| points[ring[k]]);
    let [a, b, c] = corners;
    let holds = |p: Point| turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0;
    turn(a, b, c) > 0.0 && !ring.iter().map(|&k| points[k]).any(|p| holds(p) && !corners.contains(&p))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn in_plane(points: &[(f32, f32)]) -> Vec<Vec3> {
        points.iter().map(|&(x, y)| Vec3::new(x, y, 0.25 * x - 0.5 * y)).collect()
    }

    /// The area vectors of the triangles, each of which must point where the polygon's does.
    fn check(corners: &[Vec3], triangles: &[[usize; 3]]) {
        let vector = |t: &[usize; 3]| {
            let [a, b, c] = t.map(|i| corners[i].as_dvec3());
            0.5 * (b - a).cross(c - a)
        };
        let whole: DVec3 = fan(&Vec::from_iter(0..corners.len())).iter().map(vector).sum();
        let parts: Vec<DVec3> = triangles.iter().map(vector).collect();
        assert!(parts.iter().all(|p| p.dot(whole) > 0.0), "{triangles:?}");
        let covered: f64 = parts.iter().map(|p| p.length()).sum();
        assert!((covered / whole.length() - 1.0).abs() < 1e-6, "{covered} {whole}");
        assert_eq!(triangles.len(), corners.len() - 2);
    }

    const ARROW: [(f32, f32); 4] = [(0., 0.), (2., 1.), (0., 2.), (1., 1.)];
    const COMB: [(f32, f32); 9] =
        [(0., 0.), (5., 0.), (5., 3.), (4., 3.), (4., 1.), (3., 1.), (2., 3.), (1., 1.), (0., 3.)];

    #[test]
    fn concave_polygons_are_covered_exactly_from_any_corner_and_side() {
        for shape in [&ARROW[..], &COMB[..]] {
            let mut corners = in_plane(shape);
            for _ in 0..corners.len() {
                corners.rotate_left(1);
                check(&corners, &triangulate(&corners).unwrap());
                let backward: Vec<Vec3> = corners.iter().rev().copied().collect();
                check(&backward, &triangulate(&backward).unwrap());
            }
        }
    }

    #[test]
    fn polygons_facing_any_axis_are_covered() {
        for turned in [|p: Vec3| p, |p: Vec3| Vec3::new(p.y, p.z, p.x), |p: Vec3| Vec3::new(p.z, p.x, p.y)] {
            let corners: Vec<Vec3> = in_plane(&COMB).into_iter().map(turned).collect();
            check(&corners, &triangulate(&corners).unwrap());
        }
    }

    #[test]
    fn a_corner_in_the_middle_of_an_edge_makes_no_empty_triangle() {
        let corners = in_plane(&[(0., 0.), (1., 0.), (2., 0.), (2., 2.), (0., 2.)]);
        check(&corners, &triangulate(&corners).unwrap());
    }

    #[test]
    fn a_pentagon_is_a_fan_and_self_crossing_ends() {
        let pentagon = in_plane(&[(0., 0.), (2., 0.), (3., 2.), (1., 3.), (-1., 2.)]);
        assert_eq!(triangulate(&pentagon).unwrap(), [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
        let bow_tie = in_plane(&[(0., 0.), (1., 1.), (1., 0.), (0., 1.)]);
        assert_eq!(triangulate(&bow_tie).unwrap().len(), 2);
        assert_eq!(triangulate(&[Vec3::ONE; 6]).unwrap().len(), 4);
    }

    #[test]
    fn huge_polygons_must_be_convex() {
        let circle = |n: usize| {
            let angle = move |i| std::f32::consts::TAU * i as f32 / n as f32;
            (0..n).map(move |i| Vec3::new(angle(i).cos(), angle(i).sin(), 7.0)).collect::<Vec<_>>()
        };
        assert_eq!(triangulate(&circle(200_000)).unwrap().len(), 199_998);
        let mut notched = circle(MAX_CONCAVE + 1);
        notched[5] = (0.5 * notched[5]).with_z(7.0);
        assert_eq!(triangulate(&notched), None);
        notched.pop();
        check(&notched, &triangulate(&notched).unwrap());
    }

    /// No round of looking again helps these, so the number of rounds is what bounds the work.
    #[test]
    fn a_polygon_that_crosses_itself_everywhere_ends() {
        let n = MAX_CONCAVE;
        let mut rng = crate::math::Rng::new(1, crate::math::Stream::Eye, 0, 0);
        let corners: Vec<Vec3> = (0..n).map(|_| rng.next_vec2().extend(0.0)).collect();
        assert_eq!(triangulate(&corners).unwrap().len(), n - 2);
    }

    proptest! {
        #[test]
        fn star_shaped_polygons_are_covered(radii in prop::collection::vec(0.2f32..1.0, 3..40)) {
            let n = radii.len() as f32;
            let angle = |i: usize| std::f32::consts::TAU * i as f32 / n;
            let points: Vec<_> =
                radii.iter().enumerate().map(|(i, r)| (r * angle(i).cos(), r * angle(i).sin())).collect();
            let corners = in_plane(&points);
            check(&corners, &triangulate(&corners).unwrap());
        }
    }
}
