//! Who renders what, when: a process a job, the next one's scene loading while others render.

mod replies;

use std::collections::{BTreeMap, VecDeque};
use std::path::Path;
use std::sync::mpsc::{self, Receiver, Sender};
use std::time::Duration;

use super::forecast::{Left, Spent};
use super::process::{Heard, Process, Start};
use super::task::Task;
use super::{
    BatchError, Change, Crew, Hashes, Job, Ledger, Order, Row, Schedule, Standing, State, Verdict, Watch,
};

/// Renders the jobs of a list that are not done, or of which anything has changed since.
///
/// # Errors
/// When the ledger cannot be written. Whatever is under way ends with it.
pub fn run(
    crew: &Crew,
    ledger: &mut Ledger,
    schedule: impl FnOnce(usize) -> Schedule,
    watch: &mut dyn Watch,
) -> Result<Standing, BatchError> {
    ledger.close_lost()?;
    let rows: Vec<Row> = ledger.rows()?.into_iter().filter(|row| row.is_listed).collect();
    let (jobs, mut hashes, mut tasks) = (rows.len(), Hashes::default(), Vec::new());
    for row in rows {
        if !is_current(crew, ledger, &row, &mut hashes)? {
            tasks.push(Task::of(row));
        }
    }
    let batch = ledger.begin(&crew.version)?;
    let standing = Standing { jobs, unchanged: jobs - tasks.len(), ..Standing::default() };
    let mut runner = Runner::new(crew, ledger, watch, schedule(tasks.len()), batch, tasks, standing);
    runner.run()?;
    let standing = runner.standing;
    let outcome = match (standing.waiting(), standing.failed) {
        (0, 0) => "done",
        (0, _) => "some jobs failed",
        _ => "stopped",
    };
    ledger.end(batch, outcome)?;
    Ok(standing)
}

/// Whether its picture is what the job would come to now.
fn is_current(crew: &Crew, ledger: &Ledger, row: &Row, hashes: &mut Hashes) -> Result<bool, BatchError> {
    if row.state != State::Done || row.program.as_ref() != Some(&crew.version) {
        return Ok(false);
    }
    let (inputs, outputs) = (ledger.inputs(&row.job.name)?, ledger.outputs(&row.job.name)?);
    let is_known = !inputs.is_empty() && !outputs.is_empty();
    Ok(is_known && hashes.hold(Path::new(""), &inputs) && hashes.hold(&crew.folder, &outputs))
}

/// A process whose scene took so many seconds to load and build may take on the next job, which may share what took them.
const SLOW_LOAD: f64 = 0.1;

/// Whether the process of one job may take on another: jobs of one folder share meshes. A limit of memory is for one job alone.
fn may_follow(previous: &Task, next: &Task) -> bool {
    previous.started_in == next.started_in
        && previous.job.scene.parent() == next.job.scene.parent()
        && previous.job.memory_limit.is_none()
        && next.job.memory_limit.is_none()
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Loading,
    Ready,
    Rendering,
    /// What came of its job is known.
    Over,
}

/// A process and its job.
#[derive(Debug)]
struct Hand {
    task: usize,
    process: Process,
    phase: Phase,
    round: usize,
    threads: usize,
    /// Seconds that its slowest job took to load.
    slowest_load: f64,
}

struct Runner<'a> {
    crew: &'a Crew,
    ledger: &'a mut Ledger,
    watch: &'a mut dyn Watch,
    schedule: Schedule,
    batch: i64,
    tasks: Vec<Task>,
    /// Those that are to be begun, the next one in front.
    queue: VecDeque<usize>,
    hands: BTreeMap<usize, Hand>,
    hired: usize,
    tell: Sender<(usize, Heard)>,
    heard: Receiver<(usize, Heard)>,
    /// What the ledger is yet to be told.
    changes: Vec<Change>,
    spent: Spent,
    standing: Standing,
    is_stopping: bool,
}

/// How often to look whether the batch is to stop.
const TICK: Duration = Duration::from_millis(200);

