//! How many rays slip out of closed meshes between their triangles.

use std::ops::Range;

use rayon::prelude::*;
use serde::Serialize;

use super::BenchError;
use super::closed_meshes::{ClosedMesh, MESHES};
use super::machine::Machine;
use super::timing::timed;
use crate::bsdf::{DiffuseSampling, Event, sample_diffuse};
use crate::math::{Ray, Rng, Stream};
use crate::scene::{Scene, SurfaceHit, Traversal};

/// Who may let rays slip through.
pub const TRAVERSALS: [Traversal; 3] = [Traversal::Embree, Traversal::EmbreeFast, Traversal::Custom];

/// Rays that are drawn, timed and counted together.
const CHUNK: u64 = 1 << 14;

/// The measurement: every row is a mesh by one way of tracing.
#[derive(Clone, Debug, Serialize)]
pub struct LeakReport {
    /// What it was measured on.
    pub machine: Machine,
    /// Threads.
    pub threads: usize,
    /// One for each mesh and traversal.
    pub rows: Vec<LeakRow>,
}

/// What one way of tracing lets out of one mesh.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LeakRow {
    /// The mesh.
    pub mesh: &'static str,
    /// Its triangles.
    pub triangles: usize,
    /// Who traced.
    pub traversal: String,
    /// From inside to points on edges.
    pub edges: Leaks,
    /// From inside to vertices.
    pub vertices: Leaks,
    /// Onward from where those met the mesh.
    pub bounces: Leaks,
    /// Million rays to edges and vertices a second and thread.
    pub rays_per_microsecond: f64,
}

/// Rays, and those of them that met nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Leaks {
    /// All.
    pub rays: u64,
    /// Those that slipped out.
    pub leaks: u64,
}

impl Leaks {
    /// One ray more.
    fn count(&mut self, is_leak: bool) {
        self.rays += 1;
        self.leaks += u64::from(is_leak);
    }

    fn plus(self, other: Leaks) -> Leaks {
        Leaks { rays: self.rays + other.rays, leaks: self.leaks + other.leaks }
    }
}

#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    edges: Leaks,
    vertices: Leaks,
    bounces: Leaks,
    seconds: f64,
}

impl Tally {
    fn plus(self, other: Tally) -> Tally {
        Tally {
            edges: self.edges.plus(other.edges),
            vertices: self.vertices.plus(other.vertices),
            bounces: self.bounces.plus(other.bounces),
            seconds: self.seconds + other.seconds,
        }
    }
}

/// Sends `rays` rays into every mesh by every traversal, and another from wherever one of them arrives.
///
/// # Errors
/// If Embree cannot be started or refuses a mesh.
pub fn measure(rays: u64, mut progress: impl FnMut(&str)) -> Result<LeakReport, BenchError> {
    let mut rows = Vec::new();
    for mesh in MESHES {
        progress(mesh.name());
        for traversal in TRAVERSALS {
            rows.push(row(mesh, traversal, rays)?);
        }
    }
    Ok(LeakReport { machine: Machine::detect()?, threads: rayon::current_num_threads(), rows })
}

fn row(mesh: ClosedMesh, traversal: Traversal, rays: u64) -> Result<LeakRow, BenchError> {
    let scene = Scene::with_traversal(mesh.scene(), traversal)?;
    let chunks = (0..rays.div_ceil(CHUNK)).into_par_iter();
    let tally = chunks
        .map(|chunk| count(&scene, mesh, chunk * CHUNK..rays.min((chunk + 1) * CHUNK)))
        .reduce(Tally::default, Tally::plus);
    let rays = tally.edges.plus(tally.vertices).rays;
    Ok(LeakRow {
        mesh: mesh.name(),
        triangles: scene.primitives(),
        traversal: traversal.to_string(),
        edges: tally.edges,
        vertices: tally.vertices,
        bounces: tally.bounces,
        rays_per_microsecond: rays as f64 / (1e6 * tally.seconds),
    })
}

/// Every other ray goes to a vertex.
fn count(scene: &Scene, mesh: ClosedMesh, indices: Range<u64>) -> Tally {
    let shape = mesh.shape();
    let mut rngs: Vec<Rng> = indices.map(|index| Rng::new(0, Stream::Probe, 0, index)).collect();
    let rays: Vec<Ray> = rngs
        .iter_mut()
        .enumerate()
        .map(|(k, rng)| if k % 2 == 0 { shape.ray_to_an_edge(rng) } else { shape.ray_to_a_vertex(rng) })
        .collect();
    let (hits, seconds): (Vec<Option<SurfaceHit>>, f64) =
        timed(|| rays.iter().map(|ray| scene.intersect(ray)).collect());
    let mut tally = Tally { seconds, ..Tally::default() };
    for (k, (hit, rng)) in hits.iter().zip(&mut rngs).enumerate() {
        let aimed = if k % 2 == 0 { &mut tally.edges } else { &mut tally.vertices };
        aimed.count(hit.is_none());
        if let Some(ray) = hit.and_then(|hit| bounce(&hit, rng)) {
            tally.bounces.count(scene.distance(&ray).is_none());
        }
    }
    tally
}

/// The way of a photon off the wall that it has met.
fn bounce(hit: &SurfaceHit, rng: &mut Rng) -> Option<Ray> {
    let (wi, _) = sample_diffuse(DiffuseSampling::Uniform, hit.wo_local(), rng);
    hit.continue_along(Event::Diffuse, hit.frame().to_world(wi))
}
