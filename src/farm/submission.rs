use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::{FarmError, script};
use crate::output::write_bytes;
use crate::shard::PassRange;

/// The name of the file that says what a folder is for.
const FILE: &str = "submission.json";

/// What is to be made, by which commands. All paths are absolute.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Submission {
    /// The version of the program that wrote it.
    pub version: String,
    /// The program that tasks run.
    pub program: PathBuf,
    /// What the tasks share out.
    pub work: Work,
}

/// What tasks share out.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Work {
    /// The passes of one picture.
    Picture(Picture),
    /// The jobs of a batch.
    Jobs(Jobs),
}

/// One picture that is made of shards.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Picture {
    /// The scene.
    pub scene: PathBuf,
    /// Flags of `caustica render` beside those that shards need.
    pub flags: Vec<String>,
    /// Passes of the picture.
    pub passes: u32,
    /// Passes of a shard, one at least; the last shard may have fewer.
    pub shard_passes: u32,
    /// The picture.
    pub output: PathBuf,
}

/// Jobs of a batch, each of which has a folder and a ledger of its own.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Jobs {
    /// Job lists, scenes and patterns.
    pub lists: Vec<PathBuf>,
    /// Flags of `caustica batch`.
    pub flags: Vec<String>,
    /// The names of the jobs in their order.
    pub names: Vec<String>,
    /// Threads of each.
    pub threads: u32,
}

/// The work of one machine at a time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Task {
    /// Counted from 0: the index in the array.
    pub number: u32,
    /// What it makes.
    pub product: Product,
    /// The program and its arguments.
    pub command: Vec<String>,
}

/// What a task makes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Product {
    /// Some passes of a picture.
    Shard {
        /// Where.
        path: PathBuf,
        /// Which.
        passes: PassRange,
    },
    /// The picture of a job, in a folder with a ledger.
    Job {
        /// The folder.
        folder: PathBuf,
    },
}

impl Submission {
    /// The work in `folder`, by task.
    ///
    /// # Errors
    /// When a path is no text.
    pub fn tasks(&self, folder: &Path) -> Result<Vec<Task>, FarmError> {
        match &self.work {
            Work::Picture(picture) => (0..picture.passes.div_ceil(picture.shard_passes))
                .map(|number| self.shard(picture, number, folder))
                .collect(),
            Work::Jobs(jobs) => {
                (0..).zip(&jobs.names).map(|(number, name)| self.job(jobs, number, name, folder)).collect()
            }
        }
    }

    fn shard(&self, picture: &Picture, number: u32, folder: &Path) -> Result<Task, FarmError> {
        let first = number * picture.shard_passes;
        let passes = PassRange { first, end: first.saturating_add(picture.shard_passes).min(picture.passes) };
        let path = shards(folder).join(format!("{number:06}.shard"));
        let mut command = vec![text(&self.program)?, "render".into(), text(&picture.scene)?];
        command.extend(picture.flags.iter().cloned());
        command.extend(["--passes".into(), passes.to_string(), "--partial".into()]);
        command.extend(["-o".into(), text(&path)?]);
        Ok(Task { number, product: Product::Shard { path, passes }, command })
    }

    fn job(&self, jobs: &Jobs, number: u32, name: &str, folder: &Path) -> Result<Task, FarmError> {
        let folder = folder.join("jobs").join(name);
        let mut command = vec![text(&self.program)?, "batch".into()];
        command.extend(jobs.lists.iter().map(|list| text(list)).collect::<Result<Vec<_>, _>>()?);
        command.extend(jobs.flags.iter().cloned());
        command.extend([format!("--only={name}"), "-o".into(), text(&folder)?]);
        command.extend(["--jobs=1".into(), format!("--threads={}", jobs.threads)]);
        Ok(Task { number, product: Product::Job { folder }, command })
    }

