use std::path::Path;

use serde::Serialize;

use super::args::BenchArgs;
use super::console::print;
use super::error::{CliError, Outcome};
use super::loading::load;
use super::threads::use_threads;
use crate::bench::aim;
use crate::bench::equal_time::EqualTimeSettings;
use crate::bench::gather::{self, GatherSettings, RadiusChoice};
use crate::bench::gather_source::{Rendered, Source};
use crate::bench::guide;
use crate::bench::leaks;
use crate::bench::numerics;
use crate::bench::pass::{self, PassSettings};
use crate::bench::rays::{self, RaySettings};
use crate::bench::structures::{RIVALS, variants};
use crate::output::{check_writable, write_bytes};
use crate::ppm::{Aiming, Guiding, Kinds, Settings};
use crate::report::Page;
use crate::scene::{Access, Scene};

/// Measures what was asked for, and reports it in all forms that were asked for.
pub fn run(args: &BenchArgs) -> Result<Outcome, CliError> {
    check_outputs(args)?;
    use_threads(args.threads)?;
    if cfg!(debug_assertions) {
        note!("warning: this build checks its arithmetic: measure with one of `cargo build --release`");
    }
    match (&args.pass, &args.aim, &args.guide) {
        (Some(scene), _, _) => run_pass(args, scene),
        (_, Some(scene), _) => run_aim(args, scene),
        (_, _, Some(scene)) => run_guide(args, scene),
        _ => run_on_generated_scenes(args),
    }
}

fn run_on_generated_scenes(args: &BenchArgs) -> Result<Outcome, CliError> {
    match (args.leaks, args.numerics) {
        (Some(rays), _) => run_leaks(args, rays),
        (_, Some(passes)) => run_numerics(args, passes),
        _ if args.rays => run_rays(args),
        _ => run_gather(args),
    }
}

fn run_leaks(args: &BenchArgs, rays: u64) -> Result<Outcome, CliError> {
    let report = leaks::measure(rays, |mesh| note!("{mesh}"))?;
    write(args, &report, &report.page())
}

fn run_numerics(args: &BenchArgs, passes: u32) -> Result<Outcome, CliError> {
    let report = numerics::measure(passes)?;
    write(args, &report, &report.page())
}

/// A scene to measure in, what reports call it, and what it asks for.
struct Subject {
    scene: Scene,
    name: String,
    settings: Settings,
}

impl Subject {
    fn load(path: &Path) -> Result<Subject, CliError> {
        let scene = Scene::new(load(path, Access::any())?)?;
        let settings = Settings::of_scene(scene.render());
        Ok(Subject { scene, name: path.display().to_string(), settings })
    }

    fn equal_time(&self, args: &BenchArgs) -> EqualTimeSettings {
        let photons = args.photons.unwrap_or(self.settings.photons);
        let render = Settings { photons, ..self.settings };
        EqualTimeSettings { render, passes: args.passes, repetitions: args.repetitions as usize }
    }
}

fn run_aim(args: &BenchArgs, path: &Path) -> Result<Outcome, CliError> {
    let subject = Subject::load(path)?;
    let report = aim::measure(&subject.scene, &subject.name, &subject.equal_time(args))?;
    write(args, &report, &report.page())
}

fn run_guide(args: &BenchArgs, path: &Path) -> Result<Outcome, CliError> {
    let subject = Subject::load(path)?;
    let report = guide::measure(&subject.scene, &subject.name, &subject.equal_time(args))?;
    write(args, &report, &report.page())
}

fn run_pass(args: &BenchArgs, path: &Path) -> Result<Outcome, CliError> {
    let Subject { scene, name, settings: of_scene } = Subject::load(path)?;
    let render = Settings {
        radius: args.radius.or(of_scene.radius),
        samples: args.samples.unwrap_or(of_scene.samples),
        photons: args.photons.unwrap_or(of_scene.photons),
        caustic_photons: Aiming::Photons(0),
        guiding: Guiding::Off,
        kinds: if args.apart { Kinds::Apart } else { Kinds::Together },
        ..of_scene
    };
    let settings = PassSettings { render, repetitions: args.repetitions as usize, retrace: args.retrace };
    let report = pass::measure(&scene, &name, &settings)?;
    write(args, &report, &report.page())
}

