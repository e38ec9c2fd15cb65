//! What can be asked of a render: its pictures, what it knows of itself, and the memory that it holds.

use super::accuracy::BatchMeans;
use super::collector::Collector;
use super::glints::Glints;
use super::pixel_lists::PixelLists;
use super::{Accuracy, Facets, Features, GatherState, HitPoint, Render, Settings, SetupStatistics, develop};
use crate::effects::{EyePaths, PathClass, Plan};
use crate::film::Image;
use crate::light::Guide;
use crate::math::DVec3;
use crate::scene::Scene;

impl Render<'_> {
    /// How wrong the picture is, with bounds that hold at `confidence` in (0, 1).
    ///
    /// `None` if the settings do not ask for estimates of the error, or before the second pass.
    pub fn accuracy(&self, confidence: f64) -> Option<Accuracy<'_>> {
        Accuracy::new(self, self.batches.as_ref()?, confidence)
    }

    /// The picture of all light found so far (radiance). Where kinds of paths are kept apart, bit for bit the sum of their
    /// layers in the order of [`PathClass::ALL`].
    pub fn picture(&self) -> Image {
        develop::picture(self)
    }

    /// The picture of direct light alone: seen lights and what shadow rays brought (radiance).
    pub fn direct_picture(&self) -> Image {
        develop::direct_picture(self)
    }

    /// The picture of light by one kind of path (radiance), black where the plan leaves it out; `None` where it is kept together
    /// with another.
    pub fn layer(&self, class: PathClass) -> Option<Image> {
        develop::layer(self, class)
    }

    /// What the eye first sees of each pixel; computed when it is asked for.
    pub fn features(&self) -> Features {
        Features::of(self)
    }

    /// What is simulated, and why nothing else.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Whether eye paths stay.
    pub fn eye_paths(&self) -> EyePaths {
        self.plan.eye_paths
    }

    /// Whether no further pass can change the picture.
    pub fn is_finished(&self) -> bool {
        self.collectors.is_empty() && self.glints.is_none() && !self.direct.is_sampled()
    }

    pub(super) fn pixel_lists(&self) -> &PixelLists {
        self.pixel_lists
            .get_or_init(|| PixelLists::new(&self.hit_points, self.scene.film().pixels(), |h| h.reflectance))
    }

    /// Whether a pixel saw no hit point in any pass.
    pub(super) fn sees_nothing(&self, pixel: usize) -> bool {
        self.direct.sees_nothing(self.pixel_lists(), pixel)
    }

    /// What the set-up found and took.
    pub fn setup(&self) -> &SetupStatistics {
        &self.setup
    }

    /// Photon passes done.
    pub fn passes(&self) -> u32 {
        self.passes
    }

    /// What is rendered.
    pub fn scene(&self) -> &Scene {
        self.scene
    }

    /// The settings of the render.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The hit points, in the order of the tree: those of the pass under way, where eye paths are retraced.
    pub fn hit_points(&self) -> &[HitPoint] {
        &self.hit_points
    }

    /// The progressive statistics of the hit points for photons of one kind of path, and of others that are kept together with it,
    /// in their order; none if it is not simulated. Where eye paths are retraced, those of the pixels, with the flux of each hit point weighed by
    /// `weight · albedo / π`.
    pub fn states(&self, class: PathClass) -> Vec<GatherState> {
        let all = |c: &Collector| (0..c.states.len()).map(|position| c.state(position)).collect();
        self.collector(class).map(all).unwrap_or_default()
    }

    /// The irradiance by all photons at the hit point at `position` (W/m²). Where eye paths are retraced, the radiance by photons
    /// of the pixel of that number.
    pub fn photon_irradiance(&self, position: usize) -> DVec3 {
        self.collectors.iter().map(|c| c.state(position).irradiance(self.emitted_photons)).sum()
    }

    pub(super) fn collector(&self, class: PathClass) -> Option<&Collector> {
        self.collectors.iter().find(|collector| collector.classes.contains(class))
    }

    /// The normals that photons are held against.
    pub fn facets(&self) -> &Facets {
        &self.facets
    }

    /// Heap memory of statistics and trees, in bytes.
    pub fn collectors_bytes(&self) -> usize {
        self.collectors.iter().map(Collector::memory_bytes).sum()
    }

    /// Heap memory of the statistics alone, in bytes.
    pub fn states_bytes(&self) -> usize {
        self.collectors.iter().map(|collector| collector.states.memory_bytes()).sum()
    }

    /// Heap memory of hit points, statistics, trees, direct light and photons, in bytes.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&*self.hit_points)
            + self.collectors_bytes()
            + self.glints.as_ref().map_or(0, Glints::memory_bytes)
            + self.pixel_lists.get().map_or(0, PixelLists::memory_bytes)
            + self.batches.as_ref().map_or(0, BatchMeans::memory_bytes)
            + self.facets.memory_bytes()
            + self.direct.memory_bytes()
            + self.guide.as_ref().map_or(0, Guide::memory_bytes)
            + self.photon_pass.memory_bytes()
    }
}
