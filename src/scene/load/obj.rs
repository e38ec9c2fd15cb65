//! OBJ files. A scan refuses, with its line, what the parser `tobj` would refuse without one, misread or panic on;
//! it hands on plain vertices and faces, which `tobj` then parses and joins.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use super::super::SceneError;
use super::fields::{COORDINATE, MAX_COORDINATE, shortened};
use super::polygon::{MAX_CONCAVE, triangulate};
use super::source::file_error;
use super::statements::{decode, keyword, statements, words};
use crate::math::Vec3;

/// What an OBJ file holds, cut into triangles.
#[derive(Debug)]
pub(super) struct Obj {
    pub vertices: Vec<Vec3>,
    /// One per vertex, of any length; zero for corners without one. None if no corner has one.
    pub normals: Option<Vec<Vec3>>,
    pub triangles: Vec<[u32; 3]>,
    /// Per triangle an index into `material_names`, or none before the first `usemtl`.
    pub materials: Vec<Option<u32>>,
    pub material_names: Vec<String>,
    /// What stands behind each `mtllib`, with its line.
    pub libraries: Vec<(usize, String)>,
    /// Points, lines and faces of fewer than three vertices.
    pub ignored: usize,
}

/// Reads the bytes of an OBJ file. Without `keep_normals`, corners that share a position share a vertex.
///
/// # Errors
/// The table in the documentation of [`crate::scene`] tells what is refused.
pub(super) fn parse(path: &Path, bytes: Vec<u8>, keep_normals: bool) -> Result<Obj, SceneError> {
    let text = decode(path, bytes)?;
    let mut scan = Scan::new(path, keep_normals);
    for (line, statement) in statements(&text) {
        scan.line = line;
        scan.statement(&statement)?;
    }
    scan.check_furthest()?;
    if scan.face_materials.is_empty() {
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

/// Corners, and an index into the names of materials.
type Triangle = ([u32; 3], Option<u32>);

struct Scan<'a> {
    path: &'a Path,
    line: usize,
    keep_normals: bool,
    /// What `tobj` gets to read. Its first normal is zero and stands for the missing ones.
    plain: String,
    counts: [usize; 3],
    /// The largest index of each kind and its line: indices may run ahead of what they count.
    furthest: [(usize, usize); 3],
    any_normal: bool,
    material_names: BTreeMap<String, u32>,
    material: Option<u32>,
    face_materials: Vec<Option<u32>>,
    /// Face numbers and lines of those too large to clip ears from.
    large_faces: Vec<(usize, usize)>,
    libraries: Vec<(usize, String)>,
    ignored: usize,
}

impl<'a> Scan<'a> {
    fn new(path: &'a Path, keep_normals: bool) -> Scan<'a> {
        Scan {
            path,
            line: 0,
            keep_normals,
            plain: String::from("vn 0 0 0\n"),
            counts: [0; 3],
            furthest: [(0, 0); 3],
            any_normal: false,
            material_names: BTreeMap::new(),
            material: None,
            face_materials: Vec::new(),
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
            "v" => self.vertex(&words(rest))?,
            "vt" => self.counts[TEXTURE] += 1,
            "vn" => self.normal(&words(rest))?,
            "f" => self.face(&words(rest))?,
            "p" | "l" => self.ignored += 1,
            "usemtl" => self.use_material(rest),
            "mtllib" => self.libraries.push((self.line, rest.to_owned())),
            _ => {}
        }
        Ok(())
    }

    fn floats(&self, words: &[&str], what: &str) -> Result<Vec<f32>, SceneError> {
        let number = |word: &&str| {
            let wrong = |_| {
                self.error(format!(
                    "{what}: `{}` is not a number; allowed: {}",
                    shortened(word),
                    COORDINATE.text
                ))
            };
            word.parse::<f32>().map_err(wrong)
        };
        words.iter().map(number).collect()
    }

    fn vertex(&mut self, words: &[&str]) -> Result<(), SceneError> {
        // Of more than four numbers, those behind the first three are a colour.
        let used = if words.len() == 4 { words } else { &words[..words.len().min(3)] };
        let numbers = self.floats(used, "vertex")?;
        let (Some(xyz), weight) = (numbers.get(..3), numbers.get(3).copied().unwrap_or(1.0)) else {
            return Err(self.error(format!("vertex of {} numbers; allowed: 3 or more", numbers.len())));
        };
        if weight == 0.0 {
            return Err(self.error(String::from("vertex of weight 0; allowed: any other weight, or none")));
        }
        if let Some(outside) = xyz.iter().find(|&x| !(COORDINATE.holds)(f64::from(x / weight))) {
            let value = outside / weight;
            return Err(self.error(format!("vertex coordinate {value}; allowed: {}", COORDINATE.text)));
        }
        self.counts[VERTEX] += 1;
        self.hand_on("v", used);
        Ok(())
    }

    fn normal(&mut self, words: &[&str]) -> Result<(), SceneError> {
        let used = &words[..words.len().min(3)];
        if self.floats(used, "normal")?.len() < 3 {
            return Err(self.error(format!("normal of {} numbers; allowed: 3", words.len())));
        }
        self.counts[NORMAL] += 1;
        self.hand_on("vn", used);
        Ok(())
    }

    fn hand_on(&mut self, keyword: &str, words: &[&str]) {
        self.plain.push_str(keyword);
        for word in words {
            self.plain.push(' ');
            self.plain.push_str(word);
        }
        self.plain.push('\n');
    }

    fn use_material(&mut self, name: &str) {
        let next = self.material_names.len() as u32;
        self.material =
            (!name.is_empty()).then(|| *self.material_names.entry(name.to_owned()).or_insert(next));
    }

    fn face(&mut self, words: &[&str]) -> Result<(), SceneError> {
        let corners = words.iter().map(|word| self.corner(word)).collect::<Result<Vec<_>, _>>()?;
        if corners.len() < 3 {
            self.ignored += 1;
            return Ok(());
        }
        if corners.len() > MAX_CONCAVE {
            self.large_faces.push((self.face_materials.len(), self.line));
        }
        self.face_materials.push(self.material);
        self.plain.push('f');
        for (vertex, normal) in corners {
            // Writing to a string cannot fail.
            let _ = write!(self.plain, " {vertex}//{normal}");
        }
        self.plain.push('\n');
        Ok(())
    }

    /// The numbers from 1 of a corner's position and normal in what is handed on.
    fn corner(&mut self, word: &str) -> Result<(usize, usize), SceneError> {
        let parts: Vec<&str> = word.split('/').collect();
        if parts.len() > KINDS.len() {
            let word = shortened(word);
            return Err(self.error(format!("corner `{word}`; allowed: v, v/vt, v//vn or v/vt/vn")));
        }
        let mut numbers = [None; 3];
        for (kind, part) in
            parts.iter().enumerate().filter(|(kind, part)| *kind == VERTEX || !part.is_empty())
        {
            numbers[kind] = Some(self.index(kind, part)?);
        }
        let normal = numbers[NORMAL].filter(|_| self.keep_normals);
        self.any_normal |= normal.is_some();
        Ok((numbers[VERTEX].unwrap_or_default(), 1 + normal.unwrap_or_default()))
    }

    /// An index as a number from 1; negative ones count back from the latest.
    fn index(&mut self, kind: usize, word: &str) -> Result<usize, SceneError> {
        let what = KINDS[kind];
        let index: i64 = word.parse().map_err(|_| {
            let word = shortened(word);
            self.error(format!("{what} index `{word}` is not a whole number; allowed: one, other than 0"))
        })?;
        let number =
            if index < 0 { index.saturating_add_unsigned(self.counts[kind] as u64) + 1 } else { index };
        if index == 0 || number < 1 {
            return Err(self.out_of_range(kind, index));
        }
        self.furthest[kind] = self.furthest[kind].max((number as usize, self.line));
        Ok(number as usize)
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
        let options = tobj::LoadOptions { single_index: true, ..Default::default() };
        let no_library = |_: &Path| Err(tobj::LoadError::OpenFileFailed);
        let (models, _) = tobj::load_obj_buf(&mut self.plain.as_bytes(), &options, no_library)
            .map_err(|e| file_error(self.path, format!("cannot be parsed: {e}")))?;
        let mesh = models.into_iter().next().map(|model| model.mesh).unwrap_or_default();
        let vertices = triples(&mesh.positions);
        let (triangles, materials) = self.triangles(&mesh, &vertices)?.into_iter().unzip();
        let mut names: Vec<(String, u32)> = self.material_names.into_iter().collect();
        names.sort_by_key(|(_, index)| *index);
        Ok(Obj {
            vertices,
            normals: self.any_normal.then(|| triples(&mesh.normals)),
            triangles,
            materials,
            material_names: names.into_iter().map(|(name, _)| name).collect(),
            libraries: self.libraries,
            ignored: self.ignored,
        })
    }

    /// The triangles of all faces, each with its material.
    fn triangles(&self, mesh: &tobj::Mesh, vertices: &[Vec3]) -> Result<Vec<Triangle>, SceneError> {
        let mut rest = &mesh.indices[..];
        let mut triangles = Vec::new();
        for (face, &material) in self.face_materials.iter().enumerate() {
            // tobj leaves the arities out where all faces are triangles.
            let arity = mesh.face_arities.get(face).map_or(3, |&n| n as usize);
            let (ring, others) = rest.split_at(arity);
            rest = others;
            let corners: Vec<Vec3> = ring.iter().map(|&i| vertices[i as usize]).collect();
            let cut = triangulate(&corners).ok_or_else(|| self.too_large(face))?;
            triangles.extend(cut.into_iter().map(|t| (t.map(|i| ring[i]), material)));
        }
        Ok(triangles)
    }

    fn too_large(&self, face: usize) -> SceneError {
        let line = self.large_faces.iter().find(|(number, _)| *number == face).map_or(0, |(_, line)| *line);
        let reason =
            format!("concave face of more than {MAX_CONCAVE} vertices; allowed: cut it into smaller ones");
        SceneError::Line { path: self.path.to_owned(), line, reason }
    }
}

fn triples(flat: &[f32]) -> Vec<Vec3> {
    flat.chunks_exact(3).map(Vec3::from_slice).collect()
}

/// Whether Embree traces a vertex there.
pub(super) fn is_traceable(p: Vec3) -> bool {
    f64::from(p.abs().max_element()) <= MAX_COORDINATE && p.is_finite()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

    fn read(text: &str) -> Result<Obj, SceneError> {
        parse(Path::new("m.obj"), text.as_bytes().to_vec(), true)
    }

    fn faces(statements: &str) -> Obj {
        read(&format!("{SQUARE}{statements}")).unwrap()
    }

    #[test]
    fn dirty_but_clear_files_load() {
        let file = "\u{feff}v 0 0 0 # a\r\n\tv  1. +0 0e0  \r\nvt 7\r\nv 1 1 .0 1 0 0\r\nv 0 2 0 2\r\nf 1/1 2 3/-1 \\\r\n 4#b";
        let obj = read(file).unwrap();
        assert_eq!(obj.vertices, faces("f 1 2 3 4").vertices);
        assert_eq!(obj.triangles, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!((obj.normals, obj.ignored), (None, 0));
    }

    #[test]
    fn indices_count_from_either_end_and_may_run_ahead() {
        let ahead = read(&format!("f 1 2 3\n{SQUARE}f -4 -3 -2")).unwrap();
        assert_eq!(ahead.triangles, [[0, 1, 2], [0, 1, 2]]);
        assert_eq!(ahead.vertices.len(), 3);
    }

    #[test]
    fn corners_without_a_normal_have_a_zero_one() {
        let obj = faces("vn 0 0 2\nvn nan 0 1\nf 1//1 2//-2 3\nf 1/ 3// 4//2");
        let normals = obj.normals.unwrap();
        let of_corner = |t: usize, k: usize| normals[obj.triangles[t][k] as usize];
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
        let shared = parse(Path::new("m.obj"), text.clone().into_bytes(), false).unwrap();
        assert_eq!((shared.vertices.len(), shared.normals), (4, None));
        assert_eq!(read(&text).unwrap().vertices.len(), 6);
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
        #[test]
        fn no_text_makes_it_panic(
            lines in proptest::collection::vec("(v|vn|vt|f|f|usemtl|mtllib|p|g)( (-?[0-9]{1,2}|[0-9/.-]{0,6}|nan|inf|1e39)){0,6}", 0..30)
        ) {
            let _ = read(&lines.join("\n"));
            let _ = read(&format!("{SQUARE}{SQUARE}vn 0 0 0\nvt 0 0\n{}", lines.join("\n")));
        }
    }
}
