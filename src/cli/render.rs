use std::sync::Arc;

use super::args::{PassesArg, RenderArgs};
use super::checkpoints::Checkpoints;
use super::error::{CliError, Outcome};
use super::error_watch::{ErrorWatch, percent};
use super::interrupt::Interrupt;
use super::live::Live;
use super::loading::load_sized;
use super::memory;
use super::outputs::Outputs;
use super::part_error::PartError;
use super::progress::{Budget, Progress};
use super::threads::use_threads;
use crate::checkpoint::Checkpoint;
use crate::effects::{EyePaths, Unseen};
use crate::ppm::{ErrorEstimates, Kinds, PictureError, Planning, RadiusPolicy, Render, Settings};
use crate::scene::{Access, Scene, SceneDesc, Traversal, TraversalError};

/// Renders a scene by photon mapping: passes until the budget is spent or the target reached, then the picture.
pub fn run(args: &RenderArgs) -> Result<Outcome, CliError> {
    let threads = use_threads(args.run.threads)?;
    let prepared = Prepared::new(args, Access::from(&args.run.access), threads)?;
    let interrupt = Interrupt::listen();
    prepared.render(&interrupt, Leaving::Both, &mut |_| ())?;
    Ok(if interrupt.is_asked() { Outcome::Interrupted } else { Outcome::Done })
}

/// What a render leaves behind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Leaving {
    /// The picture, and the checkpoint where one is kept, whether it is interrupted or not.
    Both,
    /// The picture; or the checkpoint alone, if it is interrupted.
    Either,
}

/// What came of a render.
#[derive(Clone, Copy, Debug)]
pub struct Rendered {
    pub passes: u32,
    pub seconds: f64,
    pub error: Option<PictureError>,
}

/// A render whose scene is there, and whose outputs are found to be writable.
pub struct Prepared<'a> {
    args: &'a RenderArgs,
    settings: Settings,
    pub budget: Budget,
    scene: Arc<Scene>,
    outputs: Outputs,
    checkpoints: Option<Checkpoints>,
    resumed: Option<Checkpoint<'static>>,
    live: Live,
}

impl<'a> Prepared<'a> {
    pub fn new(args: &'a RenderArgs, access: Access, threads: usize) -> Result<Prepared<'a>, CliError> {
        Prepared::following(None, args, access, threads)
    }

    /// With the tree of a scene before, where the surfaces lie as they do there.
    pub fn following(
        before: Option<&Scene>,
        args: &'a RenderArgs,
        access: Access,
        threads: usize,
    ) -> Result<Prepared<'a>, CliError> {
        let passes = count_of_passes(args)?;
        let desc = load_sized(&args.scene, access, args.run.size)?;
        let settings = settings(args, &desc);
        check_target(args, &settings)?;
        memory::check_render(&desc, &settings)?;
        let mut checkpoints = Checkpoints::open(args, &desc, &settings)?;
        let resumed = match &mut checkpoints {
            Some(checkpoints) if args.resume => checkpoints.load()?,
            _ => None,
        };
        let passes_before = resumed.as_ref().map(|checkpoint| checkpoint.render.passes());
        let outputs = Outputs::check(args, &desc, threads, passes_before)?;
        let budget = budget(args, passes, &desc);
        let live = Live::start(&args.run, &desc.name);
        let scene = Arc::new(build(before, desc, args.run.traversal.into())?);
        Ok(Prepared { args, settings, budget, scene, outputs, checkpoints, resumed, live })
    }

    pub fn scene(&self) -> Arc<Scene> {
        Arc::clone(&self.scene)
    }

    pub fn photons(&self) -> u64 {
        self.settings.photons
    }

