//! Embree and the project's own tree share no code, so what they agree on is right.
#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

mod common;

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use caustica::bsdf::{DiffuseSampling, sample_diffuse};
use caustica::compare::{BlockCriterion, BlockReport, Estimate};
use caustica::film::Image;
use caustica::math::{Ray, Rng, Stream, Vec2, offset_origin};
use caustica::ppm::Settings;
use caustica::scene::{Coherence, Scene, SurfaceHit, Traversal};
use common::{data, desc, photon_mapped, settings};

const SCENES: [&str; 5] =
    ["course_diffuse.toml", "course_balls.toml", "course_water.toml", "cornell_a.toml", "cornell_b.toml"];

fn both(name: &str, size: u32) -> [Scene; 2] {
    [Traversal::Embree, Traversal::Custom].map(|traversal| {
        let mut desc = desc(name);
        (desc.film.width, desc.film.height) = (size, size);
        let scene = Scene::with_traversal(desc, traversal).unwrap();
        assert_eq!(scene.traversal(), traversal);
        scene
    })
}

/// Right beside the origin of a ray, the error of a point is much of the way to it.
fn is_same_point(a: &SurfaceHit, b: &SurfaceHit) -> bool {
    a.material == b.material && a.ng.dot(b.ng) > 0.99999 && a.p.distance(b.p) <= a.p_error
}

fn agree(a: &Option<SurfaceHit>, b: &Option<SurfaceHit>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => (a.t / b.t - 1.0).abs() < 1e-4 || is_same_point(a, b),
        (a, b) => a.is_none() && b.is_none(),
    }
}

/// How often the two were asked, and how often they disagreed.
#[derive(Debug, Default)]
struct Tally {
    rays: u64,
    hits: u64,
    disagreements: u64,
}

impl Tally {
    /// The nearest hit by both; that of Embree is returned.
    fn nearest(&mut self, [embree, custom]: &[Scene; 2], ray: &Ray) -> Option<SurfaceHit> {
        let hits = [embree, custom].map(|scene| scene.intersect(ray));
        self.count(hits[0].is_some(), agree(&hits[0], &hits[1]), ray);
        hits[0]
    }

    fn any(&mut self, scenes: &[Scene; 2], ray: &Ray) {
        let [embree, custom] = [0, 1].map(|k| scenes[k].occluded(ray));
        self.count(embree, embree == custom, ray);
    }

    fn count(&mut self, hit: bool, agree: bool, ray: &Ray) {
        self.rays += 1;
        self.hits += u64::from(hit);
        self.disagreements += u64::from(!agree);
        if !agree {
            eprintln!("disagreement: {ray:?}");
        }
    }

    /// An eye ray, shadow rays from what it hits, a bounce off it, and so on.
    fn follow(&mut self, scenes: &[Scene; 2], mut ray: Ray, rng: &mut Rng) {
        for _ in 0..4 {
            let Some(hit) = self.nearest(scenes, &ray) else { return };
            let receiver = hit.receiver();
            let lights = scenes[0].lights();
            for light in lights.illuminate_delta(hit.p).chain(lights.illuminate_area(hit.p, rng)) {
                let origin = offset_origin(hit.p, hit.p_error, hit.ng, light.wi);
                let dir = light.target - origin;
                self.any(scenes, &Ray { origin, dir, t_max: 1.0 - light.target_error / dir.length() });
            }
            let (wi, _) = sample_diffuse(DiffuseSampling::Cosine, hit.wo_local(), rng);
            // Every other bounce goes through the surface, so that spheres and water are seen from inside.
            let through = if rng.next_f32() < 0.5 { -1.0 } else { 1.0 };
            let dir = through * hit.frame().to_world(wi);
            ray = Ray::new(offset_origin(hit.p, hit.p_error, receiver.ng, dir), dir);
        }
    }
}

