//! The `caustica` command: see `caustica --help`.

use std::process::ExitCode;

fn main() -> ExitCode {
    caustica::cli::run()
}
