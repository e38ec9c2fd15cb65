//! Renders configurations in turn and holds their pictures against the reference.

use std::path::{Path, PathBuf};

use super::fingerprint::{described, fingerprint};
use super::flat::flat_pixels;
use super::looks::Looks;
use super::reference::Reference;
use super::watch::Watch;
use super::{Configuration, Journal, Method, Point, Run, StudyError};
use crate::bench::timing::timed;
use crate::compare::Metrics;
use crate::film::Image;
use crate::output::{Metadata, write_exr};
use crate::ppm::{Render, Settings};
use crate::reference::Estimator;
use crate::scene::{Scene, SceneDesc, Traversal};

/// What is measured and how long.
#[derive(Debug)]
pub struct Plan {
    /// The scene, with the size of the pictures.
    pub desc: SceneDesc,
    /// What is measured against what.
    pub configurations: Vec<Configuration>,
    /// How often each is rendered, from another seed each time.
    pub repetitions: u32,
    /// The share of each run.
    pub seconds_per_run: f64,
    /// Repetition `k` has the seed `seed + 1 + k`.
    pub seed: u64,
    /// What else the numbers depend on, such as the machine.
    pub surroundings: String,
}

impl Plan {
    /// Runs in all.
    pub fn runs(&self) -> u32 {
        self.configurations.len() as u32 * self.repetitions
    }

    /// The seed of a repetition.
    pub fn seed_of(&self, repetition: u32) -> u64 {
        self.seed.wrapping_add(1 + u64::from(repetition))
    }

    /// What tells the runs of a configuration from those of other scenes, settings, references and machines.
    pub fn key(&self, configuration: &Configuration, reference: u64) -> String {
        let settings = (configuration, self.seconds_per_run, self.seed, reference, &self.surroundings);
        format!("{:016x}", fingerprint(&(described(&self.desc), settings)))
    }
}

/// Runs every configuration once in each round, so that a slow spell of the machine hits all alike, and skips what the
/// journal holds. Returns whether all was measured.
///
/// The pictures of the first round go to `pictures`, and there, for as long as repetitions are missing, those of every look.
///
/// # Errors
/// When a scene cannot be traced, a picture is not finite or has another size than the reference, or a file cannot
/// be written.
pub fn measure(
    plan: &Plan,
    reference: &Reference,
    journal: &mut Journal,
    pictures: &Path,
    watch: &impl Watch,
) -> Result<bool, StudyError> {
    let reference_print = reference.fingerprint();
    let mut scenes = Scenes { desc: &plan.desc, scenes: Vec::new() };
    let mut flat = FlatPixels { seed: plan.seed, found: Vec::new() };
    let keys: Vec<String> = plan.configurations.iter().map(|c| plan.key(c, reference_print)).collect();
    for repetition in 0..plan.repetitions {
        for (configuration, key) in plan.configurations.iter().zip(&keys) {
            if journal.find(key, repetition).is_some() {
                watch.is_done();
                continue;
            }
            watch.begins(configuration.name, repetition);
            // The first repetition finds how many steps its share holds, and the others take as many.
            let steps = journal.find(key, 0).and_then(|run| run.points.last()).map(|point| point.steps);
            let limit = steps.map_or(Limit::Seconds(plan.seconds_per_run), Limit::Steps);
            let scene = scenes.get(configuration.traversal)?;
            let task = Task {
                configuration,
                repetition,
                seed: plan.seed_of(repetition),
                limit,
                reference,
                looks: Looks::new(pictures, key, plan.repetitions),
                flat: if repetition > 0 { flat.get(scene, configuration) } else { None },
            };
            let Some((points, picture)) = task.run(scene, watch)? else { return Ok(false) };
            if repetition == 0 {
                write_exr(&picture_path(pictures, configuration), &picture, &Metadata::new())?;
            }
            let (key, configuration) = (key.clone(), configuration.name.to_owned());
            journal.append(Run { key, configuration, repetition, seed: task.seed, points })?;
            task.looks.finish(repetition);
            watch.is_done();
        }
    }
    Ok(true)
}

