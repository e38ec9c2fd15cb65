use proptest::prelude::*;

use super::super::testing::{BLACK, GLASS, MIRROR, WALL, ball, ceiling, cube, room, scene, without_triangle};
use super::*;
use crate::math::{DVec3, Frame};
use crate::scene::{Mesh, SceneDesc};

fn point(p: Vec3) -> Thing<'static> {
    Thing::Box(Aabb::of_points([p]))
}

/// The region of each point in the room with these meshes and spheres, and without its own walls.
fn regions(meshes: Vec<Mesh>, spheres: Vec<SphereDesc>, points: &[Vec3]) -> Vec<Region> {
    let scene = scene(SceneDesc { meshes, spheres, ..room() });
    let surfaces = Surfaces::of(&scene);
    assert!(surfaces.may_part);
    let barriers = Barriers::of(&surfaces);
    points.iter().map(|p| barriers.region(point(*p))).collect()
}

fn known(sides: &[(u32, i32)]) -> Region {
    Region::Known(sides.iter().map(|&(barrier, winding)| (barrier, Side::Of(winding))).collect())
}

/// Something specular, so that barriers are looked for.
fn reason() -> Mesh {
    ceiling("mirror", 50.0 * Vec3::Y, 1.0, MIRROR)
}

#[test]
fn closed_surfaces_part_and_open_ones_do_not() {
    let points = [Vec3::ZERO, 3.0 * Vec3::X];
    let regions_of = |mesh: Mesh| regions(vec![mesh, reason()], vec![], &points);
    assert_eq!(regions_of(cube("box", Vec3::ZERO, 1.0, WALL)), [known(&[(0, 1)]), known(&[])]);
    assert_eq!(regions_of(Mesh::inward_cube("box", WALL)), [known(&[(0, -1)]), known(&[])]);
    for triangle in 0..12 {
        let open = without_triangle(cube("box", Vec3::ZERO, 1.0, WALL), triangle);
        assert_eq!(regions_of(open), [known(&[]), known(&[])], "without triangle {triangle}");
    }
    let mut window = cube("box", Vec3::ZERO, 1.0, WALL);
    window.materials[3] = GLASS;
    assert_eq!(regions_of(window), [known(&[]), known(&[])]);
}

#[test]
fn spheres_part_unless_they_are_clear() {
    let points = [Vec3::ZERO, 0.999 * Vec3::X, 1.001 * Vec3::X, Vec3::X];
    let of = |material| regions(vec![reason()], vec![ball(Vec3::ZERO, 1.0, material)], &points);
    let on_it = Region::Known(vec![(0, Side::Either)]);
    assert_eq!(of(MIRROR), [known(&[(0, 1)]), known(&[(0, 1)]), known(&[]), on_it]);
    assert!(of(GLASS).iter().all(|region| *region == known(&[])));
}

/// What comes near to a wall may be on either side of it.
#[test]
fn boxes_that_touch_a_wall_are_on_both_sides() {
    let scene = scene(SceneDesc { meshes: vec![cube("box", Vec3::ZERO, 1.0, WALL), reason()], ..room() });
    let surfaces = Surfaces::of(&scene);
    let barriers = Barriers::of(&surfaces);
    let side = |center: Vec3, half: f32| barriers.region(Thing::Box(Aabb::of_sphere(center, half)));
    let either = Region::Known(vec![(0, Side::Either)]);
    assert_eq!(side(Vec3::ZERO, 0.99), known(&[(0, 1)]));
    assert_eq!(
        [side(Vec3::ZERO, 1.0), side(Vec3::ZERO, 2.0), side(Vec3::X, 0.1)],
        [(); 3].map(|()| either.clone())
    );
    assert_eq!(side(1.2 * Vec3::X, 0.1), known(&[]));
}

/// Where glass lies in a wall, a ray may meet the glass and go on behind the wall.
#[test]
fn walls_with_glass_in_the_same_place_do_not_part() {
    let points = [Vec3::ZERO, 3.0 * Vec3::X];
    let apart = |height: f32| {
        let pane = ceiling("pane", height * Vec3::Y, 0.5, GLASS);
        let regions = regions(vec![cube("box", Vec3::ZERO, 1.0, WALL), pane], vec![], &points);
        !regions[0].meets(&regions[1])
    };
    assert_eq!([1.0, 0.99, 1.01].map(apart), [false, true, true]);
    let around = |radius: f32| {
        let spheres = vec![ball(Vec3::ZERO, 1.0, WALL), ball(Vec3::ZERO, radius, GLASS)];
        let regions = regions(vec![], spheres, &points);
        !regions[0].meets(&regions[1])
    };
    assert_eq!([1.0, 0.99, 1.01].map(around), [false, true, true]);
}