    /// The command that makes the picture of all shards; none where there are no shards.
    ///
    /// # Errors
    /// When a path is no text.
    pub fn merge(&self, folder: &Path) -> Result<Option<Vec<String>>, FarmError> {
        let Work::Picture(picture) = &self.work else { return Ok(None) };
        let all = PassRange { first: 0, end: picture.passes };
        let mut command = vec![text(&self.program)?, "merge".into(), text(&shards(folder))?];
        command.extend(["-o".into(), text(&picture.output)?, "--passes".into(), all.to_string()]);
        command.extend(["--shard-passes".into(), picture.shard_passes.to_string()]);
        Ok(Some(command))
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
        let merge = self.merge(folder)?.map(|command| script::merge(&command)).transpose()?;
        let files = [
            ("tasks.txt", Some(script::lines(tasks.iter().map(|task| &task.command))?)),
            ("array.sh", Some(script::array(&text(&folder.join("tasks.txt"))?)?)),
            ("merge.sh", merge),
            ("logs/README.txt", Some(String::from("What the tasks and the merge print.\n"))),
            (FILE, Some(format!("{:#}\n", serde_json::json!(self)))),
        ];
        for (name, content) in files {
            let Some(content) = content else { continue };
            write_bytes(&folder.join(name), content)?;
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
        match &submission.work {
            Work::Picture(picture) if picture.shard_passes == 0 => Err(foreign("shards of no pass".into())),
            Work::Picture(_) | Work::Jobs(_) => Ok(submission),
        }
    }

    /// What differs first, but for the program, which may move.
    fn difference(&self, other: &Submission) -> Option<&'static str> {
        let of_work = match (&self.work, &other.work) {
            (Work::Picture(ours), Work::Picture(theirs)) => ours.difference(theirs),
            (Work::Jobs(ours), Work::Jobs(theirs)) => ours.difference(theirs),
            (Work::Picture(_), Work::Jobs(_)) | (Work::Jobs(_), Work::Picture(_)) => Some("kind of work"),
        };
        if self.version == other.version { of_work } else { Some("version of the program") }
    }
}

impl Picture {
    fn difference(&self, other: &Picture) -> Option<&'static str> {
        first_difference(&[
            ("scene", self.scene == other.scene),
            ("flags for render", self.flags == other.flags),
            ("number of passes", self.passes == other.passes),
            ("number of passes a shard", self.shard_passes == other.shard_passes),
            ("picture", self.output == other.output),
        ])
    }
}

impl Jobs {
    /// Threads may change: no picture depends on them.
    fn difference(&self, other: &Jobs) -> Option<&'static str> {
        first_difference(&[
            ("lists", self.lists == other.lists),
            ("flags for batch", self.flags == other.flags),
            ("jobs", self.names == other.names),
        ])
    }
}

