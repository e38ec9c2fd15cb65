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
//! Where a lens or a pixel filter asks for it, every pass begins with the first two lines, and pixels take the place of hit
//! points in what is kept ([`EyePaths`]).
//!
//! # Source
//! Hachisuka, Ogaki and Jensen, "Progressive Photon Mapping", SIGGRAPH Asia 2008; Hachisuka and Jensen, "Stochastic Progressive
//! Photon Mapping", SIGGRAPH Asia 2009.

mod accuracy;
mod aimed_flights;
pub mod camera_pass;
mod collector;
mod develop;
mod diffuse_bounce;
mod direct;
mod direct_light;
mod draws;
mod emission;
mod evenness;
mod facets;
mod features;
mod flights;
mod flux_ledger;
mod gather;
mod gather_by_pixel;
mod gather_glossy;
mod glints;
mod glossy_point;
mod guiding;
mod hit_point;
mod hit_points;
mod independent;
mod lane_flux;
mod lane_parts;
mod ledger;
mod mixture;
mod photon_media;
pub mod photon_pass;
mod pilot;
mod pixel_light;
mod pixel_lists;
mod radius;
mod radius_floor;
mod radius_policy;
mod render_state;
mod settings;
mod stage;
mod statistic;
mod statistics;
mod trial;
mod trial_points;
mod wavefront;

pub use accuracy::{Accuracy, Forecast, Layers, Outlook, PictureError, PixelError};
pub use camera_pass::EyePass;
pub use direct::DirectPass;
pub use facets::Facets;
pub use features::Features;
pub use flux_ledger::FluxLedger;
pub use gather::{Found, received};
pub use glossy_point::GlossyPoint;
pub use guiding::GuidePlan;
pub use hit_point::{GatherState, HitPoint, PassSum};
pub use hit_points::HitPoints;
pub use independent::{DependentPasses, IndependentPasses};
pub use ledger::Ledger;
pub use mixture::{Mixture, PhotonBudget};
pub use photon_pass::{Deposits, Photon, PhotonBatch, PhotonPass, Photons};
pub use pilot::AimPlan;
pub use radius::automatic_radius;
pub use radius_floor::least_radius;
pub use radius_policy::RadiusPolicy;
pub use render_state::{ForeignState, RenderState};
pub use settings::{Aiming, ErrorEstimates, Guiding, Kinds, Planning, Settings};
pub use stage::Stage;
pub use statistic::Precision;
pub use statistics::{CollectorStatistics, PassStatistics, PhaseSeconds, RadiusRange, SetupStatistics};

use std::sync::OnceLock;

use rayon::prelude::*;

use crate::bvh::{Sphere, SphereBvh};
use crate::effects::{EyePaths, PathClass, PathClasses, Plan};
use crate::film::Image;
use crate::light::{Guide, Lights};
use crate::math::DVec3;
use crate::scene::Scene;
use accuracy::{BatchMeans, sampling_step};
use collector::{Collector, Keeper, View};
use direct_light::DirectLight;
use gather::Receivers;
use glints::Glints;
use pixel_lists::PixelLists;
use statistics::Stopwatch;

/// A render under way: the picture is there at any time, and every pass makes it better.
pub struct Render<'s> {
    scene: &'s Scene,
    settings: Settings,
    /// In the order of the tree, as are the states: those of the pass under way, where eye paths are retraced.
    hit_points: Vec<HitPoint>,
    /// For the kinds of paths that photons bring light by, one for all or one for each.
    collectors: Vec<Collector>,
    /// Where some light is collected on rough surfaces.
    glints: Option<Glints>,
    /// For each pixel, where its statistics stand; made when a picture is first asked for.
    pixel_lists: OnceLock<PixelLists>,
    facets: Facets,
    plan: Plan,
    /// Those that the plan keeps.
    lights: Lights,
    direct: DirectLight,
    photon_pass: PhotonPass,
    /// Where some photons are aimed.
    mixture: Option<Mixture>,
    /// Where the others start, if not by nature.
    guide: Option<Guide>,
    emitted_photons: u64,
    passes: u32,
    /// Where the settings ask for estimates of the error.
    batches: Option<BatchMeans>,
    setup: SetupStatistics,
}

