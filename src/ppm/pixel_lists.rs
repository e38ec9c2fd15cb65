use super::HitPoint;
use crate::math::Rgb;

/// For every pixel, its hit points in the order of the tree, so that pixels can be summed side by side.
#[derive(Clone, Debug, Default)]
pub(super) struct PixelLists {
    /// Where the list of each pixel begins, and at the end their length together.
    starts: Vec<u32>,
    seen: Vec<Seen>,
}

/// A hit point as its pixel sees it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Seen {
    /// Its position in the tree.
    pub(super) position: u32,
    /// The factor from its irradiance to the radiance of the pixel: `weight · albedo / π`.
    pub(super) factor: Rgb,
}

impl PixelLists {
    /// Of a picture of `pixels` pixels.
    pub(super) fn new(
        hit_points: &[HitPoint],
        pixels: usize,
        factor: impl Fn(&HitPoint) -> Rgb,
    ) -> PixelLists {
        let mut starts = vec![0u32; pixels + 1];
        for hit_point in hit_points {
            starts[hit_point.pixel as usize + 1] += 1;
        }
        for pixel in 0..pixels {
            starts[pixel + 1] += starts[pixel];
        }
        let (mut next, mut seen) = (starts.clone(), vec![Seen::default(); hit_points.len()]);
        for (position, hit_point) in (0..).zip(hit_points) {
            let place = &mut next[hit_point.pixel as usize];
            seen[*place as usize] = Seen { position, factor: factor(hit_point) };
            *place += 1;
        }
        PixelLists { starts, seen }
    }

    /// The hit points of a pixel.
    pub(super) fn of(&self, pixel: usize) -> &[Seen] {
        &self.seen[self.starts[pixel] as usize..self.starts[pixel + 1] as usize]
    }

    /// Heap memory, in bytes.
    pub(super) fn memory_bytes(&self) -> usize {
        size_of_val(&*self.starts) + size_of_val(&*self.seen)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::scene::Receiver;

    #[test]
    fn every_hit_point_is_found_at_its_pixel_in_order() {
        let receiver = Receiver { p: Vec3::ZERO, p_error: 0.0, ng: Vec3::Y, ns: Vec3::Y };
        let at = |pixel| HitPoint { receiver, weight: Rgb::ONE, pixel, material: 0, footprint: 0.0 };
        let lists = PixelLists::new(&[3, 0, 3, 2, 0, 3].map(at), 5, |h| Rgb::splat(h.pixel as f32));
        let found = |pixel| lists.of(pixel).iter().map(|seen| seen.position).collect();
        let found: Vec<Vec<u32>> = (0..5).map(found).collect();
        assert_eq!(found, [vec![1, 4], vec![], vec![3], vec![0, 2, 5], vec![]]);
        assert_eq!(lists.of(2)[0].factor, Rgb::splat(2.0));
        assert!(PixelLists::new(&[], 2, |_| Rgb::ONE).of(1).is_empty());
    }
}
