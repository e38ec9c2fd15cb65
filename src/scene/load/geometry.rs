//! From the contents of a mesh file to a mesh in its place.

use std::collections::BTreeMap;
use std::path::Path;

use super::super::{Mesh, SceneError};
use super::fields::MAX_COORDINATE;
use super::source::file_error;
use crate::math::{Vec2, Vec3};

/// What a mesh file holds, cut into triangles.
#[derive(Clone, Debug, Default)]
pub(super) struct Geometry {
    pub vertices: Vec<Vec3>,
    /// One per vertex, of any length; zero for corners without one. None if no corner has one.
    pub normals: Option<Vec<Vec3>>,
    /// Texture coordinates, one per vertex.
    pub uvs: Option<Vec<Vec2>>,
    pub triangles: Vec<[u32; 3]>,
    /// Points, lines and faces of fewer than three vertices.
    pub ignored: usize,
}

/// Why a file without any triangle is refused.
pub(super) const NO_FACE: &str = "empty mesh: it has no face of 3 or more vertices; at least one is needed";

/// Where shading normals come from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Normals {
    Smooth,
    Flat,
    File,
    /// The file's if it has any, else flat.
    FileOrFlat,
    /// The file's if it has any, else smooth.
    FileOrSmooth,
}

/// How a mesh is moved.
pub(super) trait Motion {
    fn point(&self, p: Vec3) -> Vec3;
    /// The moved unit normal; none for a normal without direction.
    fn normal(&self, n: Vec3) -> Option<Vec3>;
    /// Whether left hands become right hands.
    fn mirrors(&self) -> bool;
    /// Whether nothing moves.
    fn is_identity(&self) -> bool;
}

/// Where a mesh file's contents go, and by whose wish.
pub(super) struct Placement<'a> {
    pub name: &'a str,
    /// The mesh file.
    pub path: &'a Path,
    pub motion: &'a dyn Motion,
    pub normals: Normals,
    /// Whether the geometric and the shading normals are turned over.
    pub flip: bool,
    /// Whether normals of unit length that are not moved keep every bit.
    pub keeps_unit_normals: bool,
    /// An error in the scene file.
    pub error: &'a dyn Fn(String) -> SceneError,
}

impl Placement<'_> {
    /// The mesh, with a material for each triangle of `geometry`.
    ///
    /// # Errors
    /// When it lies beyond what is traced, when no triangle has an area, or when it lacks the normals that are asked for.
    pub fn mesh(
        &self,
        geometry: Geometry,
        materials: Vec<u32>,
        warnings: &mut Vec<String>,
    ) -> Result<Mesh, SceneError> {
        let mut mesh = Mesh {
            name: self.name.to_owned(),
            vertices: self.placed(&geometry.vertices)?,
            normals: None,
            uvs: geometry.uvs,
            triangles: self.wound(geometry.triangles),
            materials,
        };
        self.tell_count(
            geometry.ignored,
            "ignored points, lines and faces of fewer than 3 vertices",
            warnings,
        );
        self.tell_count(mesh.drop_degenerate(), "dropped triangles without area", warnings);
        if mesh.triangles.is_empty() {
            return Err(file_error(self.path, "empty mesh: no triangle has an area; at least one is needed"));
        }
        mesh.normals = self.shading_normals(&mesh, geometry.normals, warnings)?;
        Ok(mesh)
    }

    fn tell_count(&self, n: usize, what: &str, warnings: &mut Vec<String>) {
        if n > 0 {
            warnings.push(format!("{}: {what}: {n}", self.path.display()));
        }
    }

    fn placed(&self, vertices: &[Vec3]) -> Result<Vec<Vec3>, SceneError> {
        let vertices: Vec<Vec3> = vertices.iter().map(|&p| self.motion.point(p)).collect();
        match vertices.iter().find(|p| !is_traceable(**p)) {
            None => Ok(vertices),
            Some(p) => Err((self.error)(format!(
                "scale, rotate and translate take a vertex to {p}; allowed: coordinates from -1.8e18 to 1.8e18"
            ))),
        }
    }

    /// The triangles, turned over where the motion mirrors, so that their normals are mirrored and not inverted.
    fn wound(&self, mut triangles: Vec<[u32; 3]>) -> Vec<[u32; 3]> {
        if self.motion.mirrors() != self.flip {
            triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
        triangles
    }

    fn shading_normals(
        &self,
        mesh: &Mesh,
        from_file: Option<Vec<Vec3>>,
        warnings: &mut Vec<String>,
    ) -> Result<Option<Vec<Vec3>>, SceneError> {
        match (self.normals, from_file) {
            (Normals::Smooth, _) | (Normals::FileOrSmooth, None) => Ok(Some(smooth_normals(mesh))),
            (Normals::Flat, _) | (Normals::FileOrFlat, None) => Ok(None),
            (_, Some(normals)) => Ok(Some(self.repaired(mesh, &normals, warnings))),
            (Normals::File, None) => {
                let reason = format!("normals = \"file\", but `{}` has none", self.path.display());
                Err((self.error)(format!("{reason}; allowed: `smooth` or `flat`")))
            }
        }
    }

    fn repaired(&self, mesh: &Mesh, normals: &[Vec3], warnings: &mut Vec<String>) -> Vec<Vec3> {
        let sign = if self.flip { -1.0 } else { 1.0 };
        let is_unit = |n: Vec3| (n.as_dvec3().length_squared() - 1.0).abs() < 4.0 * f64::from(f32::EPSILON);
        let stays = |n: Vec3| self.keeps_unit_normals && self.motion.is_identity() && is_unit(n);
        let turn = |n: Vec3| if stays(n) { Some(n) } else { self.motion.normal(n) };
        let turned: Vec<Option<Vec3>> = normals.iter().map(|&n| turn(sign * n)).collect();
        let n_missing = turned.iter().filter(|n| n.is_none()).count();
        if n_missing == 0 {
            return turned.into_iter().flatten().collect();
        }
        self.tell_count(
            n_missing,
            "missing or zero vertex normals replaced by those of the faces around",
            warnings,
        );
        turned.into_iter().zip(smooth_normals(mesh)).map(|(n, smooth)| n.unwrap_or(smooth)).collect()
    }
}

/// Smooth normals, also where texture coordinates part the vertices of one place.
fn smooth_normals(mesh: &Mesh) -> Vec<Vec3> {
    if mesh.uvs.is_none() {
        return mesh.smooth_normals();
    }
    let mut places = BTreeMap::new();
    let mut vertices = Vec::new();
    let mut place = |p: &Vec3| {
        *places.entry((*p + Vec3::ZERO).to_array().map(f32::to_bits)).or_insert_with(|| {
            vertices.push(*p);
            vertices.len() as u32 - 1
        })
    };
    let of_vertex: Vec<u32> = mesh.vertices.iter().map(&mut place).collect();
    let triangles = mesh.triangles.iter().map(|t| t.map(|vertex| of_vertex[vertex as usize])).collect();
    let joined =
        Mesh { name: String::new(), vertices, normals: None, uvs: None, triangles, materials: Vec::new() };
    let normals = joined.smooth_normals();
    of_vertex.into_iter().map(|place| normals[place as usize]).collect()
}

/// Whether Embree traces a vertex there.
pub(super) fn is_traceable(p: Vec3) -> bool {
    f64::from(p.abs().max_element()) <= MAX_COORDINATE && p.is_finite()
}
