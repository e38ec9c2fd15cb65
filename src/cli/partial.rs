//! `render --partial`: some passes of a picture, whose file is result and checkpoint in one.

use std::path::{Path, PathBuf};
use std::time::Instant;

use super::args::{PassesArg, RenderArgs};
use super::checkpoints::DEFAULT_SECONDS;
use super::error::{CliError, Outcome};
use super::interrupt::Interrupt;
use super::loading::load_sized;
use super::memory;
use super::outputs::described;
use super::part_error::PartError;
use super::pictures::default_output;
use super::progress::{Budget, Progress};
use super::render::{announce, settings};
use super::threads::use_threads;
use crate::checkpoint::Facts;
use crate::effects::Unseen;
use crate::output::{OutputError, check_writable};
use crate::ppm::{ErrorEstimates, IndependentPasses, RadiusPolicy, Settings};
use crate::scene::{Scene, SceneDesc};
use crate::shard::{Identity, Merge, PassRange, Shard, Work};

/// What the names of shards end in.
pub const EXTENSION: &str = "shard";

/// Renders a range of passes, those that are not in the file yet.
pub fn run(args: &RenderArgs) -> Result<Outcome, CliError> {
    let range = range(args)?;
    use_threads(args.run.threads)?;
    let desc = load_sized(&args.scene, &args.run.access, args.run.size)?;
    let settings = settings_of_part(args, &desc);
    IndependentPasses::check(&settings)?;
    memory::check_partial(&desc, &settings)?;
    let path = path(args, &desc, range);
    check_name(&path)?;
    check_writable(&path).map_err(CliError::BadOutput)?;
    let facts = Facts::of(&desc, &settings, args.run.traversal.into())?;
    let before = existing(&path, &facts, range)?;
    if before.as_ref().is_some_and(|shard| shard.passes.end() == range.end) {
        note!("{}: its passes {range} are there already", path.display());
        return Ok(Outcome::Done);
    }
    let started = Instant::now();
    let (name, size) = (desc.name.clone(), (desc.film.width as usize, desc.film.height as usize));
    let scene = Scene::with_traversal(desc, args.run.traversal.into())?;
    let interrupt = Interrupt::listen();
    let passes = IndependentPasses::new(&scene, settings)?;
    announce(args, passes.render());
    let header = described(passes.render(), &name, args.run.traversal.into());
    let shard = begin(before, Identity { facts, header }, size, &path)?;
    let every = args.checkpoint_every.unwrap_or(DEFAULT_SECONDS);
    Session::new(passes, shard, range, Place { path, every }, started).run(&interrupt)
}

/// What is asked for, if it can be had in parts.
fn range(args: &RenderArgs) -> Result<PassRange, CliError> {
    let Some(PassesArg::Range(range)) = args.passes else { return Err(PartError::NoRange.into()) };
    let refused = refusals(args).into_iter().find(|refusal| refusal.0);
    refused.map_or(Ok(range), |(_, flag, reason)| Err(PartError::NotInPart { flag, reason }.into()))
}

/// What was asked for, by which flag, and why parts of a picture cannot have it.
fn refusals(args: &RenderArgs) -> [(bool, &'static str, &'static str); 11] {
    let whole = "it is of the whole picture; `caustica merge` writes that";
    let features = "it needs no photons, so that a render with --passes 0 writes it at once";
    [
        (
            args.run.time.is_some(),
            "--time",
            "which passes a shard holds must not depend on how fast a machine is",
        ),
        (
            args.target_error.is_some(),
            "--target-error",
            "a part does not know the error of the whole picture",
        ),
        (args.layers, "--layers", "`caustica merge` finds the standard error from all passes"),
        (args.apart, "--apart", "shards keep one sum a pixel; render a kind of light alone with --transport"),
        (args.features, "--features", features),
        (args.direct.is_some(), "--direct", features),
        (args.every_pass.is_some(), "--every-pass", whole),
        (args.run.display_server.is_some(), "--display-server", whole),
        (
            args.json.is_some(),
            "--json",
            "a shard keeps its seconds and photons; `caustica merge --json` tells them",
        ),
        (args.checkpoint.is_some(), "--checkpoint", "the shard itself is the checkpoint"),
        (args.resume, "--resume", "a shard that is there always goes on"),
    ]
}

fn settings_of_part(args: &RenderArgs, desc: &SceneDesc) -> Settings {
    let policy = args.radius_policy.map_or(RadiusPolicy::Shared, Into::into);
    Settings { policy, error_estimates: ErrorEstimates::None, ..settings(args, desc) }
}

fn path(args: &RenderArgs, desc: &SceneDesc, PassRange { first, end }: PassRange) -> PathBuf {
    let beside = || default_output(&desc.name, &format!(".{first}-{end}")).with_extension(EXTENSION);
    args.output.clone().unwrap_or_else(beside)
}

fn check_name(path: &Path) -> Result<(), CliError> {
    match path.extension().is_some_and(|extension| extension == EXTENSION) {
        true => Ok(()),
        false => Err(PartError::NotShardName { path: path.into() }.into()),
    }
}

