//! Renders do what their plan says: what a scene does not call for costs nothing and changes no byte.
#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use std::fs;

use assert_cmd::Command;
use caustica::bsdf::Bsdf;
use caustica::effects::{PathClass, PathClasses};
use caustica::math::{Rgb, Vec3};
use caustica::ppm::{Kinds, PassStatistics, Planning, Render, Settings};
use caustica::scene::{
    CameraDesc, FilmDesc, Material, Mesh, PointLightDesc, RenderDesc, Scene, SceneDesc, SphereDesc,
};

const GLASS: u32 = 1;
const MIRROR: u32 = 2;

/// A grey room from -1 to 1 with a lamp, seen from within.
fn room() -> SceneDesc {
    let material = |name: &str, bsdf| Material::plain(name, bsdf, Rgb::ZERO);
    SceneDesc {
        name: "room".into(),
        path: "room.toml".into(),
        film: FilmDesc::new(24, 24),
        render: RenderDesc { passes: 3, photons: 4000, samples: 1, alpha: 0.7, radius: Some(0.1), depth: 16 },
        materials: vec![
            material("wall", Bsdf::Diffuse { albedo: Rgb::splat(0.5) }),
            material("glass", Bsdf::Dielectric { ior: 1.5 }),
            material("mirror", Bsdf::Mirror { reflectance: Rgb::splat(0.9) }),
        ],
        meshes: vec![Mesh::inward_cube("room", 0)],
        point_lights: vec![PointLightDesc { position: Vec3::new(0.15, 0.55, -0.1), intensity: Rgb::ONE }],
        ..SceneDesc::new(CameraDesc::pinhole(Vec3::new(0.1, 0.2, 0.9), Vec3::new(0.0, -0.4, -1.0), 70.0))
    }
}

const CORNER: Vec3 = Vec3::new(-0.5, -0.6, -0.3);

/// With a closed grey box in a corner, and things in it.
fn with_case(things: impl Fn(&mut SceneDesc)) -> SceneDesc {
    let mut desc = room();
    let mut case = Mesh::inward_cube("case", 0);
    case.vertices.iter_mut().for_each(|vertex| *vertex = CORNER + 0.3 * *vertex);
    case.triangles.iter_mut().for_each(|corners| corners.reverse());
    desc.meshes.push(case);
    things(&mut desc);
    desc
}

fn glass(desc: &mut SceneDesc) {
    desc.spheres.push(SphereDesc { center: CORNER, radius: 0.1, material: GLASS });
}

fn lamp(desc: &mut SceneDesc) {
    desc.point_lights.push(PointLightDesc { position: CORNER, intensity: Rgb::splat(9.0) });
}

fn scene(desc: &SceneDesc) -> Scene {
    Scene::new(desc.clone()).unwrap()
}

fn rendered(scene: &Scene, planning: Planning) -> (Render<'_>, Vec<PassStatistics>) {
    let settings = Settings { planning, ..Settings::of_scene(scene.render()) };
    let mut render = Render::new(scene, settings);
    let passes = (0..scene.render().passes).map(|_| render.pass()).collect();
    (render, passes)
}

/// Glass in a box pays nothing but its geometry: the same rays, memory and bytes as the box without it.
#[test]
fn glass_out_of_reach_costs_nothing() {
    let (with, without) = (scene(&with_case(glass)), scene(&with_case(|_| ())));
    let ((with, its), (without, theirs)) =
        (rendered(&with, Planning::Derived), rendered(&without, Planning::Derived));
    assert_eq!(with.memory_bytes(), without.memory_bytes());
    assert_eq!(with.setup().eye_rays, without.setup().eye_rays);
    assert!(with.setup().aim.is_none(), "nothing is aimed at it");
    for (a, b) in its.iter().zip(&theirs) {
        assert!(a.photons == b.photons && a.collectors == b.collectors);
    }
    assert!(with.picture() == without.picture());
}