#[test]
fn nothing_is_known_when_the_effort_is_spent() {
    let scene = scene(SceneDesc { meshes: vec![cube("box", Vec3::ZERO, 1.0, WALL), reason()], ..room() });
    let surfaces = Surfaces::of(&scene);
    let barriers = Barriers::of(&surfaces);
    barriers.effort.set(20);
    assert_eq!(barriers.region(point(Vec3::ZERO)), Region::Unknown);
}

/// A lamp in the floor of a box, outward or inward, whichever way the rest faces.
#[test]
fn lamps_in_a_barrier_shine_to_one_side() {
    for (turn_lamp, turn_rest) in [(false, false), (false, true), (true, false), (true, true)] {
        let mut cube = cube("box", Vec3::ZERO, 1.0, WALL);
        let turn = |k: usize| if k < 2 { turn_lamp } else { turn_rest };
        (0..12).filter(|&k| turn(k)).for_each(|k| cube.triangles[k].reverse());
        let scene = scene(SceneDesc { meshes: vec![cube, reason()], ..room() });
        let surfaces = Surfaces::of(&scene);
        let barriers = Barriers::of(&surfaces);
        let inside = barriers.region(point(Vec3::ZERO));
        let front = barriers.front(0, &[Face { mesh: 0, triangle: 0 }, Face { mesh: 0, triangle: 1 }]);
        let region = known(&[]).moved(0, front);
        assert!(matches!(front, Side::Of(_)), "{turn_lamp} {turn_rest}");
        assert_eq!(region.meets(&inside), turn_lamp, "{turn_lamp} {turn_rest}");
    }
}

/// Whether a ray from `p` leaves a closed surface of these triangles behind, or never was within.
fn parity(triangles: &[[Vec3; 3]], p: Vec3, dir: DVec3) -> i32 {
    let crossed = triangles.iter().filter(|triangle| {
        let [a, b, c] = triangle.map(|corner| corner.as_dvec3() - p.as_dvec3());
        let sides = [dir.dot(a.cross(b)), dir.dot(b.cross(c)), dir.dot(c.cross(a))];
        let normal = (b - a).cross(c - a);
        let alike = sides.iter().all(|s| *s > 0.0) || sides.iter().all(|s| *s < 0.0);
        alike && normal.dot(a) / normal.dot(dir) > 0.0
    });
    crossed.count() as i32 % 2
}

prop_compose! {
    /// A box of any shape and place.
    fn any_box()(
        middle in prop::array::uniform3(-3f32..3.0),
        half in prop::array::uniform3(0.2f32..3.0),
        axis in prop::array::uniform3(-1f32..1.0),
    ) -> Mesh {
        let mut mesh = cube("box", Vec3::ZERO, 1.0, BLACK);
        let frame = Frame::around(Vec3::from(axis).normalize_or(Vec3::X));
        let place = |v: Vec3| Vec3::from(middle) + frame.to_world(Vec3::from(half) * v);
        mesh.vertices.iter_mut().for_each(|v| *v = place(*v));
        mesh
    }
}

prop_compose! {
    fn any_ball()(middle in prop::array::uniform3(-3f32..3.0), radius in 0.2f32..3.0) -> SphereDesc {
        ball(Vec3::from(middle), radius, MIRROR)
    }
}

proptest! {
    /// Sides are those that rays tell, of boxes and balls that may cut each other.
    #[test]
    fn sides_are_what_rays_count(
        boxes in prop::collection::vec(any_box(), 0..5),
        balls in prop::collection::vec(any_ball(), 1..4),
        points in prop::collection::vec(prop::array::uniform3(-4f32..4.0), 1..12),
    ) {
        let points: Vec<Vec3> = points.into_iter().map(Vec3::from).collect();
        let dir = DVec3::new(0.267, 0.534, 0.802);
        for (p, region) in points.iter().zip(regions(boxes.clone(), balls.clone(), &points)) {
            let within_box = |mesh: &Mesh| {
                let triangles: Vec<[Vec3; 3]> = (0..12).map(|k| mesh.corners(k)).collect();
                parity(&triangles, *p, dir)
            };
            let within_ball = |ball: &SphereDesc| i32::from(ball.center.distance(*p) < ball.radius);
            let counted: Vec<i32> =
                boxes.iter().map(within_box).chain(balls.iter().map(within_ball)).collect();
            let Region::Known(sides) = &region else { panic!("effort") };
            for (barrier, winding) in (0..).zip(counted) {
                let side = sides.iter().find(|side| side.0 == barrier).map_or(Side::Of(0), |side| side.1);
                let is_near = match boxes.get(barrier as usize) {
                    Some(mesh) => (0..12).any(|k| super::super::contacts::heights(mesh.corners(k), [*p; 3])[0].abs() < 1e-4),
                    None => {
                        let ball = &balls[barrier as usize - boxes.len()];
                        (ball.center.distance(*p) - ball.radius).abs() < 1e-4
                    }
                };
                let is_right = side == Side::Of(winding) || (side == Side::Either && is_near);
                prop_assert!(is_right, "{p}: {side:?} of barrier {barrier}");
            }
        }
    }
}
