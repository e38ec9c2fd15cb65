use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::error::CliError;
use crate::output::check_writable;

/// A stream of JSON objects, one a line, flushed as they come, so that a reader can follow the render.
pub struct JsonLines {
    path: PathBuf,
    out: Box<dyn Write>,
}

impl JsonLines {
    /// `-` is standard output.
    pub fn create(path: &Path) -> Result<JsonLines, CliError> {
        let out: Box<dyn Write> = if path == Path::new("-") {
            Box::new(io::stdout())
        } else {
            check_writable(path).map_err(CliError::BadOutput)?;
            Box::new(File::create(path).map_err(|source| CliError::Statistics { path: path.into(), source })?)
        };
        Ok(JsonLines { path: path.into(), out })
    }

    pub fn write(&mut self, value: &impl Serialize) -> Result<(), CliError> {
        serde_json::to_writer(&mut self.out, value)
            .map_err(io::Error::from)
            .and_then(|()| writeln!(self.out))
            .and_then(|()| self.out.flush())
            .map_err(|source| CliError::Statistics { path: self.path.clone(), source })
    }
}
