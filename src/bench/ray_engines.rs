//! What answers which primitive a ray hits, and how to tell answers apart.

use super::BenchError;
use super::ray_scenes::RayKind;
use super::timing::timed;
use crate::bvh::{RayBvh, RayBvhBuilder, RayHit};
use crate::embree::{self, BuildQuality, Coherence, Device, Hit, PacketWidth, SceneBuilder, SceneOptions};
use crate::math::Ray;
use crate::scene::Mesh;

/// How a structure over triangles is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Build {
    /// The project's own tree.
    Custom,
    /// Embree's.
    Embree(SceneOptions),
}

/// All builds; the first is what the program renders with.
pub const BUILDS: [Build; 7] = [
    embree(BuildQuality::High, true),
    Build::Custom,
    embree(BuildQuality::Medium, true),
    embree(BuildQuality::Low, true),
    embree(BuildQuality::High, false),
    embree(BuildQuality::Medium, false),
    embree(BuildQuality::Low, false),
];

const fn embree(quality: BuildQuality, robust: bool) -> Build {
    Build::Embree(SceneOptions { quality, robust })
}

/// What rays are asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Query {
    /// The nearest hit of one ray after the other.
    Nearest,
    /// The nearest hits of packets, which only Embree knows.
    Packets(PacketWidth, Coherence),
    /// Whether there is a hit.
    Any,
}

impl Query {
    /// Whether the rays come sorted; the time of sorting is not counted.
    pub fn wants_sorted_rays(self) -> bool {
        matches!(self, Query::Packets(_, Coherence::Coherent))
    }
}

/// A build that is asked in one way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Engine {
    /// What is asked.
    pub build: Build,
    /// And how.
    pub query: Query,
}

const PACKETS: [Query; 4] = [
    Query::Packets(PacketWidth::Eight, Coherence::Incoherent),
    Query::Packets(PacketWidth::Eight, Coherence::Coherent),
    Query::Packets(PacketWidth::Sixteen, Coherence::Incoherent),
    Query::Packets(PacketWidth::Sixteen, Coherence::Coherent),
];

impl Engine {
    /// Who takes part in a measurement of such rays; shadow rays need no nearest hit. The first is what others are held
    /// against.
    pub fn all(kind: RayKind) -> Vec<Engine> {
        let nearest = BUILDS.map(|build| Engine { build, query: Query::Nearest });
        let packets = PACKETS.map(|query| Engine { build: BUILDS[0], query });
        let any = BUILDS.map(|build| Engine { build, query: Query::Any });
        let any = if kind == RayKind::Shadow { &any[..] } else { &[] };
        [&nearest[..2], &packets, &nearest[2..], any].concat()
    }

    /// The name of what is built.
    pub fn structure(&self) -> &'static str {
        let Build::Embree(options) = self.build else { return "custom tree" };
        match (options.quality, options.robust) {
            (BuildQuality::Low, false) => "Embree low",
            (BuildQuality::Low, true) => "Embree low robust",
            (BuildQuality::Medium, false) => "Embree medium",
            (BuildQuality::Medium, true) => "Embree medium robust",
            (BuildQuality::High, false) => "Embree high",
            (BuildQuality::High, true) => "Embree high robust",
        }
    }

    /// The name of the way in which it is asked.
    pub fn query(&self) -> &'static str {
        match (self.build, self.query) {
            (Build::Custom, Query::Any) => "any hit",
            (Build::Custom, _) => "nearest hit",
            (_, Query::Nearest) => "rtcIntersect1",
            (_, Query::Any) => "rtcOccluded1",
            (_, Query::Packets(PacketWidth::Eight, Coherence::Incoherent)) => "rtcIntersect8",
            (_, Query::Packets(PacketWidth::Eight, Coherence::Coherent)) => "rtcIntersect8 coherent",
            (_, Query::Packets(PacketWidth::Sixteen, Coherence::Incoherent)) => "rtcIntersect16",
            (_, Query::Packets(PacketWidth::Sixteen, Coherence::Coherent)) => "rtcIntersect16 coherent",
        }
    }
}

/// A structure that can be asked.
#[derive(Debug)]
pub enum Structure {
    /// The project's own tree.
    Custom(RayBvh),
    /// Embree's; the device holds nothing else.
    Embree(embree::Scene, Device),
}

