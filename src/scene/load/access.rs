//! Which files a scene may be read from, how much it may ask for, and what its parameters are.

use std::cell::Cell;
use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::super::SceneError;
use super::files_read::FilesRead;
use super::mesh_memory::MeshMemory;
use super::source::file_error;
use crate::input;

/// Which files a scene may be read from, how much it may ask for, what its parameters are, and how strict its reader is.
#[derive(Clone, Debug)]
pub struct Access {
    files: Files,
    limits: Limits,
    definitions: BTreeMap<String, String>,
    lenient: bool,
    memory: Option<Arc<MeshMemory>>,
    record: Option<FilesRead>,
}

#[derive(Clone, Debug)]
enum Files {
    Any,
    InFolder,
    Given(BTreeMap<PathBuf, Vec<u8>>),
}

/// The most that a scene may ask for, beyond the bounds of the format itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Width and height of the picture in pixels.
    pub side: u64,
    /// Eye samples a pixel.
    pub samples: u64,
    /// Pixels times samples.
    pub eye_paths: u64,
    /// Photon passes.
    pub passes: u64,
    /// Photons a pass.
    pub photons: u64,
    /// Specular events on an eye path. Trees of glass double with each.
    pub depth: u64,
    /// Triangles of all meshes together.
    pub triangles: u64,
    /// Bytes of the scene file.
    pub scene_bytes: u64,
    /// Bytes of all files together; those of a file that is read twice count twice.
    pub bytes: u64,
}

impl Limits {
    /// The format's own bounds alone.
    pub const NONE: Limits = Limits {
        side: u64::MAX,
        samples: u64::MAX,
        eye_paths: u64::MAX,
        passes: u64::MAX,
        photons: u64::MAX,
        depth: u64::MAX,
        triangles: u64::MAX,
        scene_bytes: u64::MAX,
        bytes: u64::MAX,
    };

    /// What a scene of a stranger may ask for.
    pub const SANDBOX: Limits = Limits {
        side: 8192,
        samples: 256,
        eye_paths: 1 << 26,
        passes: 100_000,
        photons: 10_000_000,
        depth: 32,
        triangles: 20_000_000,
        scene_bytes: 16 << 20,
        bytes: 2 << 30,
    };

    /// Refuses a mesh with which there are so many triangles.
    pub(super) fn check_triangles(&self, n: u64) -> Result<(), String> {
        let most = self.triangles;
        if n <= most {
            return Ok(());
        }
        Err(format!("with it the meshes have {n} triangles; allowed in the sandbox: {most}"))
    }
}

impl Access {
    fn new(files: Files, limits: Limits) -> Access {
        Access { files, limits, definitions: BTreeMap::new(), lenient: false, memory: None, record: None }
    }

    /// Every file that the user may read, wherever a scene says; asking for as much as the format allows.
    pub fn any() -> Access {
        Access::new(Files::Any, Limits::NONE)
    }

    /// Regular files in the scene's folder and below it alone, by their real paths: `..`, absolute paths and links
    /// lead nowhere else. Asking for no more than [`Limits::SANDBOX`].
    pub fn sandbox() -> Access {
        Access::new(Files::InFolder, Limits::SANDBOX)
    }

    /// No file of the disk, but what is given here under the paths that scenes and meshes name.
    pub fn given(files: BTreeMap<PathBuf, Vec<u8>>) -> Access {
        Access::new(Files::Given(files), Limits::NONE)
    }

    /// The same files under other limits.
    #[must_use]
    pub fn limited(self, limits: Limits) -> Access {
        Access { limits, ..self }
    }

    /// The same with values for the parameters of a Mitsuba scene, which count before its own `<default>`s.
    #[must_use]
    pub fn defining(self, definitions: BTreeMap<String, String>) -> Access {
        Access { definitions, ..self }
    }

    /// The same, and whether a Mitsuba scene may hold what is not supported: then it is left out, with a warning that says
    /// what the picture will lack.
    #[must_use]
    pub fn lenient(self, lenient: bool) -> Access {
        Access { lenient, ..self }
    }

    /// The same with a memory of mesh files: those that the scene before read are not parsed again.
    #[must_use]
    pub fn remembering(self, memory: Arc<MeshMemory>) -> Access {
        Access { memory: Some(memory), ..self }
    }

    /// The same, noting there which files are looked for, and what is in them.
    #[must_use]
    pub fn recording(self, record: &FilesRead) -> Access {
        Access { record: Some(record.clone()), ..self }
    }
}

