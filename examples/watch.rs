//! A render that its caller watches and stops: `cargo run --release --example watch SCENE PERCENT`.
//!
//! After every pass it prints what the pass did and how the discs of the hit points stand, and it ends as soon as the picture's own
//! estimate of its error is below PERCENT.

use std::error::Error;

use caustica::effects::PathClass;
use caustica::ppm::ErrorEstimates;
use caustica::{PassStatistics, Render, Scene, Settings, scene};

const CONFIDENCE: f64 = 0.9;
const MOST_PASSES: u32 = 1000;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(file), Some(percent)) = (arguments.next(), arguments.next()) else {
        return Err("usage: watch SCENE PERCENT".into());
    };
    let target = percent.parse::<f64>()? / 100.0;
    let desc = scene::load(file.as_ref())?;
    let settings = Settings { error_estimates: ErrorEstimates::Picture, ..Settings::of_scene(&desc.render) };
    let scene = Scene::new(desc)?;
    let mut render = Render::new(&scene, settings);
    println!("{} hit points", render.hit_points().len());
    while render.passes() < MOST_PASSES && error(&render).is_none_or(|error| error > target) {
        let pass = render.pass();
        tell(&render, &pass);
    }
    Ok(())
}

/// What √relMSE stays below, as far as the passes tell.
fn error(render: &Render) -> Option<f64> {
    Some(render.accuracy(CONFIDENCE)?.picture().upper)
}

fn tell(render: &Render, pass: &PassStatistics) {
    let error =
        error(render).map_or("not known yet".into(), |error| format!("at most {:.1} %", 100.0 * error));
    println!(
        "pass {}: {} photons found in {:.3} s, radii {:.4} to {:.4}, {:.1} photons kept a hit point, error {error}",
        pass.pass,
        pass.gathered,
        pass.seconds,
        pass.radius.min,
        pass.radius.max,
        photons_kept(render),
    );
}

/// The mean over hit points of the reduced count `N`.
fn photons_kept(render: &Render) -> f64 {
    let states = render.states(PathClass::Indirect);
    states.iter().map(|state| state.photons).sum::<f64>() / states.len().max(1) as f64
}
