use super::args::ReferenceArgs;
use super::circumstances::with_circumstances;
use super::error::{CliError, Outcome};
use super::interrupt::Interrupt;
use super::live::Live;
use super::loading::load_sized;
use super::memory;
use super::pictures::{PicturePath, default_output};
use super::progress::{Budget, Progress};
use super::threads::use_threads;
use crate::output::{Display, Metadata, Value};
use crate::reference::{Estimator, Method, share_seen_specular};
use crate::scene::{Scene, Traversal};

/// Renders a scene by path or light tracing, with the standard error of every pixel beside it.
pub fn run(args: &ReferenceArgs) -> Result<Outcome, CliError> {
    use_threads(args.run.threads)?;
    let method = Method::from(args.method);
    let desc = load_sized(&args.scene, &args.run.access, args.run.size)?;
    memory::check_reference(&desc.film)?;
    let output = args.output.clone().unwrap_or_else(|| default_output(&desc.name, suffix(method)));
    let picture = PicturePath::new(&output)?.with_half(args.run.half);
    let error = picture.with_suffix("_stderr")?;
    let mut live = Live::start(&args.run, &desc.name);
    let scene = Scene::with_traversal(desc, args.run.traversal.into())?;
    if method == Method::Light {
        tell_what_is_missing(&scene);
    }
    let interrupt = Interrupt::listen();
    let progress = Progress::start("sample", Budget { steps: Some(args.spp), seconds: args.run.time });
    let mut estimator = Estimator::new(&scene, method, args.run.seed);
    while !progress.is_over(estimator.samples()) && !interrupt.is_asked() {
        estimator.add_sample();
        live.follow(|| estimator.picture());
        progress.step(String::new());
    }
    progress.finish();
    let metadata = metadata(args, &scene, &estimator, progress.seconds());
    picture.write(&estimator.picture(), &metadata, &Display::from(&args.run.display))?;
    error.write_exr(&estimator.standard_error(), &metadata)?;
    note!(
        "{} samples a pixel in {:.1} s: {}, {} and {}",
        estimator.samples(),
        progress.seconds(),
        picture.exr().display(),
        picture.png().display(),
        error.exr().display()
    );
    live.finish(|| estimator.picture());
    Ok(if interrupt.is_asked() { Outcome::Interrupted } else { Outcome::Done })
}

fn suffix(method: Method) -> &'static str {
    match method {
        Method::Path => "_reference",
        Method::Light => "_reference_light",
    }
}

fn name(method: Method) -> &'static str {
    match method {
        Method::Path => "path tracing",
        Method::Light => "light tracing",
    }
}

fn tell_what_is_missing(scene: &Scene) {
    let share = share_seen_specular(scene);
    if share > 0.0 {
        note!(
            "note: {:.1} % of the pixels show surfaces that mirror or refract; light tracing misses what is seen in them",
            100.0 * share
        );
    }
}

fn metadata(args: &ReferenceArgs, scene: &Scene, estimator: &Estimator, seconds: f64) -> Metadata {
    let metadata = Metadata::new()
        .with_world_to_camera(scene.camera().world_to_camera())
        .with("caustica:version", Value::Text(env!("CARGO_PKG_VERSION").into()))
        .with("caustica:method", Value::Text(name(args.method.into()).into()))
        .with("caustica:scene", Value::Text(args.scene.display().to_string()))
        .with("caustica:spp", Value::Integer(estimator.samples().into()))
        .with("caustica:traversal", Value::Text(Traversal::from(args.run.traversal).to_string()))
        .with("caustica:seed", Value::Text(args.run.seed.to_string()));
    with_circumstances(metadata, args.run.reproducible, seconds)
}
