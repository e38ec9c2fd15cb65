//! Progressive photon mapping, as the recipe has it:
//!
//! ```text
//! eye pass ──> hit points ──> direct light
//!                   └──────> sphere tree
//! every pass:  photons ──> gather ──> radius reduction ──> refit
//! whenever asked:                     develop ──> picture
//!                                     accuracy ──> its error
//! ```
//!
//! # Source
//! Hachisuka, Ogaki and Jensen, "Progressive Photon Mapping", SIGGRAPH Asia 2008.

mod accuracy;
pub mod camera_pass;
mod develop;
mod diffuse_bounce;
mod direct;
mod draws;
mod emission;
mod evenness;
mod facets;
mod flights;
mod flux_ledger;
mod gather;
mod hit_point;
mod hit_points;
mod lane_flux;
mod lane_parts;
mod ledger;
pub mod photon_pass;
mod pixel_lists;
mod radius;
mod radius_floor;
mod radius_policy;
mod render_state;
mod settings;
mod statistic;
mod statistics;
mod wavefront;

pub use accuracy::{Accuracy, Forecast, Layers, Outlook, PictureError, PixelError};
pub use camera_pass::EyePass;
pub use direct::DirectPass;
pub use facets::Facets;
pub use flux_ledger::FluxLedger;
pub use gather::{Found, received};
pub use hit_point::{GatherState, HitPoint, PassSum};
pub use hit_points::HitPoints;
pub use ledger::Ledger;
pub use photon_pass::{Photon, PhotonBatch, PhotonPass};
pub use radius::automatic_radius;
pub use radius_floor::least_radius;
pub use radius_policy::RadiusPolicy;
pub use render_state::{ForeignState, RenderState};
pub use settings::{ErrorEstimates, Settings};
pub use statistic::Precision;
pub use statistics::{PassStatistics, PhaseSeconds, RadiusRange, SetupStatistics};

use std::f32::consts::PI;
use std::sync::OnceLock;

use rayon::prelude::*;

use crate::bvh::{Sphere, SphereBvh};
use crate::film::Image;
use crate::math::Rgb;
use crate::scene::Scene;
use accuracy::{BatchMeans, sampling_step};
use pixel_lists::PixelLists;
use radius_floor::RadiusFloor;
use statistic::Statistics;
use statistics::Stopwatch;

/// A render under way: the picture is there at any time, and every pass makes it better.
pub struct Render<'s> {
    scene: &'s Scene,
    settings: Settings,
    /// In the order of the tree, as are the states.
    hit_points: Vec<HitPoint>,
    states: Statistics,
    /// Made when a picture is first asked for.
    pixel_lists: OnceLock<PixelLists>,
    facets: Facets,
    radius_floor: RadiusFloor,
    tree: SphereBvh,
    direct: DirectPass,
    photon_pass: PhotonPass,
    /// Lights that are seen directly, by pixel.
    emitted_light: Vec<Rgb>,
    emitted_photons: u64,
    passes: u32,
    /// Where the settings ask for estimates of the error.
    batches: Option<BatchMeans>,
    setup: SetupStatistics,
}

impl<'s> Render<'s> {
    /// Traces the eye paths, finds the direct light and builds the tree over the hit points.
    pub fn new(scene: &'s Scene, settings: Settings) -> Render<'s> {
        let mut watch = Stopwatch::start();
        let eye = camera_pass::trace(scene, &settings);
        let eye_seconds = watch.lap();
        let radius = settings.radius.unwrap_or_else(|| automatic_radius(&eye.hit_points));
        let (mut tree, hit_points, order) = build_tree(&eye.hit_points, radius);
        let mut states = Statistics::new(hit_points.len(), radius, settings.policy, settings.precision);
        let facets = Facets::of(&hit_points);
        let radius_floor = RadiusFloor::of(&hit_points);
        radius_floor.apply(&hit_points, &mut states, &mut tree);
        let batches = batch_means(&settings, eye.emitted.len());
        let tree_seconds = watch.lap();
        let direct = DirectPass::new(scene, &hit_points, order, settings.seed);
        let setup = SetupStatistics {
            hit_points: hit_points.len() as u64,
            eye_rays: eye.rays,
            shadow_rays: direct.rays(),
            cut_weight: eye.cut_weight,
            radius,
            eye_seconds,
            tree_seconds,
            direct_seconds: watch.lap(),
        };
        Render {
            scene,
            settings,
            hit_points,
            states,
            pixel_lists: OnceLock::new(),
            facets,
            radius_floor,
            tree,
            direct,
            photon_pass: PhotonPass::default(),
            emitted_light: eye.emitted,
            emitted_photons: 0,
            passes: 0,
            batches,
            setup,
        }
    }

    /// One photon pass: trace the photons; gather them, shrink the radii and refit the tree.
    pub fn pass(&mut self) -> PassStatistics {
        let mut watch = Stopwatch::start();
        let mut phases = PhaseSeconds::default();
        let shadow_rays_before = self.direct.rays();
        if self.passes > 0 {
            self.direct.add_pass(self.scene, &self.hit_points, self.settings.seed);
        }
        phases.direct = watch.lap();
        let batch = self.photon_pass.trace(self.scene, &self.settings, self.passes);
        phases.trace = watch.lap();
        let ledger = batch.ledger;
        let alpha = self.settings.policy.own_alpha(self.settings.alpha);
        let found = gather::gather(&mut self.tree, &self.facets, batch, alpha, &mut self.states);
        self.emitted_photons += ledger.emitted;
        self.passes += 1;
        self.shrink_together();
        phases.gather = watch.lap();
        let radius = self.radius_floor.apply(&self.hit_points, &mut self.states, &mut self.tree);
        if self.batches.is_some() {
            // The picture needs them as well: they are no cost of the estimates.
            self.pixel_lists();
        }
        watch.lap();
        self.close_batch(radius.mean);
        phases.errors = watch.lap();
        let shadow_rays = self.direct.rays() - shadow_rays_before;
        self.statistics(phases, ledger, found, shadow_rays, radius)
    }

    /// Shrinks the radii that follow a common schedule.
    fn shrink_together(&mut self) {
        let Settings { policy, alpha, .. } = self.settings;
        if let Some(ratio) = policy.common_ratio(alpha, self.passes) {
            self.states.shrink(ratio);
            self.tree.refit(|position| self.states.get(position).radius() as f32);
        }
    }

    /// Ends the batch of passes that the estimates of the error count by, if it is long enough.
    fn close_batch(&mut self, mean_radius: f64) {
        let Some(mut batches) = self.batches.take() else { return };
        batches.shrink((mean_radius / self.setup.radius).powi(2));
        if batches.is_due(self.passes) {
            let lists = self.pixel_lists();
            batches.close(self.passes, |place| develop::noisy_radiance(self, lists.pixel(place)));
        }
        self.batches = Some(batches);
    }

    /// How wrong the picture is, with bounds that hold at `confidence` in (0, 1).
    ///
    /// `None` if the settings do not ask for estimates of the error, or before the second pass.
    pub fn accuracy(&self, confidence: f64) -> Option<Accuracy<'_>> {
        Accuracy::new(self, self.batches.as_ref()?, confidence)
    }

