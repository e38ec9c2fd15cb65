//! What processes say, and what follows from it.

use std::path::Path;

use super::super::process::{End, Heard};
use super::super::{Change, FileHash, Reply, State, Verdict};
use super::{Phase, Runner, SLOW_LOAD, TICK, may_follow};

impl Runner<'_> {
    pub fn listen(&mut self) {
        let mut next = self.heard.recv_timeout(TICK).ok();
        while let Some((number, heard)) = next {
            match heard {
                Heard::Reply(reply) => self.reply(number, reply),
                Heard::Ended(end) => self.ended(number, &end),
            }
            next = self.heard.try_recv().ok();
        }
    }

    fn reply(&mut self, number: usize, reply: Reply) {
        let Some(hand) = self.hands.get_mut(&number) else { return };
        let task = &mut self.tasks[hand.task];
        let job = task.job.name.clone();
        match reply {
            Reply::Ready { seconds, photons, passes, inputs } => {
                (task.photons_a_pass, task.passes) = (Some(photons as f64), passes);
                hand.phase = Phase::Ready;
                hand.slowest_load = hand.slowest_load.max(seconds);
                self.changes.push(Change::Loaded { job, seconds, inputs });
            }
            Reply::Pass { passes } => task.passes_done = passes,
            Reply::Done(mut done) => {
                let photons = task.photons_a_pass.unwrap_or(0.0) * f64::from(done.passes);
                self.schedule.is_done(hand.round, photons, done.seconds);
                self.spent.add(done.seconds, photons);
                done.outputs.iter_mut().for_each(|output| relative_to(&self.crew.folder, output));
                self.over(number, Verdict::Done(done), "");
            }
            Reply::Stopped if self.is_stopping => self.over(number, Verdict::Stopped, ""),
            Reply::Stopped => self.died(number, "its process was told to stop by a signal", ""),
            Reply::Failed { reason, memory, inputs } => {
                let limit = task.job.memory_limit.filter(|_| memory);
                let reason = limit.map_or(reason.clone(), |limit| out_of_memory(limit, &reason));
                if hand.phase == Phase::Loading {
                    self.changes.push(Change::Loaded { job, seconds: 0.0, inputs });
                }
                self.over(number, Verdict::Failed { reason }, "");
            }
        }
    }

    fn ended(&mut self, number: usize, end: &End) {
        let Some(hand) = self.hands.get(&number) else { return };
        let limit = self.tasks[hand.task].job.memory_limit;
        match (hand.phase, limit) {
            (Phase::Over, _) => self.warned(number, end.warnings()),
            (Phase::Loading | Phase::Ready, _) if self.is_stopping => self.over(number, Verdict::Stopped, ""),
            (_, Some(limit)) if end.was_short_of_memory() => {
                let reason = out_of_memory(limit, &end.reason());
                self.over(number, Verdict::Failed { reason }, &end.last_words);
            }
            _ => self.died(number, &end.reason(), &end.last_words),
        }
        self.hands.remove(&number);
    }

    fn warned(&mut self, number: usize, warnings: String) {
        let Some(hand) = self.hands.get(&number).filter(|_| !warnings.is_empty()) else { return };
        let job = self.tasks[hand.task].job.name.clone();
        self.changes.push(Change::Warned { job, process: hand.process.id, warnings });
    }

    /// It is begun again, if that is not too often.
    fn died(&mut self, number: usize, reason: &str, last_words: &str) {
        let Some(hand) = self.hands.get(&number) else { return };
        let (index, task) = (hand.task, &mut self.tasks[hand.task]);
        let again = self.is_stopping || task.deaths < task.job.retries;
        task.deaths += 1;
        if again {
            self.queue.push_front(index);
        }
        self.over(number, Verdict::Died { reason: reason.to_owned(), again }, last_words);
    }

    /// What came of a job is known.
    fn over(&mut self, number: usize, verdict: Verdict, last_words: &str) {
        let Some(hand) = self.hands.get_mut(&number) else { return };
        let task = &mut self.tasks[hand.task];
        task.is_over = State::after(&verdict) != State::Waiting;
        match State::after(&verdict) {
            State::Done => self.standing.done += 1,
            State::Failed => self.standing.failed += 1,
            State::Waiting | State::Running => {}
        }
        hand.phase = Phase::Over;
        let is_done = matches!(verdict, Verdict::Done(_));
        let job = task.job.name.clone();
        self.changes.push(Change::Ended { job, verdict, last_words: last_words.to_owned() });
        if !is_done || self.is_stopping || !self.go_on(number) {
            self.dismiss(number);
        }
    }

    fn dismiss(&mut self, number: usize) {
        if let Some(hand) = self.hands.get_mut(&number) {
            hand.process.dismiss();
        }
    }

    /// Gives a process that has done its job the next one, if that is allowed.
    fn go_on(&mut self, number: usize) -> bool {
        let (Some(hand), Some(&next)) = (self.hands.get(&number), self.queue.front()) else { return false };
        let is_worth_it = hand.slowest_load > SLOW_LOAD && self.schedule.is_settled();
        let is_theirs = hand.threads == self.schedule.layout().threads;
        if !is_worth_it || !is_theirs || !may_follow(&self.tasks[hand.task], &self.tasks[next]) {
            return false;
        }
        let order = self.prepare(&self.tasks[next].job);
        let job = self.tasks[next].job.name.clone();
        let Some((round, threads)) = self.schedule.assign() else { return false };
        let Some(hand) = self.hands.get_mut(&number) else { return false };
        self.queue.pop_front();
        (hand.task, hand.phase, hand.round) = (next, Phase::Loading, round);
        self.changes.push(Change::Began { job, process: hand.process.id, threads });
        hand.process.order(&order);
        true
    }
}

fn relative_to(folder: &Path, file: &mut FileHash) {
    if let Ok(relative) = file.path.strip_prefix(folder) {
        file.path = relative.to_owned();
    }
}

fn out_of_memory(limit: u64, reason: &str) -> String {
    format!("it ran into its memory limit of {}: {reason}", crate::input::size(limit))
}
