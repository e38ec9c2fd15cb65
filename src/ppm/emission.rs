//! Sixteen photons that leave their lights.

use super::draws::Draws;
use super::flights::{COUNT, Flights, LaneFlights, at};
use crate::light::{Guide, LaneEmission, Lights, Numbers, start};
use crate::math::Vec3;
use crate::scene::Row;
use crate::simd::{Kernel, LANES, LaneVec3, Lanes, Mask};

/// The photons of a pass that are guided: all of them.
#[derive(Clone, Copy)]
pub(super) struct Guided<'a> {
    pub guide: &'a Guide,
    /// How many there are.
    pub photons: u64,
}

impl Guided<'_> {
    /// The cell that a photon starts from. Photons go through the cells in their order, so each gets as many as its probability
    /// says, to one, and neighbours start alike; `u` in `[0, 1)` is where in its part of them the photon stands.
    pub fn cell(&self, number: u64, u: f32) -> usize {
        self.guide.cell((number as f64 + f64::from(u)) / self.photons as f64)
    }
}

/// Emits the photons `first`, `first + 1`, ... of a chunk: those of the lanes of `mask`.
///
/// Returns those that are dropped for want of power.
pub(super) struct Emission<'a> {
    pub lights: &'a Lights,
    pub guided: Option<Guided<'a>>,
    pub draws: Draws,
    pub first: u32,
    pub mask: Mask,
    pub flights: &'a mut Flights,
}

impl Kernel for Emission<'_> {
    type Output = Mask;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Mask {
        let path = lanes.add_u32(lanes.splat_u32(self.first), lanes.load_u32(&COUNT));
        let (_, LaneEmission { origin, dir, power }) =
            emit(lanes, self.lights, self.draws, self.guided, path);
        let flights = LaneFlights { origin, dir, power, path };
        let bright = flights.have_power(lanes) & flights.are_finite(lanes);
        self.flights.push(lanes, self.mask & bright, &flights);
        self.mask & !bright
    }
}

/// The starts of the photons `path`, and by which numbers their lights are chosen.
#[inline(always)]
fn emit<L: Lanes>(
    lanes: L,
    lights: &Lights,
    draws: Draws,
    guided: Option<Guided>,
    path: L::U32,
) -> ([L::F32; 2], LaneEmission<L>) {
    let [coarse, a, b, c] = draws.in_lanes(lanes, path, 0);
    let [d, fine, place, _] = draws.in_lanes(lanes, path, 1);
    let Some(guided) = guided else {
        return ([coarse, fine], lights.sample_emissions(lanes, [coarse, fine], [a, b, c, d]));
    };
    let mut rows = [[0.0; LANES]; 7];
    let mut k = 0;
    while k < rows.len() {
        lanes.store([coarse, a, b, c, d, fine, place][k], &mut rows[k]);
        k += 1;
    }
    let mut paths = [0; LANES];
    lanes.store_u32(path, &mut paths);
    warp(&guided, draws.first, &paths, &mut rows);
    let [coarse, a, b, c, d, fine, weight] = rows;
    let choice = [lanes.load(&coarse), lanes.load(&fine)];
    let numbers = [lanes.load(&a), lanes.load(&b), lanes.load(&c), lanes.load(&d)];
    let emission = lights.sample_emissions(lanes, choice, numbers);
    (choice, LaneEmission { power: emission.power.scaled(lanes, lanes.load(&weight)), ..emission })
}

/// Puts warped numbers in the place of the natural ones, and weights in the place of those that choose the cell.
fn warp(guided: &Guided, first: u64, paths: &[u32; LANES], rows: &mut [Row; 7]) {
    for (lane, &path) in paths.iter().enumerate() {
        let [numbers @ .., place] = rows.each_ref().map(|row| row[lane]);
        let cell = guided.cell(first + u64::from(path), place);
        let warped: Numbers = guided.guide.warp(cell, numbers);
        rows.iter_mut().zip(warped).for_each(|(row, number)| row[lane] = number);
        rows[6][lane] = guided.guide.weight(cell);
    }
}

/// How some photons of a chunk started, sixteen at most, which nothing remembers.
pub(super) struct Starts<'a> {
    pub lights: &'a Lights,
    pub guided: Option<Guided<'a>>,
    pub draws: Draws,
    pub paths: &'a [u32],
}

/// The number of a photon's light, the origin and the direction.
pub(super) type LightRay = (usize, Vec3, Vec3);

impl Kernel for Starts<'_> {
    type Output = [Option<LightRay>; LANES];

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Self::Output {
        let mut paths = [0; LANES];
        let count = self.paths.len().min(LANES);
        paths[..count].copy_from_slice(&self.paths[..count]);
        let path = lanes.load_u32(&paths);
        let (choice, emission) = emit(lanes, self.lights, self.draws, self.guided, path);
        let [mut coarse, mut fine] = [[0.0; LANES]; 2];
        lanes.store(choice[0], &mut coarse);
        lanes.store(choice[1], &mut fine);
        light_rays(self.lights, [coarse, fine], &arrays(lanes, emission.origin), &arrays(lanes, emission.dir))
    }
}

#[inline(always)]
fn arrays<L: Lanes>(lanes: L, v: LaneVec3<L>) -> [Row; 3] {
    v.to_arrays(lanes)
}

fn light_rays(
    lights: &Lights,
    [coarse, fine]: [Row; 2],
    origin: &[Row; 3],
    dir: &[Row; 3],
) -> [Option<LightRay>; LANES] {
    std::array::from_fn(|lane| {
        let [choice, ..] = start([coarse[lane], 0.0, 0.0, 0.0, 0.0, fine[lane]]);
        Some((lights.chosen(choice)?, at(origin, lane), at(dir, lane)))
    })
}
