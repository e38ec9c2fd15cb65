//! The eye pass: Whitted's tree of specular rays from the camera, which leaves hit points where it meets diffuse surfaces.
//!
//! Where glass is in glass such a tree doubles from event to event. So branches fainter than 1/4096 of their sample follow one
//! way, chosen by roulette: what they find is right on average, and no more than some thousand can be brighter.

use std::f32::consts::PI;
use std::ops::Range;

use rayon::prelude::*;

use super::{GlossyPoint, HitPoint, HitPoints, Settings, Stage};
use crate::bsdf::{Choice, Event, Scattering, Transport};
use crate::math::{Ray, Rgb, Rng, Stream, Vec2, mean};
use crate::scene::{Coherence, Media, Scene, SurfaceHit};

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

/// Most rays that are traced at a time. The newest go first, so that few wait however the trees branch.
const BATCH: usize = 8192;

/// The share of an eye sample below which its branches do not split.
const SPLIT_WEIGHT: f32 = 1.0 / 4096.0;

/// Traces every eye path of the picture, tile by tile in parallel; the order of the result is that of the tiles. Every
/// `pass` has paths of its own.
pub fn trace<'a>(stage: impl Into<Stage<'a>>, settings: &Settings, pass: u32) -> EyePass {
    let stage = stage.into();
    let scene = stage.scene;
    let course = Course { stage, settings, pass };
    let (width, height) = (scene.film().width, scene.film().height);
    let tiles: Vec<Tile> = (0..tiles(scene))
        .into_par_iter()
        .map_init(Fronts::default, |fronts, k| trace_tile(course, k, fronts, |_| ()))
        .collect();
    let mut emitted = vec![Rgb::ZERO; scene.film().pixels()];
    for (pixel, radiance) in tiles.iter().flat_map(|tile| &tile.emitted) {
        emitted[*pixel as usize] += *radiance;
    }
    let share = 1.0 / (f64::from(width) * f64::from(height));
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

/// What eye paths depend on.
#[derive(Clone, Copy)]
struct Course<'a> {
    stage: Stage<'a>,
    settings: &'a Settings,
    pass: u32,
}

/// What the eye paths of a tile found.
#[derive(Default)]
struct Tile {
    hit_points: Vec<HitPoint>,
    glossy_points: Vec<GlossyPoint>,
    /// Radiance of lights, with the pixel that sees it.
    emitted: Vec<(u32, Rgb)>,
    rays: u64,
    cut_weight: f64,
}

