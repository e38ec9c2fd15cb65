//! Standard output and standard error, which whoever reads them may close at any time.

use std::fmt::Display;
use std::io::{self, Write};

use serde::Serialize;

use super::error::CliError;

/// Says something on standard error; where nobody listens any more, the work goes on.
macro_rules! note {
    ($($arguments:tt)*) => {
        $crate::cli::console::say(format_args!($($arguments)*))
    };
}

pub(super) fn say(text: impl Display) {
    drop(writeln!(io::stderr(), "{text}"));
}

/// Prints a result on standard output, as it is.
pub fn print(text: impl Display) -> Result<(), CliError> {
    let mut out = io::stdout().lock();
    write!(out, "{text}").and_then(|()| out.flush()).map_err(|source| CliError::StandardOutput { source })
}

/// Prints a result as a line of JSON.
pub fn print_json(value: &impl Serialize) -> Result<(), CliError> {
    print(format_args!("{}\n", serde_json::json!(value)))
}
