//! Seconds of a whole photon pass (trace, gather) of 100,000 photons at 512 x 512 pixels and 4
//! samples a pixel, on all cores. The radius shrinks from pass to pass, so the first passes are the dearest.

use std::path::Path;

use caustica::ppm::{Render, Settings};
use caustica::scene::{self, Scene, water};
use criterion::{Criterion, SamplingMode, criterion_group, criterion_main};

const SCENES: [&str; 3] = ["course_diffuse", "course_balls", "course_water"];

fn scene(name: &str) -> Result<Scene, Box<dyn std::error::Error>> {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("data");
    let surface = data.join("surface.obj");
    if !surface.exists() {
        caustica::output::write_atomically(&surface, |mut out| {
            water::write_obj(&mut out, water::DEFAULT_CELLS)
        })?;
    }
    Ok(Scene::new(scene::load(&data.join(name).with_extension("toml"))?)?)
}

fn passes(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("pass");
    group.sample_size(10).sampling_mode(SamplingMode::Flat);
    for name in SCENES {
        match scene(name) {
            Ok(scene) => {
                let settings = Settings::of_scene(scene.render());
                let mut render = Render::new(&scene, settings);
                group.bench_function(name, |bencher| bencher.iter(|| render.pass()));
            }
            Err(error) => eprintln!("{name}: {error}"),
        }
    }
    group.finish();
}

criterion_group!(benches, passes);
criterion_main!(benches);
