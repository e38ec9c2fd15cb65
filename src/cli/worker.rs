//! The process of a job of `caustica batch`: it renders what it is told on standard input, and says how far it is.

use std::ffi::OsString;
use std::io::{self, BufRead};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, Sender};
use std::thread;
use std::time::{Duration, Instant};

use clap::{CommandFactory, FromArgMatches};

use super::args::{Arguments, Command, RenderArgs, WorkerArgs};
use super::console::print_json;
use super::error::{CliError, Outcome};
use super::interrupt::Interrupt;
use super::memory;
use super::render::{Leaving, Prepared};
use super::threads::use_threads;
use crate::batch::{Done, FileHash, Order, Reply, hash_file};
use crate::checkpoint::CheckpointFile;
use crate::input;
use crate::scene::{Access, FilesRead, MeshMemory, Scene};

/// Renders one job after the other until there are no more orders.
pub fn run(args: &WorkerArgs) -> Result<Outcome, CliError> {
    args.memory_limit.map_or(Ok(()), limit_memory)?;
    let threads = use_threads(args.threads)?;
    let interrupt = Interrupt::listen();
    let (send, orders) = mpsc::channel();
    let stop = interrupt.clone();
    thread::spawn(move || listen(&send, &stop));
    let mut kept = Kept { meshes: args.keep_geometry.then(Arc::default), scene: None };
    while let Ok(Order::Prepare { arguments }) = orders.recv() {
        let files = FilesRead::default();
        let mut job = Job { orders: &orders, interrupt: &interrupt, threads, files, kept: &mut kept };
        job.make(&arguments)?;
    }
    Ok(Outcome::Done)
}

/// What a job leaves to the next.
struct Kept {
    meshes: Option<Arc<MeshMemory>>,
    scene: Option<Arc<Scene>>,
}

/// What the process writes to counts; what it only reserves does not.
fn limit_memory(bytes: u64) -> Result<(), CliError> {
    rlimit::setrlimit(rlimit::Resource::DATA, bytes, bytes)
        .map_err(|source| CliError::MemoryLimit { limit: input::size(bytes), source })
}

/// Without a batch nobody wants the picture, and another batch may be at the same one.
fn listen(orders: &Sender<Order>, stop: &Interrupt) {
    for line in io::stdin().lock().lines().map_while(Result::ok) {
        match serde_json::from_str(&line) {
            Ok(Order::Stop) => stop.ask(),
            Ok(order) => drop(orders.send(order)),
            Err(error) => note!("warning: `{line}` is no order: {error}"),
        }
    }
    std::process::exit(0);
}

/// The arguments of `caustica render`; variables of the environment do not count.
pub fn parse(arguments: &[String]) -> Result<RenderArgs, clap::Error> {
    let words = std::iter::once("caustica").chain(arguments.iter().map(String::as_str)).map(OsString::from);
    let matches = Arguments::command().try_get_matches_from(words)?;
    match Arguments::from_arg_matches(&matches)?.command {
        Command::Render(args) => Ok(args),
        _ => Err(clap::Error::raw(clap::error::ErrorKind::InvalidSubcommand, "a job is a `caustica render`")),
    }
}

/// A job under way.
struct Job<'a> {
    orders: &'a Receiver<Order>,
    interrupt: &'a Interrupt,
    threads: usize,
    files: FilesRead,
    kept: &'a mut Kept,
}

impl Job<'_> {
    fn make(&mut self, arguments: &[String]) -> Result<(), CliError> {
        let reply = match parse(arguments) {
            Ok(args) => self.render(&args).unwrap_or_else(|error| self.failed(&error)),
            Err(error) => Reply::Failed { reason: error.to_string(), memory: false, inputs: Vec::new() },
        };
        print_json(&reply)
    }

    fn render(&mut self, args: &RenderArgs) -> Result<Reply, CliError> {
        let started = Instant::now();
        let prepared = self.prepare(args)?;
        self.kept.scene = self.kept.meshes.is_some().then(|| prepared.scene());
        print_json(&Reply::Ready {
            seconds: started.elapsed().as_secs_f64(),
            photons: prepared.photons(),
            passes: prepared.budget.steps,
            inputs: self.inputs(),
        })?;
        if self.orders.recv().is_err() {
            return Ok(Reply::Stopped);
        }
        let mut told = Instant::now();
        let rendered = prepared.render(self.interrupt, Leaving::Either, &mut |passes| {
            if told.elapsed() > BETWEEN_PASSES {
                drop(print_json(&Reply::Pass { passes }));
                told = Instant::now();
            }
        })?;
        if self.interrupt.is_asked() {
            return Ok(Reply::Stopped);
        }
        remove_checkpoint(args);
        Ok(Reply::Done(Done {
            passes: rendered.passes,
            seconds: rendered.seconds,
            error: rendered.error.map(|error| error.error),
            error_bound: rendered.error.map(|error| error.upper),
            peak_memory: memory::peak_bytes(),
            outputs: outputs(args),
        }))
    }

    /// A checkpoint that does not fit is that of another scene or other settings, which the job had before.
    fn prepare<'a>(&self, args: &'a RenderArgs) -> Result<Prepared<'a>, CliError> {
        match self.begin(args) {
            Err(CliError::Checkpoint(error)) => {
                note!("note: {error}; the render starts anew");
                remove_checkpoint(args);
                self.begin(args)
            }
            prepared => prepared,
        }
    }

    fn begin<'a>(&self, args: &'a RenderArgs) -> Result<Prepared<'a>, CliError> {
        let access = Access::from(&args.run.access).recording(&self.files);
        let access = match &self.kept.meshes {
            Some(meshes) => access.remembering(Arc::clone(meshes)),
            None => access,
        };
        Prepared::following(self.kept.scene.as_deref(), args, access, self.threads)
    }

    fn failed(&self, error: &CliError) -> Reply {
        let reason = error.to_string();
        let memory = matches!(error, CliError::Memory { .. }) || reason.contains("out of memory");
        Reply::Failed { reason, memory, inputs: self.inputs() }
    }

    fn inputs(&self) -> Vec<FileHash> {
        let absolute = |path: PathBuf| std::path::absolute(&path).unwrap_or(path);
        let hash = |hash: blake3::Hash| hash.to_hex().to_string();
        let files = self.files.list().into_iter();
        files.map(|(path, bytes)| FileHash { path: absolute(path), hash: bytes.map(hash) }).collect()
    }
}

/// Passes are told no more often than this.
const BETWEEN_PASSES: Duration = Duration::from_millis(250);

fn remove_checkpoint(args: &RenderArgs) {
    args.checkpoint.iter().for_each(|path| CheckpointFile::remove(path));
}

/// The pictures that are there.
fn outputs(args: &RenderArgs) -> Vec<FileHash> {
    let Some(picture) = &args.output else { return Vec::new() };
    let files = [picture.clone(), picture.with_extension("png")];
    files.into_iter().map(|path| FileHash { hash: hash_file(&path).ok(), path }).collect()
}
