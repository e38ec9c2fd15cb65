//! Where the photons of a packet are stored, and with what power.

use super::Photon;
use super::course::Course;
use super::diffuse_bounce::Arrivals;
use super::draws::Draws;
use super::emission::Starts;
use super::flights::{FlightPacket, at, lanes_of};
use super::photons::{Deposits, PhotonChunk};
use crate::bsdf::Coat;
use crate::scene::{SurfaceHit, SurfacePacket};
use crate::simd::{LANES, Mask};

/// Shares of the power of sixteen photons: 1 but for the lanes of the mask.
#[derive(Debug)]
pub(super) struct Enters {
    coated: Mask,
    shares: [f32; LANES],
}

impl Enters {
    pub const ALL: Enters = Enters { coated: 0, shares: [1.0; LANES] };

    pub fn clear(&mut self) {
        self.coated = 0;
    }

    pub fn set(&mut self, lane: usize, hit: &SurfaceHit, coat: Coat) {
        if coat != Coat::NONE {
            self.coated |= 1 << lane;
            self.shares[lane] = coat.transmittance(hit.normal.dot(hit.wo));
        }
    }

    pub fn of(&self, lane: usize) -> f32 {
        if self.coated & 1 << lane == 0 { 1.0 } else { self.shares[lane] }
    }
}

/// Stores the photons where the surface has a diffuse share, before roulette decides how they go on: with what of their power
/// gets there.
///
/// Only light straight from its source is left out, since shadow rays bring that: light that was mirrored or
/// refracted on its way (water is opaque to shadow rays) is a caustic and stays.
pub(super) fn deposit(
    course: &Course,
    to: &mut Deposits,
    who: Mask,
    photons: &FlightPacket,
    surfaces: &SurfacePacket,
    arrivals: &Arrivals,
    enters: &Enters,
) {
    let (mut lanes, mut count) = ([0; LANES], 0);
    for lane in lanes_of(who) {
        lanes[count] = lane;
        count += 1;
    }
    let lanes = &lanes[..count];
    let photon = |lane| Photon {
        wi: at(&arrivals.wo, lane),
        ng: at(&arrivals.ng, lane),
        power: photons.power(lane) * enters.of(lane),
    };
    to.positions.extend(lanes.iter().map(|&lane| at(&surfaces.p, lane % LANES)));
    to.photons.extend(lanes.iter().map(|&lane| photon(lane % LANES)));
    if course.names_paths {
        to.paths.extend(lanes.iter().map(|&lane| photons.path[lane % LANES]));
    }
}

/// Weighs the caustic photons that were stored last, those of `who`, where they are part of a mixture.
pub(super) fn weigh(
    course: &Course,
    draws: Draws,
    who: Mask,
    photons: &FlightPacket,
    chunk: &mut PhotonChunk,
) {
    let Some(mixture) = course.mixture else { return };
    let (lights, draws) = (course.stage.lights, Draws { segment: 0, ..draws });
    let first = chunk.ratios.len();
    let paths = lanes_of(who).map(|lane| photons.path[lane]);
    if course.guided.is_some() && who != 0 {
        let paths: Vec<u32> = paths.collect();
        let starts = Starts { lights, guided: course.guided, draws, paths: &paths };
        let starts = course.isa.run(starts).into_iter().take(paths.len());
        chunk.ratios.extend(starts.map(|start| mixture.ratio_along(start) as f32));
    } else {
        chunk.ratios.extend(paths.map(|path| mixture.ratio_of(lights, draws, path) as f32));
    }
    for (photon, &ratio) in chunk.caustic.photons[first..].iter_mut().zip(&chunk.ratios[first..]) {
        photon.power *= mixture.weight(ratio.into());
    }
}

/// Stores caustic photons of lights without extent on rough surfaces, weighed where they are part of a mixture.
pub(super) fn deposit_glints(
    course: &Course,
    draws: Draws,
    who: Mask,
    photons: &FlightPacket,
    surfaces: &SurfacePacket,
    arrivals: &Arrivals,
    chunk: &mut PhotonChunk,
) {
    if who == 0 {
        return;
    }
    let (lights, draws) = (course.stage.lights, Draws { segment: 0, ..draws });
    let paths: Vec<u32> = lanes_of(who).map(|lane| photons.path[lane]).collect();
    let starts = course.isa.run(Starts { lights, guided: course.guided, draws, paths: &paths });
    for (lane, start) in lanes_of(who).zip(starts) {
        let Some(start) = start.filter(|&(light, ..)| lights.is_delta(light)) else { continue };
        let weight = course.mixture.map_or(1.0, |mixture| mixture.weight(mixture.ratio_along(Some(start))));
        let power = photons.power(lane) * weight;
        let photon = Photon { wi: at(&arrivals.wo, lane), ng: at(&arrivals.ng, lane), power };
        chunk.glints.push(at(&surfaces.p, lane), photon);
    }
}
