//! The project's own scene files.

#![allow(clippy::unwrap_used)]

mod common;

use std::fs;
use std::path::Path;

use caustica::bsdf::Bsdf;
use caustica::math::{Aabb, Rgb, Vec3};
use caustica::scene::{Mesh, SceneDesc, load, water};

/// One of the project's own scenes.
fn ours(name: &str) -> SceneDesc {
    load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name)).unwrap()
}

/// Loads a scene of this text that lies beside the other `files`.
fn read(text: &str, files: &[(&str, &[u8])]) -> Result<SceneDesc, String> {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        fs::write(folder.path().join(name), bytes).unwrap();
    }
    let path = folder.path().join("s.toml");
    fs::write(&path, text).unwrap();
    load(&path).map_err(|e| e.to_string())
}

fn normal(mesh: &Mesh, triangle: usize) -> Vec3 {
    let [a, b, c] = mesh.corners(triangle);
    (b - a).cross(c - a).normalize()
}

/// Whether the front of every triangle of quad `i` sees `point`.
fn faces(scene: &SceneDesc, i: usize, point: Vec3) -> bool {
    let mesh = &scene.meshes[i];
    (0..2).all(|t| normal(mesh, t).dot(point - mesh.vertices[0]) > 0.0)
}

/// The scene in the documentation, with each mesh file it names.
#[test]
fn the_documented_format_loads() {
    let docs = include_str!("../docs/scenes.md");
    let text = docs.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    let mut surface = Vec::new();
    water::write_obj(&mut surface, 2).unwrap();
    let scene = read(text, &[("surface.obj", &surface)]).unwrap();
    assert_eq!((scene.spheres.len(), scene.meshes.len(), scene.point_lights.len()), (1, 2, 1));
    let smooth = scene.meshes[1].normals.as_ref().unwrap();
    assert_eq!(smooth.len(), 9);
}

#[test]
fn the_course_scenes_hold_the_courses_numbers() {
    for (name, n_materials) in [("course_diffuse.toml", 3), ("course_balls.toml", 5)] {
        let scene = ours(name);
        assert_eq!((scene.meshes.len(), scene.spheres.len(), scene.materials.len()), (5, 2, n_materials));
        assert_eq!((scene.point_lights.len(), scene.warnings.len()), (1, 0));
        assert_eq!(
            (scene.render.radius, scene.render.photons, scene.render.alpha),
            (Some(0.5), 100_000, 0.7)
        );
        assert!((0..5).all(|i| faces(&scene, i, Vec3::new(0.0, 60.0, 100.0))));
        let extent = |m: &Mesh| Aabb::of_points(m.vertices.iter().copied()).extent();
        assert!(scene.meshes.iter().all(|m| extent(m).element_sum() == 1500.0));
    }
    let balls = ours("course_balls.toml");
    let kind = |i: usize| (balls.spheres[i].center, balls.materials[balls.spheres[i].material as usize].bsdf);
    let color = Rgb::splat(0.7);
    let reflecting = Bsdf::FixedWeight { color, reflectivity: 0.5, transparency: 0.0, ior: 1.0 };
    let refracting = Bsdf::FixedWeight { color, reflectivity: 0.0, transparency: 0.5, ior: 1.5 };
    assert_eq!(kind(0), (Vec3::new(23.5, 16.5, 31.0), reflecting));
    assert_eq!(kind(1), (Vec3::new(-22.5, 16.5, 0.0), refracting));
}

#[test]
fn the_water_scene_loads_beside_its_surface() {
    let mut surface = Vec::new();
    water::write_obj(&mut surface, 32).unwrap();
    let text =
        fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("data/course_water.toml")).unwrap();
    let scene = read(&text, &[("surface.obj", &surface)]).unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    assert_eq!((scene.meshes.len(), scene.spheres.len(), scene.materials.len()), (6, 2, 6));
    let (sheet, built) = (&scene.meshes[5], water::surface_mesh(32));
    assert_eq!((sheet.vertices.len(), sheet.triangles.len()), (33 * 33, 2 * 32 * 32));
    assert!(
        sheet.vertices.iter().all(|v| v.abs().x <= 60.0 && v.abs().z <= 60.0 && (v.y - 50.0).abs() < 1.7)
    );
    // The loader numbers vertices as the faces first use them, so the sheets are compared corner by corner.
    let placed = |v: Vec3| 120.0 * v + Vec3::new(0.0, 50.0, 0.0);
    for t in 0..built.triangles.len() {
        assert!(
            sheet.corners(t).into_iter().zip(built.corners(t)).all(|(a, b)| (a - placed(b)).length() < 3e-5)
        );
        let of = |mesh: &Mesh| mesh.triangles[t].map(|i| mesh.normals.as_ref().unwrap()[i as usize]);
        assert!(of(sheet).into_iter().zip(of(&built)).all(|(a, b)| (a - b).length() < 1e-6));
    }
}

#[test]
fn the_cornell_scenes_hold_their_numbers() {
    let a = ours("cornell_a.toml");
    assert_eq!(
        (a.meshes.len(), a.spheres.len(), a.point_lights[0].intensity),
        (15, 0, Rgb::splat(150_000.0))
    );
    assert_eq!((a.render.radius, a.warnings.len()), (Some(2.0), 0));
    let b = ours("cornell_b.toml");
    assert_eq!((b.meshes.len(), b.spheres.len(), b.point_lights.len()), (6, 2, 0));
    assert_eq!((b.render.radius, b.warnings.len()), (Some(1.0), 0));
    let middle = Vec3::new(275.0, 500.0, 100.0);
    assert!((0..5).all(|i| faces(&a, i, middle) && faces(&b, i, middle)));
    for (block, center) in [(5..10, Vec3::new(185.0, 80.0, 170.0)), (10..15, Vec3::new(368.0, 160.0, 351.0))]
    {
        assert!(block.into_iter().all(|i| {
            let mesh = &a.meshes[i];
            (0..2).all(|t| normal(mesh, t).dot(center - mesh.vertices[0]) < 0.0)
        }));
    }
    let light = &b.meshes[5];
    assert!(normal(light, 0) == Vec3::NEG_Y && light.vertices[0].y == 549.9);
    assert_eq!(b.materials[light.materials[0] as usize].emission, Rgb::splat(80.0));
    for scene in [a, b] {
        assert_eq!(
            (scene.camera.position, scene.camera.fov_degrees),
            (Vec3::new(275., 275., -800.), 39.3077)
        );
    }
}

/// What stands in `data/` is read without a complaint, so that nothing there is of no use.
#[test]
fn every_scene_of_the_project_is_read() {
    let folder = common::data("course_water.toml").parent().unwrap().to_path_buf();
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let scenes: Vec<_> = files.filter(|path| path.extension().is_some_and(|e| e == "toml")).collect();
    assert!(scenes.len() >= 14, "{scenes:?}");
    for path in scenes {
        let scene = load(&path).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(scene.warnings, Vec::<String>::new(), "{}", path.display());
    }
}
