use super::choice::place;
use super::guide_tree::GuideTree;
use super::start::{Numbers, Start, start};
use crate::math::UNIT;

/// The largest number below 1 that [`Numbers`] know.
const LAST: f32 = 1.0 - UNIT;

/// Photons guided to what is seen: a density of the numbers that emissions are drawn by, constant in each cell of a partition of their
/// cube. Natural photons have the density 1 there, whatever the lights are; so a guided one carries `1 / q` of their power, and
/// nothing else about it changes.
///
/// # Source
/// That photons are sent where paths arrive at what is seen: Hachisuka and Jensen, "Robust Adaptive Photon Tracing Using Photon Path
/// Visibility", TOG 30(5), 2011. That they are by a piecewise constant density over the numbers behind: own.
#[derive(Clone, Debug)]
pub struct Guide {
    tree: GuideTree,
    /// Running sums of the cells' probabilities, up to 1.
    cumulative: Vec<f64>,
    /// `1 / q` of each cell.
    weights: Vec<f32>,
}

impl Guide {
    /// Photons of which the part `share` in `[0, 1)` goes where `tree` says, and the rest wherever light goes:
    /// `q = (1 - share) + share · q_tree`.
    ///
    /// So `q` is nowhere less than `1 - share`, and no photon carries more than `1 / (1 - share)` of its natural power.
    pub(crate) fn new(tree: GuideTree, share: f64) -> Guide {
        let volumes: Vec<f64> = tree.volumes().collect();
        let probability = |(volume, density): (&f64, &f64)| volume * ((1.0 - share) + share * density);
        let probabilities: Vec<f64> = volumes.iter().zip(tree.densities()).map(probability).collect();
        let all: f64 = probabilities.iter().sum();
        let mut sum = 0.0;
        let running = |p: &f64| {
            sum += p;
            sum / all
        };
        let cumulative: Vec<f64> = probabilities.iter().map(running).collect();
        let weights = volumes.iter().zip(&probabilities).map(|(v, p)| (v * all / p) as f32).collect();
        Guide { tree, cumulative, weights }
    }

    /// The cell that `u` in `[0, 1)` chooses.
    pub fn cell(&self, u: f64) -> usize {
        place(&self.cumulative, u)
    }

    /// What an emission from this cell carries, in parts of a natural one: `1 / q`.
    pub fn weight(&self, cell: usize) -> f32 {
        self.weights[cell]
    }

    /// Moves the numbers of a natural emission into a cell.
    pub fn warp(&self, cell: usize, numbers: Numbers) -> Numbers {
        let (low, high) = self.tree.cell(cell);
        let at = |axis: usize, u: f64| low[axis] + (high[axis] - low[axis]) * u;
        let [_, a, b, c, d, _] = numbers;
        let rest = |axis: usize, u: f32| (at(axis, u.into()) as f32).min(LAST);
        let [coarse, fine] = halves(at(0, start(numbers)[0]));
        [coarse, rest(1, a), rest(2, b), rest(3, c), rest(4, d), fine]
    }

    /// `q` of a start.
    pub fn density(&self, start: &Start) -> f64 {
        1.0 / f64::from(self.weights[self.tree.find(start)])
    }

    /// How many cells there are.
    pub fn cells(&self) -> usize {
        self.weights.len()
    }

    /// Where photons go but for the share of natural ones.
    pub(crate) fn tree(&self) -> &GuideTree {
        &self.tree
    }

    /// Heap memory, in bytes.
    pub fn memory_bytes(&self) -> usize {
        self.tree.memory_bytes() + size_of_val(&*self.cumulative) + size_of_val(&*self.weights)
    }
}

/// The coarse and the fine number of a choice in `[0, 1)`.
fn halves(choice: f64) -> [f32; 2] {
    let unit = f64::from(UNIT);
    let coarse = (choice / unit).floor() * unit;
    [(coarse as f32).min(LAST), (((choice - coarse) / unit) as f32).min(LAST)]
}

#[cfg(test)]
mod tests {
    use super::super::{Example, LEVELS, Purpose};
    use super::*;
    use crate::math::{Rng, Stream};

