use super::args::ReferenceArgs;
use super::error::{CliError, Outcome};
use super::interrupt::Interrupt;
use super::pictures::{PicturePath, default_output};
use super::progress::{Budget, Progress};
use super::{load, use_threads};
use crate::output::{Display, Metadata, Value};
use crate::reference::PathTracer;
use crate::scene::{Scene, Traversal};

/// Renders a scene by path tracing, with the standard error of every pixel beside it.
pub fn run(args: &ReferenceArgs) -> Result<Outcome, CliError> {
    use_threads(args.run.threads)?;
    let desc = load(&args.scene)?;
    let output = args.output.clone().unwrap_or_else(|| default_output(&desc.name, "_reference"));
    let picture = PicturePath::new(&output)?;
    let error = picture.with_suffix("_stderr")?;
    let scene = Scene::with_traversal(desc, args.run.traversal.into())?;
    let interrupt = Interrupt::listen();
    let progress = Progress::start("sample", Budget { steps: Some(args.spp), seconds: args.run.time });
    let mut tracer = PathTracer::new(&scene, args.run.seed);
    while !progress.is_over(tracer.samples()) && !interrupt.is_asked() {
        tracer.add_sample();
        progress.step(String::new());
    }
    progress.finish();
    let metadata = metadata(args, &tracer, progress.seconds());
    picture.write(&tracer.picture(), &metadata, &Display::from(&args.run.display))?;
    error.write_exr(&tracer.standard_error(), &metadata)?;
    eprintln!(
        "{} samples a pixel in {:.1} s: {}, {} and {}",
        tracer.samples(),
        progress.seconds(),
        picture.exr().display(),
        picture.png().display(),
        error.exr().display()
    );
    Ok(if interrupt.is_asked() { Outcome::Interrupted } else { Outcome::Done })
}

fn metadata(args: &ReferenceArgs, tracer: &PathTracer, seconds: f64) -> Metadata {
    let metadata = Metadata::new()
        .with("caustica:version", Value::Text(env!("CARGO_PKG_VERSION").into()))
        .with("caustica:method", Value::Text("path tracing".into()))
        .with("caustica:scene", Value::Text(args.scene.display().to_string()))
        .with("caustica:spp", Value::Integer(tracer.samples().into()))
        .with("caustica:traversal", Value::Text(Traversal::from(args.run.traversal).to_string()))
        .with("caustica:seed", Value::Text(args.run.seed.to_string()));
    if args.run.reproducible { metadata } else { metadata.with("caustica:seconds", Value::Double(seconds)) }
}
