//! What is to be rendered: job lists in TOML and JSON lines, scenes, patterns of scenes.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value as Json;
use toml::de::DeTable;

use super::draft::{Draft, Place};
use super::sweep::{products, suffix};
use super::value::{Entry, Value, entries_of_toml};
use super::{BatchError, Job, Options, Vocabulary};

/// All jobs that the arguments name, in order, with the names of their pictures.
///
/// An argument is a job list (`.jsonl`, or `.toml` with `[[job]]`), a scene, or a pattern of scenes such as `scenes/*.toml`.
///
/// # Errors
/// When a list cannot be read, a key or a value is not allowed, a pattern fits nothing, or two jobs have one name. Scenes are not
/// looked into: that a job is broken is found when its turn comes.
pub fn jobs(given: &[String], options: &Options, vocabulary: &Vocabulary) -> Result<Vec<Job>, BatchError> {
    let mut drafts = Vec::new();
    for given in given {
        drafts.extend(of_argument(given, options, vocabulary)?);
    }
    let named = with_names(&drafts);
    let mut jobs: Vec<(Job, &Place)> = Vec::new();
    for (draft, name) in drafts.iter().zip(&named) {
        for product in products(&draft.axes) {
            let job = draft.job(format!("{name}{}", suffix(&draft.axes, &product)), &product, vocabulary)?;
            jobs.push((job, &draft.place));
        }
    }
    check_names(&jobs)?;
    Ok(jobs.into_iter().map(|(job, _)| job).collect())
}

fn of_argument(given: &str, options: &Options, vocabulary: &Vocabulary) -> Result<Vec<Draft>, BatchError> {
    let path = Path::new(given);
    let ends_with =
        |ends: &[&str]| path.extension().is_some_and(|end| ends.iter().any(|e| end.eq_ignore_ascii_case(e)));
    if ends_with(&["jsonl", "ndjson"]) {
        return of_json_lines(path, &read(path)?, options, vocabulary);
    }
    if ends_with(&["toml"]) && path.is_file() {
        let text = read(path)?;
        if is_list(&text) {
            return of_toml(path, &text, options, vocabulary);
        }
    }
    let place = Place::argument(given);
    scenes(Path::new(""), given, &place)?
        .into_iter()
        .map(|scene| Draft::of_scene(scene, &place, options, vocabulary))
        .collect()
}

fn read(path: &Path) -> Result<String, BatchError> {
    fs::read_to_string(path).map_err(|source| BatchError::File { path: path.to_owned(), source })
}

/// A scene has no jobs. What cannot be parsed is a list if it looks like one.
fn is_list(text: &str) -> bool {
    match DeTable::parse(text) {
        Ok(table) => table.get_ref().contains_key("job"),
        Err(_) => text.lines().any(|line| line.trim().starts_with("[[job]]")),
    }
}

/// The scenes that a path or pattern names, in the order of their names.
fn scenes(folder: &Path, given: &str, place: &Place) -> Result<Vec<PathBuf>, BatchError> {
    let path = folder.join(given);
    let is_pattern = given.contains(['*', '?', '[']) && !path.exists();
    if !is_pattern {
        // A list may name scenes that come later; what is typed is there, or misspelt.
        let is_missing = place.line.is_none() && !path.exists();
        return if is_missing { Err(place.error("there is no such file")) } else { Ok(vec![path]) };
    }
    let pattern = path.to_str().ok_or_else(|| place.error("a pattern is UTF-8"))?;
    let found = glob::glob(pattern).map_err(|error| place.error(&format!("is no pattern: {error}")))?;
    let scenes: Vec<PathBuf> = found.filter_map(Result::ok).filter(|path| path.is_file()).collect();
    if scenes.is_empty() { Err(place.error(&format!("no file fits `{given}`"))) } else { Ok(scenes) }
}

