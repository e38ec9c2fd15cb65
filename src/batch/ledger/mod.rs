//! What became of every job, in SQLite beside the pictures.
//!
//! The journal is SQLite's rollback journal, flushed at every commit: it needs no memory shared between processes, so it also holds on
//! network disks, and whatever kills the process leaves the last commit.

mod notes;
mod rows;
mod schema;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};
use std::time::Duration;

use rusqlite::{Connection, OpenFlags, Transaction, TransactionBehavior, params};

pub use self::rows::{Attempt, Row, State};

use self::notes::{apply, enlist};
use self::schema::{Found, VERSION};
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
        let (mut ledger, found) = Ledger::connect(folder, OpenFlags::default())?;
        match found {
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
        if !folder.join(LEDGER).is_file() {
            return Err(BatchError::NoLedger { folder: folder.to_owned() });
        }
        // A journal that a killed batch left behind is rolled back by whoever opens the file next, and that takes writing.
        let flags = OpenFlags::SQLITE_OPEN_READ_WRITE | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        let (ledger, found) = Ledger::connect(folder, flags)?;
        match found {
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

    /// The ledger of a folder, and what its file holds.
    fn connect(folder: &Path, flags: OpenFlags) -> Result<(Ledger, Found), BatchError> {
        let path = folder.join(LEDGER);
        let connection =
            Connection::open_with_flags(&path, flags).map_err(|source| failure(folder, &path, source))?;
        let ledger = Ledger { folder: folder.to_owned(), path, connection };
        let found = ledger.configure().and_then(|()| schema::find(&ledger.connection));
        let found = found.map_err(|source| ledger.not_readable(source))?;
        Ok((ledger, found))
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
