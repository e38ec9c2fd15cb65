use std::path::PathBuf;

/// A scene as the contents of files.
#[derive(Clone, Debug, PartialEq)]
pub struct SavedScene {
    /// The scene file.
    pub text: String,
    /// The mesh files, with their paths relative to the scene file.
    pub meshes: Vec<(PathBuf, Vec<u8>)>,
    /// The picture files, in the same way.
    pub pictures: Vec<(PathBuf, Vec<u8>)>,
    /// What the files lack of the scene.
    pub warnings: Vec<String>,
}

/// Why a scene has no file of that kind.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SaveError {
    /// The name says of what kind the file is to be.
    #[error("{}: unknown kind of scene file; allowed: names that end in .toml or .xml", path.display())]
    UnknownKind {
        /// The file.
        path: PathBuf,
    },
    /// The format has no word for a part of the scene.
    #[error("{what} cannot be written as Mitsuba's XML; allowed: {allowed}")]
    NoCounterpart {
        /// The part and what it is.
        what: String,
        /// What can be written, and the way around.
        allowed: String,
    },
    /// A picture is no longer what was loaded.
    #[error("{}: the picture cannot be copied: {reason}; allowed: the file that the scene was read with", path.display())]
    Picture {
        /// Its file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
}
