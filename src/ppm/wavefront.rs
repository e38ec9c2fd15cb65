//! A chunk of photons on their way, all of them one bounce at a time, so that their rays can share packets.

use std::ops::Range;

use super::diffuse_bounce::{Arrivals, Bounced, DiffuseBounce, Specials};
use super::draws::Draws;
use super::emission::{Emission, Guided, Starts};
use super::flights::{FlightPacket, Flights, at};
use super::lane_flux::{LaneFlux, PowerOf};
use super::mixture::Mixture;
use super::photon_media::PhotonMedia;
use super::photon_pass::{Deposits, PhotonChunk};
use super::{FluxLedger, Ledger, Photon, Settings, Stage};
use crate::bsdf::{
    Choice, Coat, DiffuseSampling, Event, SPECULAR, Scattering, SpecularLobe, Transport, sample_diffuse,
};
use crate::effects::PathClass;
use crate::math::{DVec3, Frame, Ray, Rgb, Rng, Vec3};
use crate::scene::{Coherence, HitPacket, SurfaceHit, SurfacePacket};
use crate::simd::{Isa, LANES, Mask, first_lanes};

/// A closed box of albedo 1 holds a photon for ever; what is cut here is counted as terminated.
pub(super) const MAX_SEGMENTS: u32 = 1000;

/// In scenes of at most so many triangles and spheres, rays of one octant mostly meet the same boxes: then packets that
/// stay together win. In larger ones they part too early.
const SMALL_SCENE: usize = 512;

/// Photons on their way, and the memory for those that go on.
#[derive(Debug, Default)]
pub(super) struct Wavefront {
    flights: Flights,
    next: Flights,
    /// The flights, in the order of their rays.
    order: Vec<u32>,
    packet: Packet,
    pasts: Pasts,
}

/// By the numbers of the paths, whether nothing but specular events lies behind each: then its photon makes a caustic.
/// Empty where no surface is specular.
#[derive(Debug, Default)]
struct Pasts {
    specular: Vec<bool>,
    media: PhotonMedia,
}

impl Pasts {
    fn begin(&mut self, paths: usize) {
        self.specular.clear();
        self.specular.resize(paths, true);
    }

    /// Who of a packet has such a past.
    fn specular(&self, photons: &FlightPacket) -> Mask {
        if self.specular.is_empty() {
            return 0;
        }
        let lanes = photons.path.iter().enumerate().take(photons.rays.len);
        lanes.fold(0, |mask, (lane, &path)| mask | Mask::from(self.specular[path as usize]) << lane)
    }

    fn is_specular(&self, path: u32) -> bool {
        self.specular.get(path as usize).is_some_and(|&specular| specular)
    }

    /// Notes a bounce that is not specular.
    fn bounce(&mut self, photons: &FlightPacket, lanes: Mask) {
        if !self.specular.is_empty() {
            bits(lanes).for_each(|lane| self.specular[photons.path[lane] as usize] = false);
        }
    }
}

/// Sixteen photons, and what they meet.
#[derive(Debug)]
struct Packet {
    photons: FlightPacket,
    hits: HitPacket,
    surfaces: SurfacePacket,
    specials: Specials,
    /// Whose past is specular.
    caustic: Mask,
    /// Who meets a rough surface where caustics are collected.
    glossy: Mask,
    /// What passes the coat of the surface that each of them meets.
    enters: Enters,
    /// Of all packets of a chunk.
    flux: LaneFlux,
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

/// Shares of the power of sixteen photons: 1 but for the lanes of the mask.
#[derive(Debug)]
struct Enters {
    coated: Mask,
    shares: [f32; LANES],
}

impl Enters {
    const ALL: Enters = Enters { coated: 0, shares: [1.0; LANES] };

    fn set(&mut self, lane: usize, hit: &SurfaceHit, coat: Coat) {
        if coat != Coat::NONE {
            self.coated |= 1 << lane;
            self.shares[lane] = coat.transmittance(hit.normal.dot(hit.wo));
        }
    }

