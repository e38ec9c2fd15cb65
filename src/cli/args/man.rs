use std::path::PathBuf;

use clap::Args;

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  caustica man ~/.local/share/man/man1
  caustica man out/man && man -l out/man/caustica-render.1")]
pub struct ManArgs {
    /// The folder for the pages, one for the program and one for each of its commands; it is made if it is not there
    pub folder: PathBuf,
}
