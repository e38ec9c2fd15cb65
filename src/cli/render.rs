use std::path::PathBuf;

use serde::Serialize;

use super::args::RenderArgs;
use super::error::{CliError, Outcome};
use super::interrupt::Interrupt;
use super::json_lines::JsonLines;
use super::pictures::{PicturePath, default_output};
use super::progress::{Budget, Progress};
use super::{load, memory, use_threads};
use crate::output::{Display, Metadata, Value};
use crate::ppm::{PassStatistics, Render, Settings, SetupStatistics};
use crate::scene::{Scene, SceneDesc, Traversal};

/// Renders a scene by photon mapping: passes until the budget is spent, then the picture.
pub fn run(args: &RenderArgs) -> Result<Outcome, CliError> {
    let threads = use_threads(args.run.threads)?;
    let desc = load(&args.scene)?;
    let settings = settings(args, &desc);
    let mut outputs = Outputs::check(args, &desc, threads)?;
    let budget = budget(args, &desc);
    let scene = Scene::with_traversal(desc, args.run.traversal.into())?;
    let interrupt = Interrupt::listen();
    let progress = Progress::start("pass", budget);
    let mut render = Render::new(&scene, settings);
    let announced = match settings.radius {
        Some(_) => "",
        None => " (found: two pixels wide)",
    };
    eprintln!("{} hit points, radius {:.4}{announced}", render.setup().hit_points, render.setup().radius);
    while !progress.is_over(render.passes()) && !interrupt.is_asked() {
        let pass = render.pass();
        progress.step(format!("{:.0} photons/s", settings.photons as f64 / pass.seconds));
        outputs.after_pass(&render, &pass, progress.seconds())?;
    }
    progress.finish();
    outputs.write(&render, progress.seconds())?;
    Ok(if interrupt.is_asked() { Outcome::Interrupted } else { Outcome::Done })
}

fn settings(args: &RenderArgs, desc: &SceneDesc) -> Settings {
    let of_scene = Settings::of_scene(&desc.render);
    Settings {
        samples: args.samples.unwrap_or(of_scene.samples),
        depth: args.depth.unwrap_or(of_scene.depth),
        photons: args.photons.unwrap_or(of_scene.photons),
        alpha: args.alpha.unwrap_or(of_scene.alpha),
        radius: args.radius.or(of_scene.radius),
        sampling: args.sampling.into(),
        seed: args.run.seed,
    }
}

fn budget(args: &RenderArgs, desc: &SceneDesc) -> Budget {
    let of_scene = args.run.time.is_none().then_some(desc.render.passes);
    Budget { steps: args.passes.or(of_scene), seconds: args.run.time }
}

/// Everything that the render writes; all paths are checked before it begins.
struct Outputs {
    scene: String,
    threads: usize,
    picture: PicturePath,
    direct: Option<PicturePath>,
    every_pass: Option<PathBuf>,
    json: Option<JsonLines>,
    display: Display,
    traversal: Traversal,
    reproducible: bool,
}

/// A line of the statistics.
#[derive(Serialize)]
struct PassRecord<'a> {
    #[serde(flatten)]
    pass: &'a PassStatistics,
    threads: usize,
    seconds_in_all: f64,
    peak_memory_bytes: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    setup: Option<&'a SetupStatistics>,
}

impl Outputs {
    fn check(args: &RenderArgs, desc: &SceneDesc, threads: usize) -> Result<Outputs, CliError> {
        let output = args.output.clone().unwrap_or_else(|| default_output(&desc.name, ""));
        if let Some(folder) = &args.every_pass {
            PicturePath::new(&folder.join("pass_0001.exr"))?;
        }
        Ok(Outputs {
            scene: args.scene.display().to_string(),
            threads,
            picture: PicturePath::new(&output)?,
            direct: args.direct.as_deref().map(PicturePath::new).transpose()?,
            every_pass: args.every_pass.clone(),
            json: args.json.as_deref().map(JsonLines::create).transpose()?,
            display: Display::from(&args.run.display),
            traversal: args.run.traversal.into(),
            reproducible: args.run.reproducible,
        })
    }

    fn after_pass(&mut self, render: &Render, pass: &PassStatistics, seconds: f64) -> Result<(), CliError> {
        if let Some(json) = &mut self.json {
            json.write(&PassRecord {
                pass,
                threads: self.threads,
                seconds_in_all: seconds,
                peak_memory_bytes: memory::peak_bytes(),
                setup: (pass.pass == 1).then(|| render.setup()),
            })?;
        }
        if let Some(folder) = &self.every_pass {
            let path = PicturePath::new(&folder.join(format!("pass_{:04}.exr", pass.pass)))?;
            path.write(&render.picture(), &self.metadata(render, seconds), &self.display)?;
        }
        Ok(())
    }

    fn write(&self, render: &Render, seconds: f64) -> Result<(), CliError> {
        let metadata = self.metadata(render, seconds);
        self.picture.write(&render.picture(), &metadata, &self.display)?;
        if let Some(direct) = &self.direct {
            direct.write(&render.direct_picture(), &metadata, &self.display)?;
        }
        eprintln!(
            "{} passes in {seconds:.1} s: {} and {}",
            render.passes(),
            self.picture.exr().display(),
            self.picture.png().display()
        );
        Ok(())
    }

    fn metadata(&self, render: &Render, seconds: f64) -> Metadata {
        let settings = render.settings();
        let metadata = Metadata::new()
            .with("caustica:version", Value::Text(env!("CARGO_PKG_VERSION").into()))
            .with("caustica:method", Value::Text("progressive photon mapping".into()))
            .with("caustica:scene", Value::Text(self.scene.clone()))
            .with("caustica:passes", Value::Integer(render.passes().into()))
            .with("caustica:photons", Value::Integer(settings.photons as i64))
            .with("caustica:alpha", Value::Double(settings.alpha))
            .with("caustica:radius", Value::Double(render.setup().radius))
            .with("caustica:samples", Value::Integer(settings.samples.into()))
            .with("caustica:depth", Value::Integer(settings.depth.into()))
            .with("caustica:sampling", Value::Text(format!("{:?}", settings.sampling).to_lowercase()))
            .with("caustica:traversal", Value::Text(self.traversal.to_string()))
            .with("caustica:seed", Value::Text(settings.seed.to_string()));
        if self.reproducible { metadata } else { metadata.with("caustica:seconds", Value::Double(seconds)) }
    }
}
