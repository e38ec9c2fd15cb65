use std::fs::{File, OpenOptions};
use std::io::{self, Read, Seek, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::{Separation, StudyError};
use crate::input;

/// The error of a picture, and what it took.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Passes, or samples a pixel.
    pub steps: u32,
    /// Seconds of set-up and steps.
    pub seconds: f64,
    /// [`crate::compare::Metrics::rel_mse`] against the reference.
    pub rel_mse: f64,
    /// What of that is variance and what is bias, by this repetition and those before.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub separation: Option<Separation>,
}

impl Point {
    /// The relative root-mean-square error in percent.
    pub fn percent(&self) -> f64 {
        100.0 * self.rel_mse.sqrt()
    }
}

/// A configuration rendered once.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// Tells scene, settings, reference and machine apart.
    pub key: String,
    /// Name of the configuration.
    pub configuration: String,
    /// Number of the repetition, from 0.
    pub repetition: u32,
    /// Key of the random numbers.
    pub seed: u64,
    /// Errors on the way, by ascending steps.
    pub points: Vec<Point>,
}

/// Finished runs, one JSON object a line: what was measured once is not measured again.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
    runs: Vec<Run>,
    torn: bool,
}

impl Journal {
    /// Opens or makes the list. A last line without an end, as an interrupted program leaves it, is cut off.
    ///
    /// # Errors
    /// When the file cannot be read or written, or when another line is no run.
    pub fn open(path: &Path) -> Result<Journal, StudyError> {
        let failed = |source| StudyError::Journal { path: path.into(), source };
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(failed)?;
        }
        match input::open_file(path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(failed(error)),
            _ => {}
        }
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(path)
            .map_err(failed)?;
        let mut text = String::new();
        file.read_to_string(&mut text).map_err(failed)?;
        let (runs, whole) = Journal::parse(path, &text)?;
        file.set_len(whole as u64).and_then(|()| file.seek(io::SeekFrom::End(0))).map_err(failed)?;
        Ok(Journal { path: path.into(), file, runs, torn: whole < text.len() })
    }

    /// The runs in the text of a list, and how many of its bytes are whole lines; `path` is named in errors.
    ///
    /// # Errors
    /// When a whole line is no run.
    pub fn parse(path: &Path, text: &str) -> Result<(Vec<Run>, usize), StudyError> {
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        let run = |(index, line): (usize, &str)| {
            serde_json::from_str(line).map_err(|error| StudyError::Line {
                path: path.into(),
                line: index + 1,
                reason: error.to_string(),
            })
        };
        Ok((text[..whole].lines().enumerate().map(run).collect::<Result<_, _>>()?, whole))
    }

    /// Whether a torn last line was cut off.
    pub fn was_torn(&self) -> bool {
        self.torn
    }

    /// All finished runs, those of other studies included.
    pub fn runs(&self) -> &[Run] {
        &self.runs
    }

    /// The run of `key` and `repetition`, if it is finished.
    pub fn find(&self, key: &str, repetition: u32) -> Option<&Run> {
        self.runs.iter().find(|run| run.key == key && run.repetition == repetition)
    }

    /// Adds a finished run, and has it reach the disk.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn append(&mut self, run: Run) -> Result<(), StudyError> {
        let line = format!("{}\n", serde_json::json!(run));
        let written = self.file.write_all(line.as_bytes()).and_then(|()| self.file.sync_data());
        written.map_err(|source| StudyError::Journal { path: self.path.clone(), source })?;
        self.runs.push(run);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::Parts;
    use super::*;
    use std::fs;

    fn run(configuration: &str, repetition: u32) -> Run {
        let parts = Parts { share: 1.0, variance: 0.5, bias2: -0.1, bias2_error: 0.2 };
        let separation = Separation { repetitions: 2, all: parts, flat: None };
        let point = |steps: u32| Point {
            steps,
            seconds: 0.1 * f64::from(steps),
            rel_mse: 1.0 / f64::from(steps),
            separation: (repetition > 0).then_some(separation),
        };
        let points = [1, 2, 3].map(point).to_vec();
        Run {
            key: format!("key of {configuration}"),
            configuration: configuration.into(),
            repetition,
            seed: 7,
            points,
        }
    }

    #[test]
    fn what_was_appended_is_there_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("new/runs.jsonl");
        let mut journal = Journal::open(&path).unwrap();
        for k in 0..3 {
            journal.append(run("a", k)).unwrap();
        }
        let again = Journal::open(&path).unwrap();
        assert_eq!((again.runs(), again.was_torn()), (&[0, 1, 2].map(|k| run("a", k))[..], false));
        assert!(again.find("key of a", 2).is_some() && again.find("key of a", 3).is_none());
        assert!(again.find("key of b", 0).is_none());
    }

    /// Wherever the program was cut off, what was whole before stays, and the next run follows it on a line of its own.
    #[test]
    fn a_torn_last_line_is_cut_off() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.jsonl");
        let mut journal = Journal::open(&path).unwrap();
        journal.append(run("a", 0)).unwrap();
        let first = fs::read(&path).unwrap();
        journal.append(run("b", 0)).unwrap();
        let whole = fs::read(&path).unwrap();
        for end in first.len()..=whole.len() {
            fs::write(&path, &whole[..end]).unwrap();
            let mut journal = Journal::open(&path).unwrap();
            assert_eq!(journal.was_torn(), end != first.len() && end != whole.len(), "{end} bytes");
            assert_eq!(journal.runs().len(), 1 + usize::from(end == whole.len()));
            journal.append(run("c", 0)).unwrap();
            assert!(Journal::open(&path).unwrap().find("key of c", 0).is_some());
        }
    }

    #[test]
    fn other_files_are_refused_with_their_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.jsonl");
        fs::write(&path, format!("{}\n{{\"a\": 1}}\n", serde_json::json!(run("a", 0)))).unwrap();
        let error = Journal::open(&path).unwrap_err().to_string();
        assert!(
            error.contains("runs.jsonl:2: not a measurement") && error.contains("remove the file"),
            "{error}"
        );
        assert!(matches!(Journal::open(folder.path()), Err(StudyError::Journal { .. })));
    }
}
