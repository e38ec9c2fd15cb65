//! What a plan leaves out brings no light, and `caustica explain` says why.
#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

mod common;

use assert_cmd::Command;
use caustica::bsdf::Bsdf;
use caustica::effects::{PathClass, PathClasses, Plan};
use caustica::math::{RELATIVE_POSITION_ERROR, Ray, Rgb, Vec3, offset_origin};
use caustica::ppm::{PhotonPass, Planning, Render, Settings};
use caustica::scene::{Mesh, PointLightDesc, Scene, SceneDesc, SphereDesc, Traversal};
use common::{data, desc};
use proptest::prelude::*;
use serde_json::Value;

const DARK: u32 = 0;
const GREY: u32 = 1;
const MIRROR: u32 = 2;
const GLASS: u32 = 3;

/// A scene of boxes and balls in a small picture, with materials of every kind.
fn scene_of(meshes: Vec<Mesh>, spheres: Vec<SphereDesc>, lights: &[Vec3], camera: Vec3) -> Scene {
    let mut scene = desc("cornell_b.toml");
    let bsdfs = [
        Bsdf::Diffuse { albedo: Rgb::ZERO },
        Bsdf::Diffuse { albedo: Rgb::splat(0.7) },
        Bsdf::Mirror { reflectance: Rgb::splat(0.9) },
        Bsdf::Dielectric { ior: 1.5 },
    ];
    let material = scene.materials[0].clone();
    scene.materials =
        bsdfs.into_iter().map(|bsdf| caustica::scene::Material { bsdf, ..material.clone() }).collect();
    (scene.film.width, scene.film.height) = (12, 12);
    (scene.camera.position, scene.camera.look_at, scene.camera.fov_degrees) =
        (camera, 0.1 * Vec3::ONE, 100.0);
    let light = |position: &Vec3| PointLightDesc { position: *position, intensity: Rgb::ONE };
    let point_lights = lights.iter().map(light).collect();
    Scene::with_traversal(SceneDesc { meshes, spheres, point_lights, ..scene }, Traversal::Custom).unwrap()
}

/// A box, whole or without its first triangle.
fn case(middle: Vec3, half: f32, material: u32, is_whole: bool) -> Mesh {
    let mut mesh = Mesh::inward_cube("case", material);
    mesh.vertices.iter_mut().for_each(|vertex| *vertex = middle + half * *vertex);
    if !is_whole {
        mesh.triangles.remove(0);
        mesh.materials.remove(0);
    }
    mesh
}

/// Whether any light comes by paths of a kind to where the camera looks straight at: direct light of its hit points, or
/// photons that it sees. Discs would collect photons from behind a wall, too, as long as they are large.
fn brings_light(scene: &Scene, class: PathClass) -> bool {
    let settings = Settings {
        planning: Planning::Everything,
        photons: 5000,
        samples: 2,
        ..Settings::of_scene(scene.render())
    };
    if class == PathClass::Direct {
        let picture = Render::new(scene, settings).direct_picture();
        return picture.pixels().iter().any(|pixel| *pixel != Rgb::ZERO);
    }
    let mut pass = PhotonPass::default();
    let photons = pass.trace(scene, &settings, 0).of(class);
    let positions: Vec<Vec3> = photons.positions().concat();
    positions.iter().zip(photons.iter()).any(|(p, photon)| is_seen(scene, *p, photon.ng))
}

/// Whether the camera sees this side of a surface at `p`.
fn is_seen(scene: &Scene, p: Vec3, ng: Vec3) -> bool {
    let to_camera = scene.camera().position() - p;
    let origin = offset_origin(p, RELATIVE_POSITION_ERROR * p.abs().max_element(), ng, to_camera);
    let dir = scene.camera().position() - origin;
    ng.dot(to_camera) > 0.0 && !scene.occluded(&Ray { t_max: 1.0, ..Ray::new(origin, dir) })
}

fn place() -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(-2f32..2.0).prop_map(Vec3::from)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(300) })]

    /// The plan is derived, the picture is rendered without it: what is off there must be black here.
    #[test]
    fn what_is_left_out_brings_no_light(
        cases in prop::collection::vec((place(), 0.1f32..2.5, 0u32..4, prop::bool::weighted(0.8)), 0..4),
        balls in prop::collection::vec((place(), 0.1f32..1.5, 0u32..4), 0..3),
        lights in prop::collection::vec(place(), 1..3),
        camera in place(),
    ) {
        let meshes = cases.into_iter().map(|(at, half, material, whole)| case(at, half, material, whole)).collect();
        let spheres = balls.into_iter().map(|(center, radius, material)| SphereDesc { center, radius, material });
        let scene = scene_of(meshes, spheres.collect(), &lights, camera);
        let plan = Plan::of(&scene, PathClasses::ALL);
        for class in PathClass::ALL.into_iter().filter(|class| !plan.classes.contains(*class)) {
            prop_assert!(!brings_light(&scene, class), "{class} light in spite of\n{plan}");
        }
        for light in (0..lights.len() as u32).filter(|light| !plan.keeps_light(*light)) {
            let alone = vec![lights[light as usize]];
            let scene = scene_of(scene.meshes().cloned().collect(), scene.spheres().to_vec(), &alone, camera);
            for class in PathClass::ALL {
                prop_assert!(!brings_light(&scene, class), "{class} light of light {light} in spite of\n{plan}");
            }
        }
    }
}

