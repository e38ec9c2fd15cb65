use super::super::testing::{BLACK, GLASS, LAMP, MIRROR, ball, ceiling, cube, room, scene, without_triangle};
use super::super::{EyePaths, Plan};
use super::*;
use crate::bsdf::{Bsdf, Ggx, Interface, RoughSurface};
use crate::math::{Rgb, Vec3};
use crate::scene::{LightDesc, Mesh, PointLightDesc, SceneDesc};

fn plan(desc: &SceneDesc) -> Plan {
    Plan::of(&scene(desc.clone()), PathClasses::ALL)
}

/// Whether something is on, and why.
fn decision<'p>(plan: &'p Plan, what: &str) -> (bool, &'p str) {
    let decision = plan.decisions.iter().find(|decision| decision.what == what).unwrap();
    (decision.on, &decision.because)
}

/// The same with a hole of one triangle in each mesh in turn.
fn opened(desc: &SceneDesc, mesh: usize) -> Vec<SceneDesc> {
    let open = |triangle| {
        let mut open = desc.clone();
        open.meshes[mesh] = without_triangle(open.meshes[mesh].clone(), triangle);
        open
    };
    (0..desc.meshes[mesh].triangles.len()).map(open).collect()
}

/// What is off in a scene, for a reason that names `words`, and on again wherever one triangle of a mesh is missing.
fn is_off_unless_opened(desc: &SceneDesc, mesh: usize, what: &str, words: &str) {
    let closed = plan(desc);
    let (on, because) = decision(&closed, what);
    assert!(!on && because.contains(words), "{closed}");
    for open in opened(desc, mesh) {
        let plan = plan(&open);
        assert!(decision(&plan, what).0, "{what} one triangle away:\n{plan}");
    }
}

/// A small box that things may be hidden in, as the last mesh.
fn with_case(mut desc: SceneDesc, middle: Vec3, half: f32) -> SceneDesc {
    desc.meshes.push(cube("case", middle, half, BLACK));
    desc
}

const CORNER: Vec3 = Vec3::new(-0.5, -0.6, -0.3);

#[test]
fn a_room_of_walls_calls_for_direct_and_indirect_light_alone() {
    let plan = plan(&room());
    assert_eq!(plan.classes.to_string(), "direct,indirect");
    assert!(plan.photons && !plan.refraction && !plan.can_aim && plan.eye_paths == EyePaths::Fixed);
    assert_eq!(decision(&plan, "caustics"), (false, "no surface mirrors or refracts"));
    assert_eq!(decision(&plan, "direct light"), (true, "point_light 1"));
    assert_eq!(decision(&plan, "indirect light"), (true, "room of `wall`"));
    assert_eq!(decision(&plan, "area lights"), (false, "no surface that shines has power"));
    assert!(decision(&plan, "eye paths anew in each pass").1.contains("camera is a pinhole"));
}

#[test]
fn specular_surfaces_in_the_room_call_for_caustics() {
    for (material, refracts) in [(GLASS, true), (MIRROR, false)] {
        let mut desc = room();
        desc.spheres.push(ball(CORNER, 0.2, material));
        let plan = plan(&desc);
        assert!(plan.classes == PathClasses::ALL && plan.can_aim && plan.refraction == refracts, "{plan}");
        assert!(decision(&plan, "caustics").1.starts_with("sphere 1 of `"), "{plan}");
    }
    let mut black = room();
    black.materials[MIRROR as usize].bsdf = Bsdf::Mirror { reflectance: Rgb::ZERO };
    black.spheres.push(ball(CORNER, 0.2, MIRROR));
    assert!(!decision(&plan(&black), "caustics").0, "a mirror that reflects nothing");
}

/// Light through a mask is a caustic, and a box that is a mask parts nothing.
#[test]
fn masks_call_for_caustics_and_let_light_out_of_boxes() {
    for (opacity, is_mask) in [(1.0, false), (0.99, true)] {
        let mut desc = with_case(room(), CORNER, 0.25);
        desc.materials[BLACK as usize].opacity = opacity;
        desc.point_lights.push(PointLightDesc { position: CORNER, intensity: Rgb::ONE });
        let plan = plan(&desc);
        assert_eq!((plan.can_aim, plan.casters, plan.keeps_light(1)), (is_mask, is_mask, is_mask), "{plan}");
        assert_eq!(decision(&plan, "masks").0, is_mask);
        assert!(!plan.refraction);
    }
    let mut hidden = with_case(room(), CORNER, 0.25);
    hidden.materials[MIRROR as usize].opacity = 0.5;
    hidden.spheres.push(ball(CORNER, 0.1, MIRROR));
    is_off_unless_opened(&hidden, 1, "masks", "sphere 1 of `mirror` is shut off from");
}