impl<'s> Render<'s> {
    /// Traces the eye paths, finds the direct light and builds the trees over the hit points.
    pub fn new(scene: &'s Scene, settings: Settings) -> Render<'s> {
        let mut watch = Stopwatch::start();
        let plan = plan_of(scene, &settings);
        let lights = scene.lights().filtered(|number| plan.keeps_light(number));
        let stage = Stage::new(scene, &lights, &plan);
        let plan_seconds = watch.lap();
        let eye = camera_pass::trace(stage, &settings, 0);
        let eye_seconds = watch.lap();
        let radius = settings.radius.unwrap_or_else(|| radius_of(&eye));
        let (tree, hit_points, order) = build_tree(&eye.hit_points, |_| radius as f32);
        let facets = Facets::of(&hit_points);
        let plan = finished(plan, &settings, hit_points.len() + eye.glossy_points.len());
        let keeper = Keeper::of(plan.eye_paths);
        let kept = (keeper, keeper.count(&hit_points, eye.emitted.len()));
        let collectors = collectors(plan.classes, tree, &hit_points, kept, radius, &settings);
        let glints =
            plan.glints.then(|| Glints::new(eye.glossy_points, eye.emitted.len(), radius, &settings));
        let batches = batch_means(&settings, eye.emitted.len());
        let pixel_lists = lists_of_pixels(plan.eye_paths, &hit_points, eye.emitted.len());
        let tree_seconds = watch.lap();
        let none = Lights::default();
        let shadows = stage.of_direct_light(&plan, &none);
        let direct =
            DirectLight::new(shadows, plan.eye_paths, settings.seed, &hit_points, order, eye.emitted);
        let direct_seconds = watch.lap();
        let setup = SetupStatistics {
            hit_points: hit_points.len() as u64,
            eye_rays: eye.rays,
            shadow_rays: direct.rays(),
            cut_weight: eye.cut_weight,
            radius,
            plan_seconds,
            eye_seconds,
            tree_seconds,
            direct_seconds,
            ..SetupStatistics::default()
        };
        let mut render = Render {
            scene,
            settings,
            hit_points,
            collectors,
            glints,
            pixel_lists,
            facets,
            plan,
            lights,
            direct,
            photon_pass: PhotonPass::default(),
            mixture: None,
            guide: None,
            emitted_photons: 0,
            passes: 0,
            batches,
            setup,
        };
        render.try_out();
        render.setup.aim_seconds = watch.lap();
        render
    }

    /// Decides by trials where photons start.
    fn try_out(&mut self) {
        let decided = pilot::decide(self);
        (self.mixture, self.setup.aim) = (decided.mixture, decided.aim);
        (self.guide, self.setup.guide) = (decided.guide, decided.guiding);
        if let Some(guide) = decided.guiding {
            self.plan.tell_of_guiding(guide.share > 0.0, guide.to_string());
        }
    }

    fn stage(&self) -> Stage<'_> {
        Stage::new(self.scene, &self.lights, &self.plan)
    }

    /// One pass: eye paths and direct light anew where they change; photons are traced and gathered, radii shrink, trees follow.
    pub fn pass(&mut self) -> PassStatistics {
        let looks_again = self.passes > 0;
        self.pass_by(self.settings, looks_again)
    }

