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

/// What is built over, on its way to its place.
pub(super) trait Item: Copy + Send + Sync {
    /// What some items span.
    type Extent: Copy + Send + Sync;
    /// What all items of a tree have in common.
    type Shared: Copy + Send + Sync;
    /// The extent of no items.
    const NOTHING: Self::Extent;

    /// The number of the item in the builder's input.
    fn index(&self) -> u32;

    /// The centre, up to a factor that is the same for all.
    fn center(&self, axis: usize) -> f32;

    /// The extent with this item added.
    fn join(&self, extent: &Self::Extent) -> Self::Extent;

    fn union(a: &Self::Extent, b: &Self::Extent) -> Self::Extent;

    /// The box of the centres.
    fn centers(extent: &Self::Extent) -> &WideBox;

    /// The box of the items.
    fn bounds(extent: &Self::Extent, shared: Self::Shared) -> WideBox;

    fn extent_of(items: &[Self]) -> Self::Extent {
        items.iter().fold(Self::NOTHING, |extent, item| item.join(&extent))
    }
}

/// Any box, with its index in the ballast lane of `max`.
#[derive(Clone, Copy, Debug)]
pub(super) struct BoxItem(WideBox);

impl BoxItem {
    pub(super) fn new(bounds: &Aabb, index: u32) -> BoxItem {
        let (min, max) = (bounds.min, bounds.max);
        let max = [max.x, max.y, max.z, f32::from_bits(index)];
        BoxItem(WideBox { min: [min.x, min.y, min.z, 0.0], max })
    }
}

/// The box of some boxes and the box of their (doubled) centres.
#[derive(Clone, Copy, Debug)]
pub(super) struct BoxExtent {
    bounds: WideBox,
    centers: WideBox,
}

impl Item for BoxItem {
    type Extent = BoxExtent;
    type Shared = ();
    const NOTHING: BoxExtent = BoxExtent { bounds: WideBox::EMPTY, centers: WideBox::EMPTY };

    fn index(&self) -> u32 {
        self.0.max[3].to_bits()
    }

    /// Twice the centre of the box: halving would change no comparison.
    #[inline(always)]
    fn center(&self, axis: usize) -> f32 {
        self.0.min[axis] + self.0.max[axis]
    }

    #[inline(always)]
    fn join(&self, extent: &BoxExtent) -> BoxExtent {
        let center = std::array::from_fn(|k| self.0.min[k] + self.0.max[k]);
        BoxExtent { bounds: extent.bounds.union(&self.0), centers: extent.centers.with_point(center) }
    }

    #[inline(always)]
    fn union(a: &BoxExtent, b: &BoxExtent) -> BoxExtent {
        BoxExtent { bounds: a.bounds.union(&b.bounds), centers: a.centers.union(&b.centers) }
    }

    fn centers(extent: &BoxExtent) -> &WideBox {
        &extent.centers
    }

    fn bounds(extent: &BoxExtent, (): ()) -> WideBox {
        extent.bounds
    }
}

/// The centre of a cube as large as all others, with its index in the fourth lane: half the bytes of a box, and the
/// box of some is that of their centres, widened by what they share, half their side.
#[derive(Clone, Copy, Debug)]
#[repr(align(16))]
pub(super) struct CubeItem([f32; 4]);

impl CubeItem {
    pub(super) fn new(center: Vec3, index: u32) -> CubeItem {
        CubeItem([center.x, center.y, center.z, f32::from_bits(index)])
    }
}

impl Item for CubeItem {
    type Extent = WideBox;
    type Shared = f32;
    const NOTHING: WideBox = WideBox::EMPTY;

    fn index(&self) -> u32 {
        self.0[3].to_bits()
    }

    #[inline(always)]
    fn center(&self, axis: usize) -> f32 {
        self.0[axis]
    }

    #[inline(always)]
    fn join(&self, extent: &WideBox) -> WideBox {
        extent.with_point(self.0)
    }

    #[inline(always)]
    fn union(a: &WideBox, b: &WideBox) -> WideBox {
        a.union(b)
    }

    fn centers(extent: &WideBox) -> &WideBox {
        extent
    }

    #[inline(always)]
    fn bounds(extent: &WideBox, half_side: f32) -> WideBox {
        WideBox { min: extent.min.map(|x| x - half_side), max: extent.max.map(|x| x + half_side) }
    }
}
