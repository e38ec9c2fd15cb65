//! Variables of the environment that stand for flags of the commands that make pictures: `CAUSTICA_EYE_SEED` for `--eye-seed`.

use std::collections::BTreeSet;
use std::env;
use std::process;

use clap::builder::{BoolishValueParser, TypedValueParser};
use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, Command, CommandFactory, FromArgMatches, Id};

use super::args::Arguments;

/// What all of them begin with.
pub const PREFIX: &str = "CAUSTICA_";

/// The commands whose flags they stand for.
const COMMANDS: [&str; 2] = ["render", "reference"];

/// The arguments of the process, with variables in the place of flags that are not given; ends the process where they are wrong
/// or ask for help.
pub fn parse() -> Arguments {
    let command = Arguments::command();
    let given = command.clone().try_get_matches().unwrap_or_else(|error| error.exit());
    let (command, bound) = with_variables(command, &given);
    let matches = command.try_get_matches().unwrap_or_else(|error| refuse(&error, &bound));
    Arguments::from_arg_matches(&matches).unwrap_or_else(|error| error.exit())
}

/// The command line alone was fine, so a variable is not.
fn refuse(error: &clap::Error, bound: &BTreeSet<String>) -> ! {
    drop(error.print());
    let values =
        bound.iter().map(|name| format!("{name}={}", env::var_os(name).unwrap_or_default().display()));
    note!("taken from the environment: {}", values.collect::<Vec<_>>().join(" "));
    process::exit(error.exit_code())
}

/// The command that looks at the variables, too, and the names of those that count.
fn with_variables(command: Command, given: &ArgMatches) -> (Command, BTreeSet<String>) {
    let mut bound = BTreeSet::new();
    let Some((name, given)) = given.subcommand().filter(|(name, _)| COMMANDS.contains(name)) else {
        return (command, bound);
    };
    tell_unknown(&command);
    let command = command.mut_subcommand(name, |command| {
        let barred = barred(&command, given);
        command.mut_args(|flag| match variable(&flag) {
            Some(name) if !barred.contains(flag.get_id()) && is_set(&flag, &name) => {
                bound.insert(name.clone());
                with_variable(flag, name)
            }
            _ => flag,
        })
    });
    (command, bound)
}

/// The name of the variable that stands for a flag.
fn variable(flag: &Arg) -> Option<String> {
    let name = flag.get_long().filter(|name| !["help", "version"].contains(name))?;
    Some(format!("{PREFIX}{}", name.replace('-', "_").to_ascii_uppercase()))
}

/// An empty variable is none; nor is one that turns a switch off, which would be on nowhere.
fn is_set(flag: &Arg, name: &str) -> bool {
    let Some(value) = env::var_os(name).filter(|value| !value.is_empty()) else { return false };
    let turns_off =
        || matches!(BoolishValueParser::new().parse_ref(&Command::default(), None, &value), Ok(false));
    !(is_switch(flag) && turns_off())
}

fn is_switch(flag: &Arg) -> bool {
    matches!(flag.get_action(), ArgAction::SetTrue)
}

fn with_variable(flag: Arg, name: String) -> Arg {
    let flag = if is_switch(&flag) { flag.value_parser(BoolishValueParser::new()) } else { flag };
    flag.env(name)
}

/// The flags that those on the command line exclude: those win over variables.
fn barred(command: &Command, given: &ArgMatches) -> BTreeSet<Id> {
    let is_given = |flag: &Arg| {
        let id = flag.get_id().as_str();
        given.try_contains_id(id).is_ok() && given.value_source(id) == Some(ValueSource::CommandLine)
    };
    let excluded = |flag: &Arg| -> BTreeSet<Id> {
        command.get_arg_conflicts_with(flag).into_iter().map(|other| other.get_id().clone()).collect()
    };
    let flags = || command.get_arguments();
    let by_given = flags().filter(|flag| is_given(flag)).flat_map(excluded);
    let themselves = flags().filter(|flag| {
        let excluded = excluded(flag);
        flags().any(|other| is_given(other) && excluded.contains(other.get_id()))
    });
    by_given.chain(themselves.map(|flag| flag.get_id().clone())).collect()
}

/// Says which variables look as if they stood for a flag, and do not.
fn tell_unknown(command: &Command) {
    let commands = COMMANDS.iter().filter_map(|name| command.find_subcommand(name));
    let known: BTreeSet<String> = commands.flat_map(Command::get_arguments).filter_map(variable).collect();
    let names = env::vars_os().filter_map(|(name, _)| name.into_string().ok());
    let unknown: BTreeSet<String> =
        names.filter(|name| name.starts_with(PREFIX) && !known.contains(name)).collect();
    for name in unknown {
        note!(
            "warning: the variable {name} stands for no flag of `caustica {}`",
            COMMANDS.join("` or `caustica ")
        );
    }
}
