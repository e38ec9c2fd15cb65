//! Four triangles that are tested together.

use super::prepared_ray::{PreparedRay, Shear};
use super::primitive::PrimitiveId;
use crate::math::{Vec3, Vec4};

/// The triangles of a leaf, one a lane. Lanes without a triangle hold NaN, which no ray meets.
#[derive(Clone, Debug)]
pub(super) struct TriangleBlock {
    /// By corner and axis.
    corners: [[Vec4; 3]; 3],
    ids: [PrimitiveId; 4],
}

/// Where a ray's line meets a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Meeting {
    pub t: f32,
    /// The weight of the second corner.
    pub u: f32,
    /// The weight of the third corner.
    pub v: f32,
    pub lane: usize,
}

impl TriangleBlock {
    pub const EMPTY: TriangleBlock =
        TriangleBlock { corners: [[Vec4::NAN; 3]; 3], ids: [PrimitiveId::NONE; 4] };

    pub fn set(&mut self, lane: usize, corners: [Vec3; 3], id: PrimitiveId) {
        for (rows, corner) in self.corners.iter_mut().zip(corners) {
            for (row, x) in rows.iter_mut().zip(corner.to_array()) {
                row[lane] = x;
            }
        }
        self.ids[lane] = id;
    }

    pub fn id(&self, lane: usize) -> PrimitiveId {
        self.ids[lane]
    }

    /// `(b - a) x (c - a)`.
    pub fn normal(&self, lane: usize) -> Vec3 {
        let [a, b, c] = self.corners.map(|rows| Vec3::from_array(rows.map(|row| row[lane])));
        (b - a).cross(c - a)
    }

    /// Calls `visit` for every triangle that the ray's line meets, behind its origin too.
    #[inline(always)]
    pub fn for_each_meeting(&self, ray: &PreparedRay, mut visit: impl FnMut(Meeting)) {
        let sheared = Sheared::new(&self.corners, &ray.shear);
        let mut lanes = sheared.candidates();
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            lanes &= lanes - 1;
            if let Some(meeting) = sheared.meeting(lane, ray) {
                visit(meeting);
            }
        }
    }
}

/// The corners of four triangles where the ray is the z axis: by coordinate and corner.
///
/// A corner depends on nothing but itself and the ray, so triangles that share an edge see the same one.
struct Sheared {
    x: [Vec4; 3],
    y: [Vec4; 3],
    z: [Vec4; 3],
}

impl Sheared {
    #[inline(always)]
    fn new(corners: &[[Vec4; 3]; 3], shear: &Shear) -> Sheared {
        let along = |k: usize| {
            let (axis, origin) = (shear.axes[k], shear.origin[k]);
            [0, 1, 2].map(|corner| corners[corner][axis] - origin)
        };
        let (x, y, z) = (along(0), along(1), along(2));
        Sheared {
            x: [0, 1, 2].map(|k| x[k] - shear.x * z[k]),
            y: [0, 1, 2].map(|k| y[k] - shear.y * z[k]),
            z,
        }
    }

    /// Bits of the lanes on which the z axis is on no edge's outer side.
    ///
    /// Rounding keeps the order of two products, so it turns no sign around: it may only leave a zero, which is
    /// on either side here.
    #[inline(always)]
    fn candidates(&self) -> u32 {
        let edge = |i: usize, j: usize| self.x[i] * self.y[j] - self.y[i] * self.x[j];
        let edges = [edge(2, 1), edge(0, 2), edge(1, 0)];
        let least = edges[0].min(edges[1]).min(edges[2]);
        let most = edges[0].max(edges[1]).max(edges[2]);
        let inside = least.cmpge(Vec4::ZERO) | most.cmple(Vec4::ZERO);
        inside.bitmask()
    }

    /// The verdict on one lane. In f64 the products of f32 are exact, so the signs of the edges are.
    ///
    /// # Source
    /// Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013.
    #[inline(always)]
    fn meeting(&self, lane: usize, ray: &PreparedRay) -> Option<Meeting> {
        let of = |row: &[Vec4; 3]| row.map(|corners| f64::from(corners[lane]));
        let (x, y, z) = (of(&self.x), of(&self.y), of(&self.z));
        let edge = |i: usize, j: usize| x[i] * y[j] - y[i] * x[j];
        let weights = [edge(2, 1), edge(0, 2), edge(1, 0)];
        let area = weights[0] + weights[1] + weights[2];
        let outside = weights.iter().any(|&w| w < 0.0) && weights.iter().any(|&w| w > 0.0);
        if outside || area == 0.0 || area.is_nan() {
            return None;
        }
        let [a, b, c] = weights.map(|w| w / area);
        let s = ray.shear.sign * (a * z[0] + b * z[1] + c * z[2]);
        Some(Meeting { t: ray.t_of(s), u: b as f32, v: c as f32, lane })
    }
}
