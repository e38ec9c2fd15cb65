use std::f32::consts::PI;
use std::ops::Range;

use rayon::prelude::*;

use super::path_tracer::{MAX_SEGMENTS, random_lens_sample, random_ray};
use crate::bsdf::{Choice, Coat, DiffuseSampling, Event, Scattering, Transport, sample_diffuse};
use crate::math::{DVec3, Frame, Ray, Rgb, Rng, Stream, Vec2, Vec3};
use crate::scene::{FilmDesc, Media, Scene, SurfaceHit};

/// Paths that one task follows; fixed, so that the order in which splats are summed is.
const CHUNK: usize = 1024;

/// Paths whose splats are in memory at a time, in whole chunks.
const ROUND: usize = 256 * CHUNK;

/// What a path adds to a pixel.
#[derive(Clone, Copy, Debug)]
struct Splat {
    pixel: usize,
    radiance: Rgb,
}

/// Sample number `sample` of every pixel: as many light paths as there are pixels.
///
/// Path `i` draws from the generator keyed by (seed, sample, i), and splats are summed in the order of the paths.
pub fn splat(scene: &Scene, seed: u64, sample: u32) -> Vec<DVec3> {
    let paths = scene.film().pixels();
    let mut sums = vec![DVec3::ZERO; paths];
    for round in (0..paths).step_by(ROUND) {
        let end = (round + ROUND).min(paths);
        let starts: Vec<usize> = (round..end).step_by(CHUNK).collect();
        let follow = |start: usize| splats_of(scene, seed, sample, start..(start + CHUNK).min(end));
        let chunks: Vec<Vec<Splat>> = starts.into_par_iter().map(follow).collect();
        for splat in chunks.iter().flatten() {
            sums[splat.pixel] += splat.radiance.as_dvec3();
        }
    }
    sums.iter_mut().for_each(|sum| *sum /= paths as f64);
    sums
}

fn splats_of(scene: &Scene, seed: u64, sample: u32, paths: Range<usize>) -> Vec<Splat> {
    let mut splats = Vec::new();
    for path in paths {
        let rng = Rng::new(seed, Stream::LightTracer, sample, path as u64);
        follow(scene, rng, &mut splats);
    }
    splats
}

/// One path from the lights to its end.
fn follow(scene: &Scene, mut rng: Rng, splats: &mut Vec<Splat>) {
    let Some(emission) = scene.lights().sample_emission(&mut rng) else { return };
    let (ray, media) = (Ray::new(emission.origin, emission.dir), scene.light_media(emission.origin));
    let mut path = LightPath { ray, power: emission.power, media };
    for _ in 0..MAX_SEGMENTS {
        let Some(hit) = scene.intersect(&path.ray) else { return };
        path.power *= scene.transmittance(path.media, hit.t);
        if scene.passes(&hit, &mut rng) {
            (path.ray, path.media) = (hit.pass(), scene.crossed(path.media, &hit));
            continue;
        }
        let scattering = scene.scatter_by(&hit, Transport::Power, || rng.next_vec2());
        if let Some(seen) = path.connected(scene, &hit, &scattering, &mut rng) {
            splats.extend(filtered(scene, seen));
        }
        let Some(choice) = scattering.choose(rng.next_f32()) else { return };
        match path.scattered(scene, choice, scattering.coat, &hit, &mut rng) {
            Some(next) if next.power.max_element() > 0.0 => path = next,
            _ => return,
        }
    }
}

struct LightPath {
    ray: Ray,
    /// Emitted flux over the density of the path (W).
    power: Rgb,
    /// What the ray goes through.
    media: Media,
}

impl LightPath {
    /// What the camera sees of the diffuse bounce at `hit`, or of what its facets scatter; `None` where it does not see the
    /// surface, or the surface not the path.
    fn connected(
        &self,
        scene: &Scene,
        hit: &SurfaceHit,
        scattering: &Scattering,
        rng: &mut Rng,
    ) -> Option<Connection> {
        let (lens, margin) = (random_lens_sample(scene, rng), scene.film().filter.reach() - 0.5);
        let seen = scene.camera().project(hit.p, lens, margin)?;
        let (event, value) = scattered_towards(scene, hit, scattering, seen.to_camera)?;
        // The sides are those of any such bounce, so that no light leaks through the surface.
        let origin = hit.continue_along(event, seen.to_camera)?.origin;
        let correction = hit.adjoint_correction(event, seen.to_camera);
        let sight = Ray { origin, dir: seen.through - origin, t_max: 1.0 };
        let left = scene.transmittance(scene.camera_media(), sight.dir.length());
        let radiance = self.power * value * left * (correction * seen.pixels_per_area);
        let visible = radiance.max_element() > 0.0 && !scene.occluded(&sight);
        visible.then_some(Connection { raster: seen.raster, radiance })
    }

