//! One picture that is to be rendered.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

/// A picture that is to be rendered: a scene, and flags of `caustica render`.
#[derive(Clone, Debug, PartialEq)]
pub struct Job {
    /// The name of its picture without extension; no other job of the batch has it.
    pub name: String,
    /// The scene, relative to the folder that the batch was started in.
    pub scene: PathBuf,
    /// What else `caustica render` is told.
    pub settings: Settings,
    /// Jobs of higher priority are begun before those of lower; equal ones in the order of the list.
    pub priority: i64,
    /// How often it is begun again after its process died.
    pub retries: u32,
    /// Bytes that its process may hold; `None` for no limit.
    pub memory_limit: Option<u64>,
}

impl Job {
    /// The arguments of `caustica render` that make this picture, up to where it is written.
    pub fn arguments(&self) -> Vec<String> {
        let scene = self.scene.to_string_lossy().into_owned();
        ["render".to_owned(), scene].into_iter().chain(self.settings.arguments()).collect()
    }

    /// Where its picture goes.
    pub fn picture(&self, folder: &Path) -> PathBuf {
        folder.join(format!("{}.exr", self.name))
    }
}

/// Flags of `caustica render` without their dashes, and their values; none for a flag that takes none.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Settings(BTreeMap<String, Vec<String>>);

impl Settings {
    /// Takes a value in the place of the one before; `None` for a flag that is off.
    pub fn set(&mut self, flag: &str, values: Option<Vec<String>>) {
        match values {
            Some(values) => self.0.insert(flag.to_owned(), values),
            None => self.0.remove(flag),
        };
    }

    /// Whether one of these flags is there.
    pub fn has_any(&self, flags: &[&str]) -> bool {
        flags.iter().any(|flag| self.0.contains_key(*flag))
    }

    /// What is set, by name.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &[String])> {
        self.0.iter().map(|(flag, values)| (flag.as_str(), values.as_slice()))
    }

    /// As they stand on a command line.
    pub fn arguments(&self) -> Vec<String> {
        let mut arguments = Vec::new();
        for (flag, values) in &self.0 {
            match values.as_slice() {
                [] => arguments.push(format!("--{flag}")),
                values => arguments.extend(values.iter().map(|value| format!("--{flag}={value}"))),
            }
        }
        arguments
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_are_those_of_render() {
        let mut settings = Settings::default();
        settings.set("passes", Some(vec!["4".into()]));
        settings.set("layers", Some(vec![]));
        settings.set("apart", Some(vec![]));
        settings.set("apart", None);
        settings.set("define", Some(vec!["a=1".into(), "b=2".into()]));
        let job = Job {
            name: "a b".into(),
            scene: "x/s.toml".into(),
            settings,
            priority: 0,
            retries: 0,
            memory_limit: None,
        };
        let expected = ["render", "x/s.toml", "--define=a=1", "--define=b=2", "--layers", "--passes=4"];
        assert_eq!(job.arguments(), expected);
        assert_eq!(job.picture(Path::new("out")), Path::new("out/a b.exr"));
    }
}
