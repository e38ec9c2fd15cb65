use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::{FarmError, script};
use crate::output::write_atomically;
use crate::shard::PassRange;

/// The name of the file that says what a folder is for.
const FILE: &str = "submission.json";

/// One picture that is made of shards: what is to be made, by which commands. All paths are absolute.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Submission {
    /// The version of the program that wrote it.
    pub version: String,
    /// The program that tasks run.
    pub program: PathBuf,
    /// The scene.
    pub scene: PathBuf,
    /// Flags of `caustica render` beside those that shards need.
    pub flags: Vec<String>,
    /// Passes of the picture.
    pub passes: u32,
    /// Passes of a shard; the last may have fewer.
    pub shard_passes: u32,
    /// The picture.
    pub output: PathBuf,
}

/// The work of one machine at a time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Task {
    /// Counted from 0: the index in the array.
    pub number: u32,
    /// Its passes.
    pub passes: PassRange,
    /// Its shard.
    pub shard: PathBuf,
    /// The program and its arguments.
    pub command: Vec<String>,
}

impl Submission {
    /// The work in `folder`, by task.
    ///
    /// # Errors
    /// When a path is no text.
    pub fn tasks(&self, folder: &Path) -> Result<Vec<Task>, FarmError> {
        (0..self.passes.div_ceil(self.shard_passes)).map(|number| self.task(number, folder)).collect()
    }

    fn task(&self, number: u32, folder: &Path) -> Result<Task, FarmError> {
        let first = number * self.shard_passes;
        let passes = PassRange { first, end: first.saturating_add(self.shard_passes).min(self.passes) };
        let shard = shards(folder).join(format!("{number:06}.shard"));
        let mut command = vec![text(&self.program)?, "render".into(), text(&self.scene)?];
        command.extend(self.flags.iter().cloned());
        command.extend(["--passes".into(), passes.to_string(), "--partial".into()]);
        command.extend(["-o".into(), text(&shard)?]);
        Ok(Task { number, passes, shard, command })
    }

    /// The command that makes the picture of all shards.
    ///
    /// # Errors
    /// When a path is no text.
    pub fn merge(&self, folder: &Path) -> Result<Vec<String>, FarmError> {
        let all = PassRange { first: 0, end: self.passes };
        let mut command = vec![text(&self.program)?, "merge".into(), text(&shards(folder))?];
        command.extend(["-o".into(), text(&self.output)?, "--passes".into(), all.to_string()]);
        command.extend(["--shard-passes".into(), self.shard_passes.to_string()]);
        Ok(command)
    }

    /// Writes the folder, or finds it written before by an equal submission.
    ///
    /// # Errors
    /// When the folder is that of another submission, or cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), FarmError> {
        if folder.join(FILE).exists() {
            let before = Submission::read(folder)?;
            if let Some(what) = self.difference(&before) {
                return Err(FarmError::OtherSubmission { path: folder.into(), what });
            }
        }
        let tasks = self.tasks(folder)?;
        let array = script::array(&text(&folder.join("tasks.txt"))?)?;
        for (name, content) in [
            ("tasks.txt", script::lines(tasks.iter().map(|task| &task.command))?),
            ("array.sh", array),
            ("merge.sh", script::merge(&self.merge(folder)?)?),
            ("logs/README.txt", String::from("What the tasks and the merge print.\n")),
            (FILE, format!("{:#}\n", serde_json::json!(self))),
        ] {
            write_atomically(&folder.join(name), |out| out.write_all(content.as_bytes()))?;
        }
        Ok(())
    }

    /// What [`Submission::write`] wrote.
    ///
    /// # Errors
    /// When there is no such file, or it holds something else.
    pub fn read(folder: &Path) -> Result<Submission, FarmError> {
        let path = folder.join(FILE);
        let text = fs::read_to_string(&path)
            .map_err(|source| FarmError::Unreadable { path: path.clone(), source })?;
        let read: Result<Submission, _> = serde_json::from_str(&text);
        let foreign = |reason: String| FarmError::Foreign { path: path.clone(), reason };
        let submission = read.map_err(|error| foreign(error.to_string()))?;
        if submission.shard_passes == 0 {
            return Err(foreign("shards of no pass".into()));
        }
        Ok(submission)
    }

    /// What differs first, but for the program, which may move.
    fn difference(&self, other: &Submission) -> Option<&'static str> {
        let parts = [
            ("version of the program", self.version == other.version),
            ("scene", self.scene == other.scene),
            ("flags for render", self.flags == other.flags),
            ("number of passes", self.passes == other.passes),
            ("number of passes a shard", self.shard_passes == other.shard_passes),
            ("picture", self.output == other.output),
        ];
        parts.iter().find(|(_, is_same)| !is_same).map(|&(what, _)| what)
    }
}

