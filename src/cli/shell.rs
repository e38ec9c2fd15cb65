//! What shells and `man` know of the program, out of the table of its arguments.

use clap::{Command, CommandFactory};
use clap_mangen::Man;

use super::args::{Arguments, CompletionsArgs, ManArgs};
use super::console::print;
use super::error::{CliError, Outcome};
use crate::output::write_atomically;

/// Prints the completions of a shell.
pub fn completions(args: &CompletionsArgs) -> Result<Outcome, CliError> {
    let mut command = Arguments::command();
    let name = command.get_name().to_owned();
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut command, name, &mut script);
    print(String::from_utf8_lossy(&script))?;
    Ok(Outcome::Done)
}

/// Writes a page for the program and one for each of its commands.
pub fn man(args: &ManArgs) -> Result<Outcome, CliError> {
    let mut command = Arguments::command().disable_help_subcommand(true);
    command.build();
    let pages = pages(&command);
    for page in &pages {
        let path = args.folder.join(page.get_filename());
        write_atomically(&path, |out| page.render(out))?;
    }
    print(format_args!("wrote {} pages into {}\n", pages.len(), args.folder.display()))?;
    Ok(Outcome::Done)
}

fn pages(command: &Command) -> Vec<Man> {
    const SOURCE: &str = concat!("caustica ", env!("CARGO_PKG_VERSION"));
    let commands = [command].into_iter().chain(command.get_subcommands());
    commands.map(|command| Man::new(command.clone()).source(SOURCE).manual("Caustica")).collect()
}
