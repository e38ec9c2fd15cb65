use super::cell_split::{Cell, Plane, best_split};
use super::start::Start;
use super::tally::{Example, LEVELS, Purpose, Tally};

/// No more lights are told apart without a photon that tells why.
const MOST_LIGHTS: usize = 64;

/// A partition of the cube that emissions are drawn from, by planes across its axes, and a density for each of its cells.
#[derive(Clone, Debug, Default)]
pub struct GuideTree {
    /// The root first, and the lower half of a node behind it.
    nodes: Vec<Node>,
    cells: Vec<Cell>,
    /// Of each cell; their mean over the cube is 1.
    densities: Vec<f64>,
    /// See [`GuideTree::gain`].
    gain: f64,
}

#[derive(Clone, Copy, Debug)]
enum Node {
    /// The number of a cell.
    Leaf(u32),
    Split {
        plane: Plane,
        /// The place of the upper half.
        upper: u32,
    },
}

impl GuideTree {
    /// All lights alike, or as many groups of them, whatever their flux is: what photons are drawn by that are to find out more.
    /// `lights` are the running sums of the probabilities by which they are chosen.
    pub fn of_lights(lights: &[f64]) -> GuideTree {
        let groups = lights.len().clamp(1, MOST_LIGHTS);
        let mut tree = GuideTree { gain: 1.0, ..GuideTree::default() };
        let mut ends: Vec<f64> = (1..groups).map(|k| lights[k * lights.len() / groups - 1]).collect();
        ends.retain(|&end| 0.0 < end && end < 1.0);
        ends.dedup();
        tree.split_lights(Cell::ALL, &ends);
        let share = 1.0 / tree.cells.len() as f64;
        tree.densities = tree.volumes().map(|volume| share / volume).collect();
        tree
    }

    fn split_lights(&mut self, cell: Cell, ends: &[f64]) {
        let Some(&at) = ends.get(ends.len() / 2) else { return self.push_leaf(cell) };
        let plane = Plane { axis: 0, at };
        let [lower, upper] = cell.halves(plane);
        let (below, above) = ends.split_at(ends.len() / 2);
        let node = self.push_split(plane);
        self.split_lights(lower, below);
        self.close_split(node);
        self.split_lights(upper, &above[1..]);
    }

    /// Splits the cube where photons come near with another probability on one side than on the other, as far as `examples` can
    /// tell.
    ///
    /// `lights` are the running sums of the probabilities by which lights are chosen: between them alone the first axis is split.
    /// Examples are put into another order.
    pub fn grow(examples: &mut [Example], lights: &[f64], purpose: Purpose) -> GuideTree {
        let mut tree = GuideTree { gain: 1.0, ..GuideTree::default() };
        let all = Tally::of(examples);
        let mut leaves = Vec::new();
        tree.grow_node(Cell::ALL, examples, lights, &mut leaves);
        if all.near == [0; LEVELS] {
            // One cell: nothing tells of another.
            tree.densities = vec![1.0];
            return tree;
        }
        if all.near[0] > 0 {
            tree.gain = (all.expense(&all) / expense(&tree.cells, &leaves, &all)).powi(2);
        }
        tree.densities = leaves.iter().map(|leaf| leaf.density(purpose, &all)).collect();
        let mean: f64 = tree.volumes().zip(&tree.densities).map(|(volume, density)| volume * density).sum();
        tree.densities.iter_mut().for_each(|density| *density /= mean);
        tree
    }

    fn grow_node(&mut self, cell: Cell, examples: &mut [Example], lights: &[f64], leaves: &mut Vec<Tally>) {
        let Some(plane) = best_split(&cell, examples, lights) else {
            leaves.push(Tally::of(examples));
            return self.push_leaf(cell);
        };
        let [lower, upper] = cell.halves(plane);
        let (below, above) = partition(examples, plane);
        let node = self.push_split(plane);
        self.grow_node(lower, below, lights, leaves);
        self.close_split(node);
        self.grow_node(upper, above, lights, leaves);
    }

    fn push_leaf(&mut self, cell: Cell) {
        self.nodes.push(Node::Leaf(self.cells.len() as u32));
        self.cells.push(cell);
    }

    fn push_split(&mut self, plane: Plane) -> usize {
        self.nodes.push(Node::Split { plane, upper: 0 });
        self.nodes.len() - 1
    }

    /// What comes next is the upper half of a node.
    fn close_split(&mut self, node: usize) {
        let next = self.nodes.len() as u32;
        if let Some(Node::Split { upper, .. }) = self.nodes.get_mut(node) {
            *upper = next;
        }
    }

    /// The number of the cell that a start lies in.
    pub fn find(&self, start: &Start) -> usize {
        let mut place = 0;
        loop {
            match self.nodes[place] {
                Node::Leaf(cell) => return cell as usize,
                Node::Split { plane: Plane { axis, at }, upper } => {
                    place = if start[axis] < at { place + 1 } else { upper as usize };
                }
            }
        }
    }

    /// The lowest and the highest corner of a cell.
    pub fn cell(&self, number: usize) -> (&Start, &Start) {
        let Cell { low, high } = &self.cells[number];
        (low, high)
    }

    /// Of the cells, in the order of their numbers; their sum is 1.
    pub fn volumes(&self) -> impl Iterator<Item = f64> {
        self.cells.iter().map(Cell::volume)
    }

