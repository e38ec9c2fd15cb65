use std::path::{Path, PathBuf};

use super::file::{Content, parse, read};
use super::{Identity, Passes, Shard, ShardError, Sums};
use crate::input::check_memory;
use crate::output::MAX_PIXELS;
use crate::sealed::FormatError;

/// Bytes of a pixel that was always black.
const LEAST_PACKED: usize = 6;

/// Of the shard that is added, and of those before.
const NAMES: [&str; 2] = ["this one", "the other"];

/// Shards that become one, file by file: memory is that of one shard, however many there are.
#[derive(Debug, Default)]
pub struct Merge {
    merged: Option<Shard>,
    files: Vec<(PathBuf, Passes)>,
}

impl Merge {
    /// Adds the shard in a file.
    ///
    /// # Errors
    /// If it cannot be read or is not whole, is of another picture than those before, or holds passes of one of them. Nothing that was
    /// merged is of use then.
    pub fn add(&mut self, path: &Path) -> Result<(), ShardError> {
        self.add_bytes(path, &read(path)?)
    }

    /// Adds the shard in `bytes`, which errors call `path`.
    ///
    /// # Errors
    /// As [`Merge::add`].
    pub fn add_bytes(&mut self, path: &Path, bytes: &[u8]) -> Result<(), ShardError> {
        let unusable = |reason| ShardError::Unusable { path: path.into(), reason };
        let content = parse(bytes).map_err(unusable)?;
        let pixels = pixels(&content)
            .ok_or_else(|| unusable(FormatError::Content(format!("{:?} pixels", content.size))))?;
        self.check(path, &content)?;
        if self.merged.is_none() {
            check_memory((pixels * Sums::BYTES_A_PIXEL) as u64)
                .map_err(|source| ShardError::Read { path: path.into(), source })?;
        }
        let passes = content.passes.clone().into_owned();
        let merged = self.merged.get_or_insert_with(|| Shard::new(identity_of(&content), content.size));
        add(merged, content)
            .ok_or_else(|| unusable(FormatError::Content("sums that nobody wrote".into())))?;
        self.files.push((path.into(), passes));
        Ok(())
    }

    fn check(&self, path: &Path, content: &Content) -> Result<(), ShardError> {
        let Some(merged) = &self.merged else { return Ok(()) };
        let mut differences = identity_of(content).differences(&merged.identity, NAMES);
        if differences.is_empty() && content.size != merged.sums.size() {
            differences.push(format!(
                "size: this one has {:?}, the other {:?}",
                content.size,
                merged.sums.size()
            ));
        }
        if !differences.is_empty() {
            let other = self.files.first().map(|file| file.0.clone()).unwrap_or_default();
            return Err(ShardError::Different { path: path.into(), other, differences });
        }
        for (other, passes) in &self.files {
            let passes = passes.common(&content.passes);
            if passes.count() > 0 {
                return Err(ShardError::Overlap { path: path.into(), other: other.clone(), passes });
            }
        }
        Ok(())
    }

    /// Files that were added, with their passes, in order.
    pub fn files(&self) -> &[(PathBuf, Passes)] {
        &self.files
    }

    /// All passes in one; `None` without a file.
    pub fn finish(self) -> Option<Shard> {
        self.merged
    }
}

/// How many pixels there are; `None` where that is no picture, or more than the sums can be of.
fn pixels(Content { size: (width, height), blocks, .. }: &Content) -> Option<usize> {
    let packed: usize = blocks.iter().map(|block| block.0.len()).sum();
    let pixels = width.checked_mul(*height)?;
    (1..=MAX_PIXELS.min(packed / LEAST_PACKED)).contains(&pixels).then_some(pixels)
}

fn identity_of(content: &Content) -> Identity {
    Identity { facts: content.facts.clone().into_owned(), header: content.header.clone().into_owned() }
}

fn add(to: &mut Shard, content: Content) -> Option<()> {
    let blocks: Vec<&[u8]> = content.blocks.iter().map(|block| block.0).collect();
    to.sums.add_packed(&blocks, &content.not_finite)?;
    to.passes = to.passes.with(&content.passes);
    to.work = to.work.with(content.work);
    Some(())
}

#[cfg(test)]
mod tests {
    use super::super::sums::tests::picture;
    use super::*;
    use crate::math::{Rng, Stream};
    use crate::output::{Metadata, Value};
    use std::fs;
    use tempfile::TempDir;