    /// A pass by `settings`, which may shrink radii in another way, and by what the set-up saw, if it does not look again.
    fn pass_by(&mut self, settings: Settings, looks_again: bool) -> PassStatistics {
        let mut watch = Stopwatch::start();
        let mut phases = PhaseSeconds::default();
        let shadow_rays_before = self.direct.rays();
        let eye_rays = if looks_again { self.look_again(&mut watch, &mut phases) } else { 0 };
        phases.direct = watch.lap();
        let stage = Stage::new(self.scene, &self.lights, &self.plan);
        let Render { collectors, glints, photon_pass, facets, hit_points, direct, mixture, guide, .. } = self;
        let (mixture, guide) = (mixture.as_ref(), guide.as_ref());
        let batch = match collectors.is_empty() && glints.is_none() {
            true => photon_pass.skip(),
            false => photon_pass.trace_guided(stage, &settings, self.passes, mixture, guide),
        };
        phases.trace = watch.lap();
        let (ledger, aimed) = (batch.ledger, batch.aimed);
        self.emitted_photons += ledger.emitted;
        self.passes += 1;
        let view = View { hit_points, receivers: Receivers::Diffuse(facets), lists: direct.view() };
        let gather = |c: &mut Collector| c.gather(view, &batch.of_any(c.classes), &settings, self.passes);
        let found: Vec<Found> = collectors.iter_mut().map(gather).collect();
        let glints = glints.as_mut().map(|glints| glints.gather(batch, &settings, self.passes));
        phases.gather = watch.lap();
        let classes = self.raise_radii(&found);
        if self.batches.is_some() {
            // The picture needs them as well: they are no cost of the estimates.
            self.pixel_lists();
        }
        watch.lap();
        self.close_batch(&classes);
        phases.errors = watch.lap();
        let shadow_rays = self.direct.rays() - shadow_rays_before;
        self.statistics(phases, [ledger, aimed], classes, glints, eye_rays + shadow_rays)
    }

    /// Sees what a further pass sees: the same points in other light, or other points. How many eye rays that took.
    fn look_again(&mut self, watch: &mut Stopwatch, phases: &mut PhaseSeconds) -> u64 {
        let stage = Stage::new(self.scene, &self.lights, &self.plan);
        let none = Lights::default();
        let shadows = stage.of_direct_light(&self.plan, &none);
        if let DirectLight::Fixed { pass, .. } = &mut self.direct {
            pass.add_pass(shadows, &self.hit_points, self.settings.seed, self.passes);
            return 0;
        }
        let eye = camera_pass::trace(stage, &self.settings, self.passes);
        let radius_of = |hit_point: &HitPoint| {
            let radius = |collector: &Collector| collector.state(hit_point.pixel as usize).radius();
            self.collectors.first().map_or(self.setup.radius, radius) as f32
        };
        let (tree, hit_points, order) = build_tree(&eye.hit_points, radius_of);
        let trees = vec![tree; self.collectors.len()];
        for (collector, tree) in self.collectors.iter_mut().zip(trees) {
            collector.look_at(tree, &hit_points);
        }
        if let Some(glints) = &mut self.glints {
            glints.look_at(eye.glossy_points);
        }
        self.facets = Facets::of(&hit_points);
        self.hit_points = hit_points;
        phases.eye = watch.lap();
        let key = (self.settings.seed, self.passes);
        self.direct.add_view(shadows, key, &self.hit_points, &order, &eye.emitted);
        eye.rays
    }

    /// Ends the pass of every collector: what it found and how large its discs are.
    fn raise_radii(&mut self, found: &[Found]) -> Vec<CollectorStatistics> {
        let Render { collectors, hit_points, .. } = self;
        let raise = |(collector, &found): (&mut Collector, _)| {
            let radius = collector.raise(hit_points);
            collector.statistics(found, radius)
        };
        collectors.iter_mut().zip(found).map(raise).collect()
    }

