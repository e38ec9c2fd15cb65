//! Rays a second on one thread, Embree against the project's own tree, in turns: eye rays, diffuse bounces off
//! what they hit, and shadow rays from there to the lights.

use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use caustica::bsdf::{DiffuseSampling, sample_diffuse};
use caustica::math::{Ray, Rng, Stream, Vec2, Vec3, offset_origin};
use caustica::scene::{self, Mesh, Scene, SceneDesc, SurfaceHit, Traversal, water};

type Error = Box<dyn std::error::Error>;

const SIDE: u32 = 512;
const ROUNDS: u32 = 7;

fn desc(name: &str) -> Result<SceneDesc, Error> {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("data");
    let surface = data.join("surface.obj");
    if !surface.exists() {
        caustica::output::write_atomically(&surface, |mut out| {
            water::write_obj(&mut out, water::DEFAULT_CELLS)
        })?;
    }
    Ok(scene::load(&data.join(name).with_extension("toml"))?)
}

/// The water scene with about a million triangles.
fn million() -> Result<SceneDesc, Error> {
    let mut desc = desc("course_water")?;
    if let Some(surface) = desc.meshes.iter_mut().max_by_key(|mesh| mesh.triangles.len()) {
        let fine = water::surface_mesh(708);
        let low = |mesh: &Mesh| mesh.vertices.iter().fold(Vec3::INFINITY, |m, v| m.min(*v));
        let high = |mesh: &Mesh| mesh.vertices.iter().fold(Vec3::NEG_INFINITY, |m, v| m.max(*v));
        let scale = (high(surface) - low(surface)).x / (high(&fine) - low(&fine)).x;
        let shift = low(surface) - scale * low(&fine);
        surface.vertices = fine.vertices.iter().map(|&v| scale * v + shift).collect();
        surface.materials = vec![surface.materials[0]; fine.triangles.len()];
        (surface.normals, surface.triangles) = (fine.normals, fine.triangles);
    }
    Ok(desc)
}

struct Rays {
    eye: Vec<Ray>,
    diffuse: Vec<Ray>,
    shadow: Vec<Ray>,
}

impl Rays {
    fn of(scene: &Scene) -> Rays {
        let film = scene.film();
        let rasters = (0..SIDE * SIDE).map(|k| {
            Vec2::new((k % SIDE) as f32 + 0.5, (k / SIDE) as f32 + 0.5) / SIDE as f32
                * Vec2::new(film.width as f32, film.height as f32)
        });
        let eye: Vec<Ray> = rasters.map(|raster| scene.camera().ray(raster)).collect();
        let hits: Vec<SurfaceHit> = eye.iter().filter_map(|ray| scene.intersect(ray)).collect();
        let diffuse = (0..).zip(&hits).map(|(index, hit)| bounce(hit, index)).collect();
        let shadow = hits.iter().flat_map(|hit| shadows(scene, hit)).collect();
        Rays { eye, diffuse, shadow }
    }
}

fn bounce(hit: &SurfaceHit, index: u64) -> Ray {
    let mut rng = Rng::new(1, Stream::Test, 0, index);
    let (wi, _) = sample_diffuse(DiffuseSampling::Cosine, hit.wo_local(), &mut rng);
    let dir = hit.frame().to_world(wi);
    Ray::new(offset_origin(hit.p, hit.p_error, hit.ng, dir), dir)
}

fn shadows(scene: &Scene, hit: &SurfaceHit) -> Vec<Ray> {
    let samples = scene.lights().illuminate_delta(hit.p);
    let ray = |sample: caustica::light::IlluminationSample| {
        let origin = offset_origin(hit.p, hit.p_error, hit.ng, sample.wi);
        Ray { origin, dir: sample.target - origin, t_max: 1.0 - 1e-5 }
    };
    samples.map(ray).collect()
}

fn seconds(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64()
}

/// The least time of each, taken in turns.
fn in_turns(mut first: impl FnMut(), mut second: impl FnMut()) -> [f64; 2] {
    let rounds = (0..ROUNDS).map(|_| [seconds(&mut first), seconds(&mut second)]);
    rounds.fold([f64::INFINITY; 2], |best, now| [best[0].min(now[0]), best[1].min(now[1])])
}

fn report(name: &str, kind: &str, n: usize, [embree, custom]: [f64; 2]) {
    let millions = |seconds: f64| n as f64 / seconds / 1e6;
    println!(
        "{name:15} {kind:8} {n:7} rays: embree {:6.2} M/s, custom {:6.2} M/s, custom/embree {:.2}",
        millions(embree),
        millions(custom),
        embree / custom
    );
}

fn consume(count: usize) {
    black_box(count);
}

fn measure(name: &str, desc: SceneDesc) -> Result<(), Error> {
    let embree = Scene::with_traversal(desc.clone(), Traversal::Embree)?;
    let custom = Scene::with_traversal(desc, Traversal::Custom)?;
    let rays = Rays::of(&embree);
    for (kind, rays) in [("eye", &rays.eye), ("diffuse", &rays.diffuse)] {
        let trace = |scene: &Scene| rays.iter().filter_map(|ray| black_box(scene.intersect(ray))).count();
        let times = in_turns(|| consume(trace(&embree)), || consume(trace(&custom)));
        report(name, kind, rays.len(), times);
    }
    let trace = |scene: &Scene| rays.shadow.iter().filter(|ray| scene.occluded(ray)).count();
    let times = in_turns(|| consume(trace(&embree)), || consume(trace(&custom)));
    report(name, "shadow", rays.shadow.len(), times);
    Ok(())
}

fn main() -> Result<(), Error> {
    for name in ["course_diffuse", "course_water"] {
        measure(name, desc(name)?)?;
    }
    measure("million", million()?)
}
