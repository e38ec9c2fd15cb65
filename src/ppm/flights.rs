use crate::math::{DVec3, Rgb, Vec3};
use crate::scene::{RayPacket, Row};
use crate::simd::{LANES, LaneVec3, Lanes, Mask, first_lanes};

/// Photons on their way, in columns.
#[derive(Debug, Default)]
pub(super) struct Flights {
    origin: [Vec<f32>; 3],
    dir: [Vec<f32>; 3],
    power: [Vec<f32>; 3],
    /// The number of each within its chunk.
    path: Vec<u32>,
    len: usize,
    /// The places of those that fly into each octant, in order.
    octants: [Places; 8],
}

#[derive(Debug, Default)]
struct Places {
    places: Vec<u32>,
    len: usize,
}

/// Up to sixteen of them.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct FlightPacket {
    pub rays: RayPacket,
    pub power: [Row; 3],
    pub path: [u32; LANES],
}

/// Sixteen of them, in lanes.
#[derive(Clone, Copy)]
pub(super) struct LaneFlights<L: Lanes> {
    pub origin: LaneVec3<L>,
    pub dir: LaneVec3<L>,
    pub power: LaneVec3<L>,
    pub path: L::U32,
}

impl Flights {
    /// Forgets all, and makes room for `capacity`.
    pub fn make_room(&mut self, capacity: usize) {
        self.clear();
        // Whole registers are written, whatever is in them.
        let length = capacity + LANES;
        let columns = self.origin.iter_mut().chain(&mut self.dir).chain(&mut self.power);
        columns.for_each(|column| column.resize(length, 0.0));
        self.path.resize(length, 0);
        self.octants.iter_mut().for_each(|octant| octant.places.resize(length, 0));
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.len = 0;
        self.octants.iter_mut().for_each(|octant| octant.len = 0);
    }

    pub fn len(&self) -> usize {
        self.len
    }

    /// The power of all, in columns of one length.
    pub fn powers(&self) -> [&[f32]; 3] {
        self.power.each_ref().map(|column| &column[..self.len])
    }

    /// The paths of all, and where they start.
    pub fn starts(&self) -> impl Iterator<Item = (u32, Vec3)> {
        (0..self.len).map(|k| (self.path[k], Vec3::from(self.origin.each_ref().map(|column| column[k]))))
    }

    /// Forgets those whose path is not to be kept: how many, and what they carried.
    pub fn retain(&mut self, keep: impl Fn(u32) -> bool) -> (u64, DVec3) {
        let (before, mut lost) = (self.len, DVec3::ZERO);
        self.clear();
        for place in 0..before {
            if keep(self.path[place]) {
                self.move_to_end(place);
            } else {
                lost += DVec3::from(self.power.each_ref().map(|column| f64::from(column[place])));
            }
        }
        ((before - self.len) as u64, lost)
    }

    /// Of those at `place` and behind all that are kept so far.
    fn move_to_end(&mut self, place: usize) {
        let columns = self.origin.iter_mut().chain(&mut self.dir).chain(&mut self.power);
        columns.for_each(|column| column[self.len] = column[place]);
        self.path[self.len] = self.path[place];
        let ahead = |(axis, column): (usize, &Vec<f32>)| usize::from(column[self.len] > 0.0) << axis;
        let octant = &mut self.octants[self.dir.iter().enumerate().map(ahead).sum::<usize>()];
        octant.places[octant.len] = self.len as u32;
        octant.len += 1;
        self.len += 1;
    }

    /// Adds the lanes of `mask`, in their order.
    #[inline(always)]
    pub fn push<L: Lanes>(&mut self, lanes: L, mask: Mask, flights: &LaneFlights<L>) {
        let LaneFlights { origin, dir, power, path } = *flights;
        let dir = dir.compress(lanes, mask);
        origin.compress(lanes, mask).store(lanes, tail(&mut self.origin, self.len));
        dir.store(lanes, tail(&mut self.dir, self.len));
        power.compress(lanes, mask).store(lanes, tail(&mut self.power, self.len));
        lanes.store_u32(lanes.compress_u32(mask, path), &mut self.path[self.len..]);
        let count = mask.count_ones() as usize;
        self.push_octants(lanes, first_lanes(count), dir);
        self.len += count;
    }

