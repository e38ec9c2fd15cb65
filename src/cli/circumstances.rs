//! What made a picture beside its scene and settings: the command line and the time that it took.

use std::env;
use std::ffi::OsString;
use std::iter;

use super::variables;
use crate::output::{Metadata, Value};
use crate::report::quoted;

/// Adds them to the facts of a picture; a reproducible one does without, since paths and seconds differ where pictures do not.
pub fn with_circumstances(metadata: Metadata, reproducible: bool, seconds: f64) -> Metadata {
    if reproducible {
        return metadata;
    }
    metadata
        .with("caustica:command", Value::Text(command_line()))
        .with("caustica:seconds", Value::Double(seconds))
}

/// The command line as a shell takes it, behind the variables that stand for flags.
fn command_line() -> String {
    let text = |text: OsString| text.to_string_lossy().into_owned();
    let mut variables: Vec<(String, String)> =
        env::vars_os().map(|(name, value)| (text(name), text(value))).collect();
    variables.retain(|(name, _)| name.starts_with(variables::PREFIX));
    variables.sort_unstable();
    let variables = variables.into_iter().map(|(name, value)| format!("{name}={}", quoted(&value)));
    variables.chain(env::args_os().map(word)).collect::<Vec<_>>().join(" ")
}

/// The command line as it is typed, whatever the path of the program.
pub fn typed() -> String {
    let arguments = env::args_os().skip(1).map(word);
    iter::once("caustica".to_owned()).chain(arguments).collect::<Vec<_>>().join(" ")
}

fn word(argument: OsString) -> String {
    quoted(&argument.to_string_lossy())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_reproducible_tells_neither_paths_nor_seconds() {
        assert_eq!(with_circumstances(Metadata::new(), true, 1.5), Metadata::new());
        let told = with_circumstances(Metadata::new(), false, 1.5);
        assert_eq!(told.entries()[1], ("caustica:seconds".into(), Value::Double(1.5)));
        let (name, Value::Text(command)) = &told.entries()[0] else { panic!("{told:?}") };
        let program = env::args().next().unwrap();
        assert!(name == "caustica:command" && command.contains(&program), "{command}");
    }
}
