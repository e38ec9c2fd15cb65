//! What made a picture beside its scene and settings: the command line and the time that it took.

use std::env;

use super::variables;
use crate::output::{Metadata, Value};

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
    let text = |text: std::ffi::OsString| text.to_string_lossy().into_owned();
    let mut variables: Vec<(String, String)> =
        env::vars_os().map(|(name, value)| (text(name), text(value))).collect();
    variables.retain(|(name, _)| name.starts_with(variables::PREFIX));
    variables.sort_unstable();
    let variables = variables.into_iter().map(|(name, value)| format!("{name}={}", quoted(&value)));
    let arguments = env::args_os().map(|argument| quoted(&text(argument)));
    variables.chain(arguments).collect::<Vec<_>>().join(" ")
}

/// In single quotes, if a shell would otherwise read anything into it.
fn quoted(argument: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_-./,:=@%+".contains(c);
    if !argument.is_empty() && argument.chars().all(is_plain) {
        return argument.into();
    }
    format!("'{}'", argument.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_are_quoted_where_a_shell_needs_it() {
        assert_eq!(quoted("data/cornell_b.toml"), "data/cornell_b.toml");
        assert_eq!(quoted("--size=64x64"), "--size=64x64");
        assert_eq!(quoted("my scene.toml"), "'my scene.toml'");
        assert_eq!(quoted("it's"), r"'it'\''s'");
        assert_eq!(quoted(""), "''");
        assert_eq!(quoted("$HOME"), "'$HOME'");
    }

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
