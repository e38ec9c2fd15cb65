use std::path::Path;

use super::args::ConvertArgs;
use super::error::{CliError, Outcome};
use super::load;
use crate::output::{check_writable, write_atomically};
use crate::scene::save;

/// Writes a scene in another format.
pub fn run(args: &ConvertArgs) -> Result<Outcome, CliError> {
    let desc = load(&args.scene, &args.access)?;
    let saved = save(&desc, &args.output, args.access.lenient)?;
    saved.warnings.iter().for_each(|warning| note!("warning: {warning}"));
    check_writable(&args.output).map_err(CliError::BadOutput)?;
    let folder = args.output.parent().unwrap_or(Path::new(""));
    // The scene file comes last: where it is, its meshes are.
    for (file, bytes) in &saved.meshes {
        write(&folder.join(file), bytes)?;
    }
    write(&args.output, saved.text.as_bytes())?;
    note!("wrote {} and {} mesh files", args.output.display(), saved.meshes.len());
    Ok(Outcome::Done)
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), CliError> {
    write_atomically(path, |out| out.write_all(bytes)).map_err(CliError::Write)
}