    /// Tells `watch` the number of passes after each.
    pub fn render(
        self,
        interrupt: &Interrupt,
        leaving: Leaving,
        watch: &mut dyn FnMut(u32),
    ) -> Result<Rendered, CliError> {
        let Prepared { args, settings, budget, scene, outputs, checkpoints, resumed, live } = self;
        let progress = Progress::start("pass", budget);
        let render = Render::new(&scene, settings);
        announce(args, &render);
        let errors = ErrorWatch::new(args.target_error, args.confidence, &settings);
        let unseen = Unseen::default();
        let mut session = Session { render, errors, unseen, progress, outputs, checkpoints, live };
        if let Some(checkpoint) = resumed {
            session.resume(checkpoint)?;
        }
        // Whatever ended the passes, what they brought is kept.
        let ended = session.render_until(interrupt, watch);
        let (keeps, writes) = match leaving {
            Leaving::Both => (true, true),
            Leaving::Either => (interrupt.is_asked(), !interrupt.is_asked()),
        };
        let finished = session.finish(keeps, writes);
        first_error([ended, finished])?;
        Ok(session.rendered())
    }
}

fn build(before: Option<&Scene>, desc: SceneDesc, traversal: Traversal) -> Result<Scene, TraversalError> {
    match before {
        Some(before) if before.traversal() == traversal => before.successor(desc),
        _ => Scene::with_traversal(desc, traversal),
    }
}

/// A render under way, and all that follows it.
struct Session<'s> {
    render: Render<'s>,
    errors: ErrorWatch,
    unseen: Unseen,
    progress: Progress,
    outputs: Outputs,
    checkpoints: Option<Checkpoints>,
    live: Live,
}

impl Session<'_> {
    fn resume(&mut self, checkpoint: Checkpoint) -> Result<(), CliError> {
        let Some(checkpoints) = &self.checkpoints else { return Ok(()) };
        self.errors.resume(&checkpoint.run.errors);
        self.progress.resume(checkpoint.render.passes(), checkpoint.run.seconds);
        checkpoints.restore(&mut self.render, checkpoint)
    }

    fn render_until(&mut self, interrupt: &Interrupt, watch: &mut dyn FnMut(u32)) -> Result<(), CliError> {
        self.live.follow(|| self.render.picture());
        while !self.is_over(interrupt) {
            self.pass()?;
            watch(self.render.passes());
            if self.checkpoints.as_ref().is_some_and(Checkpoints::is_due) && !self.is_over(interrupt) {
                self.checkpoint_if_possible();
            }
        }
        Ok(())
    }

    fn is_over(&self, interrupt: &Interrupt) -> bool {
        self.progress.is_over(self.render.passes())
            || self.render.is_finished()
            || self.errors.is_met()
            || interrupt.is_asked()
    }

    fn pass(&mut self) -> Result<(), CliError> {
        let pass = self.render.pass();
        let seconds = self.progress.seconds();
        let error = self.errors.after_pass(&self.render, seconds);
        self.outputs.after_pass(&self.render, &pass, error, seconds)?;
        if self.render.plan().photons
            && let Some(words) = self.unseen.after_pass(pass.photons.emitted, pass.gathered)
        {
            note!("warning: {words}");
        }
        self.live.follow(|| self.render.picture());
        let speed = format!("{:.0} photons/s", self.render.settings().photons as f64 / pass.seconds);
        self.progress.step(format!("{} {speed}", self.errors.message(seconds)));
        Ok(())
    }

    /// A disk that is full now may have room when the next one is due: the render goes on.
    fn checkpoint_if_possible(&mut self) {
        if let Err(error) = self.checkpoint() {
            note!("warning: no checkpoint after {} passes: {error}", self.render.passes());
        }
    }

    /// Statistics first: those of the passes in the checkpoint will not be made again.
    fn checkpoint(&mut self) -> Result<(), CliError> {
        let Some(checkpoints) = &mut self.checkpoints else { return Ok(()) };
        self.outputs.flush_statistics()?;
        Ok(checkpoints.save(&self.render, &self.errors, self.progress.seconds())?)
    }

    fn finish(&mut self, keeps: bool, writes: bool) -> Result<(), CliError> {
        self.progress.finish();
        let kept = if keeps { self.checkpoint() } else { Ok(()) };
        let seconds = self.progress.seconds();
        let written = if writes { self.outputs.write(&self.render, seconds) } else { Ok(()) };
        if let Some(summary) = self.errors.summary() {
            note!("{summary}");
        }
        self.live.finish(|| self.render.picture());
        first_error([kept, written])
    }

    fn rendered(&self) -> Rendered {
        let (passes, seconds) = (self.render.passes(), self.progress.seconds());
        Rendered { passes, seconds, error: self.errors.latest() }
    }
}

