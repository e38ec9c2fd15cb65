//! Pictures beside a scene: copies of their files, each once.

use std::path::{Path, PathBuf};

use super::SaveError;
use crate::film::Image;
use crate::input;
use crate::output::{Metadata, encode_exr};
use crate::texture::{Encoding, PictureFile, Texture};

/// The pictures of a scene that is written.
pub(super) struct Pictures {
    folder: String,
    /// With their paths relative to the scene file.
    files: Vec<(PathBuf, Vec<u8>)>,
}

impl Pictures {
    pub fn new(folder: String) -> Pictures {
        Pictures { folder, files: Vec::new() }
    }

    pub fn into_files(self) -> Vec<(PathBuf, Vec<u8>)> {
        self.files
    }

    /// The name, in the scene file, of a copy of a picture file.
    pub fn copy(&mut self, path: &Path) -> Result<String, SaveError> {
        let unreadable =
            |e: std::io::Error| SaveError::Picture { path: path.to_owned(), reason: e.to_string() };
        let bytes = input::read_file(path, 1).map_err(unreadable)?;
        Ok(self.add(&path.file_name().unwrap_or_default().to_string_lossy(), bytes))
    }

    /// The name of a picture whose file readers take for `encoding`: a copy, or an EXR where they would take the copy for
    /// something else, or where there is no file.
    pub fn texture(&mut self, texture: &Texture, encoding: Encoding) -> Result<String, SaveError> {
        match &texture.file {
            Some(file) if file.encoding == encoding || is_exr(&file.path) => self.copy(&file.path),
            Some(PictureFile { path, .. }) => self.pixels(path, texture.image()),
            None => self.pixels(Path::new(&texture.name), texture.image()),
        }
    }

    fn pixels(&mut self, path: &Path, image: &Image) -> Result<String, SaveError> {
        let bytes = encode_exr(path, image, &Metadata::default());
        let bytes = bytes.map_err(|e| SaveError::Picture { path: path.to_owned(), reason: e.to_string() })?;
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        Ok(self.add(&format!("{stem}.exr"), bytes))
    }

    fn add(&mut self, name: &str, bytes: Vec<u8>) -> String {
        let name = PathBuf::from(plain(name));
        let extension = name.extension().map(|e| e.to_os_string()).unwrap_or_default();
        let equal = |(path, known): &&(PathBuf, Vec<u8>)| {
            *known == bytes && path.extension().unwrap_or_default() == extension
        };
        if let Some((path, _)) = self.files.iter().find(equal) {
            return path.to_string_lossy().into_owned();
        }
        let path = self.free(&name);
        let shown = path.to_string_lossy().into_owned();
        self.files.push((path, bytes));
        shown
    }

    /// The name in the folder, or the first of `name_2`, `name_3`, ... that no other picture has, on disks that tell small letters
    /// from large ones and on others.
    fn free(&self, name: &Path) -> PathBuf {
        let stem = name.file_stem().unwrap_or_default().to_string_lossy();
        let extension = name.extension().map(|e| format!(".{}", e.to_string_lossy())).unwrap_or_default();
        let numbered = (2u64..).map(|k| format!("{stem}_{k}{extension}"));
        let mut names = std::iter::once(name.to_string_lossy().into_owned()).chain(numbered);
        let taken = |path: &Path| {
            let same = |known: &Path| {
                known.to_string_lossy().to_lowercase() == path.to_string_lossy().to_lowercase()
            };
            self.files.iter().any(|(known, _)| same(known))
        };
        let paths = names.by_ref().map(|name| Path::new(&self.folder).join(name));
        paths.into_iter().find(|path| !taken(path)).unwrap_or_default()
    }
}

fn is_exr(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("exr"))
}

/// A name that every system takes for that of a file.
fn plain(name: &str) -> String {
    let odd = |c: char| c.is_control() || "/\\:*?\"<>|".contains(c);
    let plain: String = name.chars().map(|c| if odd(c) { '_' } else { c }).collect();
    if plain.starts_with('.') { format!("picture{plain}") } else { plain }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Rgb;

    fn named(path: &Path, encoding: Encoding) -> Texture {
        let image = Image::from_pixels(1, 1, vec![Rgb::splat(0.25)]).unwrap();
        Texture::new("t", image).unwrap().of_file(path.to_owned(), encoding)
    }

    #[test]
    fn equal_pictures_are_copied_once_and_others_get_names_of_their_own() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str, bytes: &[u8]| {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(&path, bytes).unwrap();
            path
        };
        let mut pictures = Pictures::new("s_pictures".into());
        for (path, expected) in [
            (file("a.png", b"1"), "s_pictures/a.png"),
            (file("b/A.png", b"2"), "s_pictures/A_2.png"),
            (file("b/c.png", b"1"), "s_pictures/a.png"),
            (file("c.jpg", b"1"), "s_pictures/c.jpg"),
        ] {
            assert_eq!(pictures.copy(&path).unwrap(), expected);
        }
        assert_eq!(pictures.into_files().len(), 3);
    }

    #[test]
    fn pixels_are_written_where_a_copy_would_be_taken_for_something_else() {
        let folder = tempfile::tempdir().unwrap();
        let (png, exr) = (folder.path().join("a.png"), folder.path().join("b.EXR"));
        [&png, &exr].iter().for_each(|path| std::fs::write(path, b"any").unwrap());
        let mut pictures = Pictures::new("p".into());
        let mut of = |path: &Path, read| pictures.texture(&named(path, read), Encoding::Colour).unwrap();
        assert_eq!(of(&png, Encoding::Colour), "p/a.png");
        assert_eq!(of(&exr, Encoding::Plain), "p/b.EXR");
        assert_eq!(of(&png, Encoding::Plain), "p/a.exr");
        let pixels = named(&png, Encoding::Colour).image().clone();
        let embedded = Texture::new("s.gltf: image: 0", pixels).unwrap();
        assert_eq!(
            pictures.texture(&embedded, Encoding::Colour).unwrap(),
            "p/a.exr",
            "equal pixels are written once"
        );
    }

    #[test]
    fn a_picture_that_is_gone_is_told() {
        let gone = Pictures::new("p".into()).copy(Path::new("no.png")).unwrap_err().to_string();
        assert!(
            gone.starts_with("no.png: the picture cannot be copied: ") && gone.contains("allowed"),
            "{gone}"
        );
    }
}
