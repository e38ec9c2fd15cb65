//! Sixteen photons that arrive at surfaces, and bounce where those are Lambertian.

use super::draws::Draws;
use super::flights::{FlightPacket, Flights, LaneFlights};
use super::lane_flux::LaneFlux;
use crate::math::{Ray, Rgb};
use crate::scene::{Row, SurfacePacket};
use crate::simd::{Kernel, LaneFrame, LaneVec3, Lanes, Mask, first_lanes, warp};

/// Sends the photons of a packet on from Lambertian surfaces, joins those that go on from others, and drops what has no
/// power.
pub(super) struct DiffuseBounce<'a> {
    pub photons: &'a FlightPacket,
    pub surfaces: &'a SurfacePacket,
    pub draws: Draws,
    pub specials: &'a Specials,
    pub next: &'a mut Flights,
    pub flux: &'a mut LaneFlux,
}

/// What became of the photons of a packet.
pub(super) struct Bounced {
    pub arrivals: Arrivals,
    /// Who goes on, by roulette.
    pub survivors: Mask,
    /// Who of those is dropped for want of power.
    pub dark: Mask,
    /// Whose power is no finite number any more.
    pub lost: Mask,
}

/// Photons that go on from surfaces that are not Lambertian: in the lanes of the mask.
#[derive(Debug)]
pub(super) struct Specials {
    flights: FlightPacket,
    lanes: Mask,
}

/// How the photons of a packet arrive.
#[repr(C, align(64))]
pub(super) struct Arrivals {
    /// Back along the ray, unit.
    pub wo: [Row; 3],
    /// Geometric normals on that side.
    pub ng: [Row; 3],
    /// Those at surfaces with a diffuse share.
    pub diffuse: Mask,
}

impl Specials {
    pub const NONE: Specials = Specials { flights: FlightPacket::EMPTY, lanes: 0 };

    pub fn clear(&mut self) {
        self.lanes = 0;
    }

    pub fn set(&mut self, lane: usize, ray: &Ray, power: Rgb) {
        for axis in 0..3 {
            self.flights.rays.origin[axis][lane] = ray.origin[axis];
            self.flights.rays.dir[axis][lane] = ray.dir[axis];
            self.flights.power[axis][lane] = power[axis];
        }
        self.lanes |= 1 << lane;
    }
}

impl Kernel for DiffuseBounce<'_> {
    type Output = Bounced;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Bounced {
        let DiffuseBounce { photons, surfaces, draws, specials, next, flux } = self;
        let (all, found) = (first_lanes(photons.rays.len), surfaces.found);
        let photons = photons.load(lanes);
        let arrival = Arrival::new(lanes, photons.dir, surfaces);
        let (mut onward, survivors) = bounce(lanes, &photons, surfaces, &arrival, draws);
        let mut survivors = survivors & surfaces.lambertian;
        if specials.lanes != 0 {
            onward = onward.or(lanes, !specials.lanes, &specials.flights.load(lanes));
            survivors |= specials.lanes;
        }
        let lost = survivors & !onward.are_finite(lanes);
        let dark = survivors & !onward.have_power(lanes) | lost;
        next.push(lanes, survivors & !dark, &onward);
        flux.land(lanes, found & !lost, photons.power, arrival.albedo);
        flux.escape(lanes, all & !found, photons.power);
        Bounced { arrivals: arrival.to_arrays(lanes, found), survivors, dark, lost }
    }
}

/// How photons arrive, in lanes.
struct Arrival<L: Lanes> {
    wo: LaneVec3<L>,
    /// As the surface has it.
    outward: LaneVec3<L>,
    /// On the side of `wo`.
    ng: LaneVec3<L>,
    front: Mask,
    albedo: LaneVec3<L>,
    /// The largest channel of the albedo: the probability of a diffuse bounce.
    p: L::F32,
}

impl<L: Lanes> Arrival<L> {
    #[inline(always)]
    fn new(lanes: L, dir: LaneVec3<L>, surfaces: &SurfacePacket) -> Arrival<L> {
        let minus_one = lanes.splat(-1.0);
        let wo = dir.scaled(lanes, lanes.div(minus_one, lanes.sqrt(dir.dot(lanes, dir))));
        let outward = LaneVec3::from_arrays(lanes, &surfaces.ng);
        let front = lanes.lt(lanes.splat(0.0), outward.dot(lanes, wo));
        let ng = outward.scaled(lanes, lanes.select(front, lanes.splat(1.0), minus_one));
        let albedo = LaneVec3::from_arrays(lanes, &surfaces.albedo);
        let p = lanes.max(albedo.x, lanes.max(albedo.y, albedo.z));
        Arrival { wo, outward, ng, front, albedo, p }
    }

    #[inline(always)]
    fn to_arrays(&self, lanes: L, found: Mask) -> Arrivals {
        let diffuse = found & lanes.lt(lanes.splat(0.0), self.p);
        Arrivals { wo: self.wo.to_arrays(lanes), ng: self.ng.to_arrays(lanes), diffuse }
    }
}

/// Russian roulette between a diffuse bounce and absorption, as of a single photon: who goes on, and how.
#[inline(always)]
fn bounce<L: Lanes>(
    lanes: L,
    photons: &LaneFlights<L>,
    surfaces: &SurfacePacket,
    arrival: &Arrival<L>,
    draws: Draws,
) -> (LaneFlights<L>, Mask) {
    let [choice, u, v, _] = draws.in_lanes(lanes, photons.path, 0);
    let chosen = lanes.lt(choice, arrival.p);
    let local = warp::square_to_cosine_hemisphere(lanes, u, v);
    let dir = LaneFrame::around(lanes, arrival.ng).to_world(lanes, local);
    let side = arrival.outward.dot(lanes, dir);
    let stays = !(lanes.lt(lanes.splat(0.0), side) ^ arrival.front);
    let offset = lanes.copysign(lanes.load(&surfaces.p_error), side);
    let origin = LaneVec3::from_arrays(lanes, &surfaces.p).add(lanes, arrival.outward.scaled(lanes, offset));
    let factor = LaneVec3 {
        x: lanes.div(arrival.albedo.x, arrival.p),
        y: lanes.div(arrival.albedo.y, arrival.p),
        z: lanes.div(arrival.albedo.z, arrival.p),
    };
    let power = photons.power.mul(lanes, factor);
    (LaneFlights { origin, dir, power, path: photons.path }, chosen & stays)
}