    fn identity(scene: &str) -> Identity {
        let header = Metadata::new().with("caustica:scene", Value::Text(scene.into()));
        Identity { facts: postcard::from_bytes(b"\x01\x05alpha\x030.5").unwrap(), header }
    }

    /// Of a scene, with these passes.
    fn shard(scene: &str, passes: impl IntoIterator<Item = u32>) -> Shard {
        let mut shard = Shard::new(identity(scene), (256, 70));
        for pass in passes {
            shard.add(pass, &picture(pass));
            shard.work.photons += 100;
        }
        shard
    }

    fn put(folder: &TempDir, name: &str, shard: &Shard) -> PathBuf {
        let path = folder.path().join(name);
        shard.save(&path).unwrap();
        path
    }

    fn merged(files: &[PathBuf]) -> Result<Shard, ShardError> {
        let mut merge = Merge::default();
        files.iter().try_for_each(|path| merge.add(path))?;
        Ok(merge.finish().unwrap())
    }

    /// Files and all.
    #[test]
    fn any_split_in_any_order_is_the_whole() {
        let whole = shard("a", 0..12);
        let mut bytes = Vec::new();
        whole.write(&mut bytes).unwrap();
        let mut rng = Rng::new(1, Stream::Test, 0, 0);
        for parts in [1, 2, 5, 12] {
            let folder = tempfile::tempdir().unwrap();
            let part = |k: u32| shard("a", (0..12).filter(|pass| pass % parts == k));
            let mut files: Vec<PathBuf> =
                (0..parts).map(|k| put(&folder, &k.to_string(), &part(k))).collect();
            files.sort_by_key(|_| rng.next_u32());
            let merged = merged(&files).unwrap();
            let mut again = Vec::new();
            merged.write(&mut again).unwrap();
            assert!(merged == whole && again == bytes, "{parts} parts");
        }
    }

    #[test]
    fn what_does_not_fit_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let first = put(&folder, "first", &shard("a", 0..4));
        let told =
            |shard: &Shard| merged(&[first.clone(), put(&folder, "second", shard)]).unwrap_err().to_string();
        let overlap = told(&shard("a", [2, 3, 7]));
        assert!(
            overlap.contains("second: the passes 2..4 are in ") && overlap.contains("first, too"),
            "{overlap}"
        );
        let other = told(&shard("b", 4..5));
        assert!(other.contains("caustica:scene: this one has b, the other a"), "{other}");
        let mut facts = shard("a", 4..5);
        facts.identity.facts = postcard::from_bytes(b"\x01\x05alpha\x030.7").unwrap();
        assert!(told(&facts).contains("alpha: this one has 0.7, the other 0.5"), "{}", told(&facts));
        let small = Shard::new(identity("a"), (2, 3));
        assert!(told(&small).contains("size: this one has (2, 3), the other (256, 70)"), "{}", told(&small));
    }

    #[test]
    fn damage_is_found_wherever_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let path = put(&folder, "a", &shard("a", 0..2));
        let bytes = fs::read(&path).unwrap();
        for place in (0..bytes.len()).step_by(bytes.len() / 50) {
            let mut damaged = bytes.clone();
            damaged[place] ^= 4;
            fs::write(&path, &damaged).unwrap();
            let error = merged(std::slice::from_ref(&path)).unwrap_err().to_string();
            let reason = if place < 16 { "not a shard" } else { "damaged" };
            assert!(error.contains("a: ") && error.contains(reason), "{error}");
        }
        fs::write(&path, &bytes[..bytes.len() - 1]).unwrap();
        assert!(merged(std::slice::from_ref(&path)).unwrap_err().to_string().contains("damaged"));
    }

    /// Their hash is right, and still nothing is believed that the bytes do not hold.
    #[test]
    fn claims_of_more_pixels_than_bytes_take_no_memory() {
        let folder = tempfile::tempdir().unwrap();
        for size in [(1 << 14, 1 << 14), (usize::MAX, 2), (0, 7)] {
            let tiny = Shard::new(identity("a"), (2, 3));
            let blocks = tiny.sums.pack();
            let content = Content {
                facts: Default::default(),
                header: Default::default(),
                passes: Default::default(),
                work: tiny.work,
                size,
                not_finite: Default::default(),
                blocks: blocks.iter().map(|block| super::super::file::Bytes(block)).collect(),
            };
            let path = folder.path().join("huge");
            fs::write(&path, super::super::file::tests::bytes_of(&content)).unwrap();
            let error = merged(&[path]).unwrap_err().to_string();
            assert!(error.contains("follows no layout"), "{error}");
        }
    }
}