fn of_toml(
    path: &Path,
    text: &str,
    options: &Options,
    vocabulary: &Vocabulary,
) -> Result<Vec<Draft>, BatchError> {
    let line = |byte: usize| text.bytes().take(byte).filter(|&b| b == b'\n').count() + 1;
    let wrong = |line: usize, reason: &str| Place::line(path, line).error(reason);
    let table = DeTable::parse(text)
        .map_err(|error| wrong(error.span().map_or(1, |span| line(span.start)), error.message()))?;
    let (mut defaults, mut jobs) = (Vec::new(), Vec::new());
    for Entry { key, line, value } in entries_of_toml(table.get_ref(), &line) {
        match (key.as_str(), value) {
            ("defaults", Value::Table(entries)) => defaults = entries,
            ("job", Value::List(items)) => jobs = items,
            ("defaults" | "job", _) => {
                return Err(wrong(line, "`job` is an array of tables, [[job]], and `defaults` a table"));
            }
            _ => return Err(wrong(line, &format!("unknown key `{key}`; allowed: [defaults] and [[job]]"))),
        }
    }
    let drafts = jobs.into_iter().map(|job| match job {
        Value::Table(entries) => of_entries(path, entries, &defaults, options, vocabulary),
        _ => Err(wrong(1, "`job` is an array of tables, [[job]]")),
    });
    Ok(drafts.collect::<Result<Vec<_>, _>>()?.concat())
}

fn of_json_lines(
    path: &Path,
    text: &str,
    options: &Options,
    vocabulary: &Vocabulary,
) -> Result<Vec<Draft>, BatchError> {
    let (mut defaults, mut drafts) = (Vec::new(), Vec::new());
    for (text, line) in text.lines().zip(1..).filter(|(text, _)| !text.trim().is_empty()) {
        let wrong = |reason: &str| Place::line(path, line).error(reason);
        let json: Json = serde_json::from_str(text).map_err(|error| {
            wrong(&format!("is no JSON: {error}; allowed: a job as an object in each line"))
        })?;
        let Value::Table(mut entries) = Value::of_json(&json, line) else {
            return Err(wrong("is no object; allowed: {\"scene\": .., ..} or {\"defaults\": {..}}"));
        };
        match entries.as_mut_slice() {
            [Entry { key, value: Value::Table(table), .. }] if key == "defaults" => {
                defaults = std::mem::take(table)
            }
            _ => drafts.extend(of_entries(path, entries, &defaults, options, vocabulary)?),
        }
    }
    Ok(drafts)
}

/// A job of a list: one draft for each scene that it names.
fn of_entries(
    path: &Path,
    entries: Vec<Entry>,
    defaults: &[Entry],
    options: &Options,
    vocabulary: &Vocabulary,
) -> Result<Vec<Draft>, BatchError> {
    let place = Place::line(path, entries.first().map_or(1, |entry| entry.line));
    let is_scene = |entry: &&Entry| entry.key == "scene";
    let scene = entries.iter().find(is_scene).or_else(|| defaults.iter().find(is_scene));
    let scene = match scene.map(|entry| &entry.value) {
        Some(Value::Text(scene)) => scene,
        Some(_) => return Err(place.error("`scene` is the name of a file in quotes")),
        None => {
            return Err(place.error("`scene` is missing; allowed: the name of a scene file, or a pattern"));
        }
    };
    let folder = path.parent().unwrap_or(Path::new(""));
    let scenes = scenes(folder, scene, &place)?;
    let draft =
        |scene| Draft::of_entries(scene, path, &place, [defaults, entries.as_slice()], options, vocabulary);
    scenes.into_iter().map(draft).collect()
}

/// The name that is given; or that of the scene file; where other scenes have that too, behind the name of its folder.
fn with_names(drafts: &[Draft]) -> Vec<String> {
    let mut of_stem: BTreeMap<String, Vec<&Path>> = BTreeMap::new();
    for draft in drafts.iter().filter(|draft| draft.name.is_none()) {
        let scenes = of_stem.entry(stem(&draft.scene)).or_default();
        if !scenes.contains(&draft.scene.as_path()) {
            scenes.push(&draft.scene);
        }
    }
    let name = |draft: &Draft| {
        let stem = stem(&draft.scene);
        let is_shared = of_stem.get(&stem).is_some_and(|scenes| scenes.len() > 1);
        let folder = draft.scene.parent().and_then(Path::file_name).filter(|_| is_shared);
        folder.map_or(stem.clone(), |folder| format!("{}_{stem}", folder.to_string_lossy()))
    };
    drafts.iter().map(|draft| draft.name.clone().unwrap_or_else(|| name(draft))).collect()
}

