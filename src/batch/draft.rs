//! A job of a list before its sweep.

use std::fmt;
use std::path::{Path, PathBuf};

use super::options::{BUDGET, Options};
use super::sweep::normal;
use super::value::{Entry, Value};
use super::vocabulary::{Kind, OWN};
use super::{Axis, BatchError, Job, Settings, Vocabulary, parse_bytes};

/// Where a job comes from.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Place {
    given: String,
    /// In a list.
    pub line: Option<usize>,
}

impl Place {
    pub fn argument(given: &str) -> Place {
        Place { given: given.to_owned(), line: None }
    }

    pub fn line(path: &Path, line: usize) -> Place {
        Place { given: path.to_string_lossy().into_owned(), line: Some(line) }
    }

    pub fn error(&self, reason: &str) -> BatchError {
        match self.line {
            Some(line) => {
                BatchError::List { path: PathBuf::from(&self.given), line, reason: reason.to_owned() }
            }
            None => BatchError::Jobs { given: self.given.clone(), reason: reason.to_owned() },
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "{}:{line}", self.given),
            None => f.write_str(&self.given),
        }
    }
}

/// What a list says of a job, defaults included.
#[derive(Clone, Debug)]
pub(super) struct Draft {
    pub place: Place,
    pub scene: PathBuf,
    pub name: Option<String>,
    pub axes: Vec<Axis>,
    settings: Settings,
    priority: i64,
    retries: u32,
    memory_limit: Option<u64>,
}

impl Draft {
    /// A scene that is given by its name alone.
    pub fn of_scene(
        scene: PathBuf,
        place: &Place,
        options: &Options,
        vocabulary: &Vocabulary,
    ) -> Result<Draft, BatchError> {
        let mut draft = Draft {
            place: place.clone(),
            scene,
            name: None,
            axes: Vec::new(),
            settings: Settings::default(),
            priority: 0,
            retries: options.retries,
            memory_limit: options.memory_limit,
        };
        draft.apply(options);
        draft.check(vocabulary)?;
        Ok(draft)
    }

    /// A job of a list: its defaults first, then its own entries.
    pub fn of_entries(
        scene: PathBuf,
        path: &Path,
        place: &Place,
        entries: [&[Entry]; 2],
        options: &Options,
        vocabulary: &Vocabulary,
    ) -> Result<Draft, BatchError> {
        let none =
            Options { retries: options.retries, memory_limit: options.memory_limit, ..Options::default() };
        let mut draft = Draft::of_scene(scene, place, &none, vocabulary)?;
        for entry in entries.into_iter().flatten() {
            let place = Place::line(path, entry.line);
            draft.take(entry, &place, vocabulary)?;
        }
        draft.apply(options);
        draft.check(vocabulary)?;
        Ok(draft)
    }

    fn take(&mut self, entry: &Entry, place: &Place, vocabulary: &Vocabulary) -> Result<(), BatchError> {
        let (key, value) = (normal(&entry.key), &entry.value);
        let wrong = |allowed: &str| place.error(&format!("`{key}`: allowed: {allowed}"));
        let text = value.as_text();
        match key.as_str() {
            "scene" => {}
            "name" => self.name = Some(text.ok_or_else(|| wrong("a text in quotes"))?),
            "priority" => {
                self.priority = parsed(text).ok_or_else(|| wrong("a whole number; higher ones go first"))?
            }
            "retries" => self.retries = parsed(text).ok_or_else(|| wrong("a whole number, 0 or above"))?,
            "memory-limit" => {
                let bytes = text.and_then(|text| parse_bytes(&text).ok());
                self.memory_limit = Some(bytes.ok_or_else(|| wrong("bytes, such as 2G or 500M"))?);
            }
            "sweep" => {
                let Value::Table(axes) = value else {
                    return Err(wrong("a table of flags and lists of their values"));
                };
                axes.iter().try_for_each(|axis| self.take_axis(axis, place))?;
            }
            flag => {
                let kind = vocabulary.kind(flag).map_err(|reason| place.error(&reason))?;
                let values = setting(kind, value).ok_or_else(|| wrong(allowed(kind)))?;
                self.settings.set(flag, values);
            }
        }
        Ok(())
    }