/// What is there already, if it is the beginning of what is asked for.
fn existing(path: &Path, facts: &Facts, range: PassRange) -> Result<Option<Shard>, CliError> {
    if !path.exists() {
        return Ok(None);
    }
    let mut merge = Merge::default();
    merge.add(path)?;
    let Some(shard) = merge.finish() else { return Ok(None) };
    let differences = shard.identity.facts.differences_between(facts, ["the shard", "this render"]);
    if !differences.is_empty() {
        return Err(PartError::OtherShard { path: path.into(), differences }.into());
    }
    match shard.passes.ranges() {
        [] => Ok(Some(shard)),
        [there] if there.first == range.first && there.end <= range.end => Ok(Some(shard)),
        _ => Err(PartError::OtherPasses { path: path.into(), passes: shard.passes, range }.into()),
    }
}

/// The shard to add to. Equal facts and another set-up come from another machine, which rounds otherwise.
fn begin(
    before: Option<Shard>,
    identity: Identity,
    size: (usize, usize),
    path: &Path,
) -> Result<Shard, CliError> {
    let Some(shard) = before else { return Ok(Shard::new(identity, size)) };
    let differences = shard.identity.differences(&identity, ["the shard", "this render"]);
    if !differences.is_empty() {
        return Err(PartError::OtherShard { path: path.into(), differences }.into());
    }
    let seconds = (shard.work.setup_milliseconds + shard.work.pass_milliseconds) as f64 / 1e3;
    note!("going on from {}: passes {} in {seconds:.1} s", path.display(), shard.passes);
    Ok(shard)
}

/// Where the shard goes, and how often.
struct Place {
    path: PathBuf,
    every: f64,
}

/// A shard under way.
struct Session<'s> {
    passes: IndependentPasses<'s>,
    shard: Shard,
    range: PassRange,
    place: Place,
    progress: Progress,
    unseen: Unseen,
    saved: Instant,
}

impl<'s> Session<'s> {
    fn new(
        passes: IndependentPasses<'s>,
        mut shard: Shard,
        range: PassRange,
        place: Place,
        started: Instant,
    ) -> Session<'s> {
        let progress = Progress::start("pass", Budget { steps: Some(range.count()), seconds: None });
        progress.resume_at(shard.passes.count());
        let setup_milliseconds = milliseconds(started);
        shard.work = shard.work.with(Work { setup_milliseconds, ..Work::default() });
        Session { passes, shard, range, place, progress, unseen: Unseen::default(), saved: Instant::now() }
    }

    fn run(mut self, interrupt: &Interrupt) -> Result<Outcome, CliError> {
        let next = self.range.first + self.shard.passes.count();
        for pass in next..self.range.end {
            if interrupt.is_asked() {
                break;
            }
            self.pass(pass);
            if self.saved.elapsed().as_secs_f64() >= self.place.every && pass + 1 < self.range.end {
                self.save_if_possible();
            }
        }
        self.progress.finish();
        self.finish()?;
        Ok(if interrupt.is_asked() { Outcome::Interrupted } else { Outcome::Done })
    }

    fn pass(&mut self, pass: u32) {
        let started = Instant::now();
        let (picture, statistics) = self.passes.pass(pass);
        self.shard.add(pass, &picture);
        let (natural, aimed) = (statistics.photons.emitted, statistics.aimed_photons.emitted);
        let work =
            Work { pass_milliseconds: milliseconds(started), photons: natural + aimed, ..Work::default() };
        self.shard.work = self.shard.work.with(work);
        if self.passes.render().plan().photons
            && let Some(words) = self.unseen.after_pass(natural, statistics.gathered)
        {
            note!("warning: {words}");
        }
        self.progress.step(format!("{:.0} photons/s", (natural + aimed) as f64 / statistics.seconds));
    }

    /// A disk that is full now may have room when it is done.
    fn save_if_possible(&mut self) {
        if let Err(error) = self.save() {
            note!("warning: the passes {} are not on disk yet: {error}", self.shard.passes);
        }
    }

    fn save(&mut self) -> Result<(), OutputError> {
        self.saved = Instant::now();
        self.shard.save(&self.place.path)
    }

    fn finish(&mut self) -> Result<(), CliError> {
        let path = self.place.path.display().to_string();
        if self.shard.passes.count() == 0 {
            note!("{path} is not written: no pass was finished");
            return Ok(());
        }
        self.save()?;
        let missing = self.shard.sums.not_finite().len();
        if missing > 0 {
            note!("warning: {path}: {missing} pixels were not finite in some pass, which they leave out");
        }
        let Work { setup_milliseconds, pass_milliseconds, .. } = self.shard.work;
        let seconds = [pass_milliseconds, setup_milliseconds].map(|milliseconds| milliseconds as f64 / 1e3);
        note!(
            "{path}: passes {} in {:.1} s after {:.1} s of set-up",
            self.shard.passes,
            seconds[0],
            seconds[1]
        );
        Ok(())
    }
}

fn milliseconds(since: Instant) -> u64 {
    since.elapsed().as_millis() as u64
}
