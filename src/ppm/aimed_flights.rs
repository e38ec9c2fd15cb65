//! Aimed photons on their way: from their lights over mirrors and interfaces to the first diffuse event.

use std::ops::Range;

use super::course::Course;
use super::mixture::Mixture;
use super::onward::{Onward, go_on};
use super::photons::PhotonChunk;
use super::wavefront::MAX_SEGMENTS;
use super::{Ledger, Photon};
use crate::bsdf::{SpecularLobe, Transport};
use crate::math::{DVec3, Ray, Rgb, Rng, Stream};
use crate::scene::{Coherence, HitPacket, Media, RayPacket, SurfaceHit};
use crate::simd::LANES;

/// The photons of a chunk that are on their way, and the memory for those that go on.
#[derive(Debug, Default)]
pub(super) struct AimedFlights {
    flights: Vec<Flight>,
    next: Vec<Flight>,
}

#[derive(Clone, Copy, Debug)]
struct Flight {
    ray: Ray,
    /// Weighted by the balance heuristic from the start.
    power: Rgb,
    ratio: f32,
    path: u64,
    /// Whether its light has no extent.
    is_from_point: bool,
    media: Media,
}

impl Flight {
    fn has_power(&self) -> bool {
        self.power.is_finite() && self.power.max_element() > 0.0
    }
}

impl AimedFlights {
    /// Emits the photons of `paths` and follows them to their first diffuse event; the caustics that they make go to `chunk`.
    pub fn follow(&mut self, course: &Course, mixture: &Mixture, paths: Range<u64>, chunk: &mut PhotonChunk) {
        self.emit(course, mixture, paths, &mut chunk.ledger);
        for segment in 1..=MAX_SEGMENTS {
            if self.flights.is_empty() {
                return;
            }
            self.fly(course, segment, chunk);
        }
        chunk.ledger.terminated += self.flights.len() as u64;
        chunk.ledger.flux.terminated += self.power();
    }

    fn emit(&mut self, course: &Course, mixture: &Mixture, paths: Range<u64>, ledger: &mut Ledger) {
        self.flights.clear();
        ledger.emitted += paths.end - paths.start;
        self.flights.extend(paths.filter_map(|path| {
            let photon = mixture.aim.sample(&mut numbers(course, path, 0));
            let power = photon.power * mixture.weight(photon.ratio);
            let (ray, media) =
                (Ray::new(photon.origin, photon.dir), course.stage.scene.light_media(photon.origin));
            let is_from_point = course.stage.lights.is_delta(photon.light);
            let flight = Flight { ray, power, ratio: photon.ratio as f32, path, is_from_point, media };
            flight.has_power().then_some(flight)
        }));
        ledger.dropped += ledger.emitted - self.flights.len() as u64;
        ledger.flux.emitted += self.power();
    }

    fn power(&self) -> DVec3 {
        self.flights.iter().map(|flight| flight.power.as_dvec3()).sum()
    }

    fn fly(&mut self, course: &Course, segment: u32, chunk: &mut PhotonChunk) {
        let mut hits = HitPacket::none();
        self.next.clear();
        for flights in self.flights.chunks(LANES) {
            let rays: Vec<Ray> = flights.iter().map(|flight| flight.ray).collect();
            let rays = RayPacket::of(&rays);
            course.stage.scene.intersect_packet(&rays, &mut hits, Coherence::Coherent);
            for (lane, flight) in flights.iter().enumerate() {
                chunk.ledger.rays += 1;
                match course.stage.scene.surface_hit(&rays, &hits, lane) {
                    Some(hit) => {
                        let flight = attenuated(course, flight, &hit, chunk);
                        self.next.extend(arrive(course, &flight, segment, &hit, chunk));
                    }
                    None => {
                        chunk.ledger.escaped += 1;
                        chunk.ledger.flux.escaped += flight.power.as_dvec3();
                    }
                }
            }
        }
        std::mem::swap(&mut self.flights, &mut self.next);
        chunk.ledger.flux.fly_on(self.power());
    }
}

fn numbers(course: &Course, path: u64, segment: u32) -> Rng {
    Rng::at_segment(course.settings.seed, Stream::AimedPhoton, course.pass, path, segment)
}

/// The photon without what was absorbed on its way to `hit`.
fn attenuated(course: &Course, flight: &Flight, hit: &SurfaceHit, chunk: &mut PhotonChunk) -> Flight {
    if flight.media == Media::NONE {
        return *flight;
    }
    let power = flight.power * course.stage.scene.transmittance(flight.media, hit.t);
    chunk.ledger.flux.absorb(flight.power.as_dvec3() - power.as_dvec3());
    Flight { power, ..*flight }
}

/// Stores the photon where the surface has a diffuse share, and sends it on where roulette chooses a specular lobe.
fn arrive(
    course: &Course,
    flight: &Flight,
    segment: u32,
    hit: &SurfaceHit,
    chunk: &mut PhotonChunk,
) -> Option<Flight> {
    let mut rng = numbers(course, flight.path, segment);
    let arrived = Photon { wi: hit.wo, ng: hit.receiver().ng, power: flight.power };
    if segment > 1 && flight.is_from_point && course.stage.collects_glints_at(hit) {
        chunk.glints.push(hit.p, arrived);
    }
    let passes = course.stage.scene.passes(hit, &mut rng);
    let scattering = course.stage.scene.scatter_by(hit, Transport::Power, || rng.next_vec2());
    if segment > 1 && scattering.albedo.max_element() > 0.0 {
        let enters = scattering.coat.transmittance(hit.normal.dot(hit.wo));
        chunk.caustic.push(hit.p, Photon { power: flight.power * enters, ..arrived });
        chunk.ratios.push(flight.ratio);
        chunk.ledger.deposited += 1;
    }
    let Ledger { flux, absorbed, dropped, .. } = &mut chunk.ledger;
    flux.land(flight.power.as_dvec3(), DVec3::ZERO);
    if passes {
        flux.pass(flight.power, Rgb::ZERO);
        let media = course.stage.scene.crossed(flight.media, hit);
        return Some(Flight { ray: hit.pass(), media, ..*flight });
    }
    flux.send_on(flight.power, scattering.specular().map(SpecularLobe::weight).sum());
    let onward = go_on(hit, &scattering, course.settings, &mut rng);
    let specular = onward.filter(|onward| onward.event.is_specular());
    let Some(Onward { event, ray, factor, correction }) = specular else {
        *absorbed += 1;
        return None;
    };
    flux.correct(flight.power * factor * (correction - 1.0));
    let Some(ray) = ray else {
        *absorbed += 1;
        return None;
    };
    let power = flight.power * (factor * correction);
    let mut onward = Flight { ray, power, ..*flight };
    if event.crosses() {
        onward.media = course.stage.scene.crossed(flight.media, hit);
    }
    *dropped += u64::from(!onward.has_power());
    onward.has_power().then_some(onward)
}
