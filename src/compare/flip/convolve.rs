use crate::math::Vec4;
use rayon::prelude::*;

/// A picture of four numbers a pixel, row by row.
pub(super) struct Plane {
    pub(super) width: usize,
    pub(super) pixels: Vec<Vec4>,
}

/// Convolves each component of a plane by its own separable kernel, `along_x[i] · along_y[j]` at `(i - r, j - r)`.
///
/// Kernels have `2r + 1` weights; beyond its edge the plane goes on with the values at the edge.
pub(super) fn convolve(plane: &Plane, along_x: &[Vec4], along_y: &[Vec4]) -> Plane {
    let width = plane.width;
    let rows: Vec<Vec<Vec4>> = plane.pixels.par_chunks(width).map(|row| convolve_row(row, along_x)).collect();
    let mut pixels = vec![Vec4::ZERO; plane.pixels.len()];
    pixels.par_chunks_mut(width).enumerate().for_each(|(y, sums)| {
        for (row, &weight) in clamped_window(rows.len(), y, along_y.len()).zip(along_y) {
            sums.iter_mut().zip(&rows[row]).for_each(|(sum, &value)| *sum += weight * value);
        }
    });
    Plane { width, pixels }
}

fn convolve_row(row: &[Vec4], kernel: &[Vec4]) -> Vec<Vec4> {
    let radius = kernel.len() / 2;
    let mut extended = vec![row[0]; radius];
    extended.extend_from_slice(row);
    extended.resize(row.len() + 2 * radius, row[row.len() - 1]);
    let weigh = |window: &[Vec4]| window.iter().zip(kernel).map(|(&value, &weight)| value * weight).sum();
    extended.windows(kernel.len()).map(weigh).collect()
}

/// The indices from `centre - length / 2` on, those outside `0..n` moved to the nearest inside.
fn clamped_window(n: usize, centre: usize, length: usize) -> impl Iterator<Item = usize> {
    (0..length).map(move |offset| (centre + offset).saturating_sub(length / 2).min(n - 1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn naive(plane: &Plane, along_x: &[Vec4], along_y: &[Vec4], x: usize, y: usize) -> Vec4 {
        let height = plane.pixels.len() / plane.width;
        let radius = (along_x.len() / 2) as isize;
        let clamp = |at: usize, offset: usize, n: usize| {
            (at as isize + offset as isize - radius).clamp(0, n as isize - 1) as usize
        };
        let mut sum = Vec4::ZERO;
        for (j, &weight_y) in along_y.iter().enumerate() {
            for (i, &weight_x) in along_x.iter().enumerate() {
                let (x, y) = (clamp(x, i, plane.width), clamp(y, j, height));
                sum += weight_x * weight_y * plane.pixels[y * plane.width + x];
            }
        }
        sum
    }

    fn whole_vectors(n: usize) -> impl Strategy<Value = Vec<Vec4>> {
        // Small whole numbers, so that sums are exact in any order.
        prop::collection::vec(prop::array::uniform4(-9i8..9).prop_map(|a| Vec4::from(a.map(f32::from))), n)
    }

    proptest! {
        #[test]
        fn it_is_the_sum_over_the_whole_kernel(
            (width, pixels) in (1usize..7, 1usize..6).prop_flat_map(|(w, h)| (Just(w), whole_vectors(w * h))),
            (along_x, along_y) in (0usize..4).prop_flat_map(|r| (whole_vectors(2 * r + 1), whole_vectors(2 * r + 1))),
        ) {
            let plane = Plane { width, pixels };
            let sums = convolve(&plane, &along_x, &along_y);
            for (index, &sum) in sums.pixels.iter().enumerate() {
                prop_assert_eq!(sum, naive(&plane, &along_x, &along_y, index % width, index / width));
            }
        }
    }
}