    #[inline(always)]
    fn push_octants<L: Lanes>(&mut self, lanes: L, mask: Mask, dir: LaneVec3<L>) {
        let zero = lanes.splat(0.0);
        let [x, y, z] = [lanes.lt(zero, dir.x), lanes.lt(zero, dir.y), lanes.lt(zero, dir.z)];
        let places = lanes.add_u32(lanes.splat_u32(self.len as u32), lanes.load_u32(&COUNT));
        for (number, octant) in self.octants.iter_mut().enumerate() {
            let [not_x, not_y, not_z] = [number & 1 == 0, number & 2 == 0, number & 4 == 0];
            let inside = mask & flipped(x, not_x) & flipped(y, not_y) & flipped(z, not_z);
            if inside != 0 {
                lanes.store_u32(lanes.compress_u32(inside, places), &mut octant.places[octant.len..]);
                octant.len += inside.count_ones() as usize;
            }
        }
    }

    /// The places of all, octant after octant.
    pub fn by_octant(&self, places: &mut Vec<u32>) {
        places.clear();
        self.octants.iter().for_each(|octant| places.extend_from_slice(&octant.places[..octant.len]));
    }

    /// Puts those at `places`, sixteen at most, into a packet.
    pub fn pack(&self, places: &[u32], packet: &mut FlightPacket) {
        packet.rays.len = places.len();
        // Of one length, so that one check of a place holds for all columns.
        let all = ..self.len;
        let [ox, oy, oz] = self.origin.each_ref().map(|column| &column[all]);
        let [dx, dy, dz] = self.dir.each_ref().map(|column| &column[all]);
        let [red, green, blue] = self.power.each_ref().map(|column| &column[all]);
        let path = &self.path[all];
        let FlightPacket { rays, power, path: paths } = packet;
        for (lane, &place) in places.iter().enumerate().take(LANES) {
            let k = place as usize;
            (rays.origin[0][lane], rays.origin[1][lane], rays.origin[2][lane]) = (ox[k], oy[k], oz[k]);
            (rays.dir[0][lane], rays.dir[1][lane], rays.dir[2][lane]) = (dx[k], dy[k], dz[k]);
            (power[0][lane], power[1][lane], power[2][lane]) = (red[k], green[k], blue[k]);
            paths[lane] = path[k];
        }
    }
}

/// The number of each lane.
pub(super) const COUNT: [u32; LANES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

#[inline(always)]
fn flipped(mask: Mask, flip: bool) -> Mask {
    if flip { !mask } else { mask }
}

#[inline(always)]
fn tail([x, y, z]: &mut [Vec<f32>; 3], from: usize) -> [&mut [f32]; 3] {
    [&mut x[from..], &mut y[from..], &mut z[from..]]
}

impl FlightPacket {
    /// No photons.
    pub const EMPTY: FlightPacket =
        FlightPacket { rays: RayPacket::EMPTY, power: [[0.0; LANES]; 3], path: [0; LANES] };

    /// All numbers of all lanes that hold a photon.
    #[cfg(test)]
    pub fn to_bits(self) -> [[u32; LANES]; 10] {
        let [ox, oy, oz] = self.rays.origin;
        let [dx, dy, dz] = self.rays.dir;
        let [red, green, blue] = self.power;
        let numbers = [ox, oy, oz, dx, dy, dz, red, green, blue].map(|row| row.map(f32::to_bits));
        let [a, b, c, d, e, f, g, h, i] = numbers;
        [a, b, c, d, e, f, g, h, i, self.path]
            .map(|row| std::array::from_fn(|lane| if lane < self.rays.len { row[lane] } else { 0 }))
    }

    pub fn power(&self, lane: usize) -> Rgb {
        at(&self.power, lane)
    }

    pub fn set_power(&mut self, lane: usize, power: Rgb) {
        self.power.iter_mut().zip(power.to_array()).for_each(|(row, channel)| row[lane] = channel);
    }

    #[inline(always)]
    pub fn load<L: Lanes>(&self, lanes: L) -> LaneFlights<L> {
        LaneFlights {
            origin: LaneVec3::from_arrays(lanes, &self.rays.origin),
            dir: LaneVec3::from_arrays(lanes, &self.rays.dir),
            power: LaneVec3::from_arrays(lanes, &self.power),
            path: lanes.load_u32(&self.path),
        }
    }
}

/// The lanes of a mask.
pub(super) fn lanes_of(mut mask: Mask) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = mask.trailing_zeros() as usize;
        mask &= mask.wrapping_sub(1);
        (lane < LANES).then_some(lane)
    })
}

