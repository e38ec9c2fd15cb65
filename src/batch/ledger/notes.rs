//! How the ledger is told of jobs, in SQL.

use std::path::Path;

use rusqlite::{Transaction, named_params, params};

use super::super::{Change, FileHash, Job, Verdict};
use super::State;

fn json(value: &impl serde::Serialize) -> String {
    serde_json::json!(value).to_string()
}

/// A job takes its place in the list; with other arguments than before it waits again.
pub(super) fn enlist(
    transaction: &Transaction,
    job: &Job,
    place: i64,
    started_in: &Path,
) -> rusqlite::Result<()> {
    const ENLIST: &str = "\
        INSERT INTO jobs (name, place, priority, retries, memory_limit, started_in, scene, settings, arguments, state)
        VALUES (:name, :place, :priority, :retries, :memory_limit, :started_in, :scene, :settings, :arguments, 'waiting')
        ON CONFLICT (name) DO UPDATE SET
            place = :place, priority = :priority, retries = :retries, memory_limit = :memory_limit,
            started_in = :started_in, scene = :scene, settings = :settings, arguments = :arguments,
            state = iif(arguments = :arguments AND started_in = :started_in, state, 'waiting'),
            reason = iif(arguments = :arguments AND started_in = :started_in, reason, NULL)";
    transaction.prepare(ENLIST)?.execute(named_params! {
        ":name": job.name,
        ":place": place,
        ":priority": job.priority,
        ":retries": job.retries,
        ":memory_limit": job.memory_limit.map(|bytes| bytes as i64),
        ":started_in": started_in.to_string_lossy(),
        ":scene": job.scene.to_string_lossy(),
        ":settings": json(&job.settings),
        ":arguments": json(&job.arguments()),
    })?;
    Ok(())
}

/// A step of a job.
pub(super) fn apply(transaction: &Transaction, change: &Change, program: &str) -> rusqlite::Result<()> {
    match change {
        Change::Began { job, process, threads } => {
            transaction.execute(
                "INSERT INTO attempts (job, number, began, program, process, threads)
                 SELECT ?1, 1 + count(*), strftime('%Y-%m-%dT%H:%M:%SZ', 'now'), ?2, ?3, ?4 FROM attempts WHERE job = ?1",
                params![job, program, process, *threads as i64],
            )?;
            transaction.execute("UPDATE jobs SET state = 'running' WHERE name = ?1", [job])?;
        }
        Change::Loaded { job, seconds, inputs } => {
            transaction
                .execute(&format!("UPDATE attempts SET load_seconds = ?2 {LATEST}"), params![job, seconds])?;
            replace_files(transaction, "inputs", job, inputs)?;
        }
        Change::Ended { job, verdict, last_words } => end(transaction, job, verdict, last_words, program)?,
        Change::Warned { job, process, warnings } => {
            transaction.execute(
                "UPDATE attempts SET last_words = ?3 WHERE job = ?1 AND process = ?2 AND last_words = ''",
                params![job, process, warnings],
            )?;
        }
    }
    Ok(())
}

/// The attempt that is under way.
const LATEST: &str = "WHERE job = ?1 AND number = (SELECT max(number) FROM attempts WHERE job = ?1)";

fn end(
    transaction: &Transaction,
    job: &str,
    verdict: &Verdict,
    last_words: &str,
    program: &str,
) -> rusqlite::Result<()> {
    let (state, reason) = (State::after(verdict), verdict.reason());
    transaction.execute(
        &format!("UPDATE attempts SET outcome = ?2, reason = ?3, last_words = ?4 {LATEST}"),
        params![job, verdict.name(), reason, last_words],
    )?;
    transaction.execute(
        "UPDATE jobs SET state = ?2, reason = ?3, program = ?4 WHERE name = ?1",
        params![job, state.name(), reason, program],
    )?;
    let Verdict::Done(done) = verdict else { return Ok(()) };
    transaction.execute(
        "UPDATE jobs SET passes = ?2, seconds = ?3, error = ?4, error_bound = ?5 WHERE name = ?1",
        params![job, done.passes, done.seconds, done.error, done.error_bound],
    )?;
    transaction.execute(
        &format!("UPDATE attempts SET seconds = ?2, peak_memory = ?3 {LATEST}"),
        params![job, done.seconds, done.peak_memory.map(|bytes| bytes as i64)],
    )?;
    replace_files(transaction, "outputs", job, &done.outputs)
}

fn replace_files(
    transaction: &Transaction,
    table: &'static str,
    job: &str,
    files: &[FileHash],
) -> rusqlite::Result<()> {
    transaction.execute(&format!("DELETE FROM {table} WHERE job = ?1"), [job])?;
    let mut insert = transaction
        .prepare(&format!("INSERT OR REPLACE INTO {table} (job, path, hash) VALUES (?1, ?2, ?3)"))?;
    for file in files {
        insert.execute(params![job, file.path.to_string_lossy(), file.hash])?;
    }
    Ok(())
}