    /// The picture of all light found so far (radiance).
    pub fn picture(&self) -> Image {
        develop::picture(self)
    }

    /// The picture of direct light alone: seen lights and what shadow rays brought.
    pub fn direct_picture(&self) -> Image {
        develop::direct_picture(self)
    }

    fn pixel_lists(&self) -> &PixelLists {
        self.pixel_lists.get_or_init(|| {
            PixelLists::new(&self.hit_points, self.emitted_light.len(), |h| reflectance(self.scene, h))
        })
    }

    /// What the set-up found and took.
    pub fn setup(&self) -> &SetupStatistics {
        &self.setup
    }

    /// Photon passes done.
    pub fn passes(&self) -> u32 {
        self.passes
    }

    /// Photons emitted in all passes.
    pub fn emitted_photons(&self) -> u64 {
        self.emitted_photons
    }

    /// The settings of the render.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The hit points, in the order of the tree.
    pub fn hit_points(&self) -> &[HitPoint] {
        &self.hit_points
    }

    /// The progressive statistics of the hit points, in their order.
    pub fn states(&self) -> impl ExactSizeIterator<Item = GatherState> {
        (0..self.states.len()).map(|position| self.states.get(position))
    }

    /// The tree over the hit points' spheres.
    pub fn tree(&self) -> &SphereBvh {
        &self.tree
    }

    /// The normals that photons are held against.
    pub fn facets(&self) -> &Facets {
        &self.facets
    }

    /// Heap memory of the statistics alone, in bytes.
    pub fn states_bytes(&self) -> usize {
        self.states.memory_bytes()
    }

    /// Heap memory of hit points, statistics, tree, direct light and photons, in bytes.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&*self.hit_points)
            + self.states.memory_bytes()
            + self.pixel_lists.get().map_or(0, PixelLists::memory_bytes)
            + self.batches.as_ref().map_or(0, BatchMeans::memory_bytes)
            + self.facets.memory_bytes()
            + self.tree.memory_bytes()
            + self.direct.memory_bytes()
            + self.photon_pass.memory_bytes()
            + size_of_val(&*self.emitted_light)
    }
}

fn batch_means(settings: &Settings, pixels: usize) -> Option<BatchMeans> {
    match settings.error_estimates {
        ErrorEstimates::None => None,
        ErrorEstimates::Picture => Some(BatchMeans::new(pixels, sampling_step(pixels))),
        ErrorEstimates::Pixels => Some(BatchMeans::new(pixels, 1)),
    }
}

/// The factor from the irradiance at a hit point to the radiance of its pixel: `weight · albedo / π`.
fn reflectance(scene: &Scene, hit_point: &HitPoint) -> Rgb {
    hit_point.weight * scene.materials()[hit_point.material as usize].bsdf.albedo() / PI
}

/// The tree over spheres of the given radius, the hit points in its order, and their indices before.
fn build_tree(hit_points: &HitPoints, radius: f64) -> (SphereBvh, Vec<HitPoint>, Vec<u32>) {
    let radius = radius as f32;
    let spheres = hit_points.map(|h| Sphere { center: h.receiver.p, radius });
    let (tree, order) = SphereBvh::build(&spheres);
    let ordered = order.par_iter().map(|&index| *hit_points.get(index as usize)).collect();
    (tree, ordered, order)
}
