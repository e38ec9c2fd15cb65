//! Kernels to count the instructions of, where times are too noisy to compare: `make instructions` runs each under
//! callgrind, which counts inside `measured` alone. Prints how many units of what the kernel worked on, and its
//! nanoseconds.

use std::error::Error;
use std::hint::black_box;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use caustica::bench::gather_source::on_walls;
use caustica::bvh::{Sphere, SphereBvh};
use caustica::ppm::{PhotonPass, Render, Settings, camera_pass, photon_pass};
use caustica::scene::{self, Scene, Traversal};

const SPHERES: usize = 100_000;
const PHOTONS: usize = 20_000;

/// What the work took where it runs natively.
static NANOSECONDS: AtomicU64 = AtomicU64::new(0);

/// The name that callgrind is told of.
#[inline(never)]
fn measured<R>(work: impl FnOnce() -> R) {
    let start = Instant::now();
    black_box(work());
    NANOSECONDS.store(start.elapsed().as_nanos() as u64, Ordering::Relaxed);
}

/// As many overlaps a photon as the first pass of the course scene has in its corners.
fn spheres() -> Vec<Sphere> {
    on_walls(SPHERES, 0).into_iter().map(|center| Sphere { center, radius: 0.02 }).collect()
}

fn course(traversal: Traversal) -> Result<(Scene, Settings), Box<dyn Error + Send + Sync>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/course_diffuse.toml");
    let scene = Scene::with_traversal(scene::load(&path)?, traversal)?;
    let settings = Settings { photons: PHOTONS as u64, samples: 1, ..Settings::of_scene(scene.render()) };
    Ok((scene, settings))
}

/// Runs a kernel by name, and tells how many units of what it worked on.
fn run(kernel: &str) -> Result<(usize, &'static str), Box<dyn Error + Send + Sync>> {
    match kernel {
        "build" => {
            let spheres = spheres();
            measured(|| SphereBvh::build(&spheres));
            Ok((SPHERES, "sphere"))
        }
        "refit" => {
            let (mut tree, _) = SphereBvh::build(&spheres());
            measured(|| tree.refit(|_| 0.01));
            Ok((SPHERES, "sphere"))
        }
        "count" => {
            let (mut tree, _) = SphereBvh::build(&spheres());
            let (photons, mut counts) = (on_walls(PHOTONS, 1), vec![0u32; SPHERES]);
            measured(|| tree.gather(&photons, &mut counts, |count, _, _| *count += 1));
            Ok((PHOTONS, "photon"))
        }
        "eye" => {
            let (scene, settings) = course(Traversal::Embree)?;
            measured(|| camera_pass::trace(&scene, &settings, 0).rays);
            Ok(((scene.film().width * scene.film().height) as usize, "pixel"))
        }
        "photons" => {
            let (scene, settings) = course(Traversal::Embree)?;
            measured(|| PhotonPass::default().trace(&scene, &settings, 0).ledger);
            Ok((PHOTONS, "photon"))
        }
        "pass" => {
            let (scene, settings) = course(Traversal::Embree)?;
            let mut render = Render::new(&scene, settings);
            measured(|| render.pass());
            Ok((PHOTONS, "photon"))
        }
        "embree" => rays(Traversal::Embree),
        "custom" => rays(Traversal::Custom),
        other => Err(format!("{other} is no kernel").into()),
    }
}

fn rays(traversal: Traversal) -> Result<(usize, &'static str), Box<dyn Error + Send + Sync>> {
    let (scene, settings) = course(traversal)?;
    let rays = photon_pass::record_rays(&scene, &settings, 0);
    measured(|| rays.iter().filter(|ray| scene.distance(ray).is_some()).count());
    Ok((rays.len(), "ray"))
}

fn main() -> Result<(), Box<dyn Error + Send + Sync>> {
    // `cargo bench` runs every program of this folder, with arguments of its own.
    let Some(kernel) = std::env::args().nth(1).filter(|argument| !argument.starts_with('-')) else {
        println!("instructions are counted by `make instructions`");
        return Ok(());
    };
    // On one thread, and all of it there: callgrind keeps a switch for every thread.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let (units, unit) = pool.install(|| run(&kernel))?;
    println!("{units} {unit} {}", NANOSECONDS.load(Ordering::Relaxed));
    Ok(())
}