/// Where the picture of the first repetition lies.
pub fn picture_path(pictures: &Path, configuration: &Configuration) -> PathBuf {
    pictures.join(format!("{}.exr", configuration.file_stem()))
}

/// The scene by each means of tracing that was asked for.
struct Scenes<'p> {
    desc: &'p SceneDesc,
    scenes: Vec<Scene>,
}

impl Scenes<'_> {
    fn get(&mut self, traversal: Traversal) -> Result<&Scene, StudyError> {
        let found = self.scenes.iter().position(|scene| scene.traversal() == traversal);
        let index = found.unwrap_or(self.scenes.len());
        if found.is_none() {
            self.scenes.push(Scene::with_traversal(self.desc.clone(), traversal)?);
        }
        Ok(&self.scenes[index])
    }
}

/// The pixels whose discs lie flat, by the radius.
struct FlatPixels {
    seed: u64,
    found: Vec<(f64, Vec<bool>)>,
}

impl FlatPixels {
    /// `None` where there are no discs.
    fn get(&mut self, scene: &Scene, configuration: &Configuration) -> Option<&[bool]> {
        let Settings { radius, .. } = configuration.settings;
        let radius = radius.filter(|_| configuration.method == Method::PhotonMapping)?;
        let found = self.found.iter().position(|(of, _)| *of == radius);
        let index = found.unwrap_or(self.found.len());
        if found.is_none() {
            let settings = Settings { seed: self.seed, ..configuration.settings };
            self.found.push((radius, flat_pixels(scene, &settings, radius)));
        }
        Some(&self.found[index].1)
    }
}

/// When a run ends.
#[derive(Clone, Copy, Debug)]
enum Limit {
    /// Where the next point would lie beyond so many seconds.
    Seconds(f64),
    /// After so many steps.
    Steps(u32),
}

impl Limit {
    fn is_reached(self, point: &Point, seconds_per_step: f64) -> bool {
        match self {
            Limit::Steps(steps) => point.steps >= steps,
            Limit::Seconds(limit) => {
                let more = f64::from(next_checkpoint(point.steps) - point.steps);
                point.seconds + more * seconds_per_step > limit
            }
        }
    }
}

/// 1, 2, 3, 4, 6, 8, 12, 16, ...: two to each doubling.
fn next_checkpoint(steps: u32) -> u32 {
    match steps {
        0..=2 => steps + 1,
        _ if steps.is_power_of_two() => steps + steps / 2,
        _ => steps / 3 * 4,
    }
}

struct Task<'a> {
    configuration: &'a Configuration,
    repetition: u32,
    seed: u64,
    limit: Limit,
    reference: &'a Reference,
    looks: Looks,
    flat: Option<&'a [bool]>,
}

impl Task<'_> {
    /// The points on the way and the last picture; `None` where it was stopped.
    fn run(&self, scene: &Scene, watch: &impl Watch) -> Result<Option<(Vec<Point>, Image)>, StudyError> {
        let (mut renderer, setup) = timed(|| Renderer::new(scene, self.configuration, self.seed));
        let (mut seconds, mut points) = (setup, Vec::new());
        let mut steps = 0;
        loop {
            let checkpoint = next_checkpoint(steps);
            while steps < checkpoint {
                if watch.is_over() {
                    return Ok(None);
                }
                seconds += timed(|| renderer.step()).1;
                steps += 1;
            }
            let picture = renderer.picture();
            let point = self.look(&picture, steps, seconds)?;
            points.push(point);
            if self.limit.is_reached(&point, (seconds - setup) / f64::from(steps)) {
                return Ok(Some((points, picture)));
            }
        }
    }
}

