//! A chunk of photons on their way, all of them one bounce at a time, so that their rays can share packets.

use std::ops::Range;

use super::Ledger;
use super::course::Course;
use super::draws::Draws;
use super::emission::Emission;
use super::flights::{FlightPacket, Flights};
use super::lane_flux::PowerOf;
use super::pasts::Pasts;
use super::photon_packet::Packet;
use super::photons::PhotonChunk;
use crate::effects::PathClass;
use crate::math::DVec3;
use crate::scene::Coherence;
use crate::simd::{LANES, first_lanes};

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

#[cfg(test)]
mod tests {
    use super::super::Settings;
    use super::*;
    use crate::bsdf::DiffuseSampling;
    use crate::scene::{self, Scene};
    use crate::simd::{Isa, Mask};
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
