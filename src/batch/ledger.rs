//! What became of every job, in SQLite beside the pictures.
//!
//! The journal is SQLite's rollback journal, flushed at every commit: it needs no memory shared between processes, so it also holds on
//! network disks, and whatever kills the process leaves the last commit.

use std::path::{Path, PathBuf};
use std::time::Duration;

use rusqlite::{Connection, OpenFlags, Transaction, TransactionBehavior, params};

use super::notes::{apply, enlist};
use super::rows::{Attempt, Row};
use super::schema::{self, Found, VERSION};
use super::{BatchError, Change, FileHash, Job, Layout};

/// The ledger of a folder.
pub struct Ledger {
    folder: PathBuf,
    path: PathBuf,
    connection: Connection,
}

/// Its name in the folder.
pub const LEDGER: &str = "ledger.sqlite";

/// How long to wait for others who read or write.
const PATIENCE: Duration = Duration::from_secs(20);

impl Ledger {
    /// Opens or makes the ledger of a folder, and brings one of an earlier program up to date. Whoever writes holds the
    /// [`super::Lock`] of the folder.
    ///
    /// # Errors
    /// When a later program wrote it, the file is something else, or the disk fails; it stays as it was.
    pub fn open(folder: &Path) -> Result<Ledger, BatchError> {
        let path = folder.join(LEDGER);
        let connection = Connection::open(&path).map_err(|source| failure(folder, &path, source))?;
        let mut ledger = Ledger { folder: folder.to_owned(), path, connection };
        let found = ledger.configure().and_then(|()| schema::find(&ledger.connection));
        match found.map_err(|source| ledger.not_readable(source))? {
            Found::Foreign => Err(ledger.foreign("it holds other tables")),
            Found::Version(version) if version > VERSION => Err(ledger.newer(version)),
            Found::Version(VERSION) => Ok(ledger),
            found => {
                let from = if let Found::Version(version) = found { version } else { 0 };
                let migrated = schema::migrate(&mut ledger.connection, from);
                migrated.map_err(|source| ledger.failure(source))?;
                Ok(ledger)
            }
        }
    }

    /// Opens the ledger to look at it, while a batch may be writing.
    ///
    /// # Errors
    /// When there is none, it is of another version, or it cannot be read.
    pub fn look(folder: &Path) -> Result<Ledger, BatchError> {
        let path = folder.join(LEDGER);
        if !path.is_file() {
            return Err(BatchError::NoLedger { folder: folder.to_owned() });
        }
        // A journal that a killed batch left behind is rolled back by whoever opens the file next, and that takes writing.
        let flags = OpenFlags::SQLITE_OPEN_READ_WRITE | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        let connection =
            Connection::open_with_flags(&path, flags).map_err(|source| failure(folder, &path, source))?;
        let ledger = Ledger { folder: folder.to_owned(), path, connection };
        let found = ledger.configure().and_then(|()| schema::find(&ledger.connection));
        match found.map_err(|source| ledger.not_readable(source))? {
            Found::Version(VERSION) => Ok(ledger),
            Found::Version(version) if version > VERSION => Err(ledger.newer(version)),
            Found::Version(version) => Err(BatchError::OlderLedger {
                path: ledger.path,
                folder: ledger.folder,
                version,
                known: VERSION,
            }),
            Found::Empty | Found::Foreign => Err(ledger.foreign("it holds other tables or none")),
        }
    }

    fn configure(&self) -> rusqlite::Result<()> {
        self.connection.busy_timeout(PATIENCE)?;
        self.connection.pragma_update(None, "foreign_keys", true)?;
        self.connection.pragma_update(None, "synchronous", "FULL")
    }

    fn failure(&self, source: rusqlite::Error) -> BatchError {
        failure(&self.folder, &self.path, source)
    }

    fn not_readable(&self, source: rusqlite::Error) -> BatchError {
        match source.sqlite_error_code() {
            Some(rusqlite::ErrorCode::NotADatabase) => self.foreign("it is no file of SQLite"),
            _ => self.failure(source),
        }
    }

