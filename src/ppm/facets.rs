use rayon::prelude::*;

use super::HitPoint;
use crate::math::Vec3;

/// The normals of all hit points in columns, as the lanes of the gathering want them.
#[derive(Clone, Debug, Default)]
pub struct Facets {
    /// Geometric normals, on the side that is seen.
    pub(super) ng: [Vec<f32>; 3],
    /// Shading normals; `None` where they are the geometric ones everywhere.
    pub(super) ns: Option<[Vec<f32>; 3]>,
}

impl Facets {
    /// In the order of the hit points.
    pub fn of(hit_points: &[HitPoint]) -> Facets {
        let smooth = hit_points.par_iter().any(|h| h.receiver.ns != h.receiver.ng);
        Facets {
            ng: columns(hit_points, |h| h.receiver.ng),
            ns: smooth.then(|| columns(hit_points, |h| h.receiver.ns)),
        }
    }

    /// The memory that they hold, in bytes.
    pub fn memory_bytes(&self) -> usize {
        let columns = self.ng.iter().chain(self.ns.iter().flatten());
        columns.map(|column| size_of::<f32>() * column.capacity()).sum()
    }
}

fn columns(hit_points: &[HitPoint], of: impl Fn(&HitPoint) -> Vec3 + Sync) -> [Vec<f32>; 3] {
    [0, 1, 2].map(|axis| hit_points.par_iter().map(|h| of(h)[axis]).collect())
}
