//! The command line's arguments, one file a command.

mod batch;
mod bench;
mod compare;
mod completions;
mod convert;
mod doctor;
mod explain;
mod info;
mod man;
mod merge;
mod reference;
mod render;
mod run;
mod status;
mod study;
mod submit;
mod surface;
mod values;
mod worker;

use clap::{Parser, Subcommand};

pub use batch::{AtOnce, BatchArgs, BatchCommand, ReportArgs, RunBatchArgs, ShareArgs, StatusArgs};
pub use bench::BenchArgs;
pub use compare::CompareArgs;
pub use completions::CompletionsArgs;
pub use convert::ConvertArgs;
pub use doctor::DoctorArgs;
pub use explain::ExplainArgs;
pub use info::InfoArgs;
pub use man::ManArgs;
pub use merge::MergeArgs;
pub use reference::ReferenceArgs;
pub use render::RenderArgs;
pub use run::{AccessArgs, DisplayArgs, RunArgs, Traversal};
pub use status::FarmStatusArgs;
pub use study::StudyArgs;
pub use submit::SubmitArgs;
pub use surface::SurfaceArgs;
pub use values::PassesArg;
pub use worker::WorkerArgs;

/// Progressive photon mapping on Embree 4: caustics from small lights, in mirrors, through glass, under water.
#[derive(Debug, Parser)]
#[command(name = "caustica", version, max_term_width = 100, after_help = EXAMPLES)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Command,
}

const EXAMPLES: &str = "\
Examples:
  caustica surface data/surface.obj
  caustica render data/course_water.toml -o out/water.exr --passes 64
  caustica render data/cornell_b.toml --time 60 --json out/passes.jsonl
  caustica reference data/course_diffuse.toml --spp 256 -o out/reference.exr
  caustica compare out/course_diffuse.exr out/reference.exr --fail-above relmse=0.01
  caustica study data/course_water.toml --make-reference
  caustica batch data/*.toml --passes 64 -o out/batch
  caustica convert data/cornell_b.toml out/cornell_b.xml

Exit codes: 0 done; 1 a comparison exceeded its bound, the doctor found faults, jobs of a batch failed, passes are
missing, or a file could not be written; 2 wrong input or arguments, nothing was written; 130 interrupted, the picture so far
was written;
141 standard output was closed.";

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a scene by progressive photon mapping
    Render(RenderArgs),
    /// Render a scene by path or light tracing: the unbiased picture that photon mapping is checked against
    Reference(ReferenceArgs),
    /// Merge the shards of a picture, which `render --partial` wrote, into the picture
    Merge(MergeArgs),
    /// Compare two pictures in HDR
    Compare(CompareArgs),
    /// Say what a scene holds and how it would be rendered
    Info(InfoArgs),
    /// Examine a scene, or the program itself, and say what is odd and what a render will therefore do
    Doctor(DoctorArgs),
    /// Say which effects a scene calls for, because of which of its lines, and what they cost
    Explain(ExplainArgs),
    /// Write a scene in another format: TOML, or XML of Mitsuba 3
    Convert(ConvertArgs),
    /// Write the water surface of the course's scene as OBJ
    Surface(SurfaceArgs),
    /// Measure the photon pass against bare ray tracing, or trees of spheres or triangles against their rivals
    Bench(BenchArgs),
    /// Measure what accuracy costs: error against seconds, for settings and methods in turn
    Study(StudyArgs),
    /// Spread the passes of a picture over machines: write the work of each, and submit it to Slurm
    Submit(SubmitArgs),
    /// Say how far what was submitted is
    Status(FarmStatusArgs),
    /// Render many scenes: a process for each, and a ledger of what became of them
    Batch(BatchArgs),
    /// Render what is told on standard input; for `caustica batch` alone
    #[command(hide = true)]
    Worker(WorkerArgs),
    /// Print the completions of a shell
    Completions(CompletionsArgs),
    /// Write manual pages
    Man(ManArgs),
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn argument_table_is_consistent() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn the_help_of_every_command_has_examples() {
        let program = Arguments::command();
        for command in [&program].into_iter().chain(program.get_subcommands()) {
            let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
            let called = command.get_name();
            let start = match called {
                "caustica" => "Examples:\n  caustica ".to_owned(),
                _ => format!("Examples:\n  caustica {called}"),
            };
            assert!(help.starts_with(&start), "{called}: {help}");
        }
    }
}
