use std::fs::{File, OpenOptions};
use std::io::{self, BufRead, BufReader, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::error::CliError;
use crate::output::check_writable;

/// A stream of JSON objects, one a line, handed to the system as they come, so that a reader can follow the render.
pub struct JsonLines {
    path: PathBuf,
    /// `None` for standard output.
    file: Option<File>,
}

/// What a line tells of its place.
#[derive(Deserialize)]
struct Record {
    pass: u32,
}

/// The records that stay.
#[derive(Debug, Default, PartialEq)]
struct Kept {
    bytes: u64,
    passes: u32,
}

impl JsonLines {
    /// `-` is standard output. A render that goes on after so many passes leaves their records in the file and drops later ones,
    /// which it will make again.
    pub fn open(path: &Path, passes_before: Option<u32>) -> Result<JsonLines, CliError> {
        if path == Path::new("-") {
            return Ok(JsonLines { path: path.into(), file: None });
        }
        check_writable(path).map_err(CliError::BadOutput)?;
        let file = match passes_before {
            Some(passes) if path.exists() => go_on(path, passes)?,
            _ => File::create(path).map_err(|source| failure(path, source))?,
        };
        Ok(JsonLines { path: path.into(), file: Some(file) })
    }

    pub fn write(&mut self, value: &impl Serialize) -> Result<(), CliError> {
        let line =
            format!("{}\n", serde_json::to_string(value).map_err(|error| failure(&self.path, error.into()))?);
        match &mut self.file {
            None => super::console::print(line),
            Some(file) => file.write_all(line.as_bytes()).map_err(|source| failure(&self.path, source)),
        }
    }

    /// Has all lines reach the disk.
    pub fn sync(&mut self) -> Result<(), CliError> {
        let synced = self.file.as_ref().map_or(Ok(()), File::sync_data);
        synced.map_err(|source| failure(&self.path, source))
    }
}

fn failure(path: &Path, source: io::Error) -> CliError {
    CliError::Statistics { path: path.into(), source }
}

fn go_on(path: &Path, passes: u32) -> Result<File, CliError> {
    let kept =
        File::open(path).map_err(|source| failure(path, source)).and_then(|file| kept(path, file, passes))?;
    if kept.passes < passes {
        note!("note: {} holds no records of passes {} to {passes}", path.display(), kept.passes + 1);
    }
    let open = || {
        let file = OpenOptions::new().append(true).open(path)?;
        file.set_len(kept.bytes)?;
        Ok(file)
    };
    open().map_err(|source| failure(path, source))
}

/// The records up to a pass. A last line without an end was torn when the process was killed.
fn kept(path: &Path, file: File, passes: u32) -> Result<Kept, CliError> {
    let (mut reader, mut bytes) = (BufReader::new(file), Vec::new());
    let mut kept = Kept::default();
    for line in 1.. {
        bytes.clear();
        let length = reader.read_until(b'\n', &mut bytes).map_err(|source| failure(path, source))?;
        if !bytes.ends_with(b"\n") {
            break;
        }
        let record: Record = serde_json::from_slice(&bytes)
            .map_err(|_| CliError::ForeignStatistics { path: path.into(), line })?;
        if record.pass > passes {
            break;
        }
        kept = Kept { bytes: kept.bytes + length as u64, passes: record.pass };
    }
    Ok(kept)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn records_of_passes_that_are_made_again_are_dropped() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.jsonl");
        for (before, passes, left) in [
            (
                "{\"pass\":1,\"x\":2}\n{\"pass\":2}\n{\"pass\":3}\n{\"pas",
                2,
                "{\"pass\":1,\"x\":2}\n{\"pass\":2}\n",
            ),
            ("{\"pass\":1}\n{\"pass\":2}", 2, "{\"pass\":1}\n"),
            ("{\"pass\":1}\n", 5, "{\"pass\":1}\n"),
            ("", 5, ""),
            ("{\"pass\":1}\n", 0, ""),
        ] {
            fs::write(&path, before).unwrap();
            JsonLines::open(&path, Some(passes)).unwrap().write(&7).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), format!("{left}7\n"), "{before}");
        }
    }

    #[test]
    fn other_files_are_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        let text = "{\"pass\":1}\nDear diary\n";
        fs::write(&path, text).unwrap();
        let error = JsonLines::open(&path, Some(9)).err().unwrap().to_string();
        assert!(error.contains("a.txt:2: this is not the record of a pass"), "{error}");
        assert_eq!(fs::read_to_string(&path).unwrap(), text);
    }
}
