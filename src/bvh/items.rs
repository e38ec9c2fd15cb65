//! What the builder moves around: boxes in four lanes, so that every union is two vector instructions.

use crate::math::{Aabb, Vec3};

/// A box as two rows of four lanes, of which the fourth is ballast.
#[derive(Clone, Copy, Debug)]
#[repr(align(16))]
pub(super) struct WideBox {
    min: [f32; 4],
    max: [f32; 4],
}

impl WideBox {
    pub(super) const EMPTY: WideBox = WideBox { min: [f32::INFINITY; 4], max: [f32::NEG_INFINITY; 4] };

    #[inline(always)]
    pub(super) fn union(&self, other: &WideBox) -> WideBox {
        WideBox { min: lanewise_min(self.min, other.min), max: lanewise_max(self.max, other.max) }
    }

    #[inline(always)]
    pub(super) fn with_point(&self, point: [f32; 4]) -> WideBox {
        WideBox { min: lanewise_min(self.min, point), max: lanewise_max(self.max, point) }
    }

    pub(super) fn min(&self) -> [f32; 4] {
        self.min
    }

    /// Edge length along `axis`; negative or NaN where the box is empty.
    pub(super) fn extent(&self, axis: usize) -> f32 {
        self.max[axis] - self.min[axis]
    }

    /// The area of the six faces; 0 where the box is empty.
    #[inline(always)]
    pub(super) fn surface_area(&self) -> f32 {
        let [x, y, z] = [0, 1, 2].map(|axis| self.extent(axis).max(0.0));
        2.0 * (x * y + y * z + z * x)
    }

    pub(super) fn to_aabb(self) -> Aabb {
        Aabb { min: Vec3::from_slice(&self.min), max: Vec3::from_slice(&self.max) }
    }
}

/// A NaN in `b` leaves `a` as it is: the centre of an empty or endless box moves nothing.
#[inline(always)]
fn lanewise_min(a: [f32; 4], b: [f32; 4]) -> [f32; 4] {
    std::array::from_fn(|k| if b[k] < a[k] { b[k] } else { a[k] })
}

#[inline(always)]
fn lanewise_max(a: [f32; 4], b: [f32; 4]) -> [f32; 4] {
    std::array::from_fn(|k| if b[k] > a[k] { b[k] } else { a[k] })
}

/// One input box on its way to its place, with its index in the ballast lane of `max`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item(WideBox);

impl Item {
    pub(super) fn new(bounds: &Aabb, index: u32) -> Item {
        let (min, max) = (bounds.min, bounds.max);
        Item(WideBox { min: [min.x, min.y, min.z, 0.0], max: [max.x, max.y, max.z, f32::from_bits(index)] })
    }

    pub(super) fn index(&self) -> u32 {
        self.0.max[3].to_bits()
    }

    pub(super) fn bounds(&self) -> &WideBox {
        &self.0
    }

    /// Twice the centre of the box: halving would change no comparison.
    pub(super) fn center(&self, axis: usize) -> f32 {
        self.0.min[axis] + self.0.max[axis]
    }

    /// The same along all axes; the fourth lane is ballast.
    #[inline(always)]
    pub(super) fn centers(&self) -> [f32; 4] {
        std::array::from_fn(|k| self.0.min[k] + self.0.max[k])
    }
}

/// The box of some items and the box of their (doubled) centres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    pub(super) bounds: WideBox,
    pub(super) centers: WideBox,
}

impl Extent {
    pub(super) const EMPTY: Extent = Extent { bounds: WideBox::EMPTY, centers: WideBox::EMPTY };

    pub(super) fn of(items: &[Item]) -> Extent {
        items.iter().fold(Extent::EMPTY, |extent, item| extent.with_item(item))
    }

    #[inline(always)]
    pub(super) fn with_item(&self, item: &Item) -> Extent {
        Extent { bounds: self.bounds.union(item.bounds()), centers: self.centers.with_point(item.centers()) }
    }

    #[inline(always)]
    pub(super) fn union(self, other: Extent) -> Extent {
        Extent { bounds: self.bounds.union(&other.bounds), centers: self.centers.union(&other.centers) }
    }
}
