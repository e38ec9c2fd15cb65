//! The process of a job, as the batch sees it.

use std::collections::VecDeque;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::sync::mpsc::Sender;
use std::thread;

use super::{BatchError, Order, Reply};

/// A process that takes orders.
#[derive(Debug)]
pub(super) struct Process {
    orders: Option<ChildStdin>,
    pub id: u32,
}

/// How to start one.
#[derive(Clone, Debug)]
pub(super) struct Start<'a> {
    /// The program of this very process.
    pub program: &'a Path,
    pub folder: PathBuf,
    pub threads: usize,
    pub memory_limit: Option<u64>,
}

/// What a process says, and its end.
#[derive(Debug)]
pub(super) enum Heard {
    Reply(Reply),
    Ended(End),
}

/// How a process ended.
#[derive(Debug)]
pub(super) struct End {
    pub status: io::Result<ExitStatus>,
    /// The last lines of its standard error.
    pub last_words: String,
}

impl Process {
    /// Starts one whose replies arrive at `heard` under `number`.
    pub fn start(
        start: &Start,
        number: usize,
        heard: &Sender<(usize, Heard)>,
    ) -> Result<Process, BatchError> {
        let failed = |source| BatchError::Start { folder: start.folder.clone(), source };
        let mut command = Command::new(start.program);
        command
            .arg0("caustica")
            .arg("worker")
            .arg(format!("--threads={}", start.threads))
            .current_dir(&start.folder);
        match start.memory_limit {
            Some(bytes) => command.arg(format!("--memory-limit={bytes}")),
            None => command.arg("--keep-geometry"),
        };
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        // Ctrl-C on a terminal is for the batch, which says what to do about it.
        let mut child = command.process_group(0).spawn().map_err(failed)?;
        let process = Process { orders: child.stdin.take(), id: child.id() };
        let heard = heard.clone();
        thread::spawn(move || listen(child, number, &heard));
        Ok(process)
    }

    /// Where the process is gone, its end will be heard of.
    pub fn order(&mut self, order: &Order) {
        let line = format!("{}\n", serde_json::json!(order));
        if let Some(orders) = &mut self.orders {
            drop(orders.write_all(line.as_bytes()));
        }
    }

    /// There are no more orders: it ends, whatever it is at.
    pub fn dismiss(&mut self) {
        self.orders = None;
    }
}

fn listen(mut child: Child, number: usize, heard: &Sender<(usize, Heard)>) {
    let errors = child.stderr.take().map(|stderr| thread::spawn(move || last_lines(stderr)));
    if let Some(stdout) = child.stdout.take() {
        let lines = BufReader::new(stdout).lines().map_while(Result::ok);
        for reply in lines.filter_map(|line| serde_json::from_str(&line).ok()) {
            drop(heard.send((number, Heard::Reply(reply))));
        }
    }
    let status = child.wait();
    let last_words = errors.and_then(|errors| errors.join().ok()).unwrap_or_default();
    drop(heard.send((number, Heard::Ended(End { status, last_words }))));
}

/// What is kept of what a process says.
const MOST_LINES: usize = 20;
const LONGEST_LINE: usize = 2000;

fn last_lines(from: impl Read) -> String {
    let mut lines: VecDeque<String> = VecDeque::new();
    let mut from = BufReader::new(from);
    let mut line = Vec::new();
    while from.read_until(b'\n', &mut line).is_ok_and(|length| length > 0) {
        let text = String::from_utf8_lossy(&line);
        lines.push_back(text.trim_end().chars().take(LONGEST_LINE).collect());
        lines.drain(..lines.len().saturating_sub(MOST_LINES));
        line.clear();
    }
    Vec::from(lines).join("\n")
}

impl End {
    /// Of what it died, in words.
    pub fn reason(&self) -> String {
        let how = match &self.status {
            Err(error) => format!("its process was lost: {error}"),
            Ok(status) => match (status.signal(), status.code()) {
                (Some(signal), _) => format!("its process was killed by {}", signal_name(signal)),
                (None, Some(code)) => {
                    format!("its process ended with exit code {code} before the picture was there")
                }
                (None, None) => "its process ended before the picture was there".to_owned(),
            },
        };
        match self.telling_line() {
            Some(line) => format!("{how}; it last said: {line}"),
            None => how,
        }
    }

    /// What a panic or a lack of memory says first; else the last line.
    fn telling_line(&self) -> Option<&str> {
        let tells = |line: &&str| {
            ["panicked", "error: "].iter().chain(&WANT_OF_MEMORY).any(|words| line.contains(words))
        };
        self.last_words.lines().find(tells).or_else(|| self.last_words.lines().next_back())
    }

    /// What it warned of, as far as it is among its last words.
    pub fn warnings(&self) -> String {
        let warnings = self.last_words.lines().filter(|line| line.starts_with("warning: "));
        warnings.collect::<Vec<_>>().join("\n")
    }

    /// Whether it died for want of memory, by what it said.
    pub fn was_short_of_memory(&self) -> bool {
        WANT_OF_MEMORY.iter().any(|words| self.last_words.contains(words))
    }
}

/// What the libraries and the system say when there is no more memory.
const WANT_OF_MEMORY: [&str; 4] =
    ["memory allocation of ", "bad_alloc", "Cannot allocate memory", "Resource temporarily unavailable"];

/// The usual name of a signal.
fn signal_name(signal: i32) -> String {
    let name = match signal {
        1 => "SIGHUP",
        2 => "SIGINT",
        4 => "SIGILL",
        6 => "SIGABRT (it gave up)",
        7 => "SIGBUS",
        8 => "SIGFPE",
        9 => "SIGKILL (by someone, or by the system for want of memory)",
        11 => "SIGSEGV (it crashed)",
        13 => "SIGPIPE",
        15 => "SIGTERM",
        _ => return format!("signal {signal}"),
    };
    name.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn end(status: i32, last_words: &str) -> End {
        End { status: Ok(ExitStatus::from_raw(status)), last_words: last_words.into() }
    }

    #[test]
    fn ends_are_told_by_signal_or_code_and_last_line() {
        assert!(end(9, "").reason().starts_with("its process was killed by SIGKILL (by someone"));
        assert_eq!(end(44, "").reason(), "its process was killed by signal 44");
        assert_eq!(
            end(101 << 8, "thread panicked\nat last").reason(),
            "its process ended with exit code 101 before the picture was there; it last said: thread panicked"
        );
        assert!(end(11, "one\ntwo").reason().ends_with("it last said: two"));
    }

    #[test]
    fn want_of_memory_is_known_by_its_words() {
        assert!(end(6, "memory allocation of 800 bytes failed").was_short_of_memory());
        assert!(!end(6, "thread 'main' panicked").was_short_of_memory());
    }

    #[test]
    fn warnings_are_kept_and_other_words_are_not() {
        assert_eq!(end(0, "note: one\nwarning: two\nthree").warnings(), "warning: two");
        assert_eq!(end(0, "").warnings(), "");
    }

    #[test]
    fn the_last_lines_are_kept() {
        let text: String = (0..100).map(|line| format!("line {line}\n")).collect();
        let kept = last_lines(text.as_bytes());
        assert!(kept.starts_with("line 80\n") && kept.ends_with("line 99"), "{kept}");
        assert_eq!(last_lines("no end".as_bytes()), "no end");
        assert_eq!(last_lines(&b"\xff\n"[..]), "\u{fffd}");
    }
}