    fn of(&self, lane: usize) -> f32 {
        if self.coated & 1 << lane == 0 { 1.0 } else { self.shares[lane] }
    }
}

/// What the photons of a chunk fly through.
#[derive(Clone, Copy)]
pub(super) struct Course<'a> {
    pub isa: Isa,
    pub stage: Stage<'a>,
    pub settings: &'a Settings,
    pub pass: u32,
    /// Of which natural and aimed photons are parts, where there are aimed ones.
    pub mixture: Option<&'a Mixture>,
    /// Where those that are not aimed start, if not by nature.
    pub guided: Option<Guided<'a>>,
    /// Whether it is to be told which paths brought which photons.
    pub names_paths: bool,
}

impl<'a> Course<'a> {
    /// Of natural photons alone, by the best instruction set.
    pub fn natural(stage: Stage<'a>, settings: &'a Settings, pass: u32) -> Course<'a> {
        Course { isa: Isa::best(), stage, settings, pass, mixture: None, guided: None, names_paths: false }
    }
}

impl Wavefront {
    /// Emits the photons of `paths` and follows them to their end; what they leave behind goes to `chunk`, and `see` is
    /// shown them before every flight.
    pub(super) fn follow(
        &mut self,
        course: &Course,
        paths: Range<u64>,
        chunk: &mut PhotonChunk,
        mut see: impl FnMut(&FlightPacket),
    ) {
        let first = paths.start;
        let draws = |segment| Draws { seed: course.settings.seed, pass: course.pass, first, segment };
        self.emit(course, paths, draws(0), chunk);
        let mut segment = 1;
        while self.flights.len() > 0 && segment <= MAX_SEGMENTS {
            self.fly(course, draws(segment), chunk, &mut see);
            segment += 1;
        }
        let ledger = &mut chunk.ledger;
        ledger.terminated += self.flights.len() as u64;
        ledger.flux.terminated += self.power(course);
        self.packet.flux.settle(&mut ledger.flux);
    }

    fn emit(&mut self, course: &Course, paths: Range<u64>, draws: Draws, chunk: &mut PhotonChunk) {
        let count = (paths.end - paths.start) as usize;
        let Wavefront { flights, next, pasts, .. } = self;
        flights.make_room(count);
        next.make_room(count);
        pasts.begin(if course.stage.casters { count } else { 0 });
        for first in (0..count).step_by(LANES) {
            let (lights, mask) = (course.stage.lights, first_lanes(count - first));
            let emission =
                Emission { lights, guided: course.guided, draws, first: first as u32, mask, flights };
            let dark = course.isa.run(emission);
            chunk.ledger.dropped += u64::from(dark.count_ones());
        }
        pasts.media.begin(course.stage.scene, count, flights);
        chunk.ledger.emitted += count as u64;
        chunk.ledger.flux.emitted += self.power(course);
    }

    /// What all photons on their way carry.
    fn power(&self, course: &Course) -> DVec3 {
        course.isa.run(PowerOf(&self.flights))
    }

    /// Traces all rays, stores the photons where they arrive, and sends them on their way.
    ///
    /// Rays are ordered by the octant that they point into, otherwise as they come.
    fn fly(
        &mut self,
        course: &Course,
        draws: Draws,
        chunk: &mut PhotonChunk,
        see: &mut impl FnMut(&FlightPacket),
    ) {
        let Wavefront { flights, next, order, packet, pasts } = self;
        let small = course.stage.scene.primitives() <= SMALL_SCENE;
        let coherence = if small { Coherence::Coherent } else { Coherence::Incoherent };
        next.clear();
        flights.by_octant(order);
        for places in order.chunks(LANES) {
            flights.pack(places, &mut packet.photons);
            see(&packet.photons);
            packet.trace(course, coherence);
            packet.arrive(course, draws, pasts, chunk, next);
        }
        std::mem::swap(flights, next);
        chunk.ledger.flux.fly_on(self.power(course));
        if !course.settings.transport.contains(PathClass::Indirect) {
            self.end_indirect(&mut chunk.ledger);
        }
    }

