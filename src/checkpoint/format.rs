//! The bytes of a checkpoint: a mark, the number of the layout, the content (postcard), and the BLAKE3 hash of all before it.

use std::io::{self, BufWriter, Write};

use super::{Checkpoint, FormatError};

const MARK: [u8; 16] = *b"caustica render\n";
/// To be raised whenever what stands in [`Checkpoint`] changes.
const LAYOUT: u32 = 5;
const HEADER: usize = MARK.len() + size_of::<u32>();
/// Numbers come eight bytes at a time.
const BUFFER: usize = 1 << 16;

/// Writes a checkpoint, as [`parse`] reads it.
///
/// # Errors
/// Those of `out`.
pub fn write(checkpoint: &Checkpoint, out: &mut dyn Write) -> io::Result<()> {
    let mut hashed = Hashed { out, hasher: blake3::Hasher::new(), failure: None };
    let written = write_hashed(checkpoint, &mut hashed);
    let Hashed { out, hasher, failure } = hashed;
    match failure {
        Some(failure) => Err(failure),
        None => written.and_then(|()| out.write_all(hasher.finalize().as_bytes())),
    }
}

fn write_hashed(checkpoint: &Checkpoint, out: &mut Hashed) -> io::Result<()> {
    let mut buffered = BufWriter::with_capacity(BUFFER, out);
    buffered.write_all(&MARK)?;
    buffered.write_all(&LAYOUT.to_le_bytes())?;
    postcard::to_io(checkpoint, &mut buffered).map_err(io::Error::other)?;
    buffered.flush()
}

