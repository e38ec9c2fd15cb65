//! Whitted's trees of specular rays, many at a time.
//!
//! Where glass is in glass such a tree doubles from event to event. So branches fainter than 1/4096 of their sample follow one
//! way, chosen by roulette: what they find is right on average, and no more than some thousand can be brighter.

use std::f32::consts::PI;
use std::ops::Range;

use super::{GlossyPoint, HitPoint, Settings, Stage};
use crate::bsdf::{Choice, Event, Scattering, Transport};
use crate::math::{Ray, Rgb, Rng, Stream, mean};
use crate::scene::{Coherence, Media, SurfaceHit};

/// Most rays that are traced at a time. The newest go first, so that few wait however the trees branch.
const BATCH: usize = 8192;

/// The share of an eye sample below which its branches do not split.
pub(super) const SPLIT_WEIGHT: f32 = 1.0 / 4096.0;

/// What eye paths depend on.
#[derive(Clone, Copy)]
pub(super) struct Course<'a> {
    pub stage: Stage<'a>,
    pub settings: &'a Settings,
    pub pass: u32,
}

/// What the eye paths of a tile found.
#[derive(Default)]
pub(super) struct Tile {
    pub hit_points: Vec<HitPoint>,
    pub glossy_points: Vec<GlossyPoint>,
    /// Radiance of lights, with the pixel that sees it.
    pub emitted: Vec<(u32, Rgb)>,
    pub rays: u64,
    pub cut_weight: f64,
}

/// One branch of the tree of an eye sample.
#[derive(Clone, Copy)]
pub(super) struct Branch {
    pub weight: Rgb,
    length: f32,
    pub pixel: u32,
    pub depth: u32,
    /// Which branch of which sample it is: a hash of the turns that it took.
    key: u32,
    /// What its ray goes through.
    media: Media,
    /// The density of its direction (1/sr) where a facet of a rough surface gave that; else infinite.
    pdf_w: f32,
}

impl Branch {
    pub fn first(weight: f32, pixel: u32, sample: u32, media: Media) -> Branch {
        let (weight, key) = (Rgb::splat(weight), sample);
        Branch { weight, length: 0.0, pixel, depth: 0, key, media, pdf_w: f32::INFINITY }
    }

    pub fn after(&self, event: Event, pdf_w: f32, weight: Rgb, length: f32) -> Branch {
        const SPREAD: u32 = 0x9E37_79B1;
        let key = self.key.wrapping_add(event as u32 + 1).wrapping_mul(SPREAD);
        Branch { weight, length, depth: self.depth + 1, key, pdf_w, ..*self }
    }

    /// Straight on through a mask. No branch goes on by a diffuse event, so its key is free.
    fn straight_on(&self, weight: Rgb, length: f32) -> Branch {
        self.after(Event::Diffuse, f32::INFINITY, weight, length)
    }

    /// Its numbers: of each stream others.
    pub fn rng(&self, stream: Stream, Course { settings, pass, .. }: Course) -> Rng {
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
pub(super) struct Fronts {
    /// Mirrored rays and rays that went through a surface: each kind points alike, the two together do not.
    waiting: [Front; 2],
    batch: Front,
}

impl Fronts {
    /// Adds the first ray of an eye sample.
    pub fn start(&mut self, ray: Ray, branch: Branch) {
        self.waiting[0].push(ray, branch);
    }

    /// Whether first rays make a batch.
    pub fn make_a_batch(&self) -> bool {
        self.waiting[0].rays.len() >= BATCH
    }
}

/// The trees of the eye samples of a tile, and where their results go.
pub(super) struct EyeTrees<'a> {
    course: Course<'a>,
    split_weight: f32,
    pixel_width: f32,
    pub tile: Tile,
}

impl<'a> EyeTrees<'a> {
    /// Of a tile with so many eye samples.
    pub fn new(course: Course<'a>, eye_samples: usize) -> EyeTrees<'a> {
        let tile = Tile { hit_points: Vec::with_capacity(eye_samples.min(BATCH)), ..Tile::default() };
        let split_weight = SPLIT_WEIGHT * (1.0 / course.settings.samples as f32);
        EyeTrees { course, split_weight, pixel_width: course.stage.scene.camera().pixel_width(), tile }
    }

    /// Traces all that waits, and what comes of it.
    pub fn trace(&mut self, fronts: &mut Fronts, see: &mut impl FnMut(&[Ray])) {
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

    #[test]
    fn batches_take_all_that_waits_newest_first() {
        let (mut waiting, mut batch) = (Front::default(), Front::default());
        let count = 2 * BATCH as u32 + 5;
        for pixel in 0..count {
            let ray = Ray::new(Default::default(), Default::default());
            waiting.push(ray, Branch::first(1.0, pixel, 0, Media::NONE));
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
}
