//! The ledger on disk.

use super::super::{Done, Settings, State, Verdict};
use super::*;
use std::fs;

fn job(name: &str) -> Job {
    let settings = Settings::default();
    Job {
        name: name.into(),
        scene: "s.toml".into(),
        settings,
        priority: 0,
        retries: 1,
        memory_limit: Some(7),
    }
}

fn began(job: &str) -> Change {
    Change::Began { job: job.into(), process: 7, threads: 2 }
}

fn ended(job: &str, verdict: Verdict) -> Change {
    Change::Ended { job: job.into(), verdict, last_words: "words".into() }
}

fn file(name: &str, hash: Option<&str>) -> FileHash {
    FileHash { path: name.into(), hash: hash.map(str::to_owned) }
}

fn done() -> Verdict {
    let outputs = vec![file("a.exr", Some("12"))];
    Verdict::Done(Done {
        passes: 4,
        seconds: 1.5,
        error: Some(0.1),
        error_bound: None,
        peak_memory: Some(9),
        outputs,
    })
}

/// A ledger with the jobs a, which is done, and b, which is under way.
fn ledger(folder: &Path) -> Ledger {
    let mut ledger = Ledger::open(folder).unwrap();
    ledger.enlist(&[job("a"), job("b")], Path::new("/here")).unwrap();
    let loaded = Change::Loaded {
        job: "a".into(),
        seconds: 0.5,
        inputs: vec![file("/s.toml", Some("34")), file("/none", None)],
    };
    ledger.note(&[began("a"), loaded, ended("a", done()), began("b")], "1.0").unwrap();
    ledger
}

fn states(ledger: &Ledger) -> Vec<(String, &'static str, Option<String>)> {
    ledger.rows().unwrap().into_iter().map(|row| (row.job.name, row.state.name(), row.reason)).collect()
}

#[test]
fn what_was_noted_is_there_again() {
    let folder = tempfile::tempdir().unwrap();
    drop(ledger(folder.path()));
    let ledger = Ledger::look(folder.path()).unwrap();
    let row = &ledger.rows().unwrap()[0];
    assert_eq!((row.job.clone(), row.state, row.is_listed), (job("a"), State::Done, true));
    assert_eq!((row.passes, row.seconds, row.error, row.error_bound), (Some(4), Some(1.5), Some(0.1), None));
    assert_eq!((row.program.as_deref(), row.started_in.to_str()), (Some("1.0"), Some("/here")));
    assert_eq!(ledger.inputs("a").unwrap(), [file("/none", None), file("/s.toml", Some("34"))]);
    assert_eq!(ledger.outputs("a").unwrap(), [file("a.exr", Some("12"))]);
    let attempt = &ledger.attempts("a").unwrap()[0];
    assert_eq!((attempt.number, attempt.process, attempt.threads), (1, 7, 2));
    assert_eq!((attempt.load_seconds, attempt.seconds, attempt.peak_memory), (Some(0.5), Some(1.5), Some(9)));
    assert_eq!(attempt.outcome.as_deref(), Some("done"));
}

#[test]
fn warnings_are_those_of_their_process() {
    let folder = tempfile::tempdir().unwrap();
    let mut ledger = ledger(folder.path());
    let warned =
        |job: &str, process| Change::Warned { job: job.into(), process, warnings: "warning: w".into() };
    let silent = Change::Ended { job: "b".into(), verdict: done(), last_words: String::new() };
    ledger.note(&[silent, warned("b", 8)], "1.0").unwrap();
    let words = |ledger: &Ledger| ledger.attempts("b").unwrap()[0].last_words.clone().unwrap();
    assert_eq!(words(&ledger), "", "another process");
    ledger.note(&[warned("b", 7)], "1.0").unwrap();
    assert_eq!(words(&ledger), "warning: w");
}

#[test]
fn jobs_that_died_wait_and_keep_their_reasons() {
    let folder = tempfile::tempdir().unwrap();
    let mut ledger = ledger(folder.path());
    let died = |again| Verdict::Died { reason: "SIGKILL".into(), again };
    ledger.note(&[ended("b", died(true)), began("b"), ended("b", died(false))], "1.0").unwrap();
    assert_eq!(states(&ledger)[1], ("b".into(), "failed", Some("SIGKILL".into())));
    let attempts = ledger.attempts("b").unwrap();
    assert_eq!(attempts.iter().map(|attempt| attempt.number).collect::<Vec<_>>(), [1, 2]);
    assert!(attempts.iter().all(|attempt| attempt.last_words.as_deref() == Some("words")));
}