#[test]
fn bodies_that_absorb_are_told() {
    let mut desc = room();
    desc.spheres.push(ball(CORNER, 0.2, GLASS));
    assert_eq!(decision(&plan(&desc), "absorption"), (false, "no body absorbs"));
    desc.materials[GLASS as usize].absorption = Rgb::Y;
    assert_eq!(decision(&plan(&desc), "absorption"), (true, "sphere 1 of `glass`"));
    desc.materials[GLASS as usize].bsdf = Bsdf::ThinDielectric { ior: 1.5 };
    assert!(!decision(&plan(&desc), "absorption").0, "a pane has no inside");
}

#[test]
fn glass_outside_of_a_closed_room_is_left_out() {
    let mut desc = room();
    desc.spheres.push(ball(3.0 * Vec3::X, 0.5, GLASS));
    for what in ["caustics", "refraction", "aimed photons", "specular transmission", "specular reflection"] {
        is_off_unless_opened(&desc, 0, what, "sphere 1 of `glass` is shut off from");
    }
    desc.spheres[0].center.x = 1.4;
    assert!(plan(&desc).refraction, "glass that comes in through the wall");
}

#[test]
fn glass_in_a_sealed_box_is_left_out() {
    let mut desc = with_case(room(), CORNER, 0.25);
    desc.spheres.push(ball(CORNER, 0.2, GLASS));
    is_off_unless_opened(&desc, 1, "caustics", "shut off from the camera by case");
    let mut meshes = with_case(room(), CORNER, 0.25);
    meshes.meshes.push(cube("prism", CORNER, 0.1, GLASS));
    is_off_unless_opened(&meshes, 1, "caustics", "prism of `glass` is shut off from the camera by case");
    let mut in_ball = room();
    in_ball.spheres.extend([ball(CORNER, 0.2, GLASS), ball(CORNER, 0.3, BLACK)]);
    assert!(decision(&plan(&in_ball), "caustics").1.contains("by sphere 2"));
    in_ball.spheres[1].radius = 0.1;
    assert!(plan(&in_ball).can_aim, "the ball is in the glass");
}

#[test]
fn lights_in_a_sealed_box_are_dropped() {
    let mut desc = with_case(room(), CORNER, 0.25);
    desc.point_lights.insert(0, PointLightDesc { position: CORNER, intensity: Rgb::ONE });
    desc.point_lights.insert(0, PointLightDesc { position: Vec3::ZERO, intensity: Rgb::ZERO });
    let closed = plan(&desc);
    let dropped: Vec<(&str, &[u32])> =
        closed.dropped_lights.iter().map(|d| (d.light.as_str(), &d.numbers[..])).collect();
    assert_eq!(dropped, [("point_light 2", &[0][..]), ("point_light 1", &[])]);
    assert_eq!(closed.dropped_lights[1].because, "has no power");
    assert!(!closed.keeps_light(0) && closed.keeps_light(1) && closed.classes.contains(PathClass::Direct));
    for open in opened(&desc, 1) {
        let plan = plan(&open);
        assert!(plan.keeps_light(0) && plan.dropped_lights.len() == 1, "{plan}");
    }
    desc.point_lights.pop();
    // One light alone is looked at where something is specular.
    desc.spheres.push(ball(Vec3::ZERO, 0.1, GLASS));
    for what in ["photon passes", "direct light", "caustics", "indirect light", "point lights"] {
        is_off_unless_opened(&desc, 1, what, "point_light 2 is shut off from the camera by case");
    }
}

/// Lamps of several triangles are numbered as the scene numbers its lights.
#[test]
fn lamps_in_a_sealed_box_are_dropped() {
    let mut desc = with_case(room(), CORNER, 0.25);
    desc.meshes.push(ceiling("hidden", CORNER, 0.1, LAMP));
    desc.meshes.push(ceiling("lamp", 0.9 * Vec3::Y, 0.5, LAMP));
    let scene = scene(desc.clone());
    let closed = Plan::of(&scene, PathClasses::ALL);
    assert_eq!((scene.lights().len(), closed.dropped_lights.len()), (5, 1));
    assert_eq!(
        (closed.dropped_lights[0].light.as_str(), &closed.dropped_lights[0].numbers[..]),
        ("hidden", &[1, 2][..])
    );
    assert_eq!(decision(&closed, "lamps in the picture"), (true, "lamp of `lamp`"));
    assert!(opened(&desc, 1).iter().all(|open| plan(open).dropped_lights.is_empty()));
}

