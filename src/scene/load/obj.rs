//! OBJ files: positions, normals and faces, joined into vertices that have one of each.

mod join;

use std::collections::BTreeMap;
use std::path::Path;

use self::join::{Corner, Joined, Values};
use super::super::SceneError;
use super::fields::{COORDINATE, shortened};
use super::geometry::Geometry;
use super::polygon::{MAX_CONCAVE, triangulate};
use super::source::file_error;
use super::statements::{decode, keyword, statements};
use crate::math::{Vec2, Vec3};

/// What an OBJ file holds, cut into triangles.
#[derive(Clone, Debug)]
pub(super) struct Obj {
    pub geometry: Geometry,
    /// Per triangle an index into `material_names`, or none before the first `usemtl`.
    pub materials: Vec<Option<u32>>,
    pub material_names: Vec<String>,
    /// What stands behind each `mtllib`, with its line.
    pub libraries: Vec<(usize, String)>,
}

impl Obj {
    /// Geometry without materials.
    pub fn of(geometry: Geometry) -> Obj {
        let materials = vec![None; geometry.triangles.len()];
        Obj { geometry, materials, material_names: Vec::new(), libraries: Vec::new() }
    }
}

/// What of a corner is kept beside its position.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Keep {
    pub normals: bool,
    /// Texture coordinates.
    pub uvs: bool,
}

/// Reads the bytes of an OBJ file. Corners that differ in nothing that is kept share a vertex.
///
/// # Errors
/// The table in the documentation of [`crate::scene`] tells what is refused.
pub(super) fn parse(path: &Path, bytes: Vec<u8>, keep: Keep) -> Result<Obj, SceneError> {
    let text = decode(path, bytes)?;
    let mut scan = Scan::new(path, keep);
    for (line, statement) in statements(&text) {
        scan.line = line;
        scan.statement(&statement)?;
    }
    drop(text);
    scan.check_furthest()?;
    if scan.faces.is_empty() {
        return Err(file_error(
            path,
            "empty mesh: it has no face of 3 or more vertices; at least one is needed",
        ));
    }
    scan.finish()
}

/// What an index counts; the order is that of `v/vt/vn`.
const KINDS: [&str; 3] = ["vertex", "texture coordinate", "normal"];
const VERTEX: usize = 0;
const TEXTURE: usize = 1;
const NORMAL: usize = 2;

/// A face as it is read.
struct Face {
    /// How many of the corners are its own.
    n_corners: u32,
    /// An index into the names of materials.
    material: Option<u32>,
}

/// Triangles and the material of each.
type Triangles = (Vec<[u32; 3]>, Vec<Option<u32>>);

struct Scan<'a> {
    path: &'a Path,
    line: usize,
    keep: Keep,
    uvs: Vec<Vec2>,
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    counts: [usize; 3],
    /// The largest index of each kind and its line: indices may run ahead of what they count.
    furthest: [(usize, usize); 3],
    material_names: BTreeMap<String, u32>,
    material: Option<u32>,
    /// Of all faces, one after the other.
    corners: Vec<Corner>,
    faces: Vec<Face>,
    /// Face numbers and lines of those too large to clip ears from.
    large_faces: Vec<(usize, usize)>,
    libraries: Vec<(usize, String)>,
    ignored: usize,
}

