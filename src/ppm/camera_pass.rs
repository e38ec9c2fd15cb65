//! The eye pass: Whitted's tree of specular rays from the camera, which leaves hit points where it meets diffuse surfaces.

use rayon::prelude::*;

use super::{HitPoint, Settings};
use crate::bsdf::Transport;
use crate::math::{Ray, Rgb, Rng, Stream, Vec2, mean};
use crate::scene::{Scene, SurfaceHit};

/// What the camera sees before any photon is traced.
#[derive(Debug)]
pub struct EyePass {
    /// The hit points, pixel by pixel.
    pub hit_points: Vec<HitPoint>,
    /// Radiance of the lights that are seen directly or along specular chains, by pixel.
    pub emitted: Vec<Rgb>,
    /// Rays traced.
    pub rays: u64,
    /// The share of the picture's weight that was cut at the depth limit.
    pub cut_weight: f64,
}

/// Traces every eye path of the picture, row by row in parallel; the order of the result is that of the pixels.
pub fn trace(scene: &Scene, settings: &Settings) -> EyePass {
    let (width, height) = (scene.film().width, scene.film().height);
    let rows: Vec<EyePass> =
        (0..height).into_par_iter().map(|y| trace_row(scene, settings, y, width, |_| ())).collect();
    let mut all = EyePass::with_capacity(rows.iter().map(|r| r.hit_points.len()).sum());
    for row in rows {
        all.append(row);
    }
    all.cut_weight /= f64::from(width) * f64::from(height);
    all
}

/// The rays that [`trace`] sends through the scene, row by row.
pub fn record_rays(scene: &Scene, settings: &Settings) -> Vec<Ray> {
    let (width, height) = (scene.film().width, scene.film().height);
    let row = |y| {
        let mut rays = Vec::new();
        trace_row(scene, settings, y, width, |ray| rays.push(*ray));
        rays
    };
    (0..height).into_par_iter().map(row).collect::<Vec<_>>().concat()
}

impl EyePass {
    fn with_capacity(hit_points: usize) -> EyePass {
        EyePass { hit_points: Vec::with_capacity(hit_points), emitted: Vec::new(), rays: 0, cut_weight: 0.0 }
    }

    fn append(&mut self, row: EyePass) {
        self.hit_points.extend(row.hit_points);
        self.emitted.extend(row.emitted);
        self.rays += row.rays;
        self.cut_weight += row.cut_weight;
    }
}

/// Shows every ray to `see` before it is traced.
fn trace_row(scene: &Scene, settings: &Settings, y: u32, width: u32, mut see: impl FnMut(&Ray)) -> EyePass {
    let mut row = EyePass::with_capacity(width as usize * settings.samples as usize);
    for x in 0..width {
        row.emitted.push(Rgb::ZERO);
        let pixel = y * width + x;
        let mut rng = Rng::new(settings.seed, Stream::Eye, 0, u64::from(pixel));
        for sample in 0..settings.samples {
            let raster = Vec2::new(x as f32, y as f32) + stratified(sample, settings.samples, &mut rng);
            let root = EyePath {
                ray: scene.camera().ray(raster),
                weight: Rgb::splat(1.0 / settings.samples as f32),
                length: 0.0,
                depth: 0,
            };
            EyeTree { scene, depth: settings.depth, pixel, row: &mut row }.trace(root, &mut see);
        }
    }
    row
}

/// A random position in stratum `sample` of the `samples` that tile a pixel; a prime number makes a single row.
fn stratified(sample: u32, samples: u32, rng: &mut Rng) -> Vec2 {
    let columns = (1..=samples.isqrt()).rev().find(|c| samples.is_multiple_of(*c)).unwrap_or(1);
    let strata = Vec2::new(columns as f32, (samples / columns) as f32);
    let stratum = Vec2::new((sample % columns) as f32, (sample / columns) as f32);
    (stratum + rng.next_vec2()) / strata
}

/// One branch of the tree of an eye sample.
struct EyePath {
    ray: Ray,
    weight: Rgb,
    length: f32,
    depth: u32,
}

/// The tree of an eye sample, and where its results go.
struct EyeTree<'a> {
    scene: &'a Scene,
    depth: u32,
    pixel: u32,
    row: &'a mut EyePass,
}

impl EyeTree<'_> {
    fn trace(&mut self, root: EyePath, mut see: impl FnMut(&Ray)) {
        let mut branches = vec![root];
        while let Some(path) = branches.pop() {
            self.row.rays += 1;
            see(&path.ray);
            if let Some(hit) = self.scene.intersect(&path.ray) {
                self.visit(&path, &hit, &mut branches);
            }
        }
    }

    fn visit(&mut self, path: &EyePath, hit: &SurfaceHit, branches: &mut Vec<EyePath>) {
        if let Some(pixel) = self.row.emitted.last_mut() {
            *pixel += path.weight * self.scene.emission(hit);
        }
        let scattering = self.scene.scatter(hit, Transport::Camera);
        let length = path.length + hit.t;
        if scattering.albedo != Rgb::ZERO {
            self.leave_hit_point(path.weight, length, hit);
        }
        for lobe in scattering.specular() {
            let weight = path.weight * lobe.weight();
            let Some(ray) = hit.continue_along(lobe.event, hit.frame().to_world(lobe.wi)) else { continue };
            if path.depth < self.depth {
                branches.push(EyePath { ray, weight, length, depth: path.depth + 1 });
            } else {
                self.row.cut_weight += f64::from(mean(weight));
            }
        }
    }

    fn leave_hit_point(&mut self, weight: Rgb, length: f32, hit: &SurfaceHit) {
        self.row.hit_points.push(HitPoint {
            receiver: hit.receiver(),
            weight,
            pixel: self.pixel,
            material: hit.material,
            footprint: length * self.scene.camera().pixel_width(),
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene;
    use std::path::Path;

    #[test]
    fn recorded_rays_are_those_of_the_pass() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/cornell_b.toml");
        let mut desc = scene::load(&path).unwrap();
        (desc.film.width, desc.film.height) = (64, 48);
        let scene = Scene::new(desc).unwrap();
        let settings = Settings { samples: 2, ..Settings::of_scene(scene.render()) };
        let (eye, rays) = (trace(&scene, &settings), record_rays(&scene, &settings));
        assert_eq!(rays.len() as u64, eye.rays);
        assert!(eye.rays > 64 * 48 * 2, "the balls mirror and refract");
        let on_surfaces = rays.iter().filter_map(|ray| scene.intersect(ray)).map(|hit| hit.p);
        let mut seen: Vec<_> = on_surfaces.map(|p| p.to_array().map(f32::to_bits)).collect();
        seen.sort_unstable();
        let found = |p: crate::math::Vec3| seen.binary_search(&p.to_array().map(f32::to_bits)).is_ok();
        assert!(eye.hit_points.iter().all(|hit_point| found(hit_point.receiver.p)));
    }

    #[test]
    fn strata_tile_the_pixel() {
        for samples in [1u32, 2, 3, 4, 6, 16, 17] {
            let mut rng = Rng::new(0, Stream::Test, 0, 0);
            let mean: Vec2 =
                (0..samples).map(|s| stratified(s, samples, &mut rng)).sum::<Vec2>() / samples as f32;
            let spread = 0.5 / (samples as f32).sqrt() + 1e-6;
            assert!((mean - 0.5).abs().min_element() <= spread, "{samples} samples: {mean}");
            let corner = stratified(samples - 1, samples, &mut rng);
            assert!(corner.max_element() < 1.0 && corner.y >= 1.0 - 1.0 / (samples as f32).sqrt() - 1e-6);
        }
    }
}
