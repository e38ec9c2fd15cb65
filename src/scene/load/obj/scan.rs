//! Statement by statement.

use std::collections::BTreeMap;
use std::path::Path;

use super::super::super::SceneError;
use super::super::fields::{COORDINATE, shortened};
use super::super::geometry::{Geometry, NO_FACE};
use super::super::polygon::{MAX_CONCAVE, too_concave, triangulate};
use super::super::source::file_error;
use super::super::statements::{keyword, statements};
use super::join::{Corner, Joined, Values};
use super::{Keep, Obj};
use crate::math::{Vec2, Vec3};

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

/// What the statements so far have said.
pub(super) struct Scan<'a> {
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
    /// What all statements of a file say.
    pub fn of(path: &'a Path, text: &str, keep: Keep) -> Result<Scan<'a>, SceneError> {
        let mut scan = Scan::new(path, keep);
        for (line, statement) in statements(text) {
            scan.line = line;
            scan.statement(&statement)?;
        }
        Ok(scan)
    }

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

    pub fn finish(mut self) -> Result<Obj, SceneError> {
        self.check_furthest()?;
        if self.faces.is_empty() {
            return Err(file_error(self.path, NO_FACE));
        }
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
        let reason = too_concave();
        SceneError::Line { path: self.path.to_owned(), line, reason }
    }
}

/// The words in front of a comment.
fn in_words(rest: &str) -> impl Iterator<Item = &str> {
    let end = rest.bytes().position(|byte| byte == b'#').unwrap_or(rest.len());
    rest[..end].split_ascii_whitespace()
}
