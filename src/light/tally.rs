//! Photons that were followed, and what those of a cell tell together.

use super::start::Start;

/// How many degrees of coming near are told apart.
pub const LEVELS: usize = 8;

/// A photon that has been followed.
#[derive(Clone, Copy, Debug)]
pub struct Example {
    /// How it started.
    pub start: Start,
    /// The volume of starts that it stands for, up to a common factor: over the density by which it was drawn.
    pub weight: f64,
    /// How near it came to what is seen: 0 if it arrived, [`LEVELS`] if it came near in no way.
    pub level: u8,
    /// The rays of its path.
    pub rays: u32,
}

/// What photons are drawn for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// To find more that arrive: half go where photons came near on the lowest level on which any did, in proportion to the probability `m`
    /// with which they did, a quarter on the next, and so on.
    Search,
    /// For the least variance times rays: in proportion to `√(m / c)`, where they arrive with the probability `m` and cost `c` rays.
    Render,
}

/// Sums over the photons of a cell.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tally {
    pub photons: u32,
    /// Those that came near on each level.
    pub near: [u32; LEVELS],
    pub weight: f64,
    /// The weight of those that came near.
    pub near_weight: [f64; LEVELS],
    /// Rays times weights.
    pub rays: f64,
}

impl Tally {
    pub fn of(examples: &[Example]) -> Tally {
        let mut tally = Tally::default();
        examples.iter().for_each(|example| tally.add(example));
        tally
    }

    pub fn add(&mut self, &Example { weight, level, rays, .. }: &Example) {
        self.photons += 1;
        self.weight += weight;
        self.rays += weight * f64::from(rays);
        for level in usize::from(level)..LEVELS {
            self.near[level] += 1;
            self.near_weight[level] += weight;
        }
    }

    pub fn plus(mut self, other: &Tally) -> Tally {
        self.photons += other.photons;
        self.weight += other.weight;
        self.rays += other.rays;
        for level in 0..LEVELS {
            self.near[level] += other.near[level];
            self.near_weight[level] += other.near_weight[level];
        }
        self
    }

    /// `m` on a level: what was found, and what would not have been. That is in proportion to the next level, as with `all`, as far
    /// as the photons are too few to tell.
    fn nearness(&self, level: usize, all: &Tally) -> f64 {
        let usual = all.near_weight[level] / all.weight;
        let expected = match all.near_weight.get(level + 1) {
            Some(&next) if next > 0.0 => self.nearness(level + 1, all) * all.near_weight[level] / next,
            _ => usual,
        };
        let found = if self.weight > 0.0 { self.near_weight[level] / self.weight } else { 0.0 };
        found + expected / (1.0 + f64::from(self.photons) * expected)
    }

    /// `c`.
    fn cost(&self) -> f64 {
        if self.weight > 0.0 { (self.rays / self.weight).max(1.0) } else { 1.0 }
    }

    pub fn density(&self, purpose: Purpose, all: &Tally) -> f64 {
        let part = |level: usize| {
            let usual = all.near_weight[level] / all.weight;
            0.5f64.powi(level as i32) * self.nearness(level, all) / usual
        };
        match purpose {
            Purpose::Search => (0..LEVELS).filter(|&level| all.near[level] > 0).map(part).sum(),
            Purpose::Render => (self.nearness(0, all) / self.cost()).sqrt(),
        }
    }

    /// `√(m c)` of those that arrive: its integral squared is what variance times rays is by the best densities.
    pub fn expense(&self, all: &Tally) -> f64 {
        (self.nearness(0, all) * self.cost()).sqrt()
    }
}
