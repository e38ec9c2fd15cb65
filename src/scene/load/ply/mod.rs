//! PLY meshes: a header that says what follows, then ASCII or binary values of either byte order.

mod body;
mod fault;
mod header;
mod values;

use std::path::Path;

use self::body::Body;
use self::header::{Format, Header};
use self::values::{Ascii, Binary};
use super::super::SceneError;
use super::geometry::{Geometry, NO_FACE};
use super::source::file_error;

/// Reads the bytes of a PLY file.
///
/// # Errors
/// The table in `docs/formats.md` tells what is refused; errors in ASCII files and headers name their line.
pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Geometry, SceneError> {
    let (header, rest) = Header::read(path, bytes)?;
    let geometry = match header.format {
        Format::Ascii => Body::new(&header, Ascii::new(rest, header.lines)).read(),
        Format::LittleEndian => Body::new(&header, Binary::<false>::new(rest)).read(),
        Format::BigEndian => Body::new(&header, Binary::<true>::new(rest)).read(),
    };
    let geometry = geometry.map_err(|fault| match fault.line {
        Some(line) => SceneError::Line { path: path.to_owned(), line, reason: fault.reason },
        None => file_error(path, fault.reason),
    })?;
    if geometry.triangles.is_empty() {
        return Err(file_error(path, NO_FACE));
    }
    Ok(geometry)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use proptest::prelude::*;

    fn read(bytes: &[u8]) -> Result<Geometry, String> {
        parse(Path::new("m.ply"), bytes).map_err(|e| e.to_string())
    }

    const SQUARE: &str = "ply\r\nformat ascii 1.0\ncomment made by hand\nobj_info x\nelement vertex 4\nproperty double x\n\
        property float32 y\nproperty float z\nproperty uchar red\nelement face 1\nproperty list uchar int vertex_indices\n\
        end_header\n0 0 0 255\n1 0 0 0\n1 1e0 0 0\n0 1 0 0\n4 0 1 2 3\n";

    #[test]
    fn ascii_files_are_read_and_their_polygons_cut() {
        let geometry = read(SQUARE.as_bytes()).unwrap();
        assert_eq!(geometry.vertices, [Vec3::ZERO, Vec3::X, Vec3::new(1., 1., 0.), Vec3::Y]);
        assert_eq!(geometry.triangles, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!((geometry.normals, geometry.ignored), (None, 0));
    }

    /// A file with normals, an element of its own, faces of two and three vertices, and a list that no one reads.
    fn binary(big: bool) -> Vec<u8> {
        let order = if big { "big" } else { "little" };
        let mut bytes = format!(
            "ply\nformat binary_{order}_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty double z\n\
             property float nx\nproperty float ny\nproperty float nz\nelement extra 2\nproperty short a\n\
             property list ushort char b\nelement face 2\nproperty list uint8 float uv\n\
             property list uint uint32 vertex_index\nend_header\n"
        )
        .into_bytes();
        let mut put = |big_bytes: &[u8]| match big {
            true => bytes.extend(big_bytes),
            false => bytes.extend(big_bytes.iter().rev()),
        };
        for [x, y, z] in [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.5]] {
            put(&x.to_be_bytes());
            put(&y.to_be_bytes());
            put(&f64::from(z).to_be_bytes());
            [0.0f32, 0.0, 2.0].iter().for_each(|n| put(&n.to_be_bytes()));
        }
        for n in [0u16, 2] {
            put(&(-7i16).to_be_bytes());
            put(&n.to_be_bytes());
            (0..n).for_each(|k| put(&(k as i8).to_be_bytes()));
        }
        for face in [&[0u32, 1][..], &[2, 0, 1]] {
            put(&2u8.to_be_bytes());
            [0.5f32, 0.25].iter().for_each(|uv| put(&uv.to_be_bytes()));
            put(&(face.len() as u32).to_be_bytes());
            face.iter().for_each(|index| put(&index.to_be_bytes()));
        }
        bytes
    }

    #[test]
    fn binary_files_of_both_byte_orders_are_read() {
        for big in [false, true] {
            let geometry = read(&binary(big)).unwrap();
            assert_eq!(geometry.vertices, [Vec3::ZERO, Vec3::X, Vec3::new(0.0, 1.0, 0.5)]);
            assert_eq!(geometry.normals, Some(vec![Vec3::new(0.0, 0.0, 2.0); 3]));
            assert_eq!((geometry.triangles, geometry.ignored), (vec![[2, 0, 1]], 1));
        }
    }

    #[test]
    fn mistakes_are_told_where_they_are() {
        for (old, new, place, words) in [
            ("ply\r", "plx\r", "m.ply:1:", "`ply` is expected"),
            ("ascii", "text", "m.ply:2:", "format `text`; allowed: `ascii`"),
            ("1.0", "2.0", "m.ply:2:", "version `2.0`; allowed: 1.0"),
            ("double x", "real x", "m.ply:6:", "type `real`; allowed: `char`"),
            ("property float z\n", "", "m.ply: ", "vertices have no `z`"),
            ("element vertex 4", "element vertex -4", "m.ply:5:", "`-4`; allowed: a count"),
            ("element vertex 4", "element vertices 4", "m.ply: ", "no element `vertex`"),
            ("vertex_indices", "indices", "m.ply: ", "no list `vertex_indices` or `vertex_index`"),
            ("element face 1", "element tristrips 1", "m.ply: ", "`tristrips` are not supported"),
            ("end_header", "end", "m.ply:12:", "header line `end`; allowed: `comment`"),
            ("4 0 1 2 3", "4 0 1 2 4", "m.ply:17:", "vertex index 4 is out of range; allowed: 0 to 3"),
            ("4 0 1 2 3", "4 0 1 2 -1", "m.ply:17:", "vertex index -1 is out of range"),
            ("4 0 1 2 3", "4 0 1 2", "m.ply:18:", "the file ends"),
            ("1 1e0 0 0", "1 one 0 0", "m.ply:15:", "`one` is not a number"),
            ("1 1e0 0 0", "1 nan 0 0", "m.ply:15:", "vertex coordinate NaN; allowed"),
            ("4 0 1 2 3", "-4 0 1 2 3", "m.ply:17:", "list of -4 values; allowed: 0 or more"),
            ("4 0 1 2 3", "4 0 1 2.5 3", "m.ply:17:", "`2.5` is not a whole number"),
            ("4 0 1 2 3", "2 0 1", "m.ply: ", "empty mesh"),
        ] {
            assert!(SQUARE.contains(old), "{old}");
            let error = read(SQUARE.replacen(old, new, 1).as_bytes()).unwrap_err();
            assert!(error.starts_with(place) && error.contains(words), "{old} -> {new}: {error}");
        }
    }

    #[test]
    fn files_that_end_early_are_refused_whatever_they_promise() {
        let whole = binary(false);
        for length in 0..whole.len() {
            assert!(read(&whole[..length]).is_err(), "{length}");
        }
        let many = SQUARE.replace("element vertex 4", "element vertex 99999999999");
        assert!(read(many.as_bytes()).unwrap_err().contains("the file ends"));
        let nothing = "ply\nformat ascii 1.0\nelement none 18446744073709551615\nelement vertex 0\nproperty float x\n\
            property float y\nproperty float z\nelement face 0\nproperty list uchar int vertex_index\nend_header\n";
        assert!(read(nothing.as_bytes()).unwrap_err().contains("empty mesh"));
    }

    proptest! {
        #[test]
        fn no_bytes_make_it_panic(at in 0usize..600, byte in any::<u8>(), big in any::<bool>()) {
            let mut bytes = binary(big);
            let at = at % bytes.len();
            bytes[at] = byte;
            let _ = read(&bytes);
            let mut text = SQUARE.as_bytes().to_vec();
            let at = at % text.len();
            text[at] = byte;
            let _ = read(&text);
        }
    }
}
