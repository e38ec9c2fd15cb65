//! Scenes that others made, as they are: they load, their lights shine, and both methods agree about them.
//!
//! The scenes are not part of the project; where they are absent the tests say so and pass.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a panic is how a test fails")]

mod common;

use std::fs;
use std::path::{Path, PathBuf};

use caustica::bsdf::{Bsdf, Interface, RoughSurface};
use caustica::film::Image;
use caustica::math::{Rgb, mean};
use caustica::ppm::Settings;
use caustica::scene::{FilmDesc, Scene, SceneDesc, load};
use common::{path_traced, photon_mapped, settings};

fn foreign(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes").join(name);
    if path.exists() {
        return Some(path);
    }
    eprintln!("skipped: the scene {} is not there", path.display());
    None
}

/// A scene file that names the mesh `path` and has the tables `more`.
fn scene_of(path: &Path, more: &str) -> SceneDesc {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("s.toml");
    let path = fs::canonicalize(path).unwrap();
    fs::write(&scene, format!("[[mesh]]\nfile = {:?}\n{more}", path.to_str().unwrap())).unwrap();
    load(&scene).unwrap()
}

fn bsdf(desc: &SceneDesc, name: &str) -> Bsdf {
    let end = format!(":{name}");
    desc.materials.iter().find(|material| material.name.ends_with(&end)).expect(name).bsdf
}

fn mean_of(image: &Image) -> f64 {
    let sum: f64 = image.pixels().iter().map(|pixel| f64::from(mean(*pixel))).sum();
    sum / image.pixels().len() as f64
}

/// The means of the pictures of both methods, in a small size.
fn brightness(desc: &SceneDesc, samples: u32) -> [f64; 2] {
    let film = FilmDesc { width: 32, height: 32, ..desc.film };
    let scene = Scene::new(SceneDesc { film, ..desc.clone() }).unwrap();
    let settings = Settings { photons: 50_000, ..settings(&scene) };
    [mean_of(&photon_mapped(&scene, settings, 12)), mean_of(&path_traced(&scene, samples).0)]
}

fn assert_agreement(desc: &SceneDesc, samples: u32, tolerance: f64) {
    let [photons, paths] = brightness(desc, samples);
    eprintln!("{}: photon mapping {photons}, path tracing {paths}", desc.name);
    assert!(paths > 0.0 && (photons / paths - 1.0).abs() < tolerance, "{}: {photons} and {paths}", desc.name);
}

const MCGUIRE_CAMERA: &str = "[camera]\nposition = [0, 1, 3.4]\nlook_at = [0, 1, 0]\nfov = 40\n";

#[test]
fn the_cornell_boxes_of_mcguire_are_lit_by_their_own_lights() {
    for (name, radiance) in
        [("Original", [17., 12., 4.]), ("Mirror", [17., 12., 4.]), ("Glossy", [10.; 3]), ("Sphere", [10.; 3])]
    {
        let Some(path) = foreign(&format!("mcguire/CornellBox-{name}.obj")) else { return };
        let desc = scene_of(&path, MCGUIRE_CAMERA);
        let lights: Vec<_> =
            desc.materials.iter().filter(|material| material.emission != Rgb::ZERO).collect();
        assert_eq!(lights.len(), 1, "{name}");
        assert_eq!(lights[0].emission, Rgb::from(radiance), "{name}");
        assert_agreement(&desc, 512, 0.05);
    }
}

#[test]
fn the_surfaces_of_mcguires_boxes_are_what_they_are_called() {
    let Some(path) = foreign("mcguire/CornellBox-Mirror.obj") else { return };
    let mirror = scene_of(&path, MCGUIRE_CAMERA);
    assert_eq!(bsdf(&mirror, "tallBox"), Bsdf::Mirror { reflectance: Rgb::splat(0.95) });
    let sphere = scene_of(&path.with_file_name("CornellBox-Sphere.obj"), MCGUIRE_CAMERA);
    assert_eq!(bsdf(&sphere, "leftSphere"), Bsdf::Mirror { reflectance: Rgb::splat(0.95) });
    assert_eq!(bsdf(&sphere, "rightSphere"), Bsdf::Dielectric { ior: 2.5 });
    let glossy = scene_of(&path.with_file_name("CornellBox-Glossy.obj"), MCGUIRE_CAMERA);
    assert!(matches!(bsdf(&glossy, "floor"), Bsdf::Plastic(_)));
    let Bsdf::Rough(RoughSurface { facets, .. }) = bsdf(&glossy, "sphere") else { panic!("not rough") };
    assert!((facets.alpha - (2f32 / 34.0).sqrt()).abs() < 1e-6);
}

#[test]
fn a_bare_mesh_is_a_scene_with_a_camera() {
    let Some(path) = foreign("mcguire/CornellBox-Original.obj") else { return };
    let desc = load(&path).unwrap();
    assert!(
        desc.warnings.iter().any(|warning| warning.contains("a mesh has no camera")),
        "{:?}",
        desc.warnings
    );
    let scene = Scene::new(SceneDesc { film: FilmDesc::new(64, 64), ..desc }).unwrap();
    let image = photon_mapped(&scene, Settings { photons: 20_000, ..settings(&scene) }, 2);
    let lit = image.pixels().iter().filter(|pixel| mean(**pixel) > 0.0).count();
    assert!(lit > 64 * 64 / 2, "the room fills most of the picture: {lit} pixels");
}

#[test]
fn the_ring_and_the_glass_are_rough_gold_and_clear_glass() {
    let Some(path) = foreign("baked/ring-glass-caustics/ring-glass-caustics.obj") else { return };
    let desc = scene_of(
        &path,
        "[camera]\nposition = [2.7, 0.5, 3.1]\nlook_at = [0.75, -1.9, 0.55]\nfov = 45\n\
         [[point_light]]\nposition = [2.42, 0, -2.432593]\nintensity = [170, 120, 40]\n",
    );
    assert_eq!(bsdf(&desc, "Glass"), Bsdf::Dielectric { ior: 1.52 });
    let Bsdf::Rough(RoughSurface { facets, interface: Interface::Conductor { reflectance, .. } }) =
        bsdf(&desc, "Ring")
    else {
        panic!("not a rough metal")
    };
    assert!((facets.alpha - 0.01).abs() < 1e-6 && (reflectance.x - 0.95652).abs() < 1e-6);
    let scene = Scene::new(SceneDesc { film: FilmDesc::new(32, 32), ..desc }).unwrap();
    assert!(mean_of(&photon_mapped(&scene, Settings { photons: 50_000, ..settings(&scene) }, 2)) > 0.0);
}

#[test]
fn veachs_room_is_lit_by_its_two_lamps() {
    let Some(path) = foreign("baked/veach-bidir/veach-bidir.obj") else { return };
    let camera = "[camera]\nposition = [16.2155, 4.05167, 0.0114864]\nlook_at = [15.2155, 4.047, 0.00646176]\n\
         up = [-0.00467005, 0.999989, -2.34659e-05]\nfov = 35\n";
    let desc = scene_of(&path, camera);
    let lamps = desc.materials.iter().filter(|material| material.emission != Rgb::ZERO);
    assert_eq!(lamps.map(|lamp| lamp.emission.x).collect::<Vec<_>>(), [12048.2, 156.3258]);
    assert_eq!(bsdf(&desc, "Glass"), Bsdf::Dielectric { ior: 1.5 });
    let scene = Scene::new(SceneDesc { film: FilmDesc::new(32, 32), ..desc }).unwrap();
    assert!(mean_of(&photon_mapped(&scene, Settings { photons: 50_000, ..settings(&scene) }, 2)) > 0.0);
}