/// Rays that one call may ask about.
pub const CHUNK: usize = 256;

impl Structure {
    /// Builds over `meshes` on all threads of the pool, and counts the seconds. Embree is started before.
    ///
    /// # Errors
    /// If the meshes are too large, or want of memory.
    pub fn build(build: Build, meshes: &[Mesh]) -> Result<(Structure, f64), BenchError> {
        match build {
            Build::Custom => {
                let (tree, seconds) = timed(|| custom(meshes));
                Ok((Structure::Custom(tree?), seconds))
            }
            Build::Embree(options) => {
                let device = Device::with_threads(rayon::current_num_threads())?;
                let (scene, seconds) = timed(|| embree_scene(&device, options, meshes));
                Ok((Structure::Embree(scene?, device), seconds))
            }
        }
    }

    /// The memory that it holds, in bytes, with its copy of the triangles.
    pub fn memory_bytes(&self) -> usize {
        match self {
            Structure::Custom(tree) => tree.memory_bytes(),
            Structure::Embree(_, device) => device.memory_bytes(),
        }
    }

    /// Shows the answer to every one of at most [`CHUNK`] rays to `see`. The project's tree takes packets ray by ray.
    pub fn ask(&self, query: Query, rays: &[Ray], mut see: impl FnMut(Answer)) {
        let nearest = Answer::Nearest;
        match (self, query) {
            (Structure::Custom(tree), Query::Any) => {
                rays.iter().for_each(|ray| see(Answer::Any(tree.occluded(ray))));
            }
            (Structure::Custom(tree), _) => {
                rays.iter().for_each(|ray| see(nearest(tree.intersect(ray).map(of_embree))));
            }
            (Structure::Embree(scene, _), Query::Any) => {
                rays.iter().for_each(|ray| see(Answer::Any(scene.occluded(ray))));
            }
            (Structure::Embree(scene, _), Query::Nearest) => {
                rays.iter().for_each(|ray| see(nearest(scene.intersect(ray))));
            }
            (Structure::Embree(scene, _), Query::Packets(width, coherence)) => {
                let mut hits = [None; CHUNK];
                let hits = &mut hits[..rays.len()];
                scene.intersect_packets(rays, hits, width, coherence);
                hits.iter().for_each(|&hit| see(nearest(hit)));
            }
        }
    }
}

fn custom(meshes: &[Mesh]) -> Result<RayBvh, BenchError> {
    let mut builder = RayBvhBuilder::new();
    for mesh in meshes {
        builder.add_triangles(&mesh.vertices, &mesh.triangles)?;
    }
    Ok(builder.build())
}

fn embree_scene(
    device: &Device,
    options: SceneOptions,
    meshes: &[Mesh],
) -> Result<embree::Scene, BenchError> {
    let mut builder = SceneBuilder::with_options(device, options)?;
    for mesh in meshes {
        builder.add_triangles(&mesh.vertices, &mesh.triangles)?;
    }
    Ok(builder.commit()?)
}

fn of_embree(hit: RayHit) -> Hit {
    let RayHit { t, u, v, ng, geometry, primitive } = hit;
    Hit { t, u, v, ng, geometry, primitive }
}

/// What was said of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Answer {
    /// Its nearest hit.
    Nearest(Option<Hit>),
    /// Whether it hits anything.
    Any(bool),
}

impl Answer {
    fn is_hit(self) -> bool {
        match self {
            Answer::Nearest(hit) => hit.is_some(),
            Answer::Any(hit) => hit,
        }
    }
}

/// How often answers differed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Disagreements {
    /// Another primitive at another distance, or a hit against a miss.
    pub different: u64,
    /// The same primitive at another distance.
    pub distances: u64,
    /// Another primitive at the same distance: an edge that they share.
    pub ties: u64,
}

/// Distances closer than this share of the distance are the same.
const SAME_DISTANCE: f32 = 1e-5;

impl Disagreements {
    const ONE_DIFFERENT: Disagreements = Disagreements { different: 1, distances: 0, ties: 0 };