    /// Ends the paths that caustics do not come of any more.
    fn end_indirect(&mut self, ledger: &mut Ledger) {
        let Wavefront { flights, pasts, .. } = self;
        let (ended, power) = flights.retain(|path| pasts.is_specular(path));
        ledger.terminated += ended;
        ledger.flux.terminated += power;
    }
}

impl Packet {
    /// Finds what the photons meet.
    fn trace(&mut self, course: &Course, coherence: Coherence) {
        let Packet { photons, hits, surfaces, .. } = self;
        course.stage.scene.intersect_packet(&photons.rays, hits, coherence);
        course.stage.scene.surfaces(&photons.rays, hits, surfaces);
        if course.settings.sampling != DiffuseSampling::Cosine {
            surfaces.lambertian = 0;
        }
    }

    /// Stores the photons that arrived, and sends them on.
    fn arrive(
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
        enters.coated = 0;
        for lane in bits(surfaces.found & !surfaces.lambertian) {
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
        ledger.flux.dropped += bits(lost).map(|lane| photons.power(lane).as_dvec3()).sum::<DVec3>();
    }
}

/// The lanes of a mask.
fn bits(mut mask: Mask) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = mask.trailing_zeros() as usize;
        mask &= mask.wrapping_sub(1);
        (lane < LANES).then_some(lane)
    })
}

