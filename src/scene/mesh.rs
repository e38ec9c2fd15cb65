use crate::math::{DVec3, Vec2, Vec3};

/// An indexed triangle mesh.
///
/// Meshes that come from [`super::load`] hold no triangle without area, no index beyond the vertices and no
/// coordinate beyond ±1.8e18.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// For messages: the mesh file, or `quad N`.
    pub name: String,
    /// Positions in scene units.
    pub vertices: Vec<Vec3>,
    /// One unit shading normal per vertex, or none for a flat look.
    pub normals: Option<Vec<Vec3>>,
    /// Texture coordinates per vertex, if there are any.
    pub uvs: Option<Vec<Vec2>>,
    /// Corners as indices into `vertices`, counter-clockwise seen from the side of the geometric normal.
    pub triangles: Vec<[u32; 3]>,
    /// One index into the scene's materials per triangle.
    pub materials: Vec<u32>,
}

impl Mesh {
    /// Flat triangles of one material.
    pub fn new(name: &str, vertices: Vec<Vec3>, triangles: Vec<[u32; 3]>, material: u32) -> Mesh {
        Mesh {
            name: name.into(),
            vertices,
            normals: None,
            uvs: None,
            materials: vec![material; triangles.len()],
            triangles,
        }
    }

    /// The cube from -1 to 1 with its faces turned inward: the simplest room.
    pub fn inward_cube(name: &str, material: u32) -> Mesh {
        let corner = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 2.0 - 1.0;
        let quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
        let triangles: Vec<[u32; 3]> =
            quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
        Mesh::new(name, (0..8).map(corner).collect(), triangles, material)
    }

    /// The corners of one triangle.
    pub fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.triangles[triangle].map(|i| self.vertices[i as usize])
    }

    /// Drops the triangles that have no area, and tells how many there were.
    pub(super) fn drop_degenerate(&mut self) -> usize {
        let before = self.triangles.len();
        let faces = (0..before).map(|t| (self.triangles[t], self.materials[t]));
        let has_area = |(t, _): &(usize, _)| geometric_normal(self.corners(*t)).is_some();
        let (triangles, materials) = faces.enumerate().filter(has_area).map(|(_, face)| face).unzip();
        (self.triangles, self.materials) = (triangles, materials);
        before - self.triangles.len()
    }

    /// Unit normals per vertex, from the faces around it, each weighted by its angle at the vertex.
    ///
    /// The angle makes the result independent of how a flat polygon was cut into triangles. Where the faces
    /// cancel out, the first of them decides; a vertex of no triangle gets +y, which nothing ever reads.
    pub(super) fn smooth_normals(&self) -> Vec<Vec3> {
        let mut sums = vec![DVec3::ZERO; self.vertices.len()];
        let mut first = vec![Vec3::Y; self.vertices.len()];
        for t in (0..self.triangles.len()).rev() {
            let corners = self.corners(t);
            let Some(normal) = geometric_normal(corners) else { continue };
            for (k, vertex) in self.triangles[t].into_iter().enumerate() {
                sums[vertex as usize] += corner_angle(corners, k) * normal.as_dvec3();
                first[vertex as usize] = normal;
            }
        }
        sums.into_iter().zip(first).map(|(sum, first)| unit_or(sum, first)).collect()
    }
}

/// The unit normal of a triangle by the right-hand rule; none where it has no area.
///
/// ```text
/// n = (b - a) x (c - a) / |(b - a) x (c - a)|
/// ```
/// Computed in f64, so neither tiny nor huge triangles underflow or overflow.
pub(super) fn geometric_normal(corners: [Vec3; 3]) -> Option<Vec3> {
    let [a, b, c] = corners.map(|p| p.as_dvec3());
    let cross = (b - a).cross(c - a);
    let length = cross.length();
    (length > 0.0).then(|| (cross / length).as_vec3())
}

/// The distance of the longest edge from the corner opposite it: twice the area over the edge. 0 without area.
pub fn least_altitude(corners: [Vec3; 3]) -> f32 {
    let [a, b, c] = corners.map(|p| p.as_dvec3());
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    if longest > 0.0 { ((b - a).cross(c - a).length() / longest) as f32 } else { 0.0 }
}

/// `v` at unit length, or `fallback` where it has no direction (zero, or almost zero by cancellation, or NaN).
pub(super) fn unit_or(v: DVec3, fallback: Vec3) -> Vec3 {
    const CANCELLED: f64 = 1e-12;
    let length = v.length();
    if length > CANCELLED && length.is_finite() { (v / length).as_vec3() } else { fallback }
}

fn corner_angle(corners: [Vec3; 3], k: usize) -> f64 {
    let [p, q, r] = [0, 1, 2].map(|i| corners[(k + i) % 3].as_dvec3());
    (q - p).angle_between(r - p)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh(vertices: &[[f32; 3]], triangles: &[[u32; 3]]) -> Mesh {
        Mesh {
            name: String::from("test"),
            vertices: vertices.iter().map(|&v| Vec3::from(v)).collect(),
            normals: None,
            uvs: None,
            triangles: triangles.to_vec(),
            materials: (0..triangles.len() as u32).collect(),
        }
    }

    #[test]
    fn normals_follow_the_right_hand_at_every_scale() {
        for scale in [1e-38, 1e-20, 1.0, 1e18] {
            let corners = [Vec3::ZERO, scale * Vec3::Z, scale * Vec3::X];
            assert_eq!(geometric_normal(corners), Some(Vec3::Y), "{scale}");
        }
        assert_eq!(geometric_normal([Vec3::ZERO, Vec3::ONE, 3.0 * Vec3::ONE]), None);
    }

    #[test]
    fn dropping_keeps_the_materials_in_step() {
        let mut m = mesh(&[[0.; 3], [1., 0., 0.], [0., 1., 0.]], &[[0, 1, 2], [0, 1, 1], [2, 1, 0]]);
        assert_eq!(m.drop_degenerate(), 1);
        assert_eq!((m.triangles, m.materials), (vec![[0, 1, 2], [2, 1, 0]], vec![0, 2]));
    }

    #[test]
    fn a_cube_corner_is_smoothed_evenly_however_its_faces_are_cut() {
        let axes = [[0.; 3], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.], [1., 1., 0.]];
        // The face in the xy plane is cut through the corner, so two triangles of it meet there.
        let m = mesh(&axes, &[[0, 4, 1], [0, 2, 4], [0, 3, 2], [0, 1, 3]]);
        let expected = Vec3::splat(-1.0).normalize();
        assert!((m.smooth_normals()[0] - expected).length() < 1e-6);
    }

    #[test]
    fn cancelling_faces_leave_the_first_ones_normal() {
        let m = mesh(&[[0.; 3], [0., 0., 1.], [1., 0., 0.], [5.; 3]], &[[0, 1, 2], [0, 2, 1]]);
        assert_eq!(m.smooth_normals(), vec![Vec3::Y; 4]);
        let m = mesh(&[[0.; 3], [0., 0., 1.], [1., 0., 0.]], &[[0, 2, 1], [0, 1, 2]]);
        assert_eq!(m.smooth_normals(), vec![Vec3::NEG_Y; 3]);
    }
}
