//! Direct light at the hit points: exact from point lights, sampled anew in each pass from area lights.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{HitPoint, Stage};
use crate::math::{DVec3, Ray, Rgb, Rng, Stream};
use crate::scene::Scene;

/// The direct irradiance at every hit point.
#[derive(Clone, Debug, Default)]
pub struct DirectPass {
    from_points: Vec<Rgb>,
    /// Whose random numbers each hit point draws; empty where none are drawn.
    keys: Vec<u32>,
    sampled: Sampled,
}

/// What grows from pass to pass.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Sampled {
    /// Sums over passes; empty where no light has an area.
    from_areas: Vec<DVec3>,
    pub(super) passes: u32,
    rays: u64,
}

impl Sampled {
    /// Whether both are of as many hit points.
    pub(super) fn is_like(&self, other: &Sampled) -> bool {
        self.from_areas.len() == other.from_areas.len()
    }
}

impl DirectPass {
    /// Casts the shadow rays to all point lights, and the first one to the area lights.
    ///
    /// Hit point `k` draws random numbers of its own by `keys[k]`, not by its place, which rounding may change.
    pub fn new<'a>(
        stage: impl Into<Stage<'a>>,
        hit_points: &[HitPoint],
        keys: Vec<u32>,
        seed: u64,
    ) -> DirectPass {
        let stage = stage.into();
        let Stage { scene, lights, .. } = stage;
        let exact: Vec<_> =
            hit_points.par_iter().map(|h| scene.direct_from_points(lights, &h.receiver)).collect();
        let areas = if lights.any_area() { hit_points.len() } else { 0 };
        let mut direct = DirectPass {
            from_points: exact.iter().map(|d| d.irradiance).collect(),
            keys: if areas > 0 { keys } else { Vec::new() },
            sampled: Sampled {
                from_areas: vec![DVec3::ZERO; areas],
                passes: 0,
                rays: exact.iter().map(|d| u64::from(d.shadow_rays)).sum(),
            },
        };
        direct.add_pass(stage, hit_points, seed, 0);
        direct
    }

    /// Adds one sample of the area lights at every hit point, so that their noise falls with the passes; drawn by the number of
    /// the pass, from 0.
    pub(super) fn add_pass(&mut self, stage: Stage, hit_points: &[HitPoint], seed: u64, pass: u32) {
        let Stage { scene, lights, .. } = stage;
        let sampled = &mut self.sampled;
        let rays: u64 = sampled
            .from_areas
            .par_iter_mut()
            .zip(hit_points)
            .zip(&self.keys)
            .map(|((sum, hit_point), &key)| {
                let mut rng = generator(seed, pass, key);
                let sample = scene.direct_from_areas(lights, &hit_point.receiver, &mut rng);
                *sum += sample.irradiance.as_dvec3();
                u64::from(sample.shadow_rays)
            })
            .sum();
        sampled.rays += rays;
        sampled.passes += 1;
    }

    /// Empties the sums over passes.
    pub(super) fn forget(&mut self) {
        self.sampled.from_areas.fill(DVec3::ZERO);
        self.sampled.passes = 0;
    }

    /// The shadow rays that [`DirectPass::new`] casts, hit point by hit point, each keyed by its place.
    pub fn record_rays(scene: &Scene, hit_points: &[HitPoint], seed: u64) -> Vec<Ray> {
        let rays = |(key, hit_point): (u32, &HitPoint)| {
            let mut rng = generator(seed, 0, key);
            scene.shadow_rays(scene.lights(), &hit_point.receiver, &mut rng).collect::<Vec<_>>()
        };
        (0..hit_points.len() as u32).into_par_iter().zip(hit_points).flat_map_iter(rays).collect()
    }

    /// The direct irradiance at hit point `index` (W/m²).
    pub fn irradiance(&self, index: usize) -> DVec3 {
        self.from_points[index].as_dvec3() + self.irradiance_from_areas(index)
    }

    /// Whether any of it is sampled, and so changes from pass to pass.
    pub(super) fn is_sampled(&self) -> bool {
        !self.sampled.from_areas.is_empty()
    }

    /// The part of [`DirectPass::irradiance`] that is sampled.
    pub(super) fn irradiance_from_areas(&self, index: usize) -> DVec3 {
        let Sampled { from_areas, passes, .. } = &self.sampled;
        from_areas.get(index).map_or(DVec3::ZERO, |sum| *sum / f64::from(*passes))
    }

    /// Shadow rays cast so far.
    pub fn rays(&self) -> u64 {
        self.sampled.rays
    }

    /// Heap memory, in bytes.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&*self.from_points) + size_of_val(&*self.sampled.from_areas) + size_of_val(&*self.keys)
    }

    pub(super) fn sampled(&self) -> &Sampled {
        &self.sampled
    }

    pub(super) fn set_sampled(&mut self, sampled: Sampled) {
        self.sampled = sampled;
    }
}

/// The direct irradiance at every hit point (W/m²), by one sample of the area lights of its own `pass`, and the shadow rays
/// that it took. Keys are those of [`DirectPass::new`].
pub(super) fn sample_once(
    Stage { scene, lights, .. }: Stage,
    hit_points: &[HitPoint],
    keys: &[u32],
    seed: u64,
    pass: u32,
) -> (Vec<DVec3>, u64) {
    let sample = |(hit_point, &key): (&HitPoint, &u32)| {
        let exact = scene.direct_from_points(lights, &hit_point.receiver);
        let sample = scene.direct_from_areas(lights, &hit_point.receiver, &mut generator(seed, pass, key));
        let irradiance = exact.irradiance.as_dvec3() + sample.irradiance.as_dvec3();
        (irradiance, u64::from(exact.shadow_rays + sample.shadow_rays))
    };
    let samples: Vec<(DVec3, u64)> = hit_points.par_iter().zip(keys).map(sample).collect();
    let rays = samples.iter().map(|(_, rays)| rays).sum();
    (samples.into_iter().map(|(irradiance, _)| irradiance).collect(), rays)
}

fn generator(seed: u64, pass: u32, key: u32) -> Rng {
    Rng::new(seed, Stream::DirectLight, pass, key.into())
}

#[cfg(test)]
mod tests {
    use super::super::{Settings, camera_pass};
    use super::*;
    use crate::scene;
    use std::path::Path;

    /// With a light of a single kind, the irradiance tells which rays were free.
    #[test]
    fn recorded_rays_are_those_of_the_pass() {
        for name in ["cornell_a", "cornell_b"] {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name).with_extension("toml");
            let mut desc = scene::load(&path).unwrap();
            (desc.film.width, desc.film.height) = (64, 64);
            let scene = Scene::new(desc).unwrap();
            let settings = Settings { samples: 1, ..Settings::of_scene(scene.render()) };
            let hit_points: Vec<HitPoint> =
                camera_pass::trace(&scene, &settings, 0).hit_points.iter().copied().collect();
            let direct = DirectPass::new(&scene, &hit_points, (0..hit_points.len() as u32).collect(), 3);
            let rays = DirectPass::record_rays(&scene, &hit_points, 3);
            assert_eq!(rays.len() as u64, direct.rays());
            let free = rays.iter().filter(|ray| !scene.occluded(ray)).count();
            let lit = (0..hit_points.len()).filter(|&k| direct.irradiance(k) != DVec3::ZERO).count();
            assert!(free == lit && (rays.len() / 2..rays.len()).contains(&free), "{free} of {}", rays.len());
        }
    }
}
