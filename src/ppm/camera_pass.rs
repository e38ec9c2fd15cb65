//! The eye pass: Whitted's tree of specular rays from the camera, which leaves hit points where it meets diffuse surfaces.

use rayon::prelude::*;

use super::eye_trees::{Branch, Course, EyeTrees, Fronts, Tile};
use super::strata::Strata;
use super::{GlossyPoint, HitPoints, Settings, Stage};
use crate::math::{Ray, Rgb, Rng, Stream, Vec2};
use crate::scene::Scene;

/// What the camera sees before any photon is traced.
#[derive(Debug)]
pub struct EyePass {
    /// The hit points, tile by tile of the picture.
    pub hit_points: HitPoints,
    /// Points of rough surfaces, where caustics are collected there; tile by tile.
    pub glossy_points: Vec<GlossyPoint>,
    /// Radiance of the lights that are seen directly or along specular chains, by pixel.
    pub emitted: Vec<Rgb>,
    /// Rays traced; those from rough surfaces to lights are among them.
    pub rays: u64,
    /// The share of the picture's weight that was cut at the depth limit.
    pub cut_weight: f64,
}

/// Side of the square tile of pixels whose eye paths are traced together, in pixels.
const TILE: u32 = 32;

/// Traces every eye path of the picture, tile by tile in parallel; the order of the result is that of the tiles. Every
/// `pass` has paths of its own.
pub fn trace<'a>(stage: impl Into<Stage<'a>>, settings: &Settings, pass: u32) -> EyePass {
    let stage = stage.into();
    let scene = stage.scene;
    let course = Course { stage, settings, pass };
    let tiles: Vec<Tile> = (0..tiles(scene))
        .into_par_iter()
        .map_init(Fronts::default, |fronts, k| trace_tile(course, k, fronts, |_| ()))
        .collect();
    let mut emitted = vec![Rgb::ZERO; scene.film().pixels()];
    for (pixel, radiance) in tiles.iter().flat_map(|tile| &tile.emitted) {
        emitted[*pixel as usize] += *radiance;
    }
    let share = 1.0 / emitted.len() as f64;
    EyePass {
        emitted,
        glossy_points: tiles.iter().flat_map(|tile| &tile.glossy_points).copied().collect(),
        rays: tiles.iter().map(|tile| tile.rays).sum(),
        cut_weight: share * tiles.iter().map(|tile| tile.cut_weight).sum::<f64>(),
        hit_points: HitPoints::new(tiles.into_iter().map(|tile| tile.hit_points).collect()),
    }
}

/// The rays that [`trace`] sends through the scene in the first pass, in the order in which it traces them.
pub fn record_rays(scene: &Scene, settings: &Settings) -> Vec<Ray> {
    let course = Course { stage: scene.into(), settings, pass: 0 };
    let rays_of = |k| {
        let mut recorded = Vec::new();
        let see = |rays: &[Ray]| recorded.extend_from_slice(rays);
        trace_tile(course, k, &mut Fronts::default(), see);
        recorded
    };
    (0..tiles(scene)).into_par_iter().map(rays_of).collect::<Vec<_>>().concat()
}

fn tiles(scene: &Scene) -> u32 {
    scene.film().width.div_ceil(TILE) * scene.film().height.div_ceil(TILE)
}

/// Shows the rays of every batch to `see` before they are traced.
fn trace_tile(course: Course, tile: u32, fronts: &mut Fronts, mut see: impl FnMut(&[Ray])) -> Tile {
    let Course { stage: Stage { scene, .. }, settings, .. } = course;
    let (width, height) = (scene.film().width, scene.film().height);
    let columns = width.div_ceil(TILE);
    let (left, top) = (tile % columns * TILE, tile / columns * TILE);
    let (samples, media) = (settings.samples, scene.camera_media());
    let (strata, weight) = (Strata::new(samples), 1.0 / samples as f32);
    let mut trees = EyeTrees::new(course, (TILE * TILE) as usize * samples as usize);
    for y in top..height.min(top + TILE) {
        for x in left..width.min(left + TILE) {
            let pixel = y * width + x;
            eye_rays(course, &strata, pixel, |ray, sample| {
                fronts.start(ray, Branch::first(weight, pixel, sample, media));
            });
            if fronts.make_a_batch() {
                trees.trace(fronts, &mut see);
            }
        }
    }
    trees.trace(fronts, &mut see);
    trees.tile
}