/// Stores the photons where the surface has a diffuse share, before roulette decides how they go on: with what of their power
/// gets there.
///
/// Only light straight from its source is left out, since shadow rays bring that: light that was mirrored or
/// refracted on its way (water is opaque to shadow rays) is a caustic and stays.
fn deposit(
    course: &Course,
    to: &mut Deposits,
    who: Mask,
    photons: &FlightPacket,
    surfaces: &SurfacePacket,
    arrivals: &Arrivals,
    enters: &Enters,
) {
    let (mut lanes, mut count) = ([0; LANES], 0);
    for lane in bits(who) {
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
fn weigh(course: &Course, draws: Draws, who: Mask, photons: &FlightPacket, chunk: &mut PhotonChunk) {
    let Some(mixture) = course.mixture else { return };
    let (lights, draws) = (course.stage.lights, Draws { segment: 0, ..draws });
    let first = chunk.ratios.len();
    let paths = bits(who).map(|lane| photons.path[lane]);
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
fn deposit_glints(
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
    let paths: Vec<u32> = bits(who).map(|lane| photons.path[lane]).collect();
    let starts = course.isa.run(Starts { lights, guided: course.guided, draws, paths: &paths });
    for (lane, start) in bits(who).zip(starts) {
        let Some(start) = start.filter(|&(light, ..)| lights.is_delta(light)) else { continue };
        let weight = course.mixture.map_or(1.0, |mixture| mixture.weight(mixture.ratio_along(Some(start))));
        let power = photons.power(lane) * weight;
        let photon = Photon { wi: at(&arrivals.wo, lane), ng: at(&arrivals.ng, lane), power };
        chunk.glints.push(at(&surfaces.p, lane), photon);
    }
}

/// How a photon goes on.
pub(super) struct Onward {
    pub event: Event,
    /// `None` where a shading normal bends it to the wrong side of the true surface.
    pub ray: Option<Ray>,
    /// On its power.
    pub factor: Rgb,
    /// What the factor lacks for the shading normal.
    pub correction: f32,
}

/// Russian roulette between reflection, refraction, diffuse bounce and absorption, which is `None`.
pub(super) fn go_on(
    hit: &SurfaceHit,
    scattering: &Scattering,
    settings: &Settings,
    rng: &mut Rng,
) -> Option<Onward> {
    let (event, dir, factor) = match scattering.choose(rng.next_f32())? {
        Choice::Specular { event, wi, factor, .. } => (event, hit.frame().to_world(wi), factor),
        Choice::Diffuse { factor } => {
            let (wi, cosine_factor) = sample_diffuse(settings.sampling, Vec3::Z, rng);
            let factor = factor * (cosine_factor * scattering.coat.transmittance(wi.z));
            (Event::Diffuse, Frame::around(hit.receiver().ng).to_world(wi), factor)
        }
    };
    let ray = hit.continue_along(event, dir);
    let correction = if ray.is_some() { hit.adjoint_correction(event, dir) } else { 0.0 };
    Some(Onward { event, ray, factor, correction })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{self, Scene};
    use std::path::Path;

    const PATHS: u64 = 1000;

    fn scene(name: &str) -> Scene {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name);
        Scene::new(scene::load(&path).unwrap()).unwrap()
    }

    /// Mirror, glass and an area light; the course's material; nothing but Lambertian surfaces under a point.
    fn scenes() -> [Scene; 3] {
        ["cornell_b.toml", "course_balls.toml", "course_diffuse.toml"].map(scene)
    }

    fn followed(course: &Course) -> PhotonChunk {
        let mut chunk = PhotonChunk::default();
        let mut wavefront = Wavefront::default();
        for first in [0, 1024] {
            wavefront.follow(course, first..first + PATHS, &mut chunk, |_| ());
        }
        chunk
    }

    fn assert_same(a: &PhotonChunk, b: &PhotonChunk, what: impl std::fmt::Display) {
        assert_eq!(a.ledger, b.ledger, "{what}");
        assert!(a.caustic == b.caustic && a.indirect == b.indirect, "{what}: other photons");
    }

    #[test]
    fn every_instruction_set_leaves_the_same_photons() {
        for scene in scenes() {
            for sampling in [DiffuseSampling::Cosine, DiffuseSampling::Uniform] {
                let settings = Settings { sampling, ..Settings::of_scene(scene.render()) };
                let course = |isa| Course { isa, ..Course::natural((&scene).into(), &settings, 2) };
                let expected = followed(&course(Isa::portable()));
                assert!(expected.indirect.photons.len() > 1000 && expected.ledger.is_balanced());
                Isa::available().for_each(|isa| assert_same(&followed(&course(isa)), &expected, isa));
            }
        }
    }

    /// The photons of one packet after another, bounced in lanes or one by one.
    fn bounced(course: &Course, in_lanes: bool) -> (Vec<[[u32; LANES]; 10]>, PhotonChunk) {
        let (mut wavefront, mut chunk) = (Wavefront::default(), PhotonChunk::default());
        let draws = |segment| Draws { seed: 5, pass: 1, first: 0, segment };
        wavefront.emit(course, 0..PATHS, draws(0), &mut chunk);
        let mut onward = Vec::new();
        for segment in 1..4 {
            let Wavefront { flights, next, order, packet, pasts } = &mut wavefront;
            flights.by_octant(order);
            for places in order.chunks(LANES) {
                flights.pack(places, &mut packet.photons);
                onward.push(packet.photons.to_bits());
                packet.trace(course, Coherence::Coherent);
                packet.surfaces.lambertian &= if in_lanes { Mask::MAX } else { 0 };
                packet.arrive(course, draws(segment), pasts, &mut chunk, next);
            }
            std::mem::swap(flights, next);
            next.clear();
        }
        (onward, chunk)
    }

    /// The lanes against the definition, bit by bit.
    #[test]
    fn lanes_bounce_as_single_photons_do() {
        for scene in scenes() {
            let settings = Settings::of_scene(scene.render());
            for isa in Isa::available() {
                let course = Course { isa, ..Course::natural((&scene).into(), &settings, 0) };
                let ((flights, chunk), (expected, expected_chunk)) =
                    (bounced(&course, true), bounced(&course, false));
                assert!(flights.len() > 100 && flights == expected, "{isa}");
                assert_same(&chunk, &expected_chunk, isa);
            }
        }
    }
}
