//! Files that know whether they are whole: a mark, the number of the layout, the content (postcard), and the BLAKE3 hash of all before
//! it.

use std::io::{self, BufWriter, Write};

use serde::{Deserialize, Serialize};

/// What files of one kind begin with.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// The first bytes.
    pub mark: [u8; 16],
    /// The number behind them, which is another one wherever the content follows another layout.
    pub layout: u32,
    /// What people call such a file.
    pub name: &'static str,
}

/// What is wrong with the bytes of a file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FormatError {
    /// They do not begin as those of their kind do.
    #[error("not a {kind}")]
    Foreign {
        /// What they were to be.
        kind: &'static str,
    },
    /// They are not those that were written: cut off, or changed.
    #[error("damaged: its bytes are not those that were written")]
    Damaged,
    /// They are whole, but laid out in another way.
    #[error("its layout has number {found}, and this program reads number {supported} alone")]
    Version {
        /// The number that stands in the file.
        found: u32,
        /// The one that is read.
        supported: u32,
    },
    /// They are whole, but do not follow their layout: no version of this program wrote them.
    #[error("its content follows no layout ({0})")]
    Content(String),
}

/// Bytes before the content.
pub const HEADER: usize = 16 + size_of::<u32>();
/// Numbers come eight bytes at a time.
const BUFFER: usize = 1 << 16;

impl Kind {
    /// Writes a file of this kind, as [`Kind::parse`] reads it.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write(&self, content: &impl Serialize, out: &mut dyn Write) -> io::Result<()> {
        let mut hashed = Hashed { out, hasher: blake3::Hasher::new(), failure: None };
        let written = self.write_hashed(content, &mut hashed);
        let Hashed { out, hasher, failure } = hashed;
        match failure {
            Some(failure) => Err(failure),
            None => written.and_then(|()| out.write_all(hasher.finalize().as_bytes())),
        }
    }

    fn write_hashed(&self, content: &impl Serialize, out: &mut Hashed) -> io::Result<()> {
        let mut buffered = BufWriter::with_capacity(BUFFER, out);
        buffered.write_all(&self.mark)?;
        buffered.write_all(&self.layout.to_le_bytes())?;
        postcard::to_io(content, &mut buffered).map_err(io::Error::other)?;
        buffered.flush()
    }

    /// Reads a file of this kind. No length in it is believed beyond the bytes that are there.
    ///
    /// # Errors
    /// For any bytes that [`Kind::write`] did not write, or that another layout was written by.
    pub fn parse<'b, T: Deserialize<'b>>(&self, bytes: &'b [u8]) -> Result<T, FormatError> {
        if !bytes.starts_with(&self.mark) {
            return Err(FormatError::Foreign { kind: self.name });
        }
        let (hashed, hash) = bytes.split_last_chunk::<{ blake3::OUT_LEN }>().ok_or(FormatError::Damaged)?;
        let (header, content) = hashed.split_at_checked(HEADER).ok_or(FormatError::Damaged)?;
        if blake3::hash(hashed) != *hash {
            return Err(FormatError::Damaged);
        }
        let layout = header[self.mark.len()..].iter().rev().fold(0, |sum, &byte| sum << 8 | u32::from(byte));
        if layout != self.layout {
            return Err(FormatError::Version { found: layout, supported: self.layout });
        }
        match postcard::take_from_bytes(content) {
            Ok((content, [])) => Ok(content),
            Ok((_, rest)) => Err(FormatError::Content(format!("{} bytes too many", rest.len()))),
            Err(error) => Err(FormatError::Content(error.to_string())),
        }
    }
}

/// Hashes what it hands on, and remembers why it could not: the encoder would forget.
struct Hashed<'a> {
    out: &'a mut dyn Write,
    hasher: blake3::Hasher,
    failure: Option<io::Error>,
}

impl Write for Hashed<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.out.write(bytes).inspect_err(|error| {
            if error.kind() != io::ErrorKind::Interrupted {
                let code = error.raw_os_error().map(io::Error::from_raw_os_error);
                self.failure = Some(code.unwrap_or_else(|| error.kind().into()));
            }
        })?;
        self.hasher.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}