/// A part of the wall that shines out lights nothing inside; turned round it does.
#[test]
fn lamps_in_the_wall_light_the_side_that_they_face() {
    let lit_by_wall = |turned: bool| {
        let mut desc = room();
        desc.spheres.push(ball(CORNER, 0.2, GLASS));
        desc.point_lights.clear();
        desc.meshes[0].materials[6..8].fill(LAMP);
        desc.meshes[0].triangles[6..8].iter_mut().filter(|_| turned).for_each(|t| t.reverse());
        desc
    };
    let inward = plan(&lit_by_wall(false));
    assert!(inward.photons && inward.dropped_lights.is_empty(), "{inward}");
    let desc = lit_by_wall(true);
    let outward = plan(&desc);
    assert!(!outward.photons && outward.dropped_lights[0].numbers == [0, 1], "{outward}");
    assert!(opened(&desc, 0).iter().all(|open| plan(open).photons));
}

#[test]
fn without_a_receiver_there_are_no_photons() {
    let mut desc = room();
    desc.meshes[0].materials.fill(MIRROR);
    let dark = plan(&desc);
    assert!(dark.classes == PathClasses::NONE && !dark.photons, "{dark}");
    assert!(decision(&dark, "direct light").1.contains("no surface reflects diffusely"));
    // Outside of the room a receiver is none; a lamp in it is seen with direct light.
    desc.meshes.push(ceiling("floor", 3.0 * Vec3::Y, 1.0, 0));
    is_off_unless_opened(&desc, 0, "photon passes", "floor of `wall` is shut off from the camera by room");
    desc.meshes.push(ceiling("lamp", 0.9 * Vec3::Y, 0.5, LAMP));
    let lamp = plan(&desc);
    assert!(!lamp.photons && lamp.classes.to_string() == "direct", "{lamp}");
    let mut lit = room();
    lit.meshes[0].materials.fill(MIRROR);
    lit.meshes.push(ceiling("floor", Vec3::ZERO, 1.0, 0));
    assert!(plan(&lit).photons);
}

#[test]
fn a_camera_in_a_sealed_box_sees_no_light_from_outside() {
    let mut desc = room();
    desc.spheres.push(ball(CORNER, 0.2, GLASS));
    desc.camera.position = Vec3::new(0.5, 0.5, 0.5);
    let desc = with_case(desc, Vec3::splat(0.5), 0.25);
    is_off_unless_opened(&desc, 1, "photon passes", "point_light 1 is shut off from the camera by case");
    is_off_unless_opened(
        &desc,
        1,
        "diffuse reflection",
        "room of `wall` is shut off from the camera by case",
    );
}

/// Its rim is out of the box that its middle is in.
#[test]
fn a_lens_sees_light_where_any_of_it_is() {
    let mut desc = room();
    desc.camera.position = Vec3::new(0.5, 0.5, 0.5);
    let mut desc = with_case(desc, Vec3::splat(0.5), 0.25);
    desc.spheres.push(ball(CORNER, 0.2, GLASS));
    for (lens_radius, sees) in [(0.0, false), (0.1, false), (0.4, true)] {
        desc.camera.lens_radius = lens_radius;
        let plan = plan(&desc);
        assert_eq!(plan.photons, sees, "lens {lens_radius}: {plan}");
        let expected = if lens_radius > 0.0 { EyePaths::Retraced } else { EyePaths::Fixed };
        assert_eq!(plan.eye_paths, expected);
    }
}

#[test]
fn only_what_is_asked_for_is_simulated() {
    let mut desc = room();
    desc.spheres.push(ball(CORNER, 0.2, GLASS));
    let scene = scene(desc);
    for (asked, photons, can_aim) in [
        ("direct", false, false),
        ("caustic", true, true),
        ("indirect", true, false),
        ("direct,indirect", true, false),
    ] {
        let classes: PathClasses = asked.split(',').map(|name| name.parse::<PathClass>().unwrap()).collect();
        for plan in [Plan::of(&scene, classes), Plan::everything(&scene, classes)] {
            assert_eq!((plan.classes, plan.photons, plan.can_aim), (classes, photons, can_aim), "{plan}");
        }
    }
}

