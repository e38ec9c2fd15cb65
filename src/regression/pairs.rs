use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Files of one name below two folders.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pair {
    /// The path below its folder, with `/` between its parts.
    pub name: String,
    /// Where the file lies below the first folder, if it does.
    pub image: Option<PathBuf>,
    /// Where the file lies below the second folder, if it does.
    pub reference: Option<PathBuf>,
}

/// Why two folders cannot be matched.
#[derive(Debug, thiserror::Error)]
pub enum PairsError {
    /// A folder cannot be listed.
    #[error("cannot list the folder {path}: {source}; name two folders that hold EXR files", path = path.display())]
    Unlisted {
        /// The folder.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// Neither folder holds a picture.
    #[error("there is no EXR file in {image} and none in {reference}; name two folders that hold EXR files of the same names", image = image.display(), reference = reference.display())]
    Nothing {
        /// The first folder.
        image: PathBuf,
        /// The second folder.
        reference: PathBuf,
    },
    /// The name of a file is no text.
    #[error("the name of {path} is no UTF-8; rename it", path = path.display())]
    Name {
        /// The file.
        path: PathBuf,
    },
}

/// The EXR files below two folders, matched by their paths below these and ordered by name.
///
/// Links to folders are not followed, so that no folder holds itself.
///
/// # Errors
/// When a folder cannot be listed, when a name is no UTF-8, and when there is no EXR file in either.
pub fn pairs(image: &Path, reference: &Path) -> Result<Vec<Pair>, PairsError> {
    let (images, references) = (names(image)?, names(reference)?);
    if images.is_empty() && references.is_empty() {
        return Err(PairsError::Nothing { image: image.into(), reference: reference.into() });
    }
    let path =
        |names: &BTreeSet<String>, folder: &Path, name: &str| names.contains(name).then(|| folder.join(name));
    let pair = |name: &String| Pair {
        name: name.clone(),
        image: path(&images, image, name),
        reference: path(&references, reference, name),
    };
    Ok(images.union(&references).map(pair).collect())
}

fn names(folder: &Path) -> Result<BTreeSet<String>, PairsError> {
    let mut names = BTreeSet::new();
    collect(folder, "", &mut names)?;
    Ok(names)
}

/// Adds the names of the pictures in `folder`, whose own name below the root, with a `/` at its end, is `prefix`.
fn collect(folder: &Path, prefix: &str, names: &mut BTreeSet<String>) -> Result<(), PairsError> {
    let unlisted = |source| PairsError::Unlisted { path: folder.into(), source };
    for entry in fs::read_dir(folder).map_err(unlisted)? {
        let entry = entry.map_err(unlisted)?;
        let path = entry.path();
        let is_folder = entry.file_type().map_err(unlisted)?.is_dir();
        if !is_folder && !is_picture(&path) {
            continue;
        }
        let name = entry.file_name().into_string().map_err(|_| PairsError::Name { path: path.clone() })?;
        let name = format!("{prefix}{name}");
        if is_folder {
            collect(&path, &format!("{name}/"), names)?;
        } else {
            names.insert(name);
        }
    }
    Ok(())
}

fn is_picture(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("exr"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(names: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for name in names {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, "").unwrap();
        }
        folder
    }

    #[test]
    fn files_are_matched_by_their_paths_below_the_folders() {
        let a = folder(&["b.exr", "sub/c.EXR", "sub/deep/d.exr", "b.png", "notes.txt"]);
        let b = folder(&["b.exr", "sub/d.exr", "sub/c.EXR"]);
        let pairs = pairs(a.path(), b.path()).unwrap();
        let found: Vec<(&str, bool, bool)> =
            pairs.iter().map(|p| (&*p.name, p.image.is_some(), p.reference.is_some())).collect();
        let expected = [
            ("b.exr", true, true),
            ("sub/c.EXR", true, true),
            ("sub/d.exr", false, true),
            ("sub/deep/d.exr", true, false),
        ];
        assert_eq!(found, expected);
        assert_eq!(pairs[1].image.as_deref(), Some(a.path().join("sub/c.EXR").as_path()));
    }

    #[test]
    fn folders_without_pictures_and_files_are_refused() {
        let (a, b) = (folder(&["a.png"]), folder(&[]));
        let error = pairs(a.path(), b.path()).unwrap_err().to_string();
        assert!(error.starts_with("there is no EXR file in "), "{error}");
        let file = a.path().join("a.png");
        let error = pairs(&file, b.path()).unwrap_err().to_string();
        assert!(error.contains("a.png") && error.contains("name two folders"), "{error}");
    }
}