fn stem(scene: &Path) -> String {
    scene.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

fn check_names(jobs: &[(Job, &Place)]) -> Result<(), BatchError> {
    let mut places: BTreeMap<&str, &Place> = BTreeMap::new();
    for (job, place) in jobs {
        let name = job.name.as_str();
        if name.is_empty() || name.starts_with('.') || name.len() > 200 || name.contains(['/', '\\', '\0']) {
            return Err(place.error(&format!("`{name}` is no name for a picture; allowed: up to 200 bytes without slashes, not beginning with a dot")));
        }
        if let Some(other) = places.insert(name, place) {
            return Err(place.error(&format!(
                "its picture would be {name}.exr, as that of {other}; give each job a `name`"
            )));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::{Axis, Kind, Settings};
    use super::*;
    use tempfile::TempDir;

    /// Passes are a number, and a job must not have `alpha=9`.
    fn vocabulary() -> Vocabulary<'static> {
        let flags = [
            ("alpha", Kind::Value),
            ("passes", Kind::Value),
            ("photons", Kind::Value),
            ("time", Kind::Value),
            ("target-error", Kind::Value),
            ("layers", Kind::Switch),
            ("transport", Kind::Commas),
            ("define", Kind::Repeated),
        ];
        Vocabulary {
            flags: flags.map(|(flag, kind)| (flag.to_owned(), kind)).into(),
            barred: &[("threads", "the batch shares them out")],
            check: &|arguments| match arguments.iter().find(|argument| *argument == "--alpha=9") {
                Some(_) => Err("invalid value '9' for '--alpha <A>'".into()),
                None => Ok(()),
            },
        }
    }

    fn folder(files: &[(&str, &str)]) -> TempDir {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in files {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        folder
    }

    fn read(folder: &TempDir, given: &[&str], options: &Options) -> Result<Vec<Job>, String> {
        let given: Vec<String> =
            given.iter().map(|name| folder.path().join(name).to_str().unwrap().to_owned()).collect();
        let place = format!("{}/", folder.path().display());
        jobs(&given, options, &vocabulary()).map_err(|error| error.to_string().replace(&place, ""))
    }

    fn of_list(name: &str, text: &str) -> Result<Vec<Job>, String> {
        read(&folder(&[(name, text)]), &[name], &Options::default())
    }

    /// Name and settings of every job.
    fn told(jobs: &[Job]) -> Vec<String> {
        jobs.iter()
            .map(|job| format!("{} {}", job.name, job.settings.arguments().join(" ")).trim().to_owned())
            .collect()
    }

    const LIST: &str = r#"
[defaults]
passes = 4
retries = 2
memory_limit = "1G"

[[job]]
scene = "a.toml"

[[job]]
scene = "sub/b.xml"
name = "second"
priority = 5
passes = 8
layers = true
transport = ["direct", "caustic"]
define = ["x=1", "y=2"]
retries = 0

[[job]]
scene = "a.toml"
name = "swept"
sweep = { alpha = [0.5, 0.7], photons = [1e5, 1_000] }
"#;

    #[test]
    fn lists_in_toml_and_json_say_the_same() {
        let jobs = of_list("list.toml", LIST).unwrap();
        let expected = [
            "a --passes=4",
            "second --define=x=1 --define=y=2 --layers --passes=8 --transport=direct,caustic",
            "swept_alpha=0.5_photons=1e5 --alpha=0.5 --passes=4 --photons=1e5",
            "swept_alpha=0.5_photons=1000 --alpha=0.5 --passes=4 --photons=1000",
            "swept_alpha=0.7_photons=1e5 --alpha=0.7 --passes=4 --photons=1e5",
            "swept_alpha=0.7_photons=1000 --alpha=0.7 --passes=4 --photons=1000",
        ];
        assert_eq!(told(&jobs), expected);
        assert_eq!((jobs[0].priority, jobs[0].retries, jobs[0].memory_limit), (0, 2, Some(1 << 30)));
        assert_eq!((jobs[1].priority, jobs[1].retries), (5, 0));
        assert!(jobs[1].scene.ends_with("sub/b.xml"));
        let lines = [
            r#"{"defaults": {"passes": 4, "retries": 2, "memory_limit": "1G"}}"#,
            r#"{"scene": "a.toml"}"#,
            "",
            r#"{"scene": "sub/b.xml", "name": "second", "priority": 5, "passes": 8, "layers": true, "transport": "direct,caustic", "define": ["x=1", "y=2"], "retries": 0}"#,
            r#"{"scene": "a.toml", "name": "swept", "sweep": {"alpha": [0.5, 0.7], "photons": ["1e5", 1000]}}"#,
        ];
        assert_eq!(told(&of_list("list.jsonl", &lines.join("\n")).unwrap()), expected);
    }

    #[test]
    fn mistakes_are_told_with_line_key_and_what_is_allowed() {
        for (old, new, words) in [
            ("passes = 8", "passses = 8", "list.toml:14: unknown key `passses`; allowed: scene, name"),
            (
                "passes = 8",
                "threads = 8",
                "list.toml:14: `threads` is not for jobs: the batch shares them out",
            ),
            ("passes = 8", "alpha = 9", "list.toml:11: invalid value '9' for '--alpha <A>'"),
            ("passes = 8", "passes = [1, 2]", "list.toml:14: `passes`: allowed: one value"),
            ("layers = true", "layers = \"maybe\"", "list.toml:15: `layers`: allowed: true or false"),
            ("priority = 5", "priority = \"high\"", "list.toml:13: `priority`: allowed: a whole number"),
            ("\"1G\"", "\"lots\"", "list.toml:5: `memory-limit`: allowed: bytes, such as 2G"),
            ("\"swept\"", "\"a/b\"", "list.toml:21: `a/b_alpha=0.5_photons=1e5` is no name"),
            (
                "name = \"second\"",
                "name = \"a\"",
                "list.toml:11: its picture would be a.exr, as that of list.toml:8",
            ),
            ("scene = \"sub/b.xml\"", "", "`scene` is missing"),
            ("alpha = [0.5, 0.7]", "name = [1, 2]", "list.toml:21: `name` cannot be swept"),
            ("alpha = [0.5, 0.7]", "alpha = []", "list.toml:23: `sweep`: `alpha` takes a list"),
            (
                "[defaults]",
                "[default]",
                "list.toml:2: unknown key `default`; allowed: [defaults] and [[job]]",
            ),
            ("priority = 5", "priority = ", "list.toml:13: "),
        ] {
            assert_eq!(LIST.matches(old).count(), 1, "{old}");
            let error = of_list("list.toml", &LIST.replace(old, new)).unwrap_err();
            assert!(error.contains(words), "{new}: {error}");
        }
        let error = of_list("list.jsonl", "{\"scene\": \"a\"}\n{\"scene\": 7x}").unwrap_err();
        assert!(error.starts_with("list.jsonl:2: is no JSON: "), "{error}");
        let error = of_list("list.jsonl", "[1]").unwrap_err();
        assert!(error.starts_with("list.jsonl:1: is no object; allowed: "), "{error}");
    }

    #[test]
    fn scenes_and_patterns_are_jobs_by_their_names() {
        let scene = "[camera]\n";
        let folder =
            folder(&[("x/s.toml", scene), ("y/s.toml", scene), ("z.toml", scene), ("[w].toml", scene)]);
        let names = |given: &[&str]| Ok::<_, String>(told(&read(&folder, given, &Options::default())?));
        assert_eq!(names(&["z.toml", "x/s.toml"]).unwrap(), ["z", "s"]);
        assert_eq!(names(&["*/s.toml"]).unwrap(), ["x_s", "y_s"]);
        assert_eq!(names(&["[w].toml"]).unwrap(), ["[w]"], "a file before a pattern");
        assert_eq!(names(&["none.toml"]).unwrap_err(), "none.toml: there is no such file");
        assert!(names(&["*.none"]).unwrap_err().contains("no file fits"), "{:?}", names(&["*.none"]));
        assert!(names(&["z.toml", "z.toml"]).unwrap_err().contains("its picture would be z.exr"));
    }

    #[test]
    fn what_is_given_for_all_goes_before_sweeps_and_behind_budgets() {
        let mut budget = Settings::default();
        budget.set("passes", Some(vec!["64".into()]));
        let sweep = vec![Axis::parse("alpha=.3").unwrap()];
        let options = Options { sweep, budget, retries: 1, memory_limit: None };
        let list = "[[job]]\nscene = \"a\"\n[[job]]\nscene = \"b\"\ntime = 5\nsweep.alpha = [1, 2]\n";
        let folder = folder(&[("list.toml", list)]);
        let jobs = read(&folder, &["list.toml"], &options).unwrap();
        assert_eq!(told(&jobs), ["a --alpha=.3 --passes=64", "b --alpha=.3 --time=5"]);
        assert_eq!(jobs[0].retries, 1);
    }
}