impl Task<'_> {
    /// What a picture on the way is worth.
    fn look(&self, picture: &Image, steps: u32, seconds: f64) -> Result<Point, StudyError> {
        let rel_mse = Metrics::between(picture, &self.reference.image)?.rel_mse;
        if !rel_mse.is_finite() {
            return Err(StudyError::NotFinite { configuration: self.configuration.name.into() });
        }
        let separation = self.looks.separate(self.repetition, steps, picture, self.reference, self.flat);
        self.looks.keep(self.repetition, steps, picture)?;
        Ok(Point { steps, seconds, rel_mse, separation })
    }
}

enum Renderer<'s> {
    Photons(Box<Render<'s>>),
    Reference(Estimator<'s>),
}

impl<'s> Renderer<'s> {
    fn new(scene: &'s Scene, configuration: &Configuration, seed: u64) -> Renderer<'s> {
        let mut settings = configuration.settings;
        settings.seed = seed;
        match configuration.method {
            Method::PhotonMapping => Renderer::Photons(Box::new(Render::new(scene, settings))),
            Method::Reference(method) => Renderer::Reference(Estimator::new(scene, method, seed)),
        }
    }

    fn step(&mut self) {
        match self {
            Renderer::Photons(render) => drop(render.pass()),
            Renderer::Reference(estimator) => estimator.add_sample(),
        }
    }

    fn picture(&self) -> Image {
        match self {
            Renderer::Photons(render) => render.picture(),
            Renderer::Reference(estimator) => estimator.picture(),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;
    use std::collections::BTreeMap;

    use super::super::Separation;
    use super::super::testing::{Bounded, desc, plan};
    use super::*;

    fn names(journal: &Journal) -> Vec<(String, u32, u64, Vec<u32>)> {
        let entry = |run: &Run| {
            let steps = run.points.iter().map(|point| point.steps).collect();
            (run.configuration.clone(), run.repetition, run.seed, steps)
        };
        journal.runs().iter().map(entry).collect()
    }

    /// By configuration and steps, those of the second repetition; the first has none.
    fn separations(journal: &Journal) -> BTreeMap<(String, u32), Separation> {
        let of = |run: &Run| {
            assert!(run.points.iter().all(|point| point.separation.is_some() == (run.repetition > 0)));
            let name = run.configuration.clone();
            let of = move |point: &Point| Some(((name.clone(), point.steps), point.separation?));
            run.points.iter().filter_map(of).collect::<Vec<_>>()
        };
        journal.runs().iter().flat_map(of).collect()
    }

    fn black(side: usize) -> Reference {
        Reference::given(Image::new(side, side), "black.exr".as_ref())
    }

    #[test]
    fn checkpoints_double_every_other_time() {
        let steps: Vec<u32> =
            std::iter::successors(Some(1), |&n| Some(next_checkpoint(n))).take(11).collect();
        assert_eq!(steps, [1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48]);
        assert_eq!(next_checkpoint(0), 1);
    }

    #[test]
    fn a_run_ends_before_its_share_does() {
        let point = |steps, seconds| Point { steps, seconds, rel_mse: 1.0, separation: None };
        assert!(!Limit::Seconds(6.0).is_reached(&point(4, 4.0), 1.0));
        assert!(Limit::Seconds(5.9).is_reached(&point(4, 4.0), 1.0));
        assert!(
            !Limit::Steps(5).is_reached(&point(4, 1e9), 1.0)
                && Limit::Steps(4).is_reached(&point(4, 0.0), 0.0)
        );
    }

    #[test]
    fn keys_tell_everything_apart_but_the_place() {
        let plan = plan();
        let key = |plan: &Plan, k: usize, reference| plan.key(&plan.configurations[k], reference);
        let first = key(&plan, 0, 1);
        assert_ne!(first, key(&plan, 1, 1));
        assert_ne!(first, key(&plan, 0, 2));
        let mut moved = super::super::testing::plan();
        moved.desc.path = "elsewhere.toml".into();
        assert_eq!(first, key(&moved, 0, 1));
        moved.desc.point_lights[0].intensity.x += 1e-6;
        assert_ne!(first, key(&moved, 0, 1));
        let longer = Plan { seconds_per_run: 2.0 * plan.seconds_per_run, ..super::super::testing::plan() };
        assert_ne!(first, key(&longer, 0, 1));
    }

    /// Stopped after any number of runs and begun again, the list holds each run once.
    #[test]
    fn an_interrupted_study_goes_on_where_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let (plan, reference) = (plan(), black(8));
        let all_separations = RefCell::new(Vec::new());
        let measure_into = |name: &str, runs: u32| {
            let mut journal = Journal::open(&folder.path().join(name)).unwrap();
            let pictures = folder.path().join("pictures of ").join(name);
            let whole = measure(&plan, &reference, &mut journal, &pictures, &Bounded::to(runs)).unwrap();
            assert!(!whole || !pictures.join("looks").exists(), "nobody needs them any more");
            if whole {
                all_separations.borrow_mut().push(separations(&journal));
            }
            (whole, names(&journal))
        };
        let (whole, all) = measure_into("whole", u32::MAX);
        assert!(whole && all.len() as u32 == plan.runs());
        let order: Vec<(&str, u32)> = all.iter().map(|(name, k, ..)| (name.as_str(), *k)).collect();
        let first = ["baseline", "path tracing", "light tracing"].map(|name| (name, 0));
        assert_eq!((&order[..3], order[3]), (&first[..], ("baseline", 1)), "in turn");
        for stop in [0, 1, 3] {
            let (whole, some) = measure_into(&stop.to_string(), stop);
            assert!(!whole && some.len() as u32 == stop);
            let (whole, rest) = measure_into(&stop.to_string(), u32::MAX);
            assert!(whole && rest.len() == all.len());
            let identity = |runs: &[(String, u32, u64, Vec<u32>)]| -> Vec<(String, u32, u64)> {
                runs.iter().map(|(name, k, seed, _)| (name.clone(), *k, *seed)).collect()
            };
            assert_eq!(identity(&rest), identity(&all));
        }
        // How many steps a share of time holds, differs.
        let all_separations = all_separations.into_inner();
        for other in &all_separations[1..] {
            let both: Vec<_> = all_separations[0].iter().filter(|(of, _)| other.contains_key(*of)).collect();
            assert!(both.len() >= 3, "three methods have one look at least, however slow the machine is");
            assert!(both.iter().all(|(of, separation)| other[*of] == **separation), "not the same numbers");
        }
        for runs in all.chunks(3).collect::<Vec<_>>().windows(2) {
            assert_eq!(runs[0][0].3, runs[1][0].3, "every repetition has as many steps as the first");
        }
    }

    #[test]
    fn references_of_another_size_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let mut journal = Journal::open(&folder.path().join("j")).unwrap();
        let result = measure(&plan(), &black(9), &mut journal, folder.path(), &Bounded::to(9));
        assert!(matches!(result, Err(StudyError::Compare(_))), "{result:?}");
    }

    #[test]
    fn the_same_seed_gives_the_picture_of_a_render() {
        let scene = Scene::new(desc()).unwrap();
        let plan = plan();
        let (folder, reference) = (tempfile::tempdir().unwrap(), black(8));
        let task = Task {
            configuration: &plan.configurations[0],
            repetition: 0,
            seed: 5,
            limit: Limit::Steps(2),
            reference: &reference,
            looks: Looks::new(folder.path(), "key", 1),
            flat: None,
        };
        let (points, picture) = task.run(&scene, &Bounded::to(1)).unwrap().unwrap();
        let mut settings = plan.configurations[0].settings;
        settings.seed = 5;
        let mut render = Render::new(&scene, settings);
        render.pass();
        render.pass();
        assert_eq!((points.len(), picture), (2, render.picture()));
    }
}