/// Gives `take` the rays of a pixel's eye samples, with their numbers: one for every stratum of its filter, and of the lens.
fn eye_rays(course: Course, strata: &Strata, pixel: u32, mut take: impl FnMut(Ray, u32)) {
    let Course { stage: Stage { scene, .. }, settings, pass } = course;
    let film = scene.film();
    let corner = Vec2::new((pixel % film.width) as f32, (pixel / film.width) as f32);
    let generator = |stream| Rng::new(settings.key_of_eye_paths(), stream, pass, u64::from(pixel));
    let lens = if scene.camera().has_lens() {
        strata.shuffled_positions(&mut generator(Stream::Lens))
    } else {
        Vec::new()
    };
    for (u, sample) in strata.positions(&mut generator(Stream::Eye)).zip(0..) {
        let raster = corner + film.filter.sample(u);
        let through = lens.get(sample as usize).copied().unwrap_or_default();
        take(scene.camera().ray_through_lens(raster, through), sample);
    }
}

/// Gives `take` the first rays of a pixel's eye paths in a pass.
pub(super) fn first_rays(
    scene: &Scene,
    settings: &Settings,
    pass: u32,
    pixel: u32,
    mut take: impl FnMut(Ray),
) {
    let course = Course { stage: scene.into(), settings, pass };
    eye_rays(course, &Strata::new(settings.samples), pixel, |ray, _| take(ray));
}

#[cfg(test)]
mod tests {
    use super::super::eye_trees::SPLIT_WEIGHT;
    use super::*;
    use crate::bsdf::{Choice, Event, Transport};
    use crate::math::{Vec3, mean};
    use crate::scene::{self, Media, PixelFilter, SceneDesc};
    use std::f32::consts::PI;
    use std::path::Path;

    /// Not a multiple of the tile's size, so that tiles are cut at two edges.
    const SIZE: (u32, u32) = (70, 45);

    fn glass_and_mirror_desc() -> SceneDesc {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/cornell_b.toml");
        let mut desc = scene::load(&path).unwrap();
        (desc.film.width, desc.film.height) = SIZE;
        desc
    }

    fn glass_and_mirror() -> Scene {
        Scene::new(glass_and_mirror_desc()).unwrap()
    }

    /// What a pixel gets where every hit point has irradiance 1 (the sum of the weights), and its emitted light.
    type Pixel = [f64; 2];

    /// The same trees ray by ray, depth first.
    #[derive(Default)]
    struct Naive {
        pixels: Vec<Pixel>,
        hit_points: usize,
        rays: u64,
        cut_weight: f64,
    }

    impl Naive {
        fn trace(scene: &Scene, settings: &Settings) -> Naive {
            let mut naive = Naive { pixels: vec![[0.0; 2]; (SIZE.0 * SIZE.1) as usize], ..Naive::default() };
            for pixel in 0..SIZE.0 * SIZE.1 {
                let mut rng = Rng::new(settings.key_of_eye_paths(), Stream::Eye, 0, u64::from(pixel));
                for (position, sample) in Strata::new(settings.samples).positions(&mut rng).zip(0..) {
                    let corner = Vec2::new((pixel % SIZE.0) as f32, (pixel / SIZE.0) as f32);
                    let ray = scene.camera().ray(corner + position);
                    let branch = Branch::first(1.0 / settings.samples as f32, pixel, sample, Media::NONE);
                    naive.follow(scene, &ray, branch, settings);
                }
            }
            naive
        }

        fn follow(&mut self, scene: &Scene, ray: &Ray, branch: Branch, settings: &Settings) {
            self.rays += 1;
            let (weight, pixel) = (branch.weight, branch.pixel as usize);
            let Some(hit) = scene.intersect(ray) else { return };
            self.pixels[pixel][1] += f64::from(mean(weight * scene.emission(&hit)));
            let scattering = scene.scatter(&hit, Transport::Camera);
            if scattering.albedo != Rgb::ZERO {
                self.pixels[pixel][0] += f64::from(mean(weight * scattering.albedo / PI));
                self.hit_points += 1;
            }
            let ways: Vec<(Event, Vec3, Rgb)> = if mean(weight) * settings.samples as f32 >= SPLIT_WEIGHT {
                scattering.specular().map(|lobe| (lobe.event, lobe.wi, lobe.weight())).collect()
            } else {
                match scattering.choose(
                    branch
                        .rng(Stream::EyeRoulette, Course { stage: scene.into(), settings, pass: 0 })
                        .next_f32(),
                ) {
                    Some(Choice::Specular { event, wi, factor, .. }) => vec![(event, wi, factor)],
                    _ => vec![],
                }
            };
            for (event, wi, factor) in ways {
                let next = branch.after(event, f32::INFINITY, weight * factor, 0.0);
                match hit.continue_along(event, hit.frame().to_world(wi)) {
                    Some(ray) if next.depth <= settings.depth => self.follow(scene, &ray, next, settings),
                    Some(_) => self.cut_weight += f64::from(mean(next.weight)) / f64::from(SIZE.0 * SIZE.1),
                    None => (),
                }
            }
        }
    }

