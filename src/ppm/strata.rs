use crate::math::{Rng, Vec2};

/// Strata of equal size and nearly equal sides, as many as there are samples, that tile a pixel.
pub(super) struct Strata {
    columns: u32,
    rows: u32,
}

impl Strata {
    /// A prime number makes a single column.
    pub fn new(samples: u32) -> Strata {
        let columns = (1..=samples.isqrt()).rev().find(|c| samples.is_multiple_of(*c)).unwrap_or(1);
        Strata { columns, rows: samples / columns }
    }

    /// A random position in each of them.
    pub fn positions(&self, rng: &mut Rng) -> impl Iterator<Item = Vec2> {
        let strata = Vec2::new(self.columns as f32, self.rows as f32);
        let corners = (0..self.rows).flat_map(|y| (0..self.columns).map(move |x| (x, y)));
        corners.map(move |(x, y)| (Vec2::new(x as f32, y as f32) + rng.next_vec2()) / strata)
    }

    /// The same in any order, so that what is drawn from other strata has nothing to do with it.
    pub fn shuffled_positions(&self, rng: &mut Rng) -> Vec<Vec2> {
        let mut positions: Vec<Vec2> = self.positions(rng).collect();
        for last in (1..positions.len()).rev() {
            let chosen = (u64::from(rng.next_u32()) * (last as u64 + 1)) >> 32;
            positions.swap(last, chosen as usize);
        }
        positions
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Stream;
    use std::collections::BTreeSet;

    #[test]
    fn strata_tile_the_pixel() {
        for samples in [1u32, 2, 3, 4, 6, 16, 17] {
            let mut rng = Rng::new(0, Stream::Test, 0, 0);
            let positions: Vec<Vec2> = Strata::new(samples).positions(&mut rng).collect();
            assert_eq!(positions.len(), samples as usize);
            let mean: Vec2 = positions.iter().sum::<Vec2>() / samples as f32;
            let spread = 0.5 / (samples as f32).sqrt() + 1e-6;
            assert!((mean - 0.5).abs().min_element() <= spread, "{samples} samples: {mean}");
            let corner = positions[samples as usize - 1];
            assert!(corner.max_element() < 1.0 && corner.y >= 1.0 - 1.0 / (samples as f32).sqrt() - 1e-6);
        }
    }

    #[test]
    fn shuffled_strata_are_all_there_in_another_order() {
        let strata = Strata::new(12);
        let stratum = |p: &Vec2| (p.y * 4.0) as usize * 3 + (p.x * 3.0) as usize;
        let mut orders = BTreeSet::new();
        for index in 0..50 {
            let positions = strata.shuffled_positions(&mut Rng::new(0, Stream::Test, 0, index));
            let mut order: Vec<usize> = positions.iter().map(stratum).collect();
            orders.insert(order.clone());
            order.sort_unstable();
            assert!(order.into_iter().eq(0..12));
        }
        assert!(orders.len() == 50, "{} orders", orders.len());
    }
}