/// The first error; the others are told.
fn first_error<const N: usize>(results: [Result<(), CliError>; N]) -> Result<(), CliError> {
    let mut errors = results.into_iter().filter_map(Result::err);
    let Some(first) = errors.next() else { return Ok(()) };
    errors.for_each(|error| note!("error: {error}"));
    Err(first)
}

/// Says what the set-up found.
pub fn announce(args: &RenderArgs, render: &Render) {
    let found = if render.settings().radius.is_some() { "" } else { " (found: two pixels wide)" };
    note!("{} hit points, radius {:.4}{found}", render.setup().hit_points, render.setup().radius);
    if render.eye_paths() == EyePaths::Retraced {
        note!("every pass traces other eye paths; the hit points are those of the first");
    }
    if render.is_finished() {
        note!("no pass is called for: there is no light that photons or samples of area lights could bring");
    }
    if let Some(aim) = render.setup().aim.filter(|aim| aim.budget.aimed > 0) {
        let gain = aim.gain.map_or(String::new(), |gain| {
            format!("; a trial had {gain:.1} times less variance for the same rays")
        });
        note!(
            "{} of {} photons a pass are aimed at mirrors and glass{gain}",
            aim.budget.aimed,
            render.settings().photons
        );
    }
    if let Some(guide) = render.setup().guide.filter(|guide| guide.share > 0.0) {
        note!(
            "{} of photons are guided to what is seen: by nature {} arrive, of those {}; a trial had {:.1} times less variance for the same rays",
            percent(guide.share),
            percent(guide.arriving),
            percent(guide.guided_arriving),
            guide.gain
        );
    }
    let Some(target) = args.target_error else { return };
    let (target, confidence) = (percent(target), percent(args.confidence));
    note!(
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

/// What the scene asks for, and the user in its place.
pub fn settings(args: &RenderArgs, desc: &SceneDesc) -> Settings {
    let of_scene = Settings::of_scene(&desc.render);
    Settings {
        samples: args.samples.unwrap_or(of_scene.samples),
        depth: args.depth.unwrap_or(of_scene.depth),
        photons: args.photons.unwrap_or(of_scene.photons),
        caustic_photons: args.caustic_photons,
        guiding: args.guiding.into(),
        alpha: args.alpha.unwrap_or(of_scene.alpha),
        radius: args.radius.or(of_scene.radius),
        policy: args.radius_policy.map_or_else(RadiusPolicy::default, Into::into),
        precision: args.precision.into(),
        sampling: args.sampling.into(),
        seed: args.run.seed,
        eye_seed: args.eye_seed,
        eye_paths: args.eye_paths.into(),
        error_estimates: error_estimates(args),
        transport: args.transport.iter().copied().collect(),
        kinds: if args.apart { Kinds::Apart } else { Kinds::Together },
        planning: if args.no_plan { Planning::Everything } else { Planning::Derived },
    }
}

fn error_estimates(args: &RenderArgs) -> ErrorEstimates {
    match (args.no_error_estimates, args.layers) {
        (true, _) => ErrorEstimates::None,
        (false, false) => ErrorEstimates::Picture,
        (false, true) => ErrorEstimates::Pixels,
    }
}

fn count_of_passes(args: &RenderArgs) -> Result<Option<u32>, CliError> {
    match args.passes {
        None => Ok(None),
        Some(PassesArg::Count(passes)) => Ok(Some(passes)),
        Some(PassesArg::Range(range)) => Err(PartError::RangeAlone { range }.into()),
    }
}

fn budget(args: &RenderArgs, passes: Option<u32>, desc: &SceneDesc) -> Budget {
    let open = args.run.time.is_some() || args.target_error.is_some();
    let of_scene = (!open).then_some(desc.render.passes);
    Budget { steps: passes.or(of_scene), seconds: args.run.time }
}
