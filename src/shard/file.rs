//! The bytes of a shard, and its place on disk.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::Path;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{Identity, Passes, Shard, ShardError, Work};
use crate::checkpoint::Facts;
use crate::input::read_file;
use crate::output::{Metadata, OutputError, write_atomically};
use crate::sealed::{FormatError, Kind};

/// The layout is to be raised whenever what stands in [`Content`] changes, or how sums are packed.
const KIND: Kind = Kind { mark: *b"caustica shard \n", layout: 1, name: "shard" };

/// Everything but sums as it is; sums are [packed](super::exact::Exact::pack).
#[derive(Serialize, Deserialize)]
pub(super) struct Content<'a> {
    pub facts: Cow<'a, Facts>,
    pub header: Cow<'a, Metadata>,
    pub passes: Cow<'a, Passes>,
    pub work: Work,
    pub size: (usize, usize),
    pub not_finite: Cow<'a, BTreeMap<u32, u32>>,
    #[serde(borrow)]
    pub blocks: Vec<Bytes<'a>>,
}

/// Bytes as they are, in one piece.
#[derive(Clone, Copy)]
pub(super) struct Bytes<'a>(pub &'a [u8]);

impl Serialize for Bytes<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bytes(self.0)
    }
}

impl<'de: 'a, 'a> Deserialize<'de> for Bytes<'a> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        <&[u8]>::deserialize(deserializer).map(Bytes)
    }
}

impl Shard {
    /// Writes it, as [`Merge`](super::Merge) reads it.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let Shard { identity: Identity { facts, header }, passes, work, sums } = self;
        let blocks = sums.pack();
        let content = Content {
            facts: Cow::Borrowed(facts),
            header: Cow::Borrowed(header),
            passes: Cow::Borrowed(passes),
            work: *work,
            size: sums.size(),
            not_finite: Cow::Borrowed(sums.not_finite()),
            blocks: blocks.iter().map(|block| Bytes(block)).collect(),
        };
        KIND.write(&content, out)
    }

    /// Puts it into the place of a file, whole.
    ///
    /// # Errors
    /// If it cannot be written; what was there before stays then.
    pub fn save(&self, path: &Path) -> Result<(), OutputError> {
        write_atomically(path, |mut out| self.write(&mut out))
    }
}

pub(super) fn parse(bytes: &[u8]) -> Result<Content<'_>, FormatError> {
    KIND.parse(bytes)
}

/// The bytes, and what is made of them beside the sums.
const MEMORY_A_BYTE: u64 = 2;

/// The bytes of a file.
pub(super) fn read(path: &Path) -> Result<Vec<u8>, ShardError> {
    read_file(path, MEMORY_A_BYTE).map_err(|source| ShardError::Read { path: path.into(), source })
}

/// Which passes the shard in a file has.
///
/// # Errors
/// If it cannot be read or is not whole.
pub fn passes_of(path: &Path) -> Result<Passes, ShardError> {
    let bytes = read(path)?;
    let content = parse(&bytes).map_err(|reason| ShardError::Unusable { path: path.into(), reason })?;
    Ok(content.passes.into_owned())
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A file of any content.
    pub fn bytes_of(content: &Content) -> Vec<u8> {
        let mut bytes = Vec::new();
        KIND.write(content, &mut bytes).unwrap();
        bytes
    }
}