    fn foreign(&self, reason: &str) -> BatchError {
        BatchError::NotALedger { path: self.path.clone(), reason: reason.to_owned() }
    }

    fn newer(&self, version: i64) -> BatchError {
        BatchError::NewerLedger { path: self.path.clone(), version, known: VERSION }
    }

    /// Takes over a list of jobs: those of other arguments than before wait again, those that are not in it are kept without a place.
    /// What an earlier process had under way is under way no more.
    ///
    /// # Errors
    /// When the ledger cannot be written.
    pub fn enlist(&mut self, jobs: &[Job], started_in: &Path) -> Result<(), BatchError> {
        self.change(|transaction| {
            transaction.execute("UPDATE jobs SET place = NULL", [])?;
            for (job, place) in jobs.iter().zip(0i64..) {
                enlist(transaction, job, place, started_in)?;
            }
            Ok(())
        })
    }

    /// Ends what a process that is gone had under way.
    ///
    /// # Errors
    /// When the ledger cannot be written.
    pub fn close_lost(&mut self) -> Result<(), BatchError> {
        self.change(|transaction| {
            const LOST: &str = "the batch ended before the job did";
            transaction
                .execute("UPDATE attempts SET outcome = 'lost', reason = ?1 WHERE outcome IS NULL", [LOST])?;
            transaction
                .execute("UPDATE jobs SET state = 'waiting', reason = ?1 WHERE state = 'running'", [LOST])?;
            transaction.execute("UPDATE batches SET outcome = 'lost' WHERE outcome IS NULL", [])?;
            Ok(())
        })
    }

    /// Notes that a batch begins; its number.
    ///
    /// # Errors
    /// When the ledger cannot be written.
    pub fn begin(&mut self, program: &str) -> Result<i64, BatchError> {
        self.change(|transaction| {
            transaction.execute(
                "INSERT INTO batches (began, program) VALUES (strftime('%Y-%m-%dT%H:%M:%SZ', 'now'), ?1)",
                [program],
            )?;
            Ok(transaction.last_insert_rowid())
        })
    }

    /// Notes how threads are shared out, and by which measurements.
    ///
    /// # Errors
    /// When the ledger cannot be written.
    pub fn set_layout(&mut self, batch: i64, layout: Layout, measured: &str) -> Result<(), BatchError> {
        self.change(|transaction| {
            transaction.execute(
                "UPDATE batches SET jobs_at_once = ?2, threads_each = ?3, measured = ?4 WHERE number = ?1",
                params![batch, layout.jobs as i64, layout.threads as i64, measured],
            )
        })?;
        Ok(())
    }

    /// Notes how the batch ended.
    ///
    /// # Errors
    /// When the ledger cannot be written.
    pub fn end(&mut self, batch: i64, outcome: &str) -> Result<(), BatchError> {
        self.change(|transaction| {
            transaction.execute("UPDATE batches SET outcome = ?2 WHERE number = ?1", params![batch, outcome])
        })?;
        Ok(())
    }

    /// Notes what happened to jobs: all of it, or nothing.
    ///
    /// # Errors
    /// When the ledger cannot be written.
    pub fn note(&mut self, changes: &[Change], program: &str) -> Result<(), BatchError> {
        if changes.is_empty() {
            return Ok(());
        }
        self.change(|transaction| changes.iter().try_for_each(|change| apply(transaction, change, program)))
    }

    fn change<T>(
        &mut self,
        change: impl FnOnce(&Transaction) -> rusqlite::Result<T>,
    ) -> Result<T, BatchError> {
        let run = |connection: &mut Connection| {
            let transaction = Transaction::new(connection, TransactionBehavior::Immediate)?;
            let value = change(&transaction)?;
            transaction.commit()?;
            Ok(value)
        };
        run(&mut self.connection).map_err(|source| failure(&self.folder, &self.path, source))
    }