/// One triangle away from the last: light may get in, so caustics are kept.
#[test]
fn glass_behind_a_hole_is_in_reach() {
    let mut desc = with_case(glass);
    desc.meshes[1].triangles.pop();
    desc.meshes[1].materials.pop();
    let scene = scene(&desc);
    let (render, _) = rendered(&scene, Planning::Derived);
    assert!(
        render.plan().classes.contains(PathClass::Caustic) && !render.states(PathClass::Caustic).is_empty()
    );
}

/// A lamp in a closed box is left out: the bytes of the scene without it.
#[test]
fn lamps_that_are_shut_off_are_left_out() {
    let desc = with_case(|desc| {
        lamp(desc);
        glass(desc);
    });
    let (with, without) = (scene(&desc), scene(&with_case(|_| ())));
    let (with, without) = (rendered(&with, Planning::Derived).0, rendered(&without, Planning::Derived).0);
    assert_eq!(with.plan().dropped_lights.len(), 1);
    assert!(with.picture() == without.picture());
}

/// With it, most photons fly in vain, and the picture is the same but for noise.
#[test]
fn lamps_that_are_shut_off_bring_no_light() {
    let scene = scene(&with_case(lamp));
    let mean = |planning| {
        let kinds = Kinds::Apart;
        let settings = Settings { planning, kinds, photons: 200_000, ..Settings::of_scene(scene.render()) };
        let mut render = Render::new(&scene, settings);
        (0..5).for_each(|_| _ = render.pass());
        let light = render.layer(PathClass::Indirect).unwrap();
        light.pixels().iter().map(|p| f64::from(p.x)).sum::<f64>() / light.pixels().len() as f64
    };
    let (planned, everything) = (mean(Planning::Derived), mean(Planning::Everything));
    assert!((everything / planned - 1.0).abs() < 0.02, "{everything} and {planned}");
}

/// No receiver: nothing shows light but lamps, so the picture is finished before the first pass.
#[test]
fn mirror_halls_and_empty_scenes_need_no_photons() {
    let mut mirrors = room();
    mirrors.meshes[0].materials.fill(MIRROR);
    let empty = SceneDesc { meshes: vec![], ..room() };
    let dark = SceneDesc { point_lights: vec![], ..room() };
    for desc in [mirrors, empty, dark] {
        let scene = scene(&desc);
        let (planned, passes) = rendered(&scene, Planning::Derived);
        assert!(planned.is_finished() && !planned.plan().photons, "{}", planned.plan());
        assert!(passes.iter().all(|pass| pass.photons.emitted == 0));
        let (everything, _) = rendered(&scene, Planning::Everything);
        assert!(planned.picture() == everything.picture());
    }
}

#[test]
fn direct_light_alone_needs_no_photons() {
    let scene = scene(&room());
    let all = Settings::of_scene(scene.render());
    let transport: PathClasses = [PathClass::Direct].into_iter().collect();
    let direct = Render::new(&scene, Settings { transport, ..all });
    assert!(direct.is_finished() && direct.states(PathClass::Indirect).is_empty());
    assert!(direct.picture() == Render::new(&scene, all).direct_picture());
}

const HALL: &str = "
[film]
width = 16
height = 16
[camera]
position = [0, 0, 5]
look_at = [0, 0, 0]
fov = 40
[material.mirror]
mirror = { reflectance = [0.9, 0.9, 0.9] }
[[point_light]]
position = [0, 3, 0]
intensity = [1, 1, 1]
[[quad]]
corners = [[-9, -1, -9], [-9, -1, 9], [9, -1, 9], [9, -1, -9]]
material = \"mirror\"
";

#[test]
fn the_program_stops_where_no_pass_is_called_for() {
    let folder = tempfile::tempdir().unwrap();
    let (hall, picture) = (folder.path().join("hall.toml"), folder.path().join("hall.exr"));
    fs::write(&hall, HALL).unwrap();
    let mut command = Command::cargo_bin("caustica").unwrap();
    let output = command.arg("render").arg(&hall).arg("-o").arg(&picture).output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && picture.exists(), "{message}");
    assert!(message.contains("no pass is called for") && message.contains("0 passes"), "{message}");
}
