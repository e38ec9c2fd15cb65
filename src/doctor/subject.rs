//! A scene under examination, and what a small trial render of it found.

use super::bodies::{Body, bodies};
use crate::math::mean;
use crate::ppm::{
    HitPoint, PassStatistics, Planning, Render, Settings, SetupStatistics, automatic_radius, camera_pass,
};
use crate::scene::{Scene, SceneDesc, Traversal, TraversalError};

/// The longer side of the trial's picture, in pixels.
const SIDE: u32 = 96;

/// Photons of the trial's one pass, at most.
const PHOTONS: u64 = 20_000;

/// What the checks look at.
pub(super) struct Subject<'a> {
    pub desc: &'a SceneDesc,
    /// As they were asked for.
    pub settings: Settings,
    /// Traceable, with the trial's small picture.
    pub scene: Scene,
    pub bodies: Vec<Body>,
    /// How many times wider the trial's pixels are than the picture's.
    pub pixel_ratio: f64,
    pub trial: Trial,
}

/// What the trial found.
pub(super) struct Trial {
    pub setup: SetupStatistics,
    pub hit_points: Vec<HitPoint>,
    pub pass: PassStatistics,
    /// Whether lights are seen or reach what is seen.
    pub has_direct_light: bool,
}

impl<'a> Subject<'a> {
    pub fn new(
        desc: &'a SceneDesc,
        settings: Settings,
        traversal: Traversal,
    ) -> Result<Subject<'a>, TraversalError> {
        let longer = desc.film.width.max(desc.film.height);
        let mut small = desc.clone();
        let shrunk =
            |side: u32| (u64::from(side) * u64::from(SIDE.min(longer)) / u64::from(longer)).max(1) as u32;
        (small.film.width, small.film.height) = (shrunk(desc.film.width), shrunk(desc.film.height));
        let pixel_ratio = f64::from(desc.film.width) / f64::from(small.film.width);
        let scene = Scene::with_traversal(small, traversal)?;
        let trial = try_out(&scene, settings, pixel_ratio);
        Ok(Subject { desc, settings, scene, bodies: bodies(desc), pixel_ratio, trial })
    }

    /// The median width of a pixel of the picture where it is seen, in scene units; `None` where nothing is seen.
    pub fn footprint(&self) -> Option<f64> {
        let mut widths: Vec<f32> = self.trial.hit_points.iter().map(|h| h.footprint).collect();
        let middle = widths.len() / 2;
        widths.sort_unstable_by(f32::total_cmp);
        widths.get(middle).map(|&width| f64::from(width) / self.pixel_ratio)
    }
}

/// With the radius that the whole picture would begin with.
fn try_out(scene: &Scene, asked: Settings, pixel_ratio: f64) -> Trial {
    let planning = Planning::Everything;
    let settings = Settings { samples: 1, photons: asked.photons.min(PHOTONS), planning, ..asked };
    let found = || automatic_radius(&camera_pass::trace(scene, &settings, 0).hit_points) / pixel_ratio;
    let settings = Settings { radius: Some(asked.radius.unwrap_or_else(found)), ..settings };
    let mut render = Render::new(scene, settings);
    let pass = render.pass();
    Trial {
        setup: *render.setup(),
        hit_points: render.hit_points().to_vec(),
        pass,
        has_direct_light: render.direct_picture().pixels().iter().any(|&radiance| mean(radiance) > 0.0),
    }
}