#[test]
fn what_a_dead_batch_had_under_way_waits_again() {
    let folder = tempfile::tempdir().unwrap();
    drop(ledger(folder.path()));
    let mut ledger = Ledger::open(folder.path()).unwrap();
    assert_eq!(states(&ledger)[1].1, "running");
    ledger.close_lost().unwrap();
    let lost = Some("the batch ended before the job did".to_owned());
    assert_eq!(states(&ledger), [("a".into(), "done", None), ("b".into(), "waiting", lost)]);
    assert_eq!(ledger.attempts("b").unwrap()[0].outcome.as_deref(), Some("lost"));
    assert_eq!(ledger.attempts("a").unwrap()[0].outcome.as_deref(), Some("done"));
}

#[test]
fn jobs_with_other_arguments_wait_and_those_of_the_list_before_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let mut ledger = ledger(folder.path());
    ledger.enlist(&[job("c"), job("a")], Path::new("/here")).unwrap();
    let rows = ledger.rows().unwrap();
    let told: Vec<_> = rows.iter().map(|row| (row.job.name.as_str(), row.state, row.is_listed)).collect();
    assert_eq!(told, [("c", State::Waiting, true), ("a", State::Done, true), ("b", State::Running, false)]);
    let mut changed = job("a");
    changed.settings.set("passes", Some(vec!["5".into()]));
    ledger.enlist(&[changed], Path::new("/here")).unwrap();
    assert_eq!(states(&ledger)[0], ("a".into(), "waiting", None));
}

/// As the first version of the tables was, which had neither memory nor batches.
fn old_ledger(folder: &Path) {
    let connection = Connection::open(folder.join(LEDGER)).unwrap();
    connection.execute_batch(include_str!("schema.sql")).unwrap();
    let rows = "
        INSERT INTO jobs (name, place, priority, retries, started_in, scene, settings, arguments, state, program, seconds)
            VALUES ('old', 0, 3, 1, '/here', 's.toml', '{\"alpha\":[\"0.5\"]}', '[]', 'done', '0.9', 2.5);
        INSERT INTO attempts (job, number, began, program, process, threads, outcome)
            VALUES ('old', 1, '2020-01-01T00:00:00Z', '0.9', 5, 1, 'done');
        PRAGMA application_id = 1130460531;
        PRAGMA user_version = 1;";
    connection.execute_batch(rows).unwrap();
}

#[test]
fn older_ledgers_are_brought_up_to_date_with_all_that_is_in_them() {
    let folder = tempfile::tempdir().unwrap();
    old_ledger(folder.path());
    let before = fs::read(folder.path().join(LEDGER)).unwrap();
    let error = Ledger::look(folder.path()).err().unwrap().to_string();
    assert!(error.contains("version 1, this program reads 2") && error.contains("batch resume"), "{error}");
    assert!(fs::read(folder.path().join(LEDGER)).unwrap() == before, "looking changes nothing");
    let mut ledger = Ledger::open(folder.path()).unwrap();
    let row = &ledger.rows().unwrap()[0];
    assert_eq!(
        (row.job.name.as_str(), row.job.priority, row.state, row.seconds),
        ("old", 3, State::Done, Some(2.5))
    );
    assert_eq!(ledger.attempts("old").unwrap()[0].peak_memory, None);
    ledger.begin("1.0").unwrap();
    Ledger::look(folder.path()).unwrap();
}

#[test]
fn what_is_newer_or_no_ledger_is_refused_and_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(LEDGER);
    let refused = |words: &str| {
        let before = fs::read(&path).unwrap();
        for error in [Ledger::open(folder.path()).err().unwrap(), Ledger::look(folder.path()).err().unwrap()]
        {
            assert!(error.to_string().contains(words), "{error}");
        }
        assert!(fs::read(&path).unwrap() == before, "{words}");
    };
    assert!(matches!(Ledger::look(folder.path()), Err(BatchError::NoLedger { .. })));
    drop(ledger(folder.path()));
    Connection::open(&path).unwrap().pragma_update(None, "user_version", 99).unwrap();
    refused("the ledger has version 99, this program knows those up to 2");
    fs::remove_file(&path).unwrap();
    Connection::open(&path).unwrap().execute_batch("CREATE TABLE diary (day TEXT)").unwrap();
    refused("is no ledger of a batch (it holds other tables");
    fs::write(&path, "Dear diary, today I rendered a great many pictures.".repeat(99)).unwrap();
    refused("is no ledger of a batch (it is no file of SQLite)");
}
