use crate::scene::load::geometry::Geometry;

/// What an OBJ file holds, cut into triangles.
#[derive(Clone, Debug)]
pub(in super::super) struct Obj {
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
pub(in super::super) struct Keep {
    pub normals: bool,
    /// Texture coordinates.
    pub uvs: bool,
}