/// Reads a checkpoint. Memory is a small multiple of the length of `bytes`, whatever they are.
///
/// # Errors
/// A [`FormatError`] for any bytes that [`write()`] did not write, or that a program with another layout wrote.
pub fn parse(bytes: &[u8]) -> Result<Checkpoint<'static>, FormatError> {
    if !bytes.starts_with(&MARK) {
        return Err(FormatError::NotACheckpoint);
    }
    let (hashed, hash) = bytes.split_last_chunk::<{ blake3::OUT_LEN }>().ok_or(FormatError::Damaged)?;
    let content = hashed.get(HEADER..).ok_or(FormatError::Damaged)?;
    if blake3::hash(hashed) != *hash {
        return Err(FormatError::Damaged);
    }
    let layout = hashed[MARK.len()..HEADER].iter().rev().fold(0, |sum, &byte| sum << 8 | u32::from(byte));
    if layout != LAYOUT {
        return Err(FormatError::Version { found: layout, supported: LAYOUT });
    }
    match postcard::take_from_bytes(content) {
        Ok((checkpoint, [])) => Ok(checkpoint),
        Ok((_, rest)) => Err(FormatError::Content(format!("{} bytes too many", rest.len()))),
        Err(error) => Err(FormatError::Content(error.to_string())),
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

#[cfg(test)]
pub(super) mod tests {
    use super::super::{ErrorHistory, Facts, RunState};
    use super::*;
    use crate::ppm::{ErrorEstimates, Forecast, RadiusPolicy, Render, Settings};
    use crate::scene::{self, Scene};
    use proptest::prelude::*;
    use std::path::Path;
    use std::sync::LazyLock;

    fn scene() -> Scene {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/cornell_b.toml");
        let mut desc = scene::load(&path).unwrap();
        (desc.film.width, desc.film.height) = (4, 3);
        Scene::new(desc).unwrap()
    }

    /// A small checkpoint after so many passes, as bytes.
    pub fn checkpoint_after(passes: u32) -> Vec<u8> {
        let scene = scene();
        let error_estimates = ErrorEstimates::Pixels;
        let settings =
            Settings { samples: 1, photons: 500, error_estimates, ..Settings::of_scene(scene.render()) };
        let mut render = Render::new(&scene, settings);
        for _ in 0..passes {
            render.pass();
        }
        let errors = ErrorHistory {
            target: Some(0.02),
            confidence: 0.9,
            forecast: Forecast::new(RadiusPolicy::HitPoint, 0.7),
            latest: render.accuracy(0.9).map(|accuracy| accuracy.picture()),
            next: passes + 1,
        };
        let run = RunState { seconds: 0.1, errors };
        let mut bytes = Vec::new();
        write(&Checkpoint { facts: Facts::default(), run, render: render.state() }, &mut bytes).unwrap();
        bytes
    }

    static BYTES: LazyLock<Vec<u8>> = LazyLock::new(|| checkpoint_after(3));

    /// Bytes with the right hash, for what lies behind it.
    fn signed(bytes: &[u8]) -> Vec<u8> {
        [bytes, blake3::hash(bytes).as_bytes()].concat()
    }

    #[test]
    fn what_is_written_is_read() {
        let read = parse(&BYTES).unwrap();
        assert_eq!((read.render.passes(), read.run.seconds), (3, 0.1));
        let mut again = Vec::new();
        write(&read, &mut again).unwrap();
        assert!(again == *BYTES);
    }

    #[test]
    fn any_flipped_bit_is_found() {
        for place in 0..BYTES.len() {
            let mut damaged = BYTES.clone();
            damaged[place] ^= 1 << (place % 8);
            let error = if place < MARK.len() { FormatError::NotACheckpoint } else { FormatError::Damaged };
            assert_eq!(parse(&damaged), Err(error), "byte {place}");
        }
    }

    #[test]
    fn any_lost_or_added_end_is_found() {
        for length in 0..BYTES.len() {
            let error = if length < MARK.len() { FormatError::NotACheckpoint } else { FormatError::Damaged };
            assert_eq!(parse(&BYTES[..length]), Err(error), "{length} bytes");
        }
        assert_eq!(parse(&[&BYTES[..], b"\0"].concat()), Err(FormatError::Damaged));
    }

    #[test]
    fn other_layouts_are_named() {
        let content = &BYTES[HEADER..BYTES.len() - blake3::OUT_LEN];
        let with_layout = |layout: u32| signed(&[&MARK, &layout.to_le_bytes()[..], content].concat());
        assert!(parse(&with_layout(LAYOUT)).is_ok());
        let error = parse(&with_layout(0x0102_0304)).unwrap_err();
        assert_eq!(error, FormatError::Version { found: 0x0102_0304, supported: LAYOUT });
        let longer = signed(&[&MARK, &LAYOUT.to_le_bytes()[..], content, b"xy"].concat());
        assert_eq!(parse(&longer), Err(FormatError::Content("2 bytes too many".into())));
    }

    proptest! {
        /// A hash keeps nobody from writing nonsense.
        #[test]
        fn nonsense_with_a_good_hash_is_an_error(place in HEADER..1000usize, bytes in prop::collection::vec(any::<u8>(), 1..40)) {
            let mut content = BYTES[..BYTES.len() - blake3::OUT_LEN].to_vec();
            let place = place.min(content.len());
            let end = (place + bytes.len()).min(content.len());
            content.splice(place..end, bytes);
            drop(parse(&signed(&content)));
        }
    }

    /// A list that claims to be longer than the file takes no memory for it.
    #[test]
    fn claimed_lengths_are_not_believed() {
        let huge = signed(&[&MARK, &LAYOUT.to_le_bytes()[..], &[0xff; 9], &[1]].concat());
        assert!(matches!(parse(&huge), Err(FormatError::Content(_))));
    }

    #[test]
    fn errors_of_the_disk_are_told_as_they_are() {
        struct Full(usize);
        impl Write for Full {
            fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
                self.0 = self.0.checked_sub(bytes.len()).ok_or(io::ErrorKind::StorageFull)?;
                Ok(bytes.len())
            }
            fn flush(&mut self) -> io::Result<()> {
                Ok(())
            }
        }
        let checkpoint = parse(&BYTES).unwrap();
        for room in [0, BYTES.len() - 1] {
            assert_eq!(write(&checkpoint, &mut Full(room)).unwrap_err().kind(), io::ErrorKind::StorageFull);
        }
        write(&checkpoint, &mut Full(BYTES.len())).unwrap();
    }
}