    /// Of one ray.
    pub fn between(found: Answer, expected: Answer) -> Disagreements {
        if found.is_hit() != expected.is_hit() {
            return Disagreements::ONE_DIFFERENT;
        }
        let (Answer::Nearest(Some(a)), Answer::Nearest(Some(b))) = (found, expected) else {
            return Disagreements::default();
        };
        let same_distance = (a.t - b.t).abs() <= SAME_DISTANCE * b.t;
        match ((a.geometry, a.primitive) == (b.geometry, b.primitive), same_distance) {
            (true, true) => Disagreements::default(),
            (true, false) => Disagreements { distances: 1, ..Disagreements::default() },
            (false, true) => Disagreements { ties: 1, ..Disagreements::default() },
            (false, false) => Disagreements::ONE_DIFFERENT,
        }
    }

    /// Those of both.
    pub fn plus(self, other: Disagreements) -> Disagreements {
        Disagreements {
            different: self.different + other.different,
            distances: self.distances + other.distances,
            ties: self.ties + other.ties,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::ray_scenes::{record, room};
    use super::*;
    use crate::math::Vec3;

    fn hit(t: f32, primitive: u32) -> Option<Hit> {
        Some(Hit { t, u: 0.0, v: 0.0, ng: Vec3::X, geometry: 1, primitive })
    }

    #[test]
    fn wrong_answers_are_counted() {
        let count = |found, expected| {
            let Disagreements { different, distances, ties } =
                Disagreements::between(found, Answer::Nearest(expected));
            [different, distances, ties]
        };
        let nearest = |found, expected| count(Answer::Nearest(found), expected);
        assert_eq!(nearest(None, None), [0, 0, 0]);
        assert_eq!(nearest(hit(2.0, 7), hit(2.0, 7)), [0, 0, 0]);
        assert_eq!(nearest(hit(2.0, 7), hit(2.000_01, 7)), [0, 0, 0]);
        assert_eq!(nearest(hit(2.0, 7), hit(2.0001, 7)), [0, 1, 0]);
        assert_eq!(nearest(hit(f32::NAN, 7), hit(2.0, 7)), [0, 1, 0]);
        assert_eq!(nearest(hit(2.0, 8), hit(2.0, 7)), [0, 0, 1]);
        assert_eq!(nearest(hit(2.0, 8), hit(3.0, 7)), [1, 0, 0]);
        assert_eq!([nearest(None, hit(2.0, 7)), nearest(hit(2.0, 7), None)], [[1, 0, 0]; 2]);
        let other_geometry = hit(2.0, 7).map(|hit| Hit { geometry: 0, ..hit });
        assert_eq!(nearest(other_geometry, hit(2.0, 7)), [0, 0, 1]);
        assert_eq!([count(Answer::Any(true), None), count(Answer::Any(false), hit(1.0, 0))], [[1, 0, 0]; 2]);
        assert_eq!([count(Answer::Any(false), None), count(Answer::Any(true), hit(1.0, 0))], [[0; 3]; 2]);
    }

    #[test]
    fn every_engine_answers_every_ray_in_order() {
        let desc = room(500, 1000);
        let sets = record(desc.clone()).unwrap();
        let tree = Structure::build(Build::Custom, &desc.meshes).unwrap().0;
        for engine in Engine::all(RayKind::Shadow) {
            let structure = Structure::build(engine.build, &desc.meshes).unwrap().0;
            let (mut rays, mut disagreements) = (0, Disagreements::default());
            for chunk in sets.iter().flat_map(|set| set.sorted.chunks(CHUNK)) {
                let (mut expected, mut found) = (Vec::new(), Vec::new());
                tree.ask(Query::Nearest, chunk, |answer| expected.push(answer));
                structure.ask(engine.query, chunk, |answer| found.push(answer));
                assert_eq!(found.len(), chunk.len());
                for (&found, &expected) in found.iter().zip(&expected) {
                    disagreements = disagreements.plus(Disagreements::between(found, expected));
                }
                rays += chunk.len();
            }
            assert!(rays > 2000 && disagreements.different == 0, "{engine:?}: {disagreements:?} of {rays}");
        }
    }

    #[test]
    fn names_tell_engines_apart() {
        let mut names: Vec<_> =
            Engine::all(RayKind::Shadow).iter().map(|e| (e.structure(), e.query())).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), 18);
        assert_eq!(Engine::all(RayKind::Eye).len(), 11);
    }
}