    fn pixels(eye: &EyePass) -> Vec<Pixel> {
        let mut pixels: Vec<Pixel> = eye.emitted.iter().map(|e| [0.0, f64::from(mean(*e))]).collect();
        for hit_point in eye.hit_points.iter() {
            pixels[hit_point.pixel as usize][0] += f64::from(mean(hit_point.reflectance));
        }
        pixels
    }

    /// Rays that graze an edge may fall either way, here and in the twin.
    #[test]
    fn finds_what_single_rays_find() {
        let scene = glass_and_mirror();
        for (samples, depth) in [(1, 0), (3, 2), (4, 12)] {
            let settings = Settings { samples, depth, ..Settings::of_scene(scene.render()) };
            let (eye, naive) = (trace(&scene, &settings, 0), Naive::trace(&scene, &settings));
            let differs =
                |(a, b): &(Pixel, Pixel)| (0..2).any(|k| (a[k] - b[k]).abs() > 1e-3 * b[k].max(0.1));
            let different = pixels(&eye).into_iter().zip(naive.pixels).filter(differs).count();
            assert!(different <= 3, "{samples} samples, depth {depth}: {different} pixels differ");
            let close = |a: f64, b: f64| (a / b - 1.0).abs() < 2e-3;
            assert!(close(eye.rays as f64, naive.rays as f64), "{} rays for {}", eye.rays, naive.rays);
            assert!(close(eye.hit_points.len() as f64, naive.hit_points as f64));
            assert!(close(eye.cut_weight, naive.cut_weight), "{} for {}", eye.cut_weight, naive.cut_weight);
        }
    }

    /// Of a plain pixel, and of one with a filter and a lens: the middle of the lens and the mean position on the film.
    #[test]
    fn eye_rays_are_spread_over_filter_and_lens() {
        const SAMPLES: u32 = 400;
        let mut desc = glass_and_mirror_desc();
        desc.film.filter = PixelFilter::Tent;
        (desc.camera.lens_radius, desc.camera.focus_distance) = (0.1, 2.0);
        let scene = Scene::new(desc).unwrap();
        let settings = Settings { samples: SAMPLES, ..Settings::of_scene(scene.render()) };
        let (camera, middle) = (scene.camera(), Vec2::new(30.5, 20.5));
        let (mut origin, mut raster, mut correlation) = (Vec3::ZERO, Vec2::ZERO, Vec2::ZERO);
        let right = (camera.ray(Vec2::new(31.5, 20.5)).dir - camera.ray(middle).dir).normalize();
        let course = Course { stage: (&scene).into(), settings: &settings, pass: 0 };
        eye_rays(course, &Strata::new(SAMPLES), 20 * SIZE.0 + 30, |ray, _| {
            let offset = ray.origin - camera.position();
            let chief = Ray::new(
                camera.position(),
                ray.at(2.0 / ray.dir.dot(camera.ray(middle).dir)) - camera.position(),
            );
            let seen = camera.project(chief.at(1.0), Vec2::splat(0.5), 9.0).unwrap().raster - middle;
            (origin, raster) = (origin + offset, raster + seen);
            correlation += seen * offset.dot(right) / 0.1;
        });
        let n = SAMPLES as f32;
        assert!((origin / n).length() < 0.1 * 0.02, "{origin}");
        assert!((raster / n).length() < 0.02, "{raster}");
        assert!((correlation / n).length() < 0.05, "strata of film and lens go together: {correlation}");
    }

    #[test]
    fn recorded_rays_are_those_of_the_pass() {
        let scene = glass_and_mirror();
        let settings = Settings { samples: 2, ..Settings::of_scene(scene.render()) };
        let (eye, rays) = (trace(&scene, &settings, 0), record_rays(&scene, &settings));
        assert_eq!(rays.len() as u64, eye.rays);
        assert!(eye.rays > u64::from(SIZE.0 * SIZE.1 * 2), "the balls mirror and refract");
        let hits = rays.iter().filter_map(|ray| scene.intersect(ray));
        let diffuse = hits.filter(|hit| scene.scatter(hit, Transport::Camera).albedo != Rgb::ZERO);
        assert_eq!(diffuse.count(), eye.hit_points.len());
    }
}