/// More than a million rays in all.
#[test]
fn rays_hit_the_same_surfaces() {
    let mut all = Tally::default();
    for name in SCENES {
        let scenes = both(name, 220);
        let mut tally = Tally::default();
        for index in 0..220 * 220 {
            let mut rng = Rng::new(0, Stream::Test, 7, index);
            let raster = Vec2::new((index % 220) as f32, (index / 220) as f32) + rng.next_vec2();
            let ray = scenes[0].camera().ray(raster);
            tally.follow(&scenes, ray, &mut rng);
        }
        eprintln!("{name}: {tally:?}");
        assert!(tally.disagreements * 100_000 < tally.rays, "{name}: {tally:?}");
        all.rays += tally.rays;
    }
    assert!(all.rays > 1_000_000, "only {} rays", all.rays);
}

/// Ties at the edges of triangles are free to fall either way.
#[test]
fn many_rays_at_once_hit_what_single_rays_hit() {
    const SIZE: u32 = 221;
    for name in SCENES {
        for scene in both(name, SIZE) {
            let pixel = |k: u32| Vec2::new((k % SIZE) as f32, (k / SIZE) as f32) + 0.5;
            let rays: Vec<Ray> = (0..SIZE * SIZE).map(|k| scene.camera().ray(pixel(k))).collect();
            for coherence in [Coherence::Coherent, Coherence::Incoherent] {
                let mut found = vec![None; rays.len()];
                scene.intersect_all(&rays, coherence, |k, hit| found[k] = Some(*hit));
                let pairs = rays.iter().map(|ray| scene.intersect(ray)).zip(&found);
                let different = pairs.filter(|(single, batch)| !agree(single, batch)).count();
                assert!(different * 10_000 < rays.len(), "{name}: {different} of {}", rays.len());
                assert!(found.iter().flatten().count() > rays.len() / 3, "{name}");
            }
        }
    }
}

fn picture(scene: &Scene) -> Image {
    let settings = Settings { photons: 300_000, samples: 4, radius: Some(1.5), ..settings(scene) };
    photon_mapped(scene, settings, 3)
}

/// With one seed nearly all paths are the same, so pictures differ by far less than their noise.
#[test]
fn pictures_are_the_same() {
    for name in SCENES {
        let scenes = both(name, 48);
        let [embree, custom] = [picture(&scenes[0]), picture(&scenes[1])];
        let share_within = |tolerance| {
            let criterion = BlockCriterion { block: 8, ..BlockCriterion::new(tolerance, 0.0) };
            let [a, b] = [&custom, &embree].map(Estimate::exact);
            BlockReport::between(a, b, &criterion).unwrap().share_within()
        };
        assert!(share_within(0.005) > 0.95 && share_within(0.04) == 1.0, "{name}");
    }
}

fn rendered(folder: &Path, scene: &str, threads: &str) -> Vec<u8> {
    let output = folder.join(format!("{threads}.exr"));
    #[rustfmt::skip]
    Command::cargo_bin("caustica").unwrap().args([
        "render", scene, "-o", output.to_str().unwrap(), "--traversal", "custom", "--threads", threads,
        "--passes", "2", "--photons", "2e4", "--samples", "1", "--reproducible",
    ]).assert().success();
    fs::read(output).unwrap()
}

/// The water's tree is large enough to be built in parallel.
#[test]
fn the_picture_does_not_depend_on_threads() {
    let folder = tempfile::tempdir().unwrap();
    let scene = data("course_water.toml");
    let [one, two, seven] = ["1", "2", "7"].map(|n| rendered(folder.path(), scene.to_str().unwrap(), n));
    assert!(one == two && one == seven);
    let name = |value: &[u8]| one.windows(value.len()).any(|bytes| bytes == value);
    assert!(name(b"caustica:traversal\0string\0\x06\0\0\0custom"), "the header does not name the traversal");
}

#[test]
fn info_names_the_traversal() {
    let scene = data("cornell_a.toml");
    for traversal in ["embree", "custom"] {
        let arguments = ["info", scene.to_str().unwrap(), "--traversal", traversal];
        let run = |more: &[&str]| {
            let output = Command::cargo_bin("caustica").unwrap().args(arguments).args(more).output().unwrap();
            String::from_utf8(output.stdout).unwrap()
        };
        assert!(run(&[]).contains(&format!("traversal    {traversal}")));
        assert!(run(&["--json"]).contains(&format!("\"traversal\":\"{traversal}\"")));
    }
}
