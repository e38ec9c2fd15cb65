use super::HitPoint;
use crate::math::{DVec3, Rgb};

/// For every pixel, its hit points in the order of the tree, so that pixels can be summed side by side.
///
/// Pixels have places: in the order in which the tree comes to them. Whoever looks at all of them place by place finds
/// their hit points one after the other in memory.
#[derive(Clone, Debug, Default)]
pub(super) struct PixelLists {
    /// The place of each pixel.
    places: Vec<u32>,
    /// The pixel at each place.
    pixels: Vec<u32>,
    /// Where the list of each place begins, and at the end their length together.
    starts: Vec<u32>,
    seen: Vec<Seen>,
}

/// A hit point as its pixel sees it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Seen {
    /// Where its statistics stand: by its position in the tree.
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
        let (places, order) = first_come(hit_points, pixels);
        let place_of = |hit_point: &HitPoint| places[hit_point.pixel as usize] as usize;
        let mut starts = vec![0u32; pixels + 1];
        for hit_point in hit_points {
            starts[place_of(hit_point) + 1] += 1;
        }
        for place in 0..pixels {
            starts[place + 1] += starts[place];
        }
        let (mut next, mut seen) = (starts.clone(), vec![Seen::default(); hit_points.len()]);
        for (position, hit_point) in (0..).zip(hit_points) {
            let free = &mut next[place_of(hit_point)];
            seen[*free as usize] = Seen { position, factor: factor(hit_point) };
            *free += 1;
        }
        PixelLists { places, pixels: order, starts, seen }
    }

    /// Where eye paths are retraced: every pixel keeps statistics of its own radiance, and has its place by the hit points of
    /// the first pass.
    pub(super) fn of_pixels(hit_points: &[HitPoint], pixels: usize) -> PixelLists {
        let (places, order) = first_come(hit_points, pixels);
        let seen = order.iter().map(|&pixel| Seen { position: pixel, factor: Rgb::ONE }).collect();
        PixelLists { places, pixels: order, starts: (0..=pixels as u32).collect(), seen }
    }

    /// The hit points of a pixel.
    pub(super) fn of(&self, pixel: usize) -> &[Seen] {
        let place = self.places[pixel] as usize;
        &self.seen[self.starts[place] as usize..self.starts[place + 1] as usize]
    }

    /// What a pixel sees of the irradiance at its hit points, which stands at their positions.
    pub(super) fn reflected(&self, pixel: usize, irradiance: impl Fn(usize) -> DVec3) -> DVec3 {
        let seen = self.of(pixel).iter();
        seen.map(|seen| seen.factor.as_dvec3() * irradiance(seen.position as usize)).sum()
    }

    /// Pixels of the picture.
    pub(super) fn len(&self) -> usize {
        self.pixels.len()
    }

    /// The place of a pixel.
    pub(super) fn place(&self, pixel: usize) -> usize {
        self.places[pixel] as usize
    }

    /// The pixel at a place.
    pub(super) fn pixel(&self, place: usize) -> usize {
        self.pixels[place] as usize
    }

    /// Heap memory, in bytes.
    pub(super) fn memory_bytes(&self) -> usize {
        let indices = size_of_val(&*self.places) + size_of_val(&*self.pixels) + size_of_val(&*self.starts);
        indices + size_of_val(&*self.seen)
    }
}

/// The place of each pixel and the pixel at each place; those without a hit point come last.
fn first_come(hit_points: &[HitPoint], pixels: usize) -> (Vec<u32>, Vec<u32>) {
    let (mut places, mut order) = (vec![u32::MAX; pixels], Vec::with_capacity(pixels));
    for pixel in hit_points.iter().map(|hit_point| hit_point.pixel).chain(0..pixels as u32) {
        let place = &mut places[pixel as usize];
        if *place == u32::MAX {
            *place = order.len() as u32;
            order.push(pixel);
        }
    }
    (places, order)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::Coat;
    use crate::math::Vec3;
    use crate::scene::Receiver;

    #[test]
    fn every_hit_point_is_found_at_its_pixel_in_order() {
        let receiver = Receiver { p: Vec3::ZERO, p_error: 0.0, ng: Vec3::Y, ns: Vec3::Y, coat: Coat::NONE };
        let at = |pixel| HitPoint { receiver, reflectance: Rgb::ONE, pixel, footprint: 0.0 };
        let lists = PixelLists::new(&[3, 0, 3, 2, 0, 3].map(at), 5, |h| Rgb::splat(h.pixel as f32));
        let found = |pixel| lists.of(pixel).iter().map(|seen| seen.position).collect();
        let found: Vec<Vec<u32>> = (0..5).map(found).collect();
        assert_eq!(found, [vec![1, 4], vec![], vec![3], vec![0, 2, 5], vec![]]);
        assert_eq!(lists.of(2)[0].factor, Rgb::splat(2.0));
        let places: Vec<usize> = (0..5).map(|place| lists.pixel(place)).collect();
        assert_eq!(places, [3, 0, 2, 1, 4]);
        assert!((0..5).all(|place| lists.place(lists.pixel(place)) == place));
        assert!(PixelLists::new(&[], 2, |_| Rgb::ONE).of(1).is_empty());
    }
}
