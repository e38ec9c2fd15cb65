//! Many pictures in one go: a list of jobs, a process for each, and a ledger of what became of them.
//!
//! [`jobs`] reads lists and sweeps, [`Ledger`] remembers what is done, [`run`] has processes render the rest, each by the
//! [`Order`]s of this process, and [`page()`] shows it all.

mod bytes;
mod change;
mod draft;
mod error;
mod forecast;
mod hashes;
mod job;
mod job_list;
mod ledger;
mod lock;
mod options;
mod page;
mod process;
mod protocol;
mod runner;
mod schedule;
mod sweep;
mod task;
mod value;
mod vocabulary;
mod watch;

pub use bytes::parse_bytes;
pub use change::{Change, Done, FileHash, Verdict};
pub use error::BatchError;
pub use hashes::{Hashes, hash_file};
pub use job::{Job, Settings};
pub use job_list::jobs;
pub use ledger::{Attempt, LEDGER, Ledger, Row, State};
pub use lock::Lock;
pub use options::Options;
pub use page::page;
pub use protocol::{Order, Reply};
pub use runner::run;
pub use schedule::{Layout, Schedule};
pub use sweep::Axis;
pub use vocabulary::{Kind, Vocabulary};
pub use watch::{Crew, Standing, Watch};