fn run_gather(args: &BenchArgs) -> Result<Outcome, CliError> {
    let Some(path) = &args.scene else {
        return measure_gather(args, &Source::Walls);
    };
    let Subject { scene, name, settings } = Subject::load(path)?;
    measure_gather(args, &Source::Render(Rendered { scene: &scene, name: &name, settings }))
}

fn measure_gather(args: &BenchArgs, source: &Source) -> Result<Outcome, CliError> {
    let settings = gather_settings(args, source);
    let variants = if args.variants { variants() } else { Vec::new() };
    let report =
        gather::measure(&settings, source, &[&RIVALS[..], &variants].concat(), |points, percent| {
            note!("{points} spheres of radius {percent:.3} %");
        })?;
    write(args, &report, &report.page())
}

fn gather_settings(args: &BenchArgs, source: &Source) -> GatherSettings {
    let mut points: Vec<usize> = args.points.iter().map(|&n| n as usize).collect();
    if points.is_empty() {
        points = vec![10_000, 100_000, 1_000_000, 4_000_000];
    }
    // In a render 5 % may be a good part of what the picture shows: minutes a round.
    let (mut percentages, photons) = match source {
        Source::Walls => (vec![0.05, 0.1, 0.4, 1.0, 5.0], 100_000),
        Source::Render(render) => (vec![0.05, 0.1, 0.4, 1.0], render.settings.photons),
    };
    if !args.radii.is_empty() {
        percentages.clone_from(&args.radii);
    }
    let radii = args.overlaps.map_or(RadiusChoice::Percent(percentages), RadiusChoice::Overlaps);
    let photons = args.photons.unwrap_or(photons) as usize;
    GatherSettings { points, radii, photons, repetitions: args.repetitions as usize }
}

fn run_rays(args: &BenchArgs) -> Result<Outcome, CliError> {
    let mut triangles: Vec<usize> = args.triangles.iter().map(|&n| n as usize).collect();
    if triangles.is_empty() {
        triangles = vec![36, 20_000, 131_072, 1_000_000];
    }
    let photons = args.photons.unwrap_or(100_000);
    let settings = RaySettings { triangles, photons, repetitions: args.repetitions as usize };
    let report = rays::measure(&settings, |triangles| note!("{triangles} triangles"))?;
    write(args, &report, &report.page())
}

fn is_standard_output(path: &Path) -> bool {
    path == Path::new("-")
}

/// Before any work is done.
fn check_outputs(args: &BenchArgs) -> Result<(), CliError> {
    let files = [&args.json, &args.csv, &args.html].into_iter().flatten();
    for file in files.filter(|file| !is_standard_output(file)) {
        check_writable(file).map_err(CliError::BadOutput)?;
    }
    Ok(())
}

/// The text goes to standard output, unless another form does.
fn write(args: &BenchArgs, report: &impl Serialize, page: &Page) -> Result<Outcome, CliError> {
    let forms = [
        (&args.json, format!("{}\n", serde_json::json!(report))),
        (&args.csv, page.table.to_csv()),
        (&args.html, page.to_html()),
    ];
    let wanted = forms.iter().filter_map(|(path, text)| path.as_deref().map(|path| (path, text)));
    let (printed, files): (Vec<_>, Vec<_>) = wanted.partition(|(path, _)| is_standard_output(path));
    // Files first: standard output may be closed.
    for (path, text) in files {
        write_form(path, text)?;
    }
    if printed.is_empty() {
        print(page.to_text())?;
    } else {
        note!("{}", page.to_text().trim_end());
    }
    for (_, text) in printed {
        print(text)?;
    }
    Ok(Outcome::Done)
}

fn write_form(path: &Path, text: &str) -> Result<(), CliError> {
    write_bytes(path, text)?;
    note!("wrote {}", path.display());
    Ok(())
}