impl<'a> Runner<'a> {
    fn new(
        crew: &'a Crew,
        ledger: &'a mut Ledger,
        watch: &'a mut dyn Watch,
        schedule: Schedule,
        batch: i64,
        tasks: Vec<Task>,
        standing: Standing,
    ) -> Runner<'a> {
        let mut order: Vec<usize> = (0..tasks.len()).collect();
        let (tell, heard) = mpsc::channel();
        order.sort_by_key(|&task| std::cmp::Reverse(tasks[task].job.priority));
        Runner {
            crew,
            ledger,
            watch,
            schedule,
            batch,
            tasks,
            queue: order.into(),
            hands: BTreeMap::new(),
            hired: 0,
            tell,
            heard,
            changes: Vec::new(),
            spent: Spent::default(),
            standing,
            is_stopping: false,
        }
    }

    fn run(&mut self) -> Result<(), BatchError> {
        loop {
            if self.watch.is_over() && !self.is_stopping {
                self.stop();
            }
            self.turn_over()?;
            self.hire();
            self.set_going();
            self.pass_on()?;
            if self.hands.is_empty() && (self.queue.is_empty() || self.is_stopping) {
                return Ok(());
            }
            self.listen();
        }
    }

    /// Goes on to the next layout when the jobs of one have been tried.
    fn turn_over(&mut self) -> Result<(), BatchError> {
        let round = self.schedule.round();
        let is_busy = self.hands.values().any(|hand| hand.round == round && hand.phase != Phase::Over);
        if !is_busy && let Some(layout) = self.schedule.round_is_over() {
            let measured = self.schedule.told();
            self.ledger.set_layout(self.batch, layout, &measured)?;
            self.watch.layout(layout, &measured);
        }
        Ok(())
    }

    /// As many scenes are loaded ahead as jobs render at once; none where a process that is there has loaded most of it.
    fn hire(&mut self) {
        while !self.is_stopping && !self.queue.is_empty() {
            let ahead = self.count(Phase::Loading) + self.count(Phase::Ready);
            let idle = self.schedule.layout().jobs.saturating_sub(self.count(Phase::Rendering));
            let more = if self.next_has_a_process() { 0 } else { self.schedule.layout().jobs };
            if ahead >= idle + more {
                break;
            }
            let Some((round, threads)) = self.schedule.assign() else { break };
            let Some(task) = self.queue.pop_front() else { break };
            self.start(task, round, threads);
        }
    }

    /// Whether the next job is to wait for a process that may take it on, or that may turn out to.
    fn next_has_a_process(&self) -> bool {
        let Some(next) = self.queue.front().map(|&next| &self.tasks[next]) else { return false };
        let may_take_it = |hand: &Hand| {
            (hand.phase == Phase::Loading || hand.slowest_load > SLOW_LOAD)
                && may_follow(&self.tasks[hand.task], next)
        };
        self.schedule.is_settled() && self.hands.values().any(may_take_it)
    }

    fn start(&mut self, task: usize, round: usize, threads: usize) {
        let Task { job, started_in, .. } = &self.tasks[task];
        let start = Start {
            program: &self.crew.program,
            folder: started_in.clone(),
            threads,
            memory_limit: job.memory_limit,
        };
        let (order, job) = (self.prepare(job), job.name.clone());
        let mut process = match Process::start(&start, self.hired, &self.tell) {
            Ok(process) => process,
            Err(error) => return self.not_started(task, threads, &error),
        };
        process.order(&order);
        self.changes.push(Change::Began { job, process: process.id, threads });
        self.hands.insert(
            self.hired,
            Hand { task, process, phase: Phase::Loading, round, threads, slowest_load: 0.0 },
        );
        self.hired += 1;
    }

    /// The folder that its scene is relative to may be gone, or there are too many processes.
    fn not_started(&mut self, task: usize, threads: usize, error: &BatchError) {
        let job = self.tasks[task].job.name.clone();
        let verdict = Verdict::Failed { reason: error.to_string() };
        self.tasks[task].is_over = true;
        self.standing.failed += 1;
        self.changes.push(Change::Began { job: job.clone(), process: 0, threads });
        self.changes.push(Change::Ended { job, verdict, last_words: String::new() });
    }

    /// Equal pictures are equal files, so that it does not matter which attempt made one.
    fn prepare(&self, job: &Job) -> Order {
        let checkpoint = self.crew.folder.join("checkpoints").join(format!("{}.checkpoint", job.name));
        let flag = |flag: &str, path: &Path| format!("--{flag}={}", path.display());
        let mut arguments = job.arguments();
        arguments.extend(["--reproducible".to_owned(), "--resume".to_owned()]);
        arguments.extend([flag("output", &job.picture(&self.crew.folder)), flag("checkpoint", &checkpoint)]);
        Order::Prepare { arguments }
    }

    /// The first that are ready, as many as there is room for.
    fn set_going(&mut self) {
        let round = self.schedule.round();
        let mut idle = self.schedule.layout().jobs.saturating_sub(self.count(Phase::Rendering));
        let is_ready = |hand: &&mut Hand| hand.phase == Phase::Ready && hand.round == round;
        for hand in self.hands.values_mut().filter(is_ready) {
            if idle == 0 || self.is_stopping {
                break;
            }
            hand.phase = Phase::Rendering;
            hand.process.order(&Order::Go);
            idle -= 1;
        }
    }

    fn count(&self, phase: Phase) -> usize {
        self.hands.values().filter(|hand| hand.phase == phase).count()
    }

    fn stop(&mut self) {
        self.is_stopping = true;
        for hand in self.hands.values_mut() {
            match hand.phase {
                Phase::Rendering => hand.process.order(&Order::Stop),
                Phase::Loading | Phase::Ready | Phase::Over => hand.process.dismiss(),
            }
        }
    }

    fn pass_on(&mut self) -> Result<(), BatchError> {
        let changes = std::mem::take(&mut self.changes);
        self.ledger.note(&changes, &self.crew.version)?;
        changes.iter().for_each(|change| self.watch.step(change));
        self.standing.loading = self.count(Phase::Loading) + self.count(Phase::Ready);
        self.standing.rendering = self.count(Phase::Rendering);
        let left: Vec<Left> = self.tasks.iter().filter(|task| !task.is_over).map(Task::left).collect();
        self.standing.seconds_left = self.spent.seconds_left(&left, self.schedule.layout().jobs);
        self.watch.standing(&self.standing);
        Ok(())
    }
}