fn first_difference(parts: &[(&'static str, bool)]) -> Option<&'static str> {
    parts.iter().find(|(_, is_same)| !is_same).map(|&(what, _)| what)
}

/// Where the shards of a folder are.
fn shards(folder: &Path) -> PathBuf {
    folder.join("shards")
}

fn text(path: &Path) -> Result<String, FarmError> {
    let text = path.to_str().filter(|text| !text.contains(['\n', '\r', '\0']));
    text.map(str::to_owned).ok_or_else(|| FarmError::Path { path: path.into() })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(passes: u32, shard_passes: u32) -> Picture {
        Picture {
            scene: "/data/a b's.toml".into(),
            flags: vec!["--size".into(), "8x8".into()],
            passes,
            shard_passes,
            output: "/out/a.exr".into(),
        }
    }

    fn submission(work: Work) -> Submission {
        Submission { version: "1.2.3".into(), program: "/bin/caustica".into(), work }
    }

    fn of_picture(passes: u32, shard_passes: u32) -> Submission {
        submission(Work::Picture(picture(passes, shard_passes)))
    }

    fn jobs() -> Jobs {
        Jobs {
            lists: vec!["/data/jobs.toml".into()],
            flags: vec!["--passes=4".into()],
            names: vec!["a".into(), "b".into()],
            threads: 8,
        }
    }

    #[test]
    fn tasks_are_all_passes_once() {
        for (passes, each, ranges) in
            [(7, 3, &["0..3", "3..6", "6..7"][..]), (6, 3, &["0..3", "3..6"]), (1, 9, &["0..1"])]
        {
            let tasks = of_picture(passes, each).tasks(Path::new("/farm")).unwrap();
            let range = |task: &Task| match &task.product {
                Product::Shard { passes, .. } => passes.to_string(),
                Product::Job { .. } => "a job".into(),
            };
            assert_eq!(tasks.iter().map(range).collect::<Vec<_>>(), ranges);
            assert!(tasks.iter().zip(0..).all(|(task, number)| task.number == number));
        }
        let task = of_picture(7, 3).tasks(Path::new("/farm")).unwrap().remove(2);
        let expected = "/bin/caustica render /data/a b's.toml --size 8x8 --passes 6..7 --partial -o /farm/shards/000002.shard";
        assert_eq!(task.command.join(" "), expected);
    }

    #[test]
    fn a_job_is_a_batch_of_its_own() {
        let submission = submission(Work::Jobs(jobs()));
        let tasks = submission.tasks(Path::new("/farm")).unwrap();
        let expected =
            "/bin/caustica batch /data/jobs.toml --passes=4 --only=b -o /farm/jobs/b --jobs=1 --threads=8";
        assert_eq!((tasks.len(), tasks[1].command.join(" ")), (2, expected.into()));
        assert_eq!(submission.merge(Path::new("/farm")).unwrap(), None);
    }

    #[test]
    fn a_folder_goes_on_with_the_same_work_alone() {
        let folder = tempfile::tempdir().unwrap();
        let first = of_picture(7, 3);
        first.write(folder.path()).unwrap();
        assert_eq!(Submission::read(folder.path()).unwrap(), first);
        Submission { program: "/opt/caustica".into(), ..first.clone() }.write(folder.path()).unwrap();
        let tasks = fs::read_to_string(folder.path().join("tasks.txt")).unwrap();
        assert!(tasks.starts_with("/opt/caustica render \"/data/a b's.toml\" --size 8x8"), "{tasks}");
        let others = [
            Picture { scene: "/b".into(), ..picture(7, 3) },
            Picture { flags: vec![], ..picture(7, 3) },
            picture(8, 3),
            picture(7, 4),
            Picture { output: "/b.exr".into(), ..picture(7, 3) },
        ];
        let others = others.map(|picture| submission(Work::Picture(picture)));
        let version = Submission { version: "2".into(), ..first };
        for other in others.into_iter().chain([version, submission(Work::Jobs(jobs()))]) {
            let error = other.write(folder.path()).unwrap_err();
            assert!(matches!(error, FarmError::OtherSubmission { .. }), "{error}");
        }
    }

    #[test]
    fn other_jobs_are_another_submission_and_other_threads_are_not() {
        let difference = |other: Jobs| jobs().difference(&other);
        assert_eq!(difference(Jobs { threads: 1, ..jobs() }), None);
        assert_eq!(difference(Jobs { lists: vec![], ..jobs() }), Some("lists"));
        assert_eq!(difference(Jobs { flags: vec![], ..jobs() }), Some("flags for batch"));
        assert_eq!(difference(Jobs { names: vec![], ..jobs() }), Some("jobs"));
    }

    #[test]
    fn folders_of_others_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let error = Submission::read(folder.path()).unwrap_err().to_string();
        assert!(error.contains("submission.json") && error.contains("caustica submit"), "{error}");
        fs::write(folder.path().join(FILE), "{\"version\": 3}").unwrap();
        let error = Submission::read(folder.path()).unwrap_err().to_string();
        assert!(error.contains("submission.json: ") && error.contains("name a folder"), "{error}");
        fs::write(folder.path().join(FILE), serde_json::json!(of_picture(7, 0)).to_string()).unwrap();
        let error = Submission::read(folder.path()).unwrap_err().to_string();
        assert!(error.contains("shards of no pass"), "{error}");
    }

    #[test]
    fn names_that_would_break_a_script_are_refused() {
        let broken = Picture { scene: "/a\nrm -rf b".into(), ..picture(1, 1) };
        let tasks = submission(Work::Picture(broken)).tasks(Path::new("/farm"));
        assert!(matches!(tasks.unwrap_err(), FarmError::Path { .. }));
    }
}