#[test]
fn everything_is_on_where_nothing_calls_for_it() {
    let mut desc = room();
    desc.point_lights.clear();
    let plan = Plan::everything(&scene(desc), PathClasses::ALL);
    assert!(plan.classes == PathClasses::ALL && plan.photons && plan.refraction && plan.can_aim);
    assert!(plan.dropped_lights.is_empty() && plan.eye_paths == EyePaths::Fixed);
}

#[test]
fn eyes_that_found_nothing_need_no_photons() {
    let mut desc = room();
    desc.meshes.push(ceiling("lamp", 0.9 * Vec3::Y, 0.5, LAMP));
    let plan = plan(&desc);
    assert_eq!(plan.clone().finish_if_blind(1), plan);
    let blind = plan.clone().finish_if_blind(0);
    assert!(!blind.photons && blind.classes.to_string() == "direct", "{blind}");
    assert_eq!(
        decision(&blind, "indirect light").1,
        "the eye paths found no surface that reflects diffusely"
    );
    let retraced = plan.with_eye_paths(Some(EyePaths::Retraced));
    assert_eq!(retraced.clone().finish_if_blind(0), retraced);
}

/// Nothing is looked at where nothing can be gained: with one light and nothing specular.
#[test]
fn barriers_are_looked_for_where_they_may_matter() {
    let mut desc = with_case(room(), Vec3::new(0.15, 0.55, -0.1), 0.1);
    assert!(plan(&desc).photons, "the only light, and nothing specular");
    desc.meshes.push(Mesh { name: "lamp".into(), ..ceiling("lamp", CORNER, 0.1, LAMP) });
    assert_eq!(plan(&desc).dropped_lights.len(), 1);
}

/// A rough ball calls for other eye paths in each pass; smooth, or without a share, it does not.
#[test]
fn rough_surfaces_call_for_other_eye_paths() {
    let rough = |reflectance| {
        let interface = Interface::Conductor { eta: Rgb::ONE, k: Rgb::ONE, reflectance };
        Bsdf::Rough(RoughSurface { facets: Ggx { alpha: 0.3 }, interface })
    };
    let mut desc = SceneDesc { spheres: vec![ball(Vec3::ZERO, 0.2, MIRROR)], ..room() };
    assert_eq!(plan(&desc).eye_paths, EyePaths::Fixed);
    desc.materials[MIRROR as usize].bsdf = rough(Rgb::ONE);
    let with_rough = plan(&desc);
    assert_eq!(with_rough.eye_paths, EyePaths::Retraced);
    assert!(with_rough.casters && !with_rough.can_aim && decision(&with_rough, "rough surfaces").0);
    assert!(!with_rough.glints, "nothing makes caustics");
    desc.spheres.push(ball(Vec3::new(0.5, -0.5, 0.0), 0.2, GLASS));
    assert!(plan(&desc).glints && decision(&plan(&desc), "caustics on rough surfaces").0);
    let direct_alone = [PathClass::Direct].into_iter().collect();
    assert!(!Plan::of(&scene(desc.clone()), direct_alone).glints, "not asked for");
    // A lamp in place of the point: facets find it.
    desc.point_lights.clear();
    desc.meshes.push(ceiling("lamp", Vec3::new(0.0, 0.9, 0.0), 0.1, LAMP));
    assert!(!plan(&desc).glints);
}

/// Light from afar stays outside of a closed room, and comes in where a triangle is missing.
#[test]
fn light_from_afar_does_not_pass_walls() {
    let mut desc = SceneDesc { point_lights: vec![], ..room() };
    desc.further_lights = vec![
        LightDesc::Distant { direction: Vec3::NEG_Y, irradiance: Rgb::ONE },
        LightDesc::Sky(Rgb::ONE),
        LightDesc::Distant { direction: Vec3::NEG_Y, irradiance: Rgb::ZERO },
    ];
    let closed = plan(&desc);
    assert!(!closed.photons && closed.classes.iter().next().is_none(), "{closed}");
    assert_eq!(closed.dropped_lights.len(), 3, "{closed}");
    desc.meshes[0] = without_triangle(desc.meshes[0].clone(), 0);
    let open = plan(&desc);
    assert!(open.photons && decision(&open, "environment").0 && open.dropped_lights.len() == 1, "{open}");
}
