//! Hit points as the eye pass leaves them, tile after tile.

use rayon::prelude::*;

use super::HitPoint;
use crate::bvh::{Sphere, SphereBvh};

/// So many indices share an entry of the table that says in which tile to look.
const BLOCK: usize = 256;

/// The hit points of all tiles, counted through from the first of the first tile.
///
/// They stay where each tile put them: joining them would cost as much as a third of the eye pass.
#[derive(Clone, Debug, Default)]
pub struct HitPoints {
    tiles: Vec<Vec<HitPoint>>,
    /// The index of the first hit point of each tile, and at the end their number.
    starts: Vec<usize>,
    /// The tile that the first index of each block is in.
    blocks: Vec<u32>,
}

impl HitPoints {
    /// Those of `tiles`, some of which may be empty.
    pub fn new(tiles: Vec<Vec<HitPoint>>) -> HitPoints {
        let (mut starts, mut blocks, mut end) = (vec![0], Vec::new(), 0);
        for (tile, number) in tiles.iter().zip(0..) {
            end += tile.len();
            starts.push(end);
            blocks.resize(end.div_ceil(BLOCK), number);
        }
        HitPoints { tiles, starts, blocks }
    }

    /// Their number.
    pub fn len(&self) -> usize {
        self.tiles.iter().map(Vec::len).sum()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// All of them, in order.
    pub fn iter(&self) -> impl Iterator<Item = &HitPoint> {
        self.tiles.iter().flatten()
    }

    /// Number `index`.
    ///
    /// # Panics
    /// Where there are not so many.
    pub fn get(&self, index: usize) -> &HitPoint {
        let mut tile = self.blocks[index / BLOCK] as usize;
        while self.starts[tile + 1] <= index {
            tile += 1;
        }
        &self.tiles[tile][index - self.starts[tile]]
    }

    /// `of` every hit point, in order; made in parallel.
    pub fn map<T: Send>(&self, of: impl Fn(&HitPoint) -> T + Sync + Send) -> Vec<T> {
        (0..self.len()).into_par_iter().map(|index| of(self.get(index))).collect()
    }

    /// The tree over spheres of the given radii, the hit points in its order, and their indices before.
    pub(super) fn tree(
        &self,
        radius: impl Fn(&HitPoint) -> f32 + Sync + Send,
    ) -> (SphereBvh, Vec<HitPoint>, Vec<u32>) {
        let spheres = self.map(|h| Sphere { center: h.receiver.p, radius: radius(h) });
        let (tree, order) = SphereBvh::build(&spheres);
        let ordered = order.par_iter().map(|&index| *self.get(index as usize)).collect();
        (tree, ordered, order)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::Coat;
    use crate::math::{Rgb, Vec3};
    use crate::scene::Receiver;
    use proptest::prelude::*;

    fn numbered(pixel: u32) -> HitPoint {
        let receiver = Receiver { p: Vec3::ZERO, p_error: 0.0, ng: Vec3::Y, ns: Vec3::Y, coat: Coat::NONE };
        HitPoint { receiver, reflectance: Rgb::ONE, pixel, footprint: 0.0 }
    }

    proptest! {
        #[test]
        fn every_index_finds_its_hit_point(sizes in prop::collection::vec(prop_oneof![Just(0u32), 0u32..9, 200u32..900], 0..20)) {
            let mut end = 0;
            let tile = |size: &u32| {
                end += size;
                (end - size..end).map(numbered).collect()
            };
            let hit_points = HitPoints::new(sizes.iter().map(tile).collect());
            prop_assert_eq!((hit_points.len(), hit_points.is_empty()), (end as usize, end == 0));
            prop_assert!((0..end).all(|index| hit_points.get(index as usize).pixel == index));
            prop_assert!(hit_points.map(|h| h.pixel).into_iter().eq(0..end));
            prop_assert!(hit_points.iter().map(|h| h.pixel).eq(0..end));
        }
    }
}