    fn scattered(
        &self,
        scene: &Scene,
        choice: Choice,
        coat: Coat,
        hit: &SurfaceHit,
        rng: &mut Rng,
    ) -> Option<LightPath> {
        let (event, dir, factor) = match choice {
            Choice::Specular { event, wi, factor, .. } => (event, hit.frame().to_world(wi), factor),
            Choice::Diffuse { factor } => {
                // Around the true normal, as the correction for shading normals asks.
                let (wi, _) = sample_diffuse(DiffuseSampling::Cosine, Vec3::Z, rng);
                let factor = factor * coat.transmittance(wi.z);
                (Event::Diffuse, Frame::around(hit.receiver().ng).to_world(wi), factor)
            }
        };
        let ray = hit.continue_along(event, dir)?;
        let media = if event.crosses() { scene.crossed(self.media, hit) } else { self.media };
        Some(LightPath { ray, power: self.power * factor * hit.adjoint_correction(event, dir), media })
    }
}

/// `f cos θ` towards the camera by the true normal, but for the correction of shading normals (1/sr).
fn scattered_towards(
    scene: &Scene,
    hit: &SurfaceHit,
    scattering: &Scattering,
    dir: Vec3,
) -> Option<(Event, Rgb)> {
    match scene.glossy(hit, Transport::Power) {
        Some(glossy) => {
            let response = glossy.respond(hit.frame().to_local(dir))?;
            Some((response.event, response.value))
        }
        None if scattering.albedo == Rgb::ZERO => None,
        None => {
            let entry = scattering.coat.transmittance(hit.normal.dot(dir));
            Some((Event::Diffuse, scattering.albedo / PI * (entry * hit.ng.dot(dir).abs())))
        }
    }
}

/// A vertex of a light path, connected to the camera: what the film receives of it at a point.
struct Connection {
    /// In pixels from the top left corner of the picture.
    raster: Vec2,
    /// What a pixel of one point receives, if all of it is there.
    radiance: Rgb,
}

/// What the pixels around receive of it, each by its filter.
fn filtered(scene: &Scene, connection: Connection) -> impl Iterator<Item = Splat> {
    let FilmDesc { width, height, filter } = scene.film();
    let near = |at: f32, side: u32| {
        let first = (at - 0.5 - filter.reach()).ceil().max(0.0) as u32;
        first..((at - 0.5 + filter.reach()).floor() + 1.0).clamp(0.0, side as f32) as u32
    };
    let columns = near(connection.raster.x, width);
    let pixels = near(connection.raster.y, height).flat_map(move |y| columns.clone().map(move |x| (x, y)));
    pixels.filter_map(move |(x, y)| {
        let middle = Vec2::new(x as f32, y as f32) + 0.5;
        let share = filter.density(connection.raster - middle);
        let pixel = y as usize * width as usize + x as usize;
        (share > 0.0).then_some(Splat { pixel, radiance: share * connection.radiance })
    })
}

/// Sample number `sample` of the light that pixel number `pixel` receives straight from a lamp.
pub fn seen_emission(scene: &Scene, seed: u64, sample: u32, pixel: usize) -> Rgb {
    if !scene.lights().any_area() {
        return Rgb::ZERO;
    }
    let mut rng = Rng::new(seed, Stream::SeenLamps, sample, pixel as u64);
    let ray = random_ray(scene, pixel, &mut rng);
    let left = |distance| scene.transmittance(scene.camera_media(), distance);
    match scene.intersect(&ray) {
        Some(hit) => left(hit.t) * scene.emission(&hit),
        None => left(f32::INFINITY) * scene.sky(&ray),
    }
}

/// The share of the pixels in whose middle the camera first sees a surface that mirrors or refracts, or a mask: there
/// [`super::Method::Light`] finds only what the surface itself emits and scatters diffusely.
pub fn share_seen_specular(scene: &Scene) -> f64 {
    let width = scene.film().width as usize;
    let specular = |&pixel: &usize| {
        let middle = Vec2::new((pixel % width) as f32, (pixel / width) as f32) + 0.5;
        let hit = scene.intersect(&scene.camera().ray(middle));
        hit.is_some_and(|hit| {
            scene.opacity(&hit) < 1.0 || scene.scatter(&hit, Transport::Camera).specular().next().is_some()
        })
    };
    (0..scene.film().pixels()).into_par_iter().filter(specular).count() as f64 / scene.film().pixels() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene;
    use std::path::Path;

    /// Of so many pixels that a second round follows a part of its paths, in chunks of which the last is not full.
    #[test]
    fn every_path_is_followed_once_and_summed_in_order() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/cornell_b.toml");
        let mut desc = scene::load(&path).unwrap();
        (desc.film.width, desc.film.height) = (531, 499);
        let scene = Scene::new(desc).unwrap();
        let paths = scene.film().pixels();
        assert!(paths > ROUND && !(paths - ROUND).is_multiple_of(CHUNK));
        let mut expected = vec![DVec3::ZERO; paths];
        for splat in splats_of(&scene, 5, 3, 0..paths) {
            expected[splat.pixel] += splat.radiance.as_dvec3();
        }
        expected.iter_mut().for_each(|sum| *sum /= paths as f64);
        assert!(splat(&scene, 5, 3) == expected);
        assert!(splat(&scene, 5, 4) != expected, "every sample has its own paths");
        assert!(splat(&scene, 6, 3) != expected, "every seed has its own paths");
    }
}