    /// Ends the batch of passes that the estimates of the error count by, if it is long enough.
    ///
    /// The radii of the last class stand for all: indirect light, if there is any, reaches everywhere, and where caustics
    /// are, their discs shrink alike.
    fn close_batch(&mut self, classes: &[CollectorStatistics]) {
        let Some(mut batches) = self.batches.take() else { return };
        let mean_radius = classes.last().map_or(self.setup.radius, |class| class.radius.mean);
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

    fn pixel_lists(&self) -> &PixelLists {
        self.pixel_lists
            .get_or_init(|| PixelLists::new(&self.hit_points, pixels(self.scene), |h| h.reflectance))
    }

    /// Whether a pixel saw no hit point in any pass.
    fn sees_nothing(&self, pixel: usize) -> bool {
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

    /// Photons that left the lights naturally in all passes: those that flux is normalised by.
    pub fn emitted_photons(&self) -> u64 {
        self.emitted_photons
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

    fn collector(&self, class: PathClass) -> Option<&Collector> {
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

fn plan_of(scene: &Scene, settings: &Settings) -> Plan {
    let plan = match settings.planning {
        Planning::Derived => Plan::of(scene, settings.transport),
        Planning::Everything => Plan::everything(scene, settings.transport),
    };
    plan.with_eye_paths(settings.eye_paths)
}

/// The plan after an eye pass that left so many points to collect light at.
fn finished(plan: Plan, settings: &Settings, points: usize) -> Plan {
    match settings.planning {
        Planning::Derived => plan.finish_if_blind(points as u64),
        Planning::Everything => plan,
    }
}

/// That which the eye pass suggests: by its hit points, or by rough surfaces where there is nothing else.
fn radius_of(eye: &EyePass) -> f64 {
    let glossy = || HitPoints::new(vec![eye.glossy_points.iter().map(|point| point.hit_point).collect()]);
    if eye.hit_points.is_empty() { automatic_radius(&glossy()) } else { automatic_radius(&eye.hit_points) }
}

/// Where eye paths are retraced, a pixel's statistics stand at its own place from the beginning.
fn lists_of_pixels(eye_paths: EyePaths, hit_points: &[HitPoint], pixels: usize) -> OnceLock<PixelLists> {
    match eye_paths {
        EyePaths::Fixed => OnceLock::new(),
        EyePaths::Retraced => PixelLists::of_pixels(hit_points, pixels).into(),
    }
}

/// For the kinds of paths that photons bring light by, one for all or one for each; all start from the same tree.
fn collectors(
    classes: PathClasses,
    tree: SphereBvh,
    hit_points: &[HitPoint],
    kept: (Keeper, usize),
    radius: f64,
    settings: &Settings,
) -> Vec<Collector> {
    let by_photons = classes.without(PathClass::Direct);
    let sets: Vec<PathClasses> = match settings.kinds {
        Kinds::Together => by_photons.any_photons().then_some(by_photons).into_iter().collect(),
        Kinds::Apart => by_photons.iter().map(|class| [class].into_iter().collect()).collect(),
    };
    let trees = vec![tree; sets.len()];
    let collector = |(set, tree)| Collector::new(set, tree, hit_points, kept, radius, settings);
    sets.into_iter().zip(trees).map(collector).collect()
}

fn batch_means(settings: &Settings, pixels: usize) -> Option<BatchMeans> {
    match settings.error_estimates {
        ErrorEstimates::None => None,
        ErrorEstimates::Picture => Some(BatchMeans::new(pixels, sampling_step(pixels))),
        ErrorEstimates::Pixels => Some(BatchMeans::new(pixels, 1)),
    }
}

fn pixels(scene: &Scene) -> usize {
    scene.film().width as usize * scene.film().height as usize
}

/// The tree over spheres of the given radii, the hit points in its order, and their indices before.
fn build_tree(
    hit_points: &HitPoints,
    radius: impl Fn(&HitPoint) -> f32 + Sync + Send,
) -> (SphereBvh, Vec<HitPoint>, Vec<u32>) {
    let spheres = hit_points.map(|h| Sphere { center: h.receiver.p, radius: radius(h) });
    let (tree, order) = SphereBvh::build(&spheres);
    let ordered = order.par_iter().map(|&index| *hit_points.get(index as usize)).collect();
    (tree, ordered, order)
}
