//! What a ray's tests against boxes and triangles share, worked out once for each ray.

use crate::math::{RELATIVE_POSITION_ERROR, Ray, Vec3, Vec4};

/// A ray whose parameter is also counted as `s = t |dir[k]|`: the distance along its dominant axis `k`.
///
/// In this unit every component of the direction is at most 1, so lengths of directions neither over- nor underflow.
#[derive(Clone, Debug)]
pub(super) struct PreparedRay {
    pub ray: Ray,
    /// `|dir[k]|`, which turns `t` into `s`.
    pub dominant: f32,
    pub shear: Shear,
    pub slabs: Slabs,
}

/// The transformation that turns a ray into the z axis: axes change places, then x and y are sheared along z.
///
/// # Source
/// Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013, section 3.1.
#[derive(Clone, Debug)]
pub(super) struct Shear {
    /// The axes of space that become x, y and z.
    pub axes: [usize; 3],
    pub origin: [Vec4; 3],
    pub x: Vec4,
    pub y: Vec4,
    /// -1 where the ray runs down its dominant axis.
    pub sign: f64,
}

/// The ray's side of the slab test, widened against all rounding.
///
/// The test of a triangle rounds its corners relative to their distance from the origin, so a ray may hit it
/// although the exact ray passes its box by as much. Boxes therefore appear larger than they are, by the
/// position error of the farthest coordinate in play; that covers the slab test's own rounding too.
///
/// # Source
/// Woop et al. 2013, section 3.3; Ize, "Robust BVH Ray Traversal", JCGT 2(2), 2013.
#[derive(Clone, Debug)]
pub(super) struct Slabs {
    /// For each axis: 0 where the ray enters a box through its lower plane, 1 through its upper.
    pub entry: [usize; 3],
    pub near_origin: [Vec4; 3],
    pub far_origin: [Vec4; 3],
    pub inverse: [Vec4; 3],
}

impl PreparedRay {
    /// None for what is no ray: an origin or direction that is not finite, no direction, no length.
    ///
    /// `extent` is the largest absolute coordinate of the scene.
    pub fn new(ray: &Ray, extent: f32) -> Option<PreparedRay> {
        let axis = dominant_axis(ray.dir);
        let dominant = ray.dir[axis].abs();
        let is_ray = ray.origin.is_finite() && ray.dir.is_finite() && dominant > 0.0 && ray.t_max > 0.0;
        is_ray.then(|| PreparedRay {
            ray: *ray,
            dominant,
            shear: Shear::new(ray, axis),
            slabs: Slabs::new(ray, dominant, extent),
        })
    }

    /// The parameter `t` of a distance along the dominant axis.
    pub fn t_of(&self, s: f64) -> f32 {
        (s / f64::from(self.dominant)) as f32
    }
}

fn dominant_axis(dir: Vec3) -> usize {
    let d = dir.abs();
    if d.x >= d.y && d.x >= d.z {
        0
    } else if d.y >= d.z {
        1
    } else {
        2
    }
}

impl Shear {
    fn new(ray: &Ray, z: usize) -> Shear {
        let axes = [(z + 1) % 3, (z + 2) % 3, z];
        Shear {
            axes,
            origin: axes.map(|axis| Vec4::splat(ray.origin[axis])),
            x: Vec4::splat(ray.dir[axes[0]] / ray.dir[z]),
            y: Vec4::splat(ray.dir[axes[1]] / ray.dir[z]),
            sign: f64::from(1f32.copysign(ray.dir[z])),
        }
    }
}

/// Directions that are flatter than this count as this steep: over the whole scene that moves them by far less than
/// boxes are widened by, and no reciprocal is infinite.
const FLATTEST: f32 = 1.0 / (1u64 << 60) as f32;

impl Slabs {
    fn new(ray: &Ray, dominant: f32, extent: f32) -> Slabs {
        let margin = RELATIVE_POSITION_ERROR * extent.max(ray.origin.abs().max_element());
        let dir = (ray.dir / dominant).to_array();
        let (origin, inverse) = (ray.origin.to_array(), dir.map(|d| 1.0 / d.abs().max(FLATTEST).copysign(d)));
        let shifted =
            |by: f32| std::array::from_fn(|axis| Vec4::splat(origin[axis] + by * 1f32.copysign(dir[axis])));
        Slabs {
            entry: dir.map(|d| usize::from(d.is_sign_negative())),
            near_origin: shifted(margin),
            far_origin: shifted(-margin),
            inverse: inverse.map(Vec4::splat),
        }
    }
}
