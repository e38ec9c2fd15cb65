use super::args::RenderArgs;
use super::error::{CliError, Outcome};
use super::error_watch::{ErrorWatch, percent};
use super::interrupt::Interrupt;
use super::outputs::Outputs;
use super::progress::{Budget, Progress};
use super::{load, use_threads};
use crate::ppm::{ErrorEstimates, Render, Settings};
use crate::scene::{Scene, SceneDesc};

/// Renders a scene by photon mapping: passes until the budget is spent or the target reached, then the picture.
pub fn run(args: &RenderArgs) -> Result<Outcome, CliError> {
    let threads = use_threads(args.run.threads)?;
    let mut desc = load(&args.scene)?;
    desc.film = args.run.size.unwrap_or(desc.film);
    let settings = settings(args, &desc);
    check_target(args, &settings)?;
    let mut outputs = Outputs::check(args, &desc, threads)?;
    let budget = budget(args, &desc);
    let scene = Scene::with_traversal(desc, args.run.traversal.into())?;
    let interrupt = Interrupt::listen();
    let progress = Progress::start("pass", budget);
    let mut render = Render::new(&scene, settings);
    announce(args, &render);
    let mut errors = ErrorWatch::new(args.target_error, args.confidence, &settings);
    while !(progress.is_over(render.passes()) || errors.is_met() || interrupt.is_asked()) {
        let pass = render.pass();
        let seconds = progress.seconds();
        let error = errors.after_pass(&render, seconds);
        outputs.after_pass(&render, &pass, error, seconds)?;
        let speed = format!("{:.0} photons/s", settings.photons as f64 / pass.seconds);
        progress.step(format!("{} {speed}", errors.message(seconds)));
    }
    progress.finish();
    outputs.write(&render, progress.seconds())?;
    if let Some(summary) = errors.summary() {
        eprintln!("{summary}");
    }
    Ok(if interrupt.is_asked() { Outcome::Interrupted } else { Outcome::Done })
}

fn announce(args: &RenderArgs, render: &Render) {
    let found = if render.settings().radius.is_some() { "" } else { " (found: two pixels wide)" };
    eprintln!("{} hit points, radius {:.4}{found}", render.setup().hit_points, render.setup().radius);
    let Some(target) = args.target_error else { return };
    let (target, confidence) = (percent(target), percent(args.confidence));
    eprintln!(
        "target: relative error (√relMSE over all pixels and channels, as `caustica compare` has it) at most {target} with {confidence} confidence"
    );
}

/// A radius that stays as it is hides its blur, so no error could be claimed.
fn check_target(args: &RenderArgs, settings: &Settings) -> Result<(), CliError> {
    let shrinks = settings.policy.asymptotic_exponent(settings.alpha) > 0.0;
    match args.target_error {
        Some(target) if !shrinks => Err(CliError::TargetOutOfReach { target: percent(target) }),
        _ => Ok(()),
    }
}

fn settings(args: &RenderArgs, desc: &SceneDesc) -> Settings {
    let of_scene = Settings::of_scene(&desc.render);
    Settings {
        samples: args.samples.unwrap_or(of_scene.samples),
        depth: args.depth.unwrap_or(of_scene.depth),
        photons: args.photons.unwrap_or(of_scene.photons),
        alpha: args.alpha.unwrap_or(of_scene.alpha),
        radius: args.radius.or(of_scene.radius),
        policy: args.radius_policy.into(),
        precision: args.precision.into(),
        sampling: args.sampling.into(),
        seed: args.run.seed,
        eye_seed: args.eye_seed,
        error_estimates: error_estimates(args),
    }
}

fn error_estimates(args: &RenderArgs) -> ErrorEstimates {
    match (args.no_error_estimates, args.layers) {
        (true, _) => ErrorEstimates::None,
        (false, false) => ErrorEstimates::Picture,
        (false, true) => ErrorEstimates::Pixels,
    }
}

fn budget(args: &RenderArgs, desc: &SceneDesc) -> Budget {
    let open = args.run.time.is_some() || args.target_error.is_some();
    let of_scene = (!open).then_some(desc.render.passes);
    Budget { steps: args.passes.or(of_scene), seconds: args.run.time }
}
