//! The bytes of a checkpoint.

use std::io::{self, Write};

use super::{Checkpoint, FormatError};
use crate::sealed::Kind;

/// The layout is to be raised whenever what stands in [`Checkpoint`] changes.
const KIND: Kind = Kind { mark: *b"caustica render\n", layout: 5, name: "checkpoint" };

/// Writes a checkpoint, as [`parse`] reads it.
///
/// # Errors
/// Those of `out`.
pub fn write(checkpoint: &Checkpoint, out: &mut dyn Write) -> io::Result<()> {
    KIND.write(checkpoint, out)
}

/// Reads a checkpoint. Memory is a small multiple of the length of `bytes`, whatever they are.
///
/// # Errors
/// A [`FormatError`] for any bytes that [`write()`] did not write, or that a program with another layout wrote.
pub fn parse(bytes: &[u8]) -> Result<Checkpoint<'static>, FormatError> {
    KIND.parse(bytes)
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::{ErrorHistory, Facts, RunState};
    use super::*;
    use crate::ppm::{ErrorEstimates, Forecast, RadiusPolicy, Render, Settings};
    use crate::scene::{self, Scene};
    use crate::sealed::HEADER;
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
            let error = if place < KIND.mark.len() {
                FormatError::Foreign { kind: "checkpoint" }
            } else {
                FormatError::Damaged
            };
            assert_eq!(parse(&damaged), Err(error), "byte {place}");
        }
    }

    #[test]
    fn any_lost_or_added_end_is_found() {
        for length in 0..BYTES.len() {
            let error = if length < KIND.mark.len() {
                FormatError::Foreign { kind: "checkpoint" }
            } else {
                FormatError::Damaged
            };
            assert_eq!(parse(&BYTES[..length]), Err(error), "{length} bytes");
        }
        assert_eq!(parse(&[&BYTES[..], b"\0"].concat()), Err(FormatError::Damaged));
    }

    #[test]
    fn other_layouts_are_named() {
        let content = &BYTES[HEADER..BYTES.len() - blake3::OUT_LEN];
        let with_layout = |layout: u32| signed(&[&KIND.mark, &layout.to_le_bytes()[..], content].concat());
        assert!(parse(&with_layout(KIND.layout)).is_ok());
        let error = parse(&with_layout(0x0102_0304)).unwrap_err();
        assert_eq!(error, FormatError::Version { found: 0x0102_0304, supported: KIND.layout });
        let longer = signed(&[&KIND.mark, &KIND.layout.to_le_bytes()[..], content, b"xy"].concat());
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
        let huge = signed(&[&KIND.mark, &KIND.layout.to_le_bytes()[..], &[0xff; 9], &[1]].concat());
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