    /// Of the cells, in the order of their numbers; their mean over the cube is 1.
    pub fn densities(&self) -> &[f64] {
        &self.densities
    }

    /// By how much less variance times rays is than by natural photons, for all that arrive alike, as far as the examples
    /// tell.
    pub fn gain(&self) -> f64 {
        self.gain
    }

    /// Heap memory, in bytes.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&*self.nodes) + size_of_val(&*self.cells) + size_of_val(&*self.densities)
    }
}

/// Those below the plane, and the others.
fn partition(examples: &mut [Example], Plane { axis, at }: Plane) -> (&mut [Example], &mut [Example]) {
    let mut below = 0;
    for k in 0..examples.len() {
        if examples[k].start[axis] < at {
            examples.swap(k, below);
            below += 1;
        }
    }
    examples.split_at_mut(below)
}

/// The integral of `√(m c)` over cells.
fn expense(cells: &[Cell], tallies: &[Tally], all: &Tally) -> f64 {
    cells.iter().zip(tallies).map(|(cell, tally)| cell.volume() * tally.expense(all)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Rng, Stream};

    const N: usize = 16_384;

    fn examples(level: impl Fn(&Start, f32) -> u8) -> Vec<Example> {
        let mut rng = Rng::new(4, Stream::Test, 0, 0);
        let example = |_| {
            let start: Start = std::array::from_fn(|_| rng.next_f32().into());
            Example { start, weight: 1.0, level: level(&start, rng.next_f32()), rays: 3 }
        };
        (0..N).map(example).collect()
    }

    const FAR: u8 = LEVELS as u8;

    /// A gap in the middle of the cube, which no plane through the middle tells.
    #[test]
    fn photons_are_sent_through_a_gap() {
        let inside = |start: &Start| (start[1] - 0.5).abs() < 0.06 && (start[3] - 0.5).abs() < 0.06;
        let mut examples = examples(|start, _| if inside(start) { 0 } else { FAR });
        let tree = GuideTree::grow(&mut examples, &[1.0], Purpose::Render);
        let density = |start: &Start| tree.densities()[tree.find(start)];
        assert!(density(&[0.3, 0.5, 0.9, 0.5, 0.1]) > 8.0 * density(&[0.3, 0.2, 0.9, 0.5, 0.1]));
        assert!(
            tree.gain() > 5.0 && tree.densities().len() < 60,
            "{} {}",
            tree.gain(),
            tree.densities().len()
        );
        assert!(
            tree.cells.iter().all(|cell| cell.low[0] == 0.0 && cell.high[0] == 1.0),
            "there is one light"
        );
    }

    #[test]
    fn chance_does_not_divide() {
        for part in [0.5, 0.03, 0.001] {
            let mut examples = examples(|_, u| if u < part { 0 } else { FAR });
            let tree = GuideTree::grow(&mut examples, &[0.5, 1.0], Purpose::Render);
            assert!(tree.densities().len() <= 2 && tree.gain() < 1.1, "{part}: {}", tree.densities().len());
        }
    }

    /// The last one has a billionth of the flux.
    #[test]
    fn faint_lights_are_tried() {
        let tree = GuideTree::of_lights(&[0.5, 1.0 - 1e-9, 1.0]);
        let probabilities: Vec<f64> = tree.volumes().zip(tree.densities()).map(|(v, d)| v * d).collect();
        assert!(probabilities.iter().all(|p| (3.0 * p - 1.0).abs() < 1e-6), "{probabilities:?}");
        let lights: Vec<f64> = (1..=1000).map(|k| f64::from(k) / 1000.0).collect();
        assert_eq!(GuideTree::of_lights(&lights).densities().len(), MOST_LIGHTS);
        assert_eq!(GuideTree::of_lights(&[]).densities(), [1.0]);
    }

    /// Where none arrived, but some came near, more go than where none came near.
    #[test]
    fn rare_arrivals_are_expected_where_others_came_near() {
        let mut examples = examples(|start, u| match start[1] {
            x if x < 0.1 && u < 0.5 => 0,
            x if x < 0.55 => 1,
            _ => FAR,
        });
        let tree = GuideTree::grow(&mut examples, &[1.0], Purpose::Render);
        let [arrived, near, far] =
            [0.05, 0.3, 0.8].map(|x| tree.densities()[tree.find(&[0.5, x, 0.5, 0.5, 0.5])]);
        assert!(arrived > near && near > 1.5 * far, "{arrived} {near} {far}");
    }

    #[test]
    fn a_light_is_divided_by_where_and_whereto_alone() {
        let lights = [0.1, 0.35, 1.0];
        let mut examples = examples(|start, _| if start[0] < 0.3 { 0 } else { FAR });
        let tree = GuideTree::grow(&mut examples, &lights, Purpose::Search);
        let ends = tree.cells.iter().map(|cell| cell.high[0]);
        assert_eq!(ends.collect::<Vec<_>>(), lights);
    }

    #[test]
    fn without_a_photon_that_came_near_nothing_is_known() {
        for mut examples in [examples(|_, _| FAR), Vec::new()] {
            let tree = GuideTree::grow(&mut examples, &[0.5, 1.0], Purpose::Search);
            assert!(tree.densities() == [1.0] && tree.gain() == 1.0);
        }
    }
}
