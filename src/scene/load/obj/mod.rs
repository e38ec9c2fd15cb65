//! OBJ files: positions, normals and faces, joined into vertices that have one of each.

mod content;
mod join;
mod scan;

use std::path::Path;

pub(super) use self::content::{Keep, Obj};

use self::scan::Scan;
use super::super::SceneError;
use super::statements::decode;

/// Reads the bytes of an OBJ file. Corners that differ in nothing that is kept share a vertex.
///
/// # Errors
/// The table in the documentation of [`crate::scene`] tells what is refused.
pub(super) fn parse(path: &Path, bytes: Vec<u8>, keep: Keep) -> Result<Obj, SceneError> {
    let text = decode(path, bytes)?;
    let scan = Scan::of(path, &text, keep)?;
    drop(text);
    scan.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Vec2, Vec3};

    const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

    fn read(text: &str) -> Result<Obj, SceneError> {
        parse(Path::new("m.obj"), text.as_bytes().to_vec(), Keep { normals: true, uvs: false })
    }

    fn faces(statements: &str) -> Obj {
        read(&format!("{SQUARE}{statements}")).unwrap()
    }

    #[test]
    fn dirty_but_clear_files_load() {
        let file = "\u{feff}v 0 0 0 # a\r\n\tv  1. +0 0e0  \r\nvt 7\r\nv 1 1 .0 1 0 0\r\nv 0 2 0 2\r\nf 1/1 2 3/-1 \\\r\n 4#b";
        let obj = read(file).unwrap();
        assert_eq!(obj.geometry.vertices, faces("f 1 2 3 4").geometry.vertices);
        assert_eq!(obj.geometry.triangles, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!((obj.geometry.normals, obj.geometry.ignored), (None, 0));
    }

    #[test]
    fn indices_count_from_either_end_and_may_run_ahead() {
        let ahead = read(&format!("f 1 2 3\n{SQUARE}f -4 -3 -2")).unwrap();
        assert_eq!(ahead.geometry.triangles, [[0, 1, 2], [0, 1, 2]]);
        assert_eq!(ahead.geometry.vertices.len(), 3);
    }

    #[test]
    fn corners_without_a_normal_have_a_zero_one() {
        let obj = faces("vn 0 0 2\nvn nan 0 1\nf 1//1 2//-2 3\nf 1/ 3// 4//2");
        let normals = obj.geometry.normals.unwrap();
        let of_corner = |t: usize, k: usize| normals[obj.geometry.triangles[t][k] as usize];
        assert_eq!(
            [of_corner(0, 0), of_corner(0, 1), of_corner(0, 2)],
            [2.0 * Vec3::Z, 2.0 * Vec3::Z, Vec3::ZERO]
        );
        assert_eq!([of_corner(1, 0), of_corner(1, 1)], [Vec3::ZERO; 2]);
        assert!(of_corner(1, 2).x.is_nan());
    }

    #[test]
    fn unused_normals_leave_vertices_shared() {
        let text = format!("{SQUARE}vn 0 0 1\nvn 0 1 0\nf 1//1 2//1 3//1\nf 1//2 3//2 4//2");
        let shared =
            parse(Path::new("m.obj"), text.clone().into_bytes(), Keep { normals: false, uvs: false })
                .unwrap();
        assert_eq!((shared.geometry.vertices.len(), shared.geometry.normals), (4, None));
        assert_eq!(read(&text).unwrap().geometry.vertices.len(), 6);
    }

    #[test]
    fn texture_coordinates_split_vertices_where_they_are_kept() {
        let text = format!("{SQUARE}vt 0.5\nvt 0 1 7\nf 1/1 2/2 3/1\nf 1/2 3/1 4");
        let kept =
            parse(Path::new("m.obj"), text.clone().into_bytes(), Keep { normals: true, uvs: true }).unwrap();
        assert_eq!(kept.geometry.triangles, [[0, 1, 2], [3, 2, 4]]);
        let [half, one] = [Vec2::new(0.5, 0.0), Vec2::Y];
        assert_eq!(kept.geometry.uvs, Some(vec![half, one, half, one, Vec2::ZERO]));
        let shared = read(&text).unwrap().geometry;
        assert_eq!((shared.vertices.len(), shared.uvs), (4, None));
    }

    #[test]
    fn materials_follow_usemtl_across_groups() {
        let obj = faces("f 1 2 3\nusemtl b c\nf 1 2 3 4\ng x\nusemtl a\no y\nf 1 2 3\nusemtl\nf 1 2 3");
        assert_eq!(obj.material_names, ["b c", "a"]);
        assert_eq!(obj.materials, [None, Some(0), Some(0), Some(1), None]);
    }

    #[test]
    fn refusals_name_the_line_and_what_is_allowed() {
        for (statement, words) in [
            ("v 1 2", "vertex of 2 numbers; allowed: 3"),
            ("v 1 2 3.1+e2", "`3.1+e2` is not a number; allowed: a number"),
            ("v 1 nan 3", "vertex coordinate NaN; allowed: a number from -1.8e18"),
            ("v 1 2 -inf", "vertex coordinate -inf"),
            ("v 1 2e18 3", "vertex coordinate 2000000000000000000; allowed"),
            ("v 1 1e18 3 0.1", "vertex coordinate 1"),
            ("v 1 2 3 0", "weight 0"),
            ("vn 1 2", "normal of 2 numbers; allowed: 3"),
            ("vn 1 2 x", "normal: `x` is not a number"),
            ("f 0 1 2", "vertex index 0 is out of range; allowed: 1 to 4 or -4 to -1"),
            ("f 1 2 5", "vertex index 5 is out of range; allowed: 1 to 4"),
            ("f 1 2 -5", "vertex index -5 is out of range"),
            ("f 1 2 -9223372036854775808", "is out of range"),
            ("f 1 2 9223372036854775807", "is out of range"),
            ("f 1 2 99999999999999999999", "is not a whole number"),
            ("f 1/1 2 3", "texture coordinate index 1 is out of range; allowed: none"),
            ("f 1//1 2 3", "normal index 1 is out of range; allowed: none"),
            ("f 1 2 3.5", "vertex index `3.5` is not a whole number"),
            ("f 1 2 //3", "vertex index `` is not a whole number"),
            ("f 1 2 3/1/1/1", "corner `3/1/1/1`; allowed: v, v/vt"),
        ] {
            let error = read(&format!("{SQUARE}f 1 2 3\n{statement}\n# end")).unwrap_err().to_string();
            assert!(error.starts_with("m.obj:6: ") && error.contains(words), "{statement}: {error}");
        }
    }

    proptest::proptest! {
        /// The parser of others, for what it reads without fail.
        #[test]
        fn meshes_are_joined_as_by_tobj(
            corners in proptest::collection::vec((1u32..6, 0u32..4), 3..60),
            keep_normals: bool,
        ) {
            let mut text = String::from("v 0 0 0\nv 1 0 0.5\nv 1 1 0\nv 0 1 3\nv 2 2 2\nvn 0 0 1\nvn 1 0 0\nvn 0 1 0\nvn 0 0 0\n");
            for face in corners.chunks_exact(3) {
                let corner = |(v, n): &(u32, u32)| format!(" {v}//{}", if keep_normals { n + 1 } else { 1 });
                text += &format!("f{}\n", face.iter().map(corner).collect::<String>());
            }
            let ours = parse(Path::new("m.obj"), text.clone().into_bytes(), Keep { normals: keep_normals, uvs: false }).unwrap().geometry;
            let options = tobj::LoadOptions { single_index: true, ..Default::default() };
            let theirs = tobj::load_obj_buf(&mut text.as_bytes(), &options, |_| Err(tobj::LoadError::OpenFileFailed)).unwrap().0;
            let theirs = &theirs[0].mesh;
            proptest::prop_assert_eq!(ours.triangles.as_flattened(), &theirs.indices[..]);
            proptest::prop_assert_eq!(ours.vertices.iter().flat_map(|v| v.to_array()).collect::<Vec<_>>(), theirs.positions.clone());
            if keep_normals {
                proptest::prop_assert_eq!(ours.normals.unwrap().iter().flat_map(|n| n.to_array()).collect::<Vec<_>>(), theirs.normals.clone());
            }
        }

        #[test]
        fn no_text_makes_it_panic(
            lines in proptest::collection::vec("(v|vn|vt|f|f|usemtl|mtllib|p|g)( (-?[0-9]{1,2}|[0-9/.-]{0,6}|nan|inf|1e39)){0,6}", 0..30)
        ) {
            let _ = read(&lines.join("\n"));
            let _ = read(&format!("{SQUARE}{SQUARE}vn 0 0 0\nvt 0 0\n{}", lines.join("\n")));
        }
    }
}
