use super::OutputError;
use super::part::{make_part, remove_leftovers};
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Writes a file so that its path holds either all of the new content or what it held before, never a part.
///
/// The content goes into a file of a passing name in the same folder (made, with its parents, if need be), is
/// flushed to the disk and then renamed. A symbolic link stays a link: the file it points to is replaced. On failure
/// the passing file is removed.
///
/// # Errors
/// When `path` cannot be an output file, as for [`check_writable`], or when `write` or the disk fails.
///
/// ```
/// use caustica::output::write_atomically;
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("new/hello.txt");
/// write_atomically(&path, |out| out.write_all(b"hello"))?;
/// assert_eq!(std::fs::read(&path)?, b"hello");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), OutputError> {
    replace_atomically(path, None, write)
}

/// [`write_atomically`] for content that is all there.
///
/// # Errors
/// Those of [`write_atomically`].
pub fn write_bytes(path: &Path, bytes: impl AsRef<[u8]>) -> Result<(), OutputError> {
    write_atomically(path, |out| out.write_all(bytes.as_ref()))
}

/// [`write_atomically`] that first gives what `path` held the name `aside`, in the same folder.
///
/// At any moment, whatever ends the process, one of the two names has whole content.
///
/// # Errors
/// Those of [`write_atomically`].
pub fn replace_atomically(
    path: &Path,
    aside: Option<&Path>,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), OutputError> {
    let target = Target::of(path)?;
    let temporary = target.make_temporary()?;
    fill(&temporary, write)
        .and_then(|()| aside.map_or(Ok(()), |aside| put_aside(&target.file, aside)))
        .and_then(|()| Ok(temporary.persist(&target.file)?))
        .map_err(|source| OutputError::Write { path: path.to_path_buf(), source })?;
    target.flush_folder()
}

/// A file that somebody removed meanwhile leaves nothing to keep.
fn put_aside(file: &Path, aside: &Path) -> io::Result<()> {
    fs::rename(file, aside).or_else(|error| match error.kind() {
        io::ErrorKind::NotFound => Ok(()),
        _ => Err(error),
    })
}

/// Tells before a long render whether [`write_atomically`] would find a place for `path`.
///
/// Makes missing folders, and for a moment a file of a passing name; the file itself is neither made nor touched. Files of
/// passing names that killed processes left in the folder are removed.
///
/// # Errors
/// When `path` has no file name, is a folder, a device or a pipe, or when its folder cannot be made or written to.
pub fn check_writable(path: &Path) -> Result<(), OutputError> {
    let target = Target::of(path)?;
    target.make_temporary()?;
    remove_leftovers(&target.folder);
    Ok(())
}

fn fill(file: &NamedTempFile, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let mut buffered = BufWriter::new(file.as_file());
    write(&mut buffered)?;
    buffered.flush()?;
    file.as_file().sync_all()
}

/// Where a file goes: `given` by the user, `file` and `folder` behind any symbolic link.
struct Target<'a> {
    given: &'a Path,
    file: PathBuf,
    folder: PathBuf,
}