    /// All jobs: those of the list in its order, then those that it no longer has.
    ///
    /// # Errors
    /// When the ledger cannot be read.
    pub fn rows(&self) -> Result<Vec<Row>, BatchError> {
        self.query("SELECT * FROM jobs ORDER BY place IS NULL, place, name", [], Row::read)
    }

    /// All attempts at a job.
    ///
    /// # Errors
    /// When the ledger cannot be read.
    pub fn attempts(&self, job: &str) -> Result<Vec<Attempt>, BatchError> {
        self.query("SELECT * FROM attempts WHERE job = ?1 ORDER BY number", [job], Attempt::read)
    }

    /// What a job was rendered from; `None` for a file that was not there.
    ///
    /// # Errors
    /// When the ledger cannot be read.
    pub fn inputs(&self, job: &str) -> Result<Vec<FileHash>, BatchError> {
        self.query("SELECT path, hash FROM inputs WHERE job = ?1 ORDER BY path", [job], file_hash)
    }

    /// What a job was rendered to.
    ///
    /// # Errors
    /// When the ledger cannot be read.
    pub fn outputs(&self, job: &str) -> Result<Vec<FileHash>, BatchError> {
        self.query("SELECT path, hash FROM outputs WHERE job = ?1 ORDER BY path", [job], file_hash)
    }

    /// How the latest batch that measured it shared out threads, and what it measured.
    ///
    /// # Errors
    /// When the ledger cannot be read.
    pub fn measured(&self) -> Result<Option<String>, BatchError> {
        const LATEST: &str =
            "SELECT measured FROM batches WHERE measured IS NOT NULL ORDER BY number DESC LIMIT 1";
        Ok(self.query(LATEST, [], |row| row.get(0))?.pop())
    }

    fn query<T>(
        &self,
        sql: &str,
        parameters: impl rusqlite::Params,
        read: impl FnMut(&rusqlite::Row) -> rusqlite::Result<T>,
    ) -> Result<Vec<T>, BatchError> {
        let run = || -> rusqlite::Result<Vec<T>> {
            self.connection.prepare(sql)?.query_map(parameters, read)?.collect()
        };
        run().map_err(|source| self.failure(source))
    }
}

fn failure(folder: &Path, path: &Path, source: rusqlite::Error) -> BatchError {
    BatchError::Ledger { path: path.to_owned(), folder: folder.to_owned(), source }
}

fn file_hash(row: &rusqlite::Row) -> rusqlite::Result<FileHash> {
    Ok(FileHash { path: row.get::<_, String>(0)?.into(), hash: row.get(1)? })
}

#[cfg(test)]
mod tests {
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
        assert_eq!(
            (row.passes, row.seconds, row.error, row.error_bound),
            (Some(4), Some(1.5), Some(0.1), None)
        );
        assert_eq!((row.program.as_deref(), row.started_in.to_str()), (Some("1.0"), Some("/here")));
        assert_eq!(ledger.inputs("a").unwrap(), [file("/none", None), file("/s.toml", Some("34"))]);
        assert_eq!(ledger.outputs("a").unwrap(), [file("a.exr", Some("12"))]);
        let attempt = &ledger.attempts("a").unwrap()[0];
        assert_eq!((attempt.number, attempt.process, attempt.threads), (1, 7, 2));
        assert_eq!(
            (attempt.load_seconds, attempt.seconds, attempt.peak_memory),
            (Some(0.5), Some(1.5), Some(9))
        );
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
        assert_eq!(
            told,
            [("c", State::Waiting, true), ("a", State::Done, true), ("b", State::Running, false)]
        );
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
        assert!(
            error.contains("version 1, this program reads 2") && error.contains("batch resume"),
            "{error}"
        );
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
            for error in
                [Ledger::open(folder.path()).err().unwrap(), Ledger::look(folder.path()).err().unwrap()]
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
}
