//! What a batch and the processes of its jobs tell each other: a line of JSON each, on the process's standard input and output.

use serde::{Deserialize, Serialize};

use super::{Done, FileHash};

/// What a process is told. When its standard input ends, the batch is gone, and so is the process.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Order {
    /// Load the scene of a job, and build what rays are traced through.
    Prepare {
        /// Those of `caustica render`, which is the first.
        arguments: Vec<String>,
    },
    /// Render what is prepared.
    Go,
    /// Finish the pass under way, and keep a checkpoint of it.
    Stop,
}

/// What a process answers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reply {
    /// The scene is there.
    Ready {
        /// What that took.
        seconds: f64,
        /// Photons of a pass.
        photons: u64,
        /// Passes that it will take, where they are known.
        passes: Option<u32>,
        /// The files of the scene.
        inputs: Vec<FileHash>,
    },
    /// Another pass is done. Some are told, not all.
    Pass {
        /// So many are.
        passes: u32,
    },
    /// The picture is written.
    Done(Done),
    /// The render was stopped, and has a checkpoint.
    Stopped,
    /// There is no picture, and will be none.
    Failed {
        /// Why.
        reason: String,
        /// Whether memory was short.
        memory: bool,
        /// The files that it was to be made of, as far as they were read.
        inputs: Vec<FileHash>,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_as_documented() {
        let line = |order: Order| serde_json::json!(order).to_string();
        assert_eq!(
            line(Order::Prepare { arguments: vec!["render".into()] }),
            r#"{"prepare":{"arguments":["render"]}}"#
        );
        assert_eq!((line(Order::Go), line(Order::Stop)), (r#""go""#.into(), r#""stop""#.into()));
        let reply: Reply = serde_json::from_str(r#"{"pass":{"passes":3}}"#).unwrap();
        assert_eq!(reply, Reply::Pass { passes: 3 });
    }
}
