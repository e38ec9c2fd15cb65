use super::HitPoint;

/// For every pixel, the positions of its hit points in increasing order, so that pixels can be summed side by side.
#[derive(Clone, Debug, Default)]
pub(super) struct PixelLists {
    /// Where the list of each pixel begins, and at the end their length together.
    starts: Vec<u32>,
    positions: Vec<u32>,
}

impl PixelLists {
    /// Of a picture of `pixels` pixels.
    pub(super) fn new(hit_points: &[HitPoint], pixels: usize) -> PixelLists {
        let mut starts = vec![0u32; pixels + 1];
        for hit_point in hit_points {
            starts[hit_point.pixel as usize + 1] += 1;
        }
        for pixel in 0..pixels {
            starts[pixel + 1] += starts[pixel];
        }
        let (mut next, mut positions) = (starts.clone(), vec![0; hit_points.len()]);
        for (position, hit_point) in (0..).zip(hit_points) {
            let place = &mut next[hit_point.pixel as usize];
            positions[*place as usize] = position;
            *place += 1;
        }
        PixelLists { starts, positions }
    }

    /// The positions of the hit points of a pixel.
    pub(super) fn of(&self, pixel: usize) -> impl Iterator<Item = usize> {
        let list = self.starts[pixel] as usize..self.starts[pixel + 1] as usize;
        self.positions[list].iter().map(|&position| position as usize)
    }

    /// Heap memory, in bytes.
    pub(super) fn memory_bytes(&self) -> usize {
        size_of_val(&*self.starts) + size_of_val(&*self.positions)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Rgb, Vec3};
    use crate::scene::Receiver;

    #[test]
    fn every_hit_point_is_found_at_its_pixel_in_order() {
        let receiver = Receiver { p: Vec3::ZERO, p_error: 0.0, ng: Vec3::Y, ns: Vec3::Y };
        let at = |pixel| HitPoint { receiver, weight: Rgb::ONE, pixel, material: 0, footprint: 0.0 };
        let lists = PixelLists::new(&[3, 0, 3, 2, 0, 3].map(at), 5);
        let found: Vec<Vec<usize>> = (0..5).map(|pixel| lists.of(pixel).collect()).collect();
        assert_eq!(found, [vec![1, 4], vec![], vec![3], vec![0, 2, 5], vec![]]);
        assert_eq!(PixelLists::new(&[], 2).of(1).count(), 0);
    }
}