/// Shows the rays of every batch to `see` before they are traced.
fn trace_tile(course: Course, tile: u32, fronts: &mut Fronts, mut see: impl FnMut(&[Ray])) -> Tile {
    let Course { stage: Stage { scene, .. }, settings, .. } = course;
    let (width, height) = (scene.film().width, scene.film().height);
    let columns = width.div_ceil(TILE);
    let (left, top) = (tile % columns * TILE, tile / columns * TILE);
    let samples = settings.samples;
    let expected = (TILE * TILE) as usize * samples as usize;
    let tile = Tile { hit_points: Vec::with_capacity(expected.min(BATCH)), ..Tile::default() };
    let (pixel_width, media) = (scene.camera().pixel_width(), scene.camera_media());
    let (strata, weight) = (Strata::new(samples), 1.0 / samples as f32);
    let split_weight = SPLIT_WEIGHT * weight;
    let mut trees = EyeTrees { course, split_weight, pixel_width, tile };
    for y in top..height.min(top + TILE) {
        for x in left..width.min(left + TILE) {
            let pixel = y * width + x;
            eye_rays(course, &strata, pixel, |ray, sample| {
                let first = Branch { media, ..Branch::first(weight, pixel, sample) };
                fronts.waiting[0].push(ray, first);
            });
            if fronts.waiting[0].rays.len() >= BATCH {
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

/// Strata of equal size and nearly equal sides, as many as there are samples, that tile a pixel.
struct Strata {
    columns: u32,
    rows: u32,
}

impl Strata {
    /// A prime number makes a single column.
    fn new(samples: u32) -> Strata {
        let columns = (1..=samples.isqrt()).rev().find(|c| samples.is_multiple_of(*c)).unwrap_or(1);
        Strata { columns, rows: samples / columns }
    }

    /// A random position in each of them.
    fn positions(&self, rng: &mut Rng) -> impl Iterator<Item = Vec2> {
        let strata = Vec2::new(self.columns as f32, self.rows as f32);
        let corners = (0..self.rows).flat_map(|y| (0..self.columns).map(move |x| (x, y)));
        corners.map(move |(x, y)| (Vec2::new(x as f32, y as f32) + rng.next_vec2()) / strata)
    }

    /// The same in any order, so that what is drawn from other strata has nothing to do with it.
    fn shuffled_positions(&self, rng: &mut Rng) -> Vec<Vec2> {
        let mut positions: Vec<Vec2> = self.positions(rng).collect();
        for last in (1..positions.len()).rev() {
            let chosen = (u64::from(rng.next_u32()) * (last as u64 + 1)) >> 32;
            positions.swap(last, chosen as usize);
        }
        positions
    }
}

/// One branch of the tree of an eye sample.
#[derive(Clone, Copy)]
struct Branch {
    weight: Rgb,
    length: f32,
    pixel: u32,
    depth: u32,
    /// Which branch of which sample it is: a hash of the turns that it took.
    key: u32,
    /// What its ray goes through.
    media: Media,
    /// The density of its direction (1/sr) where a facet of a rough surface gave that; else infinite.
    pdf_w: f32,
}

impl Branch {
    fn first(weight: f32, pixel: u32, sample: u32) -> Branch {
        let (weight, key) = (Rgb::splat(weight), sample);
        Branch { weight, length: 0.0, pixel, depth: 0, key, media: Media::NONE, pdf_w: f32::INFINITY }
    }

    fn after(&self, event: Event, pdf_w: f32, weight: Rgb, length: f32) -> Branch {
        const SPREAD: u32 = 0x9E37_79B1;
        let key = self.key.wrapping_add(event as u32 + 1).wrapping_mul(SPREAD);
        Branch { weight, length, depth: self.depth + 1, key, pdf_w, ..*self }
    }

    /// Straight on through a mask. No branch goes on by a diffuse event, so its key is free.
    fn straight_on(&self, weight: Rgb, length: f32) -> Branch {
        self.after(Event::Diffuse, f32::INFINITY, weight, length)
    }

    /// Its numbers: of each stream others.
    fn rng(&self, stream: Stream, Course { settings, pass, .. }: Course) -> Rng {
        let index = u64::from(pass) << 32 | u64::from(self.pixel);
        Rng::new(settings.key_of_eye_paths(), stream, self.key, index)
    }
}

/// Rays, and the branches that they belong to.
#[derive(Default)]
struct Front {
    rays: Vec<Ray>,
    branches: Vec<Branch>,
}

impl Front {
    fn push(&mut self, ray: Ray, branch: Branch) {
        self.rays.push(ray);
        self.branches.push(branch);
    }

    /// Replaces the contents by the newest of `waiting`, up to [`BATCH`] of them.
    fn take_from(&mut self, waiting: &mut Front) {
        self.rays.clear();
        self.branches.clear();
        let first = waiting.rays.len().saturating_sub(BATCH);
        if first == 0 {
            std::mem::swap(self, waiting);
        } else {
            self.rays.extend(waiting.rays.drain(first..));
            self.branches.extend(waiting.branches.drain(first..));
        }
    }
}

/// Buffers that one thread uses for tile after tile.
#[derive(Default)]
struct Fronts {
    /// Mirrored rays and rays that went through a surface: each kind points alike, the two together do not.
    waiting: [Front; 2],
    batch: Front,
}

/// The trees of the eye samples of a tile, and where their results go.
struct EyeTrees<'a> {
    course: Course<'a>,
    split_weight: f32,
    pixel_width: f32,
    tile: Tile,
}

impl EyeTrees<'_> {
    /// Traces all that waits, and what comes of it.
    fn trace(&mut self, fronts: &mut Fronts, see: &mut impl FnMut(&[Ray])) {
        let Fronts { waiting, batch } = fronts;
        let scene = self.course.stage.scene;
        let veiled = scene.has_masks() || scene.absorbs();
        loop {
            let fuller = usize::from(waiting[1].rays.len() > waiting[0].rays.len());
            batch.take_from(&mut waiting[fuller]);
            if batch.rays.is_empty() {
                return;
            }
            self.tile.rays += batch.rays.len() as u64;
            see(&batch.rays);
            let mut next = 0;
            self.course.stage.scene.intersect_all(&batch.rays, Coherence::Coherent, |k, hit| {
                if k > next {
                    self.see_sky(batch, next..k);
                }
                next = k + 1;
                if veiled {
                    self.visit_veiled(&batch.branches[k], hit, waiting);
                } else {
                    self.visit(&batch.branches[k], hit, waiting);
                }
            });
            self.see_sky(batch, next..batch.rays.len());
        }
    }

    /// Light from all around, for rays that meet nothing.
    fn see_sky(&mut self, batch: &Front, missed: Range<usize>) {
        let Stage { scene, lights, .. } = self.course.stage;
        let Some(around) = lights.environment() else { return };
        for k in missed {
            let Branch { weight, pixel, pdf_w, media, .. } = batch.branches[k];
            let radiance = scene.found_sky(lights, around, &batch.rays[k], pdf_w);
            self.tile.emitted.push((pixel, weight * radiance * scene.transmittance(media, f32::INFINITY)));
        }
    }

    // Inlined for the same reason as `Surface::at`.
    #[inline(always)]
    fn visit(&mut self, branch: &Branch, hit: &SurfaceHit, waiting: &mut [Front; 2]) {
        self.see_emission(branch, hit);
        self.meet(branch, hit, waiting);
    }

    /// The same where surfaces may be masks, and bodies absorb.
    #[inline(never)]
    fn visit_veiled(&mut self, branch: &Branch, hit: &SurfaceHit, waiting: &mut [Front; 2]) {
        let left = self.course.stage.scene.transmittance(branch.media, hit.t);
        let arrived = Branch { weight: branch.weight * left, ..*branch };
        self.see_emission(&arrived, hit);
        if let Some(met) = self.past_mask(&arrived, hit, waiting) {
            self.meet(&met, hit, waiting);
        }
    }

    /// What of a branch meets the surface. The rest goes straight on, or one of the two by roulette where the branch is faint.
    fn past_mask(&mut self, branch: &Branch, hit: &SurfaceHit, waiting: &mut [Front; 2]) -> Option<Branch> {
        let opacity = self.course.stage.scene.opacity(hit);
        if opacity >= 1.0 {
            return Some(*branch);
        }
        let (met, passed) = if mean(branch.weight) >= self.split_weight {
            (opacity, 1.0 - opacity)
        } else {
            let mut rng = branch.rng(Stream::EyeRoulette, self.course);
            // The first number is that of the surface's lobes.
            let _ = rng.next_f32();
            if rng.next_f32() < opacity { (1.0, 0.0) } else { (0.0, 1.0) }
        };
        if passed > 0.0 {
            let media = self.course.stage.scene.crossed(branch.media, hit);
            let onward = branch.straight_on(branch.weight * passed, branch.length + hit.t);
            self.go_on(hit.pass(), Branch { media, ..onward }, true, waiting);
        }
        (met > 0.0).then_some(Branch { weight: branch.weight * met, ..*branch })
    }

    /// Follows a branch, unless its chain is too long.
    #[inline(always)]
    fn go_on(&mut self, ray: Ray, branch: Branch, crosses: bool, waiting: &mut [Front; 2]) {
        if branch.depth <= self.course.settings.depth {
            waiting[usize::from(crosses)].push(ray, branch);
        } else {
            self.tile.cut_weight += f64::from(mean(branch.weight));
        }
    }

    #[inline(always)]
    fn see_emission(&mut self, branch: &Branch, hit: &SurfaceHit) {
        let Stage { scene, lights, .. } = self.course.stage;
        let emission = scene.found_emission(lights, hit, branch.pdf_w);
        if emission != Rgb::ZERO {
            self.tile.emitted.push((branch.pixel, branch.weight * emission));
        }
    }

    #[inline(always)]
    fn meet(&mut self, branch: &Branch, hit: &SurfaceHit, waiting: &mut [Front; 2]) {
        let scene = self.course.stage.scene;
        let length = branch.length + hit.t;
        let albedo = scene.albedo(hit);
        if albedo != Rgb::ZERO {
            let hit_point = self.hit_point(branch.weight * albedo / PI, branch.pixel, length, hit);
            self.tile.hit_points.push(hit_point);
        }
        if self.course.stage.casters {
            self.branch_on(branch, length, hit, waiting);
        }
    }

    /// Follows the specular lobes, or those of a facet: all of them, or one chosen by roulette where the branch is faint.
    fn branch_on(&mut self, branch: &Branch, length: f32, hit: &SurfaceHit, waiting: &mut [Front; 2]) {
        let scattering = self.scattering(branch, length, hit);
        let (faint, course) = (mean(branch.weight) < self.split_weight, self.course);
        let mut go_on = |event: Event, wi, factor, pdf_w| {
            let mut branch = branch.after(event, pdf_w, branch.weight * factor, length);
            if event.crosses() {
                branch.media = course.stage.scene.crossed(branch.media, hit);
            }
            let Some(ray) = hit.continue_along(event, hit.frame().to_world(wi)) else { return };
            self.go_on(ray, branch, event.crosses(), waiting);
        };
        if !faint {
            scattering.specular().for_each(|lobe| go_on(lobe.event, lobe.wi, lobe.weight(), lobe.pdf_w));
        } else if let Some(Choice::Specular { event, wi, factor, pdf_w }) =
            scattering.choose(branch.rng(Stream::EyeRoulette, course).next_f32())
        {
            go_on(event, wi, factor, pdf_w);
        }
    }

    /// The lobes at `hit`; of a rough surface those of a facet, and the light that it reflects straight from its sources is
    /// added up.
    // Inlined for the same reason as `Surface::at`.
    #[inline(always)]
    fn scattering(&mut self, branch: &Branch, length: f32, hit: &SurfaceHit) -> Scattering {
        let Stage { scene, lights, glints, .. } = self.course.stage;
        let Some(glossy) = scene.glossy(hit, Transport::Camera) else {
            return scene.scatter(hit, Transport::Camera);
        };
        if glints {
            let hit_point = self.hit_point(branch.weight, branch.pixel, length, hit);
            self.tile.glossy_points.push(GlossyPoint { hit_point, normal: hit.normal, lobe: glossy });
        }
        let mut rng = branch.rng(Stream::Facet, self.course);
        let facet = rng.next_vec2();
        let (radiance, rays) = scene.direct_on_rough(lights, hit, &glossy, &mut rng);
        self.tile.emitted.push((branch.pixel, branch.weight * radiance));
        self.tile.rays += u64::from(rays);
        scene.scatter_by(hit, Transport::Camera, || facet)
    }

    fn hit_point(&self, reflectance: Rgb, pixel: u32, length: f32, hit: &SurfaceHit) -> HitPoint {
        let receiver = self.course.stage.scene.receiver(hit);
        let footprint = length * self.pixel_width;
        HitPoint { receiver, reflectance, pixel, footprint }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::scene::{self, PixelFilter, SceneDesc};
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
                    let branch = Branch::first(1.0 / settings.samples as f32, pixel, sample);
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

    #[test]
    fn batches_take_all_that_waits_newest_first() {
        let (mut waiting, mut batch) = (Front::default(), Front::default());
        let count = 2 * BATCH as u32 + 5;
        for pixel in 0..count {
            let ray = Ray::new(Default::default(), Default::default());
            waiting.push(ray, Branch::first(1.0, pixel, 0));
        }
        let mut end = count;
        while end > 0 {
            batch.take_from(&mut waiting);
            let start = end.saturating_sub(BATCH as u32);
            assert!(batch.branches.iter().map(|b| b.pixel).eq(start..end));
            assert_eq!((batch.rays.len(), waiting.rays.len()), (batch.branches.len(), start as usize));
            end = start;
        }
        batch.take_from(&mut waiting);
        assert!(batch.rays.is_empty() && waiting.rays.is_empty());
    }

    #[test]
    fn strata_tile_the_pixel() {
        for samples in [1u32, 2, 3, 4, 6, 16, 17] {
            let mut rng = Rng::new(0, Stream::Test, 0, 0);
            let positions: Vec<Vec2> = Strata::new(samples).positions(&mut rng).collect();
            assert_eq!(positions.len(), samples as usize);
            let mean: Vec2 = positions.iter().sum::<Vec2>() / samples as f32;
            let spread = 0.5 / (samples as f32).sqrt() + 1e-6;
            assert!((mean - 0.5).abs().min_element() <= spread, "{samples} samples: {mean}");
            let corner = positions[samples as usize - 1];
            assert!(corner.max_element() < 1.0 && corner.y >= 1.0 - 1.0 / (samples as f32).sqrt() - 1e-6);
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
    fn shuffled_strata_are_all_there_in_another_order() {
        let strata = Strata::new(12);
        let stratum = |p: &Vec2| (p.y * 4.0) as usize * 3 + (p.x * 3.0) as usize;
        let mut orders = std::collections::BTreeSet::new();
        for index in 0..50 {
            let positions = strata.shuffled_positions(&mut Rng::new(0, Stream::Test, 0, index));
            let mut order: Vec<usize> = positions.iter().map(stratum).collect();
            orders.insert(order.clone());
            order.sort_unstable();
            assert!(order.into_iter().eq(0..12));
        }
        assert!(orders.len() == 50, "{} orders", orders.len());
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