/// Where the shards of a folder are.
pub(super) fn shards(folder: &Path) -> PathBuf {
    folder.join("shards")
}

fn text(path: &Path) -> Result<String, FarmError> {
    let text = path.to_str().filter(|text| !text.contains(['\n', '\r', '\0']));
    text.map(str::to_owned).ok_or_else(|| FarmError::Path { path: path.into() })
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub fn submission(passes: u32, shard_passes: u32) -> Submission {
        Submission {
            version: "1.2.3".into(),
            program: "/bin/caustica".into(),
            scene: "/data/a b's.toml".into(),
            flags: vec!["--size".into(), "8x8".into()],
            passes,
            shard_passes,
            output: "/out/a.exr".into(),
        }
    }

    #[test]
    fn tasks_are_all_passes_once() {
        for (passes, each, ranges) in
            [(7, 3, &["0..3", "3..6", "6..7"][..]), (6, 3, &["0..3", "3..6"]), (1, 9, &["0..1"])]
        {
            let tasks = submission(passes, each).tasks(Path::new("/farm")).unwrap();
            let found: Vec<String> = tasks.iter().map(|task| task.passes.to_string()).collect();
            assert_eq!(found, ranges);
            assert!(tasks.iter().zip(0..).all(|(task, number)| task.number == number));
        }
        let task = submission(7, 3).tasks(Path::new("/farm")).unwrap().remove(2);
        let expected = "/bin/caustica render '/data/a b's.toml' --size 8x8 --passes 6..7 --partial -o /farm/shards/000002.shard";
        assert_eq!(task.command.join(" "), expected.replace("'/data", "/data").replace("toml'", "toml"));
    }

    #[test]
    fn a_folder_goes_on_with_the_same_work_alone() {
        let folder = tempfile::tempdir().unwrap();
        let first = submission(7, 3);
        first.write(folder.path()).unwrap();
        assert_eq!(Submission::read(folder.path()).unwrap(), first);
        Submission { program: "/opt/caustica".into(), ..first.clone() }.write(folder.path()).unwrap();
        let tasks = fs::read_to_string(folder.path().join("tasks.txt")).unwrap();
        assert!(tasks.starts_with("/opt/caustica render \"/data/a b's.toml\" --size 8x8"), "{tasks}");
        let others = [
            Submission { version: "2".into(), ..first.clone() },
            Submission { scene: "/b".into(), ..first.clone() },
            Submission { flags: vec![], ..first.clone() },
            Submission { passes: 8, ..first.clone() },
            Submission { shard_passes: 4, ..first.clone() },
            Submission { output: "/b.exr".into(), ..first.clone() },
        ];
        for other in others {
            let error = other.write(folder.path()).unwrap_err();
            assert!(matches!(error, FarmError::OtherSubmission { .. }), "{error}");
        }
    }

    #[test]
    fn folders_of_others_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let error = Submission::read(folder.path()).unwrap_err().to_string();
        assert!(error.contains("submission.json") && error.contains("caustica submit"), "{error}");
        fs::write(folder.path().join(FILE), "{\"version\": 3}").unwrap();
        let error = Submission::read(folder.path()).unwrap_err().to_string();
        assert!(error.contains("submission.json: ") && error.contains("name a folder"), "{error}");
    }

    #[test]
    fn names_that_would_break_a_script_are_refused() {
        let broken = Submission { scene: "/a\nrm -rf b".into(), ..submission(1, 1) };
        assert!(matches!(broken.tasks(Path::new("/farm")).unwrap_err(), FarmError::Path { .. }));
    }
}