impl<'a> Target<'a> {
    fn of(given: &'a Path) -> Result<Target<'a>, OutputError> {
        let path = given.to_path_buf();
        let names_folder = given.as_os_str().as_encoded_bytes().ends_with(b"/");
        let existing = fs::metadata(given).ok();
        if names_folder || existing.as_ref().is_some_and(|existing| existing.is_dir()) {
            return Err(OutputError::IsFolder { path });
        }
        if existing.as_ref().is_some_and(|existing| !existing.is_file()) {
            return Err(OutputError::NotAFile { path });
        }
        if given.file_name().is_none() {
            return Err(OutputError::NoFileName { path });
        }
        let file = if existing.is_some() { fs::canonicalize(given).unwrap_or(path) } else { path };
        let folder = file.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        Ok(Target { given, folder: folder.to_path_buf(), file })
    }

    /// Has the rename reach the disk.
    fn flush_folder(self) -> Result<(), OutputError> {
        let (path, folder) = (self.given.to_path_buf(), self.folder);
        File::open(&folder).and_then(|open| open.sync_all()).map_err(|source| OutputError::Flush {
            path,
            folder,
            source,
        })
    }

    /// An empty file beside the target that removes itself.
    fn make_temporary(&self) -> Result<NamedTempFile, OutputError> {
        let (path, folder) = (self.given.to_path_buf(), self.folder.clone());
        if let Err(source) = fs::create_dir_all(&self.folder) {
            return Err(OutputError::MakeFolder { path, folder, source });
        }
        // The error itself names the passing file, which means nothing to the user.
        make_part(&self.folder).map_err(|error| OutputError::FolderNotWritable {
            path,
            folder,
            source: error.kind().into(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::Permissions;
    use std::os::unix::fs::PermissionsExt;
    use tempfile::TempDir;

    fn names_in(folder: &TempDir) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(folder.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn makes_folders_and_replaces_what_was_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a/b/c.txt");
        for content in ["first, and longer", "second"] {
            write_bytes(&path, content.as_bytes()).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), content);
        }
        assert_eq!(fs::read_dir(folder.path().join("a/b")).unwrap().count(), 1);
    }

    #[test]
    fn a_failed_write_leaves_the_former_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.exr");
        write_bytes(&path, b"former").unwrap();
        let error = write_atomically(&path, |out| {
            out.write_all(&[7; 100_000])?;
            Err(io::ErrorKind::StorageFull.into())
        })
        .unwrap_err();
        assert!(matches!(error, OutputError::Write { .. }));
        let text = error.to_string();
        assert!(text.contains(path.to_str().unwrap()) && text.contains("no storage space"), "{text}");
        assert_eq!(fs::read(&path).unwrap(), b"former");
        assert_eq!(names_in(&folder), ["picture.exr"]);
    }

    #[test]
    fn what_was_there_is_put_aside_only_when_the_new_is_whole() {
        let folder = tempfile::tempdir().unwrap();
        let (path, aside) = (folder.path().join("file"), folder.path().join("aside"));
        let replace = |bytes: &[u8]| replace_atomically(&path, Some(&aside), |out| out.write_all(bytes));
        replace(b"first").unwrap();
        assert!(!aside.exists());
        replace(b"second").unwrap();
        assert_eq!(
            (fs::read(&path).unwrap(), fs::read(&aside).unwrap()),
            (b"second".to_vec(), b"first".to_vec())
        );
        let full = replace_atomically(&path, Some(&aside), |_| Err(io::ErrorKind::StorageFull.into()));
        assert!(full.is_err());
        assert_eq!(
            (fs::read(&path).unwrap(), fs::read(&aside).unwrap()),
            (b"second".to_vec(), b"first".to_vec())
        );
        assert_eq!(names_in(&folder), ["aside", "file"]);
    }

    #[test]
    fn new_files_have_the_permissions_of_any_new_file() {
        let folder = tempfile::tempdir().unwrap();
        let (ours, plain) = (folder.path().join("ours"), folder.path().join("plain"));
        write_bytes(&ours, b"").unwrap();
        File::create(&plain).unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&ours), mode(&plain));
    }

    #[test]
    fn a_link_stays_a_link() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        fs::write(&file, "former").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        write_bytes(&link, b"new").unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&file).unwrap(), b"new");
    }

    #[test]
    fn checking_neither_makes_nor_touches_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let (old, new) = (folder.path().join("old"), folder.path().join("new"));
        fs::write(&old, "former").unwrap();
        check_writable(&old).unwrap();
        check_writable(&new).unwrap();
        assert_eq!(fs::read(&old).unwrap(), b"former");
        assert_eq!(names_in(&folder), ["old"]);
    }

    #[test]
    fn folders_devices_and_nameless_paths_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let slashed = folder.path().join("new/");
        for path in [folder.path(), &slashed] {
            assert!(matches!(check_writable(path), Err(OutputError::IsFolder { .. })), "{path:?}");
            assert!(matches!(write_bytes(path, b""), Err(OutputError::IsFolder { .. })), "{path:?}");
        }
        assert!(matches!(check_writable(Path::new("/dev/null")), Err(OutputError::NotAFile { .. })));
        assert!(matches!(check_writable(Path::new("")), Err(OutputError::NoFileName { .. })));
        assert!(!slashed.exists());
    }

    #[test]
    fn a_file_cannot_serve_as_a_folder() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, "").unwrap();
        let error = check_writable(&file.join("deeper/picture.exr")).unwrap_err();
        assert!(matches!(error, OutputError::MakeFolder { .. }));
        let text = error.to_string();
        assert!(text.contains("deeper/picture.exr: cannot make its folder"), "{text}");
    }

    #[test]
    fn a_folder_that_takes_no_file_is_named() {
        let proc = Path::new("/proc");
        if !proc.is_dir() {
            eprintln!("skipped: there is no /proc, the one folder where even root can make no file");
            return;
        }
        let error = check_writable(&proc.join("picture.exr")).unwrap_err();
        assert!(matches!(error, OutputError::FolderNotWritable { .. }));
        let text = error.to_string();
        assert!(
            text.contains("cannot make a file in the folder /proc: entity not found; name a file"),
            "{text}"
        );
    }

    #[test]
    fn a_read_only_folder_keeps_its_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        fs::write(&path, "former").unwrap();
        fs::set_permissions(folder.path(), Permissions::from_mode(0o555)).unwrap();
        if File::create(folder.path().join("probe")).is_ok() {
            eprintln!("skipped: this user may write to read-only folders");
            return;
        }
        assert!(matches!(check_writable(&path), Err(OutputError::FolderNotWritable { .. })));
        assert!(matches!(write_bytes(&path, b"new"), Err(OutputError::FolderNotWritable { .. })));
        assert_eq!(fs::read(&path).unwrap(), b"former");
        fs::set_permissions(folder.path(), Permissions::from_mode(0o755)).unwrap();
    }
}
