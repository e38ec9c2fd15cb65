use std::path::PathBuf;

use clap::Args;

use super::AccessArgs;

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  caustica convert data/cornell_b.toml out/cornell_b.xml
  caustica convert room.xml room.toml -D res=256
  caustica convert room.xml room.toml --lenient

Meshes are written as PLY, and pictures copied, into folders beside the file, called as it with _meshes and
_pictures in place of the extension. No picture is overwritten by another one.
Everything that the program knows of the scene comes back as it was, number by number; comments, names of
files and how shapes were described do not. docs/formats.md tells what each format holds.

Exit codes: 0 converted; 1 a file could not be written; 2 wrong input or arguments, nothing was written.")]
pub struct ConvertArgs {
    /// The scene (TOML, or XML of Mitsuba 3)
    pub scene: PathBuf,
    /// The file to write: TOML or XML by its name, .toml or .xml
    pub output: PathBuf,
    #[command(flatten)]
    pub access: AccessArgs,
}