impl<'a> Scan<'a> {
    fn new(path: &'a Path, keep: Keep) -> Scan<'a> {
        Scan {
            path,
            line: 0,
            keep,
            uvs: Vec::new(),
            positions: Vec::new(),
            normals: Vec::new(),
            counts: [0; 3],
            furthest: [(0, 0); 3],
            material_names: BTreeMap::new(),
            material: None,
            corners: Vec::new(),
            faces: Vec::new(),
            large_faces: Vec::new(),
            libraries: Vec::new(),
            ignored: 0,
        }
    }

    fn error(&self, reason: String) -> SceneError {
        SceneError::Line { path: self.path.to_owned(), line: self.line, reason }
    }

    fn statement(&mut self, statement: &str) -> Result<(), SceneError> {
        let (word, rest) = keyword(statement);
        match word {
            "v" => self.vertex(rest)?,
            "vt" => self.uv(rest)?,
            "vn" => self.normal(rest)?,
            "f" => self.face(rest)?,
            "p" | "l" => self.ignored += 1,
            "usemtl" => self.use_material(rest),
            "mtllib" => self.libraries.push((self.line, rest.to_owned())),
            _ => {}
        }
        Ok(())
    }

    /// The first numbers of a statement, and how many words it has.
    fn numbers<const N: usize>(&self, rest: &str, what: &str) -> Result<([f32; N], usize), SceneError> {
        let mut numbers = [0.0; N];
        let mut n = 0;
        for word in in_words(rest) {
            if n < N {
                numbers[n] = word.parse().map_err(|_| self.no_number(word, what))?;
            }
            n += 1;
        }
        Ok((numbers, n))
    }

    fn no_number(&self, word: &str, what: &str) -> SceneError {
        let allowed = COORDINATE.text;
        self.error(format!("{what}: `{}` is not a number; allowed: {allowed}", shortened(word)))
    }

    fn vertex(&mut self, rest: &str) -> Result<(), SceneError> {
        let ([x, y, z], n) = self.numbers(rest, "vertex")?;
        if n < 3 {
            return Err(self.error(format!("vertex of {n} numbers; allowed: 3 or more")));
        }
        let mut position = Vec3::new(x, y, z);
        // Of more than four numbers, those behind the first three are a colour.
        if n == 4 {
            let ([.., weight], _) = self.numbers::<4>(rest, "vertex")?;
            if weight == 0.0 {
                return Err(
                    self.error(String::from("vertex of weight 0; allowed: any other weight, or none"))
                );
            }
            position /= weight;
        }
        let outside = |x: &f32| !(COORDINATE.holds)(f64::from(*x));
        if let Some(value) = position.to_array().into_iter().find(outside) {
            return Err(self.error(format!("vertex coordinate {value}; allowed: {}", COORDINATE.text)));
        }
        self.counts[VERTEX] += 1;
        self.positions.push(position);
        Ok(())
    }

    fn normal(&mut self, rest: &str) -> Result<(), SceneError> {
        let (normal, n) = self.numbers(rest, "normal")?;
        if n < 3 {
            return Err(self.error(format!("normal of {n} numbers; allowed: 3")));
        }
        self.counts[NORMAL] += 1;
        if self.keep.normals {
            self.normals.push(Vec3::from_array(normal));
        }
        Ok(())
    }

    /// Of one number or more; what is not kept may be anything.
    fn uv(&mut self, rest: &str) -> Result<(), SceneError> {
        self.counts[TEXTURE] += 1;
        if self.keep.uvs {
            let ([u, v], _) = self.numbers(rest, "texture coordinate")?;
            self.uvs.push(Vec2::new(u, v));
        }
        Ok(())
    }

    fn use_material(&mut self, name: &str) {
        let next = self.material_names.len() as u32;
        self.material =
            (!name.is_empty()).then(|| *self.material_names.entry(name.to_owned()).or_insert(next));
    }

    fn face(&mut self, rest: &str) -> Result<(), SceneError> {
        let before = self.corners.len();
        for word in in_words(rest) {
            let corner = self.corner(word)?;
            self.corners.push(corner);
        }
        let n_corners = self.corners.len() - before;
        if n_corners < 3 {
            self.corners.truncate(before);
            self.ignored += 1;
            return Ok(());
        }
        if n_corners > MAX_CONCAVE {
            self.large_faces.push((self.faces.len(), self.line));
        }
        self.faces.push(Face { n_corners: n_corners as u32, material: self.material });
        Ok(())
    }

    /// The numbers from 1 of what a corner has; 0 for nothing.
    fn corner(&mut self, word: &str) -> Result<Corner, SceneError> {
        let mut numbers = [0; 3];
        for (kind, part) in word.split('/').enumerate() {
            if kind == KINDS.len() {
                let word = shortened(word);
                return Err(self.error(format!("corner `{word}`; allowed: v, v/vt, v//vn or v/vt/vn")));
            }
            if kind == VERTEX || !part.is_empty() {
                numbers[kind] = self.index(kind, part)?;
            }
        }
        let kept = |keep: bool, number: u32| if keep { number } else { 0 };
        Ok(Corner {
            position: numbers[VERTEX],
            normal: kept(self.keep.normals, numbers[NORMAL]),
            uv: kept(self.keep.uvs, numbers[TEXTURE]),
        })
    }

    /// An index as a number from 1; negative ones count back from the latest.
    fn index(&mut self, kind: usize, word: &str) -> Result<u32, SceneError> {
        let what = KINDS[kind];
        let index: i64 = word.parse().map_err(|_| {
            let word = shortened(word);
            self.error(format!("{what} index `{word}` is not a whole number; allowed: one, other than 0"))
        })?;
        let number =
            if index < 0 { index.saturating_add_unsigned(self.counts[kind] as u64) + 1 } else { index };
        match u32::try_from(number) {
            Ok(number) if number > 0 => {
                if number as usize > self.furthest[kind].0 {
                    self.furthest[kind] = (number as usize, self.line);
                }
                Ok(number)
            }
            _ => Err(self.out_of_range(kind, index)),
        }
    }

    fn out_of_range(&self, kind: usize, index: i64) -> SceneError {
        let (what, n) = (KINDS[kind], self.counts[kind]);
        let allowed =
            if n == 0 { String::from("none, as there are none") } else { format!("1 to {n} or -{n} to -1") };
        self.error(format!("{what} index {index} is out of range; allowed: {allowed}"))
    }

    fn check_furthest(&mut self) -> Result<(), SceneError> {
        for kind in [VERTEX, TEXTURE, NORMAL] {
            let (number, line) = self.furthest[kind];
            if number > self.counts[kind] {
                self.line = line;
                return Err(self.out_of_range(kind, number as i64));
            }
        }
        Ok(())
    }

    fn finish(self) -> Result<Obj, SceneError> {
        let values = Values { positions: &self.positions, normals: &self.normals, uvs: &self.uvs };
        let Joined { vertices, normals, uvs, indices } = Joined::of(&self.corners, &values);
        let (triangles, materials) = self.triangles(&indices, &vertices)?;
        let mut names: Vec<(String, u32)> = self.material_names.into_iter().collect();
        names.sort_by_key(|(_, index)| *index);
        Ok(Obj {
            geometry: Geometry { vertices, normals, uvs, triangles, ignored: self.ignored },
            materials,
            material_names: names.into_iter().map(|(name, _)| name).collect(),
            libraries: self.libraries,
        })
    }

    /// The triangles of all faces and their materials.
    fn triangles(&self, indices: &[u32], vertices: &[Vec3]) -> Result<Triangles, SceneError> {
        let mut rest = indices;
        let mut triangles = Vec::with_capacity(self.faces.len());
        let mut materials = Vec::with_capacity(self.faces.len());
        for (number, face) in self.faces.iter().enumerate() {
            let (ring, others) = rest.split_at(face.n_corners as usize);
            rest = others;
            if let &[a, b, c] = ring {
                triangles.push([a, b, c]);
            } else {
                let corners: Vec<Vec3> = ring.iter().map(|&i| vertices[i as usize]).collect();
                let cut = triangulate(&corners).ok_or_else(|| self.too_large(number))?;
                triangles.extend(cut.into_iter().map(|triangle| triangle.map(|i| ring[i])));
            }
            materials.resize(triangles.len(), face.material);
        }
        Ok((triangles, materials))
    }

    fn too_large(&self, face: usize) -> SceneError {
        let line = self.large_faces.iter().find(|(number, _)| *number == face).map_or(0, |(_, line)| *line);
        let reason =
            format!("concave face of more than {MAX_CONCAVE} vertices; allowed: cut it into smaller ones");
        SceneError::Line { path: self.path.to_owned(), line, reason }
    }
}

/// The words in front of a comment.
fn in_words(rest: &str) -> impl Iterator<Item = &str> {
    let end = rest.bytes().position(|byte| byte == b'#').unwrap_or(rest.len());
    rest[..end].split_ascii_whitespace()
}

#[cfg(test)]
mod tests {
    use super::*;

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