    fn take_axis(&mut self, axis: &Entry, place: &Place) -> Result<(), BatchError> {
        let flag = normal(&axis.key);
        match axis.value.as_texts().filter(|values| !values.is_empty()) {
            Some(values) => self.add_axis(Axis { flag, values }),
            None => {
                return Err(
                    place.error(&format!("`sweep`: `{flag}` takes a list of its values, such as [0.5, 0.7]"))
                );
            }
        }
        Ok(())
    }

    /// In the place of a former one of the same flag.
    fn add_axis(&mut self, axis: Axis) {
        match self.axes.iter_mut().find(|former| former.flag == axis.flag) {
            Some(former) => *former = axis,
            None => self.axes.push(axis),
        }
    }

    fn apply(&mut self, options: &Options) {
        options.sweep.iter().for_each(|axis| self.add_axis(axis.clone()));
        let sweeps_budget = self.axes.iter().any(|axis| BUDGET.contains(&axis.flag.as_str()));
        if !self.settings.has_any(&BUDGET) && !sweeps_budget {
            options.budget.iter().for_each(|(flag, values)| self.settings.set(flag, Some(values.to_vec())));
        }
    }

    fn check(&self, vocabulary: &Vocabulary) -> Result<(), BatchError> {
        if self.scene.to_str().is_none() {
            return Err(self.place.error("a batch takes scenes whose names are UTF-8 alone"));
        }
        let axis = self.axes.iter().find(|axis| OWN.contains(&axis.flag.as_str()));
        axis.map_or(Ok(()), |axis| Err(self.place.error(&format!("`{}` cannot be swept", axis.flag))))?;
        let kinds = self.axes.iter().try_for_each(|axis| vocabulary.kind(&axis.flag).map(drop));
        kinds.map_err(|reason| self.place.error(&reason))
    }

    /// The job of one combination of the sweep.
    pub fn job(
        &self,
        name: String,
        product: &[(&str, &str)],
        vocabulary: &Vocabulary,
    ) -> Result<Job, BatchError> {
        let mut settings = self.settings.clone();
        for (flag, value) in product {
            let kind = vocabulary.kind(flag).map_err(|reason| self.place.error(&reason))?;
            let value = Value::Text((*value).to_owned());
            let values = setting(kind, &value)
                .ok_or_else(|| self.place.error(&format!("`{flag}`: allowed: {}", allowed(kind))))?;
            settings.set(flag, values);
        }
        let job = Job {
            name,
            scene: self.scene.clone(),
            settings,
            priority: self.priority,
            retries: self.retries,
            memory_limit: self.memory_limit,
        };
        (vocabulary.check)(&job.arguments()).map_err(|reason| self.place.error(&reason))?;
        Ok(job)
    }
}

fn parsed<T: std::str::FromStr>(text: Option<String>) -> Option<T> {
    text?.parse().ok()
}

fn allowed(kind: Kind) -> &'static str {
    match kind {
        Kind::Switch => "true or false",
        Kind::Value => "one value",
        Kind::Commas | Kind::Repeated => "a value or a list of values",
    }
}

/// `None` for what the flag does not take; a switch that is off is no setting.
fn setting(kind: Kind, value: &Value) -> Option<Option<Vec<String>>> {
    match kind {
        Kind::Switch => match value.as_text()?.as_str() {
            "true" => Some(Some(Vec::new())),
            "false" => Some(None),
            _ => None,
        },
        Kind::Value => Some(Some(vec![value.as_text()?])),
        Kind::Commas => Some(Some(vec![value.as_texts()?.join(",")])),
        Kind::Repeated => Some(Some(value.as_texts()?).filter(|values| !values.is_empty())),
    }
}