/// The same for scenes in which much is left out.
#[test]
fn sealed_boxes_keep_what_is_in_them() {
    let room = || Mesh::inward_cube("room", GREY);
    let camera = Vec3::new(0.1, 0.2, 0.8);
    let light = [Vec3::new(0.2, 0.7, 0.1)];
    let ball = |center: Vec3, material| SphereDesc { center, radius: 0.2, material };
    let corner = Vec3::new(-0.5, -0.6, -0.3);
    for (is_whole, caustics) in [(true, false), (false, true)] {
        for material in [GLASS, MIRROR] {
            let sealed = scene_of(
                vec![room(), case(corner, 0.3, DARK, is_whole)],
                vec![ball(corner, material)],
                &light,
                camera,
            );
            let plan = Plan::of(&sealed, PathClasses::ALL);
            assert_eq!(plan.classes.contains(PathClass::Caustic), caustics, "{plan}");
            assert!(brings_light(&sealed, PathClass::Indirect));
            assert!(caustics || !brings_light(&sealed, PathClass::Caustic));
        }
    }
}

fn explain(arguments: &[&str]) -> (i32, String, String) {
    let output = Command::cargo_bin("caustica").unwrap().arg("explain").args(arguments).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

fn data_scene(name: &str) -> String {
    data(name).display().to_string()
}

#[test]
fn a_table_names_objects_files_and_lines() {
    let scene = data_scene("cornell_b.toml");
    let (code, text, errors) = explain(&[&scene, "--size", "32x32", "--photons", "5000", "--passes", "3"]);
    assert_eq!(code, 0, "{errors}");
    let file = std::fs::read_to_string(&scene).unwrap();
    let line = |start: &str, nth: usize| {
        let lines = file.lines().enumerate().filter(|(_, line)| line.starts_with(start));
        lines.map(|(number, _)| number + 1).nth(nth).unwrap()
    };
    for words in [
        format!(
            "specular transmission        on   sphere 2 ({scene}:{}) of `glass`\n",
            line("[[sphere]]", 1)
        ),
        format!("lamps in the picture         on   quad 6 ({scene}:{}) of `light`\n", line("[[quad]]", 5)),
        format!(
            "caustics                     on   sphere 1 ({scene}:{}) of `mirror`\n",
            line("[[sphere]]", 0)
        ),
        "point lights                 off  no light without extent has power\n".into(),
        "3 passes of 5000 photons:\n".into(),
    ] {
        assert!(text.contains(&words), "{words}in\n{text}");
    }
}

#[test]
fn json_holds_plan_seconds_and_what_each_effect_brings() {
    let scene = data_scene("course_water.toml");
    let short = ["--size", "24x24", "--photons", "5000", "--json"];
    let (code, text, errors) =
        explain(&[&[scene.as_str(), "--measure", "2", "--ablate"][..], &short].concat());
    assert_eq!(code, 0, "{errors}");
    let value: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(value["plan"]["classes"], serde_json::json!(["direct", "caustic", "indirect"]));
    assert_eq!((&value["passes"], &value["plan"]["eye_paths"]), (&2.into(), &"fixed".into()));
    for seconds in ["predicted", "measured"] {
        assert!(value[seconds]["eye_paths"].as_f64().unwrap() > 0.0, "{seconds}");
    }
    let ablation = value["ablation"].as_array().unwrap();
    let names: Vec<&str> = ablation.iter().map(|row| row["without"].as_str().unwrap()).collect();
    assert_eq!(
        names,
        [
            "nothing",
            "direct light",
            "caustic light",
            "indirect light",
            "specular reflection",
            "specular transmission"
        ]
    );
    let differences: Vec<f64> = ablation.iter().map(|row| row["rmse"].as_f64().unwrap()).collect();
    assert!(differences[0] == 0.0 && differences[1..].iter().all(|rmse| *rmse > 0.0), "{differences:?}");
}

/// The light is under the floor, which is open at its sides.
#[test]
fn a_render_says_once_that_no_photon_is_seen() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, picture) = (folder.path().join("away.toml"), folder.path().join("away.exr"));
    let text = "[film]\nwidth = 8\nheight = 8\n[camera]\nposition = [0, 1, 0]\nlook_at = [0, 0, 0.1]\nfov = 40\n\
        [render]\nphotons = 200\n[material.grey]\ndiffuse = { albedo = [0.5, 0.5, 0.5] }\n\
        [[point_light]]\nposition = [0, -5, 0]\nintensity = [1, 1, 1]\n\
        [[quad]]\ncorners = [[-9, 0, -9], [-9, 0, 9], [9, 0, 9], [9, 0, -9]]\nmaterial = \"grey\"\n";
    std::fs::write(&scene, text).unwrap();
    let mut command = Command::cargo_bin("caustica").unwrap();
    let output =
        command.arg("render").arg(&scene).arg("-o").arg(&picture).args(["--passes", "20"]).output().unwrap();
    let errors = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && picture.exists(), "{errors}");
    assert_eq!(errors.matches("none of 1600 photons in 8 passes fell on anything").count(), 1, "{errors}");
}

#[test]
fn only_what_is_asked_for_is_explained_as_on() {
    let scene = data_scene("course_diffuse.toml");
    let (code, text, _) = explain(&[&scene, "--size", "16x16", "--transport", "direct", "--passes", "1"]);
    assert!(code == 0 && text.contains("indirect light               off  not asked for\n"), "{text}");
    assert!(text.contains("photon passes                off  nothing is left but direct light"), "{text}");
}

#[test]
fn mistakes_are_told() {
    for (arguments, words) in [
        (&["no.toml"][..], "no.toml: cannot be read"),
        (&["no.toml", "--measure", "0"], "--measure"),
        (&["no.toml", "--measure", "1", "--passes", "2"], "cannot be used with"),
        (&["no.toml", "--transport", "caustics"], "`caustics` is no kind of path"),
    ] {
        let (code, text, errors) = explain(arguments);
        assert!(code == 2 && text.is_empty() && errors.contains(words), "{code} {errors}");
    }
}
