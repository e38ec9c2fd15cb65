//! One picture, or many, spread over machines by the scheduler that the user has.
//!
//! ```text
//! Submission ──write──> FOLDER/submission.json    what is to be made, by which commands
//!                       FOLDER/tasks.txt          a command a line: any engine can run it
//!                       FOLDER/array.sh, merge.sh what Slurm runs
//! FOLDER/shards or jobs ──Progress──> which tasks are whole, begun, missing ──slurm──> an array of those, and a merge behind it
//! ```
//!
//! Tasks share nothing but the folder. Each may be given twice: what is whole is not made again.

mod array_list;
mod error;
mod progress;
mod script;
pub mod slurm;
mod submission;

pub use array_list::array_list;
pub use error::FarmError;
pub use progress::{Progress, TaskState};
pub use submission::{Jobs, Picture, Product, Submission, Work};
