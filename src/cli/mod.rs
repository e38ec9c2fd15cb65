//! The command line: arguments become library calls, results become text and exit codes. Nothing below knows of it.

#[macro_use]
mod console;

#[allow(unnameable_types, reason = "what is converted into the library's own types counts as reachable")]
mod args;
mod batch;
mod bench;
mod checkpoints;
mod circumstances;
mod compare;
mod compare_folders;
mod convert;
#[cfg(feature = "oidn")]
mod denoised;
mod doctor;
mod error;
mod error_watch;
mod explain;
mod farm;
mod info;
mod interrupt;
mod json_lines;
mod judgement;
mod live;
mod loading;
mod memory;
mod merge;
mod outputs;
mod part_error;
mod partial;
mod pictures;
mod progress;
mod reference;
mod render;
mod shell;
mod study;
mod surface;
mod threads;
mod variables;
mod worker;

use std::process::ExitCode;

use args::Command;
use error::{CliError, Outcome};

/// Runs the command that the process was started with.
///
/// Exit codes: 0 done; 1 a comparison exceeded its bound, a scene or the program is not sound, jobs of a batch failed, passes are missing, or a file
/// could not be written; 2 the input or the arguments are wrong, nothing was written; 130 interrupted, the picture so far was written;
/// 141 whoever read standard output has closed it.
pub fn run() -> ExitCode {
    match dispatch(variables::parse().command) {
        Ok(outcome) => outcome.exit_code(),
        Err(error) => {
            note!("error: {error}");
            error.exit_code()
        }
    }
}

fn dispatch(command: Command) -> Result<Outcome, CliError> {
    match command {
        Command::Render(args) if args.partial => partial::run(&args),
        Command::Render(args) => render::run(&args),
        Command::Reference(args) => reference::run(&args),
        Command::Merge(args) => merge::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Info(args) => info::run(&args),
        Command::Doctor(args) => doctor::run(&args),
        Command::Explain(args) => explain::run(&args),
        Command::Convert(args) => convert::run(&args),
        Command::Surface(args) => surface::run(&args),
        Command::Bench(args) => bench::run(&args),
        Command::Study(args) => study::run(&args),
        Command::Submit(args) => farm::submit(&args),
        Command::Status(args) => farm::status(&args),
        Command::Batch(args) => batch::run(&args),
        Command::Worker(args) => worker::run(&args),
        Command::Completions(args) => shell::completions(&args),
        Command::Man(args) => shell::man(&args),
    }
}
