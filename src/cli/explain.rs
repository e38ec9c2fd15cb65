use std::fmt;

use serde::Serialize;

use super::args::ExplainArgs;
use super::console::{print, print_json};
use super::error::{CliError, Outcome};
use super::loading::load_sized;
use super::memory;
use super::threads::use_threads;
use crate::effects::Plan;
use crate::ppm::Settings;
use crate::price::{Ablation, Seconds, ablate, measured, predicted};
use crate::report::{Cell, Table};
use crate::scene::{Scene, SceneDesc};

/// Says what a render of a scene simulates, because of what, and what that costs.
pub fn run(args: &ExplainArgs) -> Result<Outcome, CliError> {
    let desc = load_sized(&args.scene, &args.access, args.size)?;
    let settings = settings(args, &desc);
    memory::check_render(&desc, &settings)?;
    use_threads(args.threads)?;
    let traversal = args.traversal.into();
    let scene = Scene::with_traversal(desc.clone(), traversal)?;
    let passes = args.measure.or(args.passes).unwrap_or(desc.render.passes);
    let (predicted, plan) = predicted(&scene, settings, passes);
    let measured = args.measure.map(|passes| measured(&scene, settings, passes));
    let ablation = match args.ablate {
        true => ablate(&desc, traversal, settings, passes, &plan)?,
        false => Vec::new(),
    };
    let scene = desc.path.display().to_string();
    let photons = settings.photons;
    let explanation = Explanation { scene, plan, passes, photons, predicted, measured, ablation };
    if args.json {
        print_json(&explanation)?;
    } else {
        print(explanation)?;
    }
    Ok(Outcome::Done)
}

fn settings(args: &ExplainArgs, desc: &SceneDesc) -> Settings {
    let of_scene = Settings::of_scene(&desc.render);
    Settings {
        photons: args.photons.unwrap_or(of_scene.photons),
        transport: args.transport.iter().copied().collect(),
        ..of_scene
    }
}

#[derive(Serialize)]
struct Explanation {
    scene: String,
    plan: Plan,
    passes: u32,
    photons: u64,
    predicted: Seconds,
    measured: Option<Seconds>,
    ablation: Vec<Ablation>,
}

impl Explanation {
    fn seconds(&self) -> Table {
        let columns_of = [Some(&self.predicted), self.measured.as_ref()].into_iter().flatten();
        let all: Vec<_> = columns_of.map(with_total).collect();
        let row = |(k, (name, _)): (usize, &(&str, f64))| {
            let numbers = all.iter().map(|column| Cell::Number(column[k].1));
            [Cell::Text((*name).into())].into_iter().chain(numbers).collect()
        };
        let rows = all[0].iter().enumerate().map(row).collect();
        let columns = [Some("seconds for"), Some("predicted (s)"), self.measured.map(|_| "measured (s)")];
        Table { columns: columns.into_iter().flatten().collect(), rows }
    }

    fn differences(&self) -> Table {
        let row = |ablation: &Ablation| {
            let Ablation { without, seconds, rel_mse, rmse } = ablation;
            let numbers = [seconds.total(), *rel_mse, *rmse].map(Cell::Number);
            [Cell::Text(without.clone())].into_iter().chain(numbers).collect()
        };
        let columns = vec!["without", "seconds (s)", "relMSE", "RMSE"];
        Table { columns, rows: self.ablation.iter().map(row).collect() }
    }
}

fn with_total(seconds: &Seconds) -> Vec<(&'static str, f64)> {
    seconds.by_name().into_iter().chain([("all", seconds.total())]).collect()
}

impl fmt::Display for Explanation {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        writeln!(f, "{}", self.plan)?;
        writeln!(f, "{} passes of {} photons:\n{}", self.passes, self.photons, self.seconds().to_text())?;
        if !self.ablation.is_empty() {
            writeln!(f, "{}", self.differences().to_text())?;
        }
        Ok(())
    }
}
