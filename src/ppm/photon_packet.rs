//! Sixteen photons on one flight: what they meet, what they leave there, and how they go on.

use super::FluxLedger;
use super::course::Course;
use super::deposit::{Enters, deposit, deposit_glints, weigh};
use super::diffuse_bounce::{Bounced, DiffuseBounce, Specials};
use super::draws::Draws;
use super::flights::{FlightPacket, Flights, at, lanes_of};
use super::lane_flux::LaneFlux;
use super::onward::go_on;
use super::pasts::Pasts;
use super::photons::PhotonChunk;
use crate::bsdf::{DiffuseSampling, SPECULAR, SpecularLobe, Transport};
use crate::effects::PathClass;
use crate::math::DVec3;
use crate::scene::{Coherence, HitPacket, SurfacePacket};
use crate::simd::Mask;

/// Sixteen photons, and what they meet.
#[derive(Debug)]
pub(super) struct Packet {
    pub photons: FlightPacket,
    hits: HitPacket,
    pub surfaces: SurfacePacket,
    specials: Specials,
    /// Whose past is specular.
    caustic: Mask,
    /// Who meets a rough surface where caustics are collected.
    glossy: Mask,
    /// What passes the coat of the surface that each of them meets.
    enters: Enters,
    /// Of all packets of a chunk.
    pub flux: LaneFlux,
}

impl Default for Packet {
    fn default() -> Packet {
        Packet {
            photons: FlightPacket::EMPTY,
            hits: HitPacket::none(),
            surfaces: SurfacePacket::NONE,
            specials: Specials::NONE,
            caustic: 0,
            glossy: 0,
            enters: Enters::ALL,
            flux: LaneFlux::ZERO,
        }
    }
}

impl Packet {
    /// Finds what the photons meet.
    pub fn trace(&mut self, course: &Course, coherence: Coherence) {
        let Packet { photons, hits, surfaces, .. } = self;
        course.stage.scene.intersect_packet(&photons.rays, hits, coherence);
        course.stage.scene.surfaces(&photons.rays, hits, surfaces);
        if course.settings.sampling != DiffuseSampling::Cosine {
            surfaces.lambertian = 0;
        }
    }

    /// Stores the photons that arrived, and sends them on.
    pub fn arrive(
        &mut self,
        course: &Course,
        draws: Draws,
        pasts: &mut Pasts,
        chunk: &mut PhotonChunk,
        next: &mut Flights,
    ) {
        let Packet { photons, hits, .. } = &mut *self;
        pasts.media.attenuate(course.stage.scene, photons, hits, &mut chunk.ledger.flux);
        if SPECULAR {
            self.caustic = pasts.specular(&self.photons);
        }
        if SPECULAR || course.settings.sampling != DiffuseSampling::Cosine {
            self.bounce_special(course, draws, pasts, &mut chunk.ledger.flux);
        }
        self.bounce(course, draws, chunk, next);
        if SPECULAR {
            pasts.bounce(&self.photons, self.surfaces.lambertian);
        }
    }

    /// Sends photons on, one by one, from surfaces that are not Lambertian.
    ///
    /// What passes a mask arrives there all the same: hit points on it weigh what they receive by their opacity.
    fn bounce_special(&mut self, course: &Course, draws: Draws, pasts: &mut Pasts, flux: &mut FluxLedger) {
        let Packet { photons, hits, surfaces, specials, enters, glossy, .. } = self;
        specials.clear();
        *glossy = 0;
        enters.clear();
        for lane in lanes_of(surfaces.found & !surfaces.lambertian) {
            let Some(hit) = course.stage.scene.surface_hit(&photons.rays, hits, lane) else { continue };
            let (mut rng, power) = (draws.of(photons.path[lane]), photons.power(lane));
            *glossy |= Mask::from(course.stage.collects_glints_at(&hit)) << lane;
            if course.stage.scene.passes(&hit, &mut rng) {
                enters.set(lane, &hit, course.stage.scene.receiver(&hit).coat);
                flux.pass(power, at(&surfaces.albedo, lane));
                specials.set(lane, &hit.pass(), power);
                pasts.media.cross(course.stage.scene, photons.path[lane], &hit);
                continue;
            }
            let scattering = course.stage.scene.scatter_by(&hit, Transport::Power, || rng.next_vec2());
            enters.set(lane, &hit, scattering.coat);
            flux.send_on(power, scattering.specular().map(SpecularLobe::weight).sum());
            let Some(onward) = go_on(&hit, &scattering, course.settings, &mut rng) else { continue };
            flux.correct(power * onward.factor * (onward.correction - 1.0));
            if !onward.event.is_specular() {
                pasts.bounce(photons, 1 << lane);
            }
            if onward.event.crosses() {
                pasts.media.cross(course.stage.scene, photons.path[lane], &hit);
            }
            if let Some(ray) = onward.ray {
                specials.set(lane, &ray, power * (onward.factor * onward.correction));
            }
        }
    }

    /// Stores the photons, and sends them on from Lambertian surfaces.
    fn bounce(&mut self, course: &Course, draws: Draws, chunk: &mut PhotonChunk, next: &mut Flights) {
        let Packet { photons, surfaces, specials, caustic, flux, enters, glossy, .. } = self;
        let bounce = DiffuseBounce { photons, surfaces, draws, specials, next, flux };
        let Bounced { arrivals, survivors, dark, lost } = course.isa.run(bounce);
        if !draws.is_first_flight() {
            if SPECULAR && course.settings.transport.contains(PathClass::Caustic) {
                let who = arrivals.diffuse & *caustic;
                deposit(course, &mut chunk.caustic, who, photons, surfaces, &arrivals, enters);
                weigh(course, draws, who, photons, chunk);
                deposit_glints(course, draws, *glossy & *caustic, photons, surfaces, &arrivals, chunk);
            }
            if course.settings.transport.contains(PathClass::Indirect) {
                let who = arrivals.diffuse & !*caustic;
                deposit(course, &mut chunk.indirect, who, photons, surfaces, &arrivals, enters);
            }
            chunk.ledger.deposited += u64::from(arrivals.diffuse.count_ones());
        }
        let (rays, found) = (photons.rays.len as u64, u64::from(surfaces.found.count_ones()));
        let ledger = &mut chunk.ledger;
        ledger.rays += rays;
        ledger.escaped += rays - found;
        ledger.absorbed += found - u64::from(survivors.count_ones());
        ledger.dropped += u64::from(dark.count_ones());
        ledger.flux.dropped += lanes_of(lost).map(|lane| photons.power(lane).as_dvec3()).sum::<DVec3>();
    }
}
