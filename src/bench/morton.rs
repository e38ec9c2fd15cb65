//! The Morton curve: neighbours on it are near each other in space.

use rayon::prelude::*;

use crate::math::{Aabb, Vec3};

/// Bits of each coordinate.
const BITS: u32 = 20;

/// Sorts points along the Morton curve through their box.
pub fn sort(points: &mut [Vec3]) {
    let bounds = Aabb::of_points(points.iter().copied());
    let scale = ((1u32 << BITS) - 1) as f32 / bounds.extent().max_element().max(f32::MIN_POSITIVE);
    let mut keyed: Vec<(u64, Vec3)> =
        points.par_iter().map(|&p| (code(((p - bounds.min) * scale).to_array()), p)).collect();
    keyed.par_sort_by_key(|&(key, _)| key);
    points.par_iter_mut().zip(&keyed).for_each(|(point, &(_, sorted))| *point = sorted);
}

/// The bits of three coordinates, interleaved from the highest down: x above y above z.
fn code(coordinates: [f32; 3]) -> u64 {
    let [x, y, z] = coordinates.map(|c| spread(c as u64));
    x << 2 | y << 1 | z
}

/// Puts two zeros before each of the lowest 21 bits.
fn spread(x: u64) -> u64 {
    let x = (x | x << 32) & 0x001f_0000_0000_ffff;
    let x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    let x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    let x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn bits_stand_three_apart(x in 0u64..1 << BITS) {
            let naive = (0..BITS).fold(0, |sum, bit| sum | (x >> bit & 1) << (3 * bit));
            prop_assert_eq!(spread(x), naive);
        }
    }

    #[test]
    fn octants_follow_each_other() {
        let corner = |k: u32| Vec3::new((k >> 2 & 1) as f32, (k >> 1 & 1) as f32, (k & 1) as f32);
        let mut points: Vec<Vec3> = (0..8).rev().map(corner).collect();
        sort(&mut points);
        assert_eq!(points, (0..8).map(corner).collect::<Vec<_>>());
        sort(&mut []);
    }
}