/// Why a file is not read.
#[derive(Debug)]
pub(super) enum Denial {
    /// It could be, but must not be.
    Forbidden(String),
    Unreadable(String),
}

impl Denial {
    pub fn reason(self) -> String {
        match self {
            Denial::Forbidden(reason) | Denial::Unreadable(reason) => reason,
        }
    }
}

/// What a byte of a scene or mesh file takes of memory while it is read, at most.
const MEMORY_COST: u64 = 16;

/// Reads the files of one scene.
pub(super) struct Reader<'a> {
    access: &'a Access,
    scene: &'a Path,
    /// The real path of the scene's folder, where files must lie in it.
    folder: Option<PathBuf>,
    bytes: Cell<u64>,
}

impl<'a> Reader<'a> {
    pub fn new(access: &'a Access, scene: &'a Path) -> Result<Reader<'a>, SceneError> {
        let folder = match access.files {
            Files::InFolder => Some(real_folder(scene)?),
            Files::Any | Files::Given(_) => None,
        };
        if let Some(memory) = &access.memory {
            memory.begin();
        }
        Ok(Reader { access, scene, folder, bytes: Cell::new(0) })
    }

    pub fn limits(&self) -> &Limits {
        &self.access.limits
    }

    pub fn definitions(&self) -> &BTreeMap<String, String> {
        &self.access.definitions
    }

    pub fn lenient(&self) -> bool {
        self.access.lenient
    }

    pub fn memory(&self) -> Option<&MeshMemory> {
        self.access.memory.as_deref()
    }

    /// The path that a scene file means by `name`.
    pub fn beside_scene(&self, name: &str) -> PathBuf {
        self.scene.parent().unwrap_or(Path::new("")).join(name)
    }

    pub fn is_file(&self, path: &Path) -> bool {
        let is_there = match &self.access.files {
            Files::Given(files) => files.contains_key(path),
            Files::Any | Files::InFolder => path.is_file(),
        };
        if !is_there {
            self.note(path, None);
        }
        is_there
    }

    fn note(&self, path: &Path, bytes: Option<&[u8]>) {
        if let Some(record) = &self.access.record {
            record.note(path, bytes);
        }
    }

    /// The bytes of a file; `kind` says what is expected there.
    pub fn read(&self, path: &Path, kind: &str) -> Result<Vec<u8>, Denial> {
        let bytes = self.read_unnoted(path, kind);
        self.note(path, bytes.as_deref().ok());
        bytes
    }

    fn read_unnoted(&self, path: &Path, kind: &str) -> Result<Vec<u8>, Denial> {
        let unreadable = |e: io::Error| match e.kind() {
            io::ErrorKind::IsADirectory => Denial::Unreadable(format!("is a folder; {kind} is expected")),
            _ => Denial::Unreadable(format!("cannot be read: {e}; {kind} is expected")),
        };
        let bytes = match &self.access.files {
            Files::Given(files) => files.get(path).cloned().ok_or_else(|| unreadable(missing()))?,
            Files::Any => input::read_file(path, MEMORY_COST).map_err(unreadable)?,
            Files::InFolder => {
                let real = fs::canonicalize(path).map_err(unreadable)?;
                self.check_place(&real)?;
                let (_, length) = input::open_file(&real).map_err(unreadable)?;
                self.check_bytes(length)?;
                input::read_file(&real, MEMORY_COST).map_err(unreadable)?
            }
        };
        self.check_bytes(bytes.len() as u64)?;
        self.bytes.set(self.bytes.get() + bytes.len() as u64);
        Ok(bytes)
    }

    fn check_place(&self, real: &Path) -> Result<(), Denial> {
        match &self.folder {
            Some(folder) if !real.starts_with(folder) => Err(Denial::Forbidden(format!(
                "lies outside the scene's folder; allowed in the sandbox: files in {} and below",
                folder.display()
            ))),
            _ => Ok(()),
        }
    }

    fn check_bytes(&self, length: u64) -> Result<(), Denial> {
        let (before, most) = (self.bytes.get(), self.limits().bytes);
        if before.saturating_add(length) <= most {
            return Ok(());
        }
        Err(Denial::Forbidden(format!(
            "holds {}, the files before it {}; allowed in the sandbox: {} together",
            input::size(length),
            input::size(before),
            input::size(most)
        )))
    }
}

fn missing() -> io::Error {
    io::ErrorKind::NotFound.into()
}

fn real_folder(scene: &Path) -> Result<PathBuf, SceneError> {
    let folder = match scene.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    fs::canonicalize(folder).map_err(|e| file_error(scene, format!("cannot be read: {e}")))
}