/// The vector of one lane.
#[inline(always)]
pub(super) fn at([x, y, z]: &[Row; 3], lane: usize) -> Vec3 {
    Vec3::new(x[lane], y[lane], z[lane])
}

impl<L: Lanes> LaneFlights<L> {
    /// `self` in the lanes of `mask`, `other` elsewhere.
    #[inline(always)]
    pub fn or(self, lanes: L, mask: Mask, other: &LaneFlights<L>) -> LaneFlights<L> {
        LaneFlights {
            origin: self.origin.or(lanes, mask, other.origin),
            dir: self.dir.or(lanes, mask, other.dir),
            power: self.power.or(lanes, mask, other.power),
            path: self.path,
        }
    }

    /// Who carries some power.
    #[inline(always)]
    pub fn have_power(&self, lanes: L) -> Mask {
        let LaneVec3 { x, y, z } = self.power;
        let zero = lanes.splat(0.0);
        lanes.lt(zero, x) | lanes.lt(zero, y) | lanes.lt(zero, z)
    }

    /// Whose power is a finite number.
    #[inline(always)]
    pub fn are_finite(&self, lanes: L) -> Mask {
        let LaneVec3 { x, y, z } = self.power;
        let (one, most) = (lanes.splat(1.0), lanes.splat(f32::MAX));
        lanes.le(lanes.copysign(x, one), most)
            & lanes.le(lanes.copysign(y, one), most)
            & lanes.le(lanes.copysign(z, one), most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{Isa, Kernel};

    /// Photons in all octants, in one call.
    struct Fill<'a>(&'a mut Flights);

    impl Kernel for Fill<'_> {
        type Output = ();

        #[inline(always)]
        fn run<L: Lanes>(self, lanes: L) {
            let row = |of: fn(u32) -> f32| std::array::from_fn(|k| of(k as u32));
            let sides =
                [row(|k| f32::from(k & 1 == 0) - 0.5), row(|k| 0.25 - f32::from(k & 2 == 0)), row(|_| 1.0)];
            let dir = LaneVec3::from_arrays(lanes, &sides);
            let power = LaneVec3::from_arrays(lanes, &[row(|k| k as f32), row(|_| 1.0), row(|_| 0.0)]);
            let path = lanes.load_u32(&COUNT);
            self.0.push(lanes, Mask::MAX, &LaneFlights { origin: dir, dir, power, path });
        }
    }

    #[test]
    fn those_that_are_kept_keep_their_order_and_octants() {
        let mut flights = Flights::default();
        flights.make_room(LANES);
        Isa::best().run(Fill(&mut flights));
        let mut before = Vec::new();
        flights.by_octant(&mut before);
        let paths: Vec<u32> = before.iter().map(|&place| flights.path[place as usize]).collect();
        let kept = |path: &u32| path % 3 == 1;
        let (count, lost) = flights.retain(|path| kept(&path));
        assert_eq!((count, lost), (11, DVec3::new(85.0, 11.0, 0.0)));
        let mut places = Vec::new();
        flights.by_octant(&mut places);
        let left: Vec<u32> = places.iter().map(|&place| flights.path[place as usize]).collect();
        assert_eq!(left, paths.into_iter().filter(kept).collect::<Vec<_>>());
        assert!(flights.path[..5] == [1, 4, 7, 10, 13] && flights.powers()[0] == [1.0, 4.0, 7.0, 10.0, 13.0]);
    }
}
