//! A picture in ten lines: `cargo run --release --example picture SCENE OUTPUT.exr`.

use std::error::Error;

use caustica::output::{Metadata, write_exr};
use caustica::{Render, Scene, Settings, scene};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(file), Some(output)) = (arguments.next(), arguments.next()) else {
        return Err("usage: picture SCENE OUTPUT.exr".into());
    };
    let desc = scene::load(file.as_ref())?;
    let (passes, settings) = (desc.render.passes, Settings::of_scene(&desc.render));
    let scene = Scene::new(desc)?;
    let mut render = Render::new(&scene, settings);
    for _ in 0..passes {
        render.pass();
    }
    write_exr(output.as_ref(), &render.picture(), &Metadata::new())?;
    Ok(())
}
