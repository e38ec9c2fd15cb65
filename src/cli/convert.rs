use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::args::ConvertArgs;
use super::error::{CliError, Outcome};
use super::loading::load;
use crate::input;
use crate::output::{check_writable, write_bytes};
use crate::scene::save;

/// A path and what is to be there.
type SavedFile = (PathBuf, Vec<u8>);

/// Writes a scene in another format.
pub fn run(args: &ConvertArgs) -> Result<Outcome, CliError> {
    let desc = load(&args.scene, &args.access)?;
    let saved = save(&desc, &args.output, args.access.lenient)?;
    saved.warnings.iter().for_each(|warning| note!("warning: {warning}"));
    check_writable(&args.output).map_err(CliError::BadOutput)?;
    let folder = args.output.parent().unwrap_or(Path::new(""));
    let new_pictures = new_pictures(folder, saved.pictures)?;
    // The scene file comes last: where it is, its meshes and pictures are.
    for (file, bytes) in saved.meshes.iter().chain(&new_pictures) {
        write_bytes(&folder.join(file), bytes)?;
    }
    write_bytes(&args.output, &saved.text)?;
    let (meshes, pictures) = (saved.meshes.len(), new_pictures.len());
    note!("wrote {}, {meshes} mesh files and {pictures} pictures", args.output.display());
    Ok(Outcome::Done)
}

/// Those that are not there yet; a file of their name that is another one may be somebody's only copy.
fn new_pictures(folder: &Path, pictures: Vec<SavedFile>) -> Result<Vec<SavedFile>, CliError> {
    let mut new = Vec::new();
    for (file, bytes) in pictures {
        let path = folder.join(&file);
        match input::read_file(&path, 1) {
            Ok(there) if there == bytes => {}
            Err(error) if error.kind() == ErrorKind::NotFound => new.push((file, bytes)),
            _ => return Err(CliError::OtherPicture { path }),
        }
    }
    Ok(new)
}