    fn numbers(rng: &mut Rng) -> Numbers {
        std::array::from_fn(|_| rng.next_f32())
    }

    /// Of two lights, one of a hundredth of the flux, whose photons arrive through a gap.
    fn tree() -> GuideTree {
        let mut rng = Rng::new(1, Stream::Test, 0, 0);
        let example = |rng: &mut Rng| {
            let [choice, a, b, c, d] = start(numbers(rng));
            let arrives = choice < 0.01 || (a - 0.3).abs() < 0.05 && (c - 0.61 * b).abs() < 0.1;
            let level = if arrives { 0 } else { LEVELS as u8 };
            Example { start: [choice, a, b, c, d], weight: 1.0, level, rays: if arrives { 5 } else { 2 } }
        };
        let mut examples: Vec<Example> = (0..20_000).map(|_| example(&mut rng)).collect();
        GuideTree::grow(&mut examples, &[0.01, 1.0], Purpose::Render)
    }

    fn probabilities(guide: &Guide) -> impl Iterator<Item = f64> {
        let below = [0.0].into_iter().chain(guide.cumulative.iter().copied());
        guide.cumulative.iter().zip(below).map(|(c, below)| c - below)
    }

    /// The mean power of all photons is the natural one, whatever the density: exactly, cell by cell.
    #[test]
    fn all_photons_together_carry_the_natural_power() {
        let tree = tree();
        assert!(tree.densities().len() > 4);
        assert!((tree.volumes().sum::<f64>() - 1.0).abs() < 1e-12);
        for share in [0.0, 0.25, 0.5, 0.875] {
            let guide = Guide::new(tree.clone(), share);
            let cells = || probabilities(&guide).zip(tree.volumes()).zip(&guide.weights);
            assert!((probabilities(&guide).sum::<f64>() - 1.0).abs() < 1e-12);
            let power: f64 = cells().map(|((p, _), &weight)| p * f64::from(weight)).sum();
            assert!((power - 1.0).abs() < 1e-7, "weights are f32: {power}");
            for ((p, volume), &weight) in cells() {
                assert!((f64::from(weight) * p / volume - 1.0).abs() < 1e-7);
                assert!(f64::from(weight) <= (1.0 + 1e-6) / (1.0 - share), "{weight} at {share}");
            }
        }
    }

    #[test]
    fn starts_have_the_density_that_they_are_weighed_by() {
        let guide = Guide::new(tree(), 0.75);
        let mut rng = Rng::new(2, Stream::Test, 0, 0);
        for k in 0..20_000 {
            let cell = guide.cell(f64::from(k) / 20_000.0);
            let warped = guide.warp(cell, numbers(&mut rng));
            assert!(warped.iter().all(|u| (0.0..1.0).contains(u)));
            let density = guide.density(&start(warped));
            assert!((density * f64::from(guide.weight(cell)) - 1.0).abs() < 1e-6, "{warped:?}");
        }
        // As many photons as the density says fall into a part of the cube that is no cell.
        let inside = |[choice, a, ..]: Start| choice < 0.3 && a > 0.27;
        let n = 200_000;
        let guided = (0..n).filter(|&k| {
            let cell = guide.cell((f64::from(k) + 0.5) / f64::from(n));
            inside(start(guide.warp(cell, numbers(&mut rng))))
        });
        let guided = guided.count() as f64 / f64::from(n);
        let natural = (0..n).map(|_| start(numbers(&mut rng))).filter(|&start| inside(start));
        let expected = natural.map(|start| guide.density(&start)).sum::<f64>() / f64::from(n);
        assert!((guided / expected - 1.0).abs() < 0.03, "{guided} instead of {expected}");
    }

    #[test]
    fn undivided_starts_stay_as_they_are() {
        let guide = Guide::new(GuideTree::of_lights(&[1.0]), 0.5);
        let mut rng = Rng::new(3, Stream::Test, 0, 0);
        assert!((guide.cells(), guide.weight(0)) == (1, 1.0));
        for numbers in (0..1000).map(|_| numbers(&mut rng)) {
            assert_eq!(guide.warp(guide.cell(0.7), numbers), numbers);
        }
    }
}
