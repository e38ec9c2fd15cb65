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
mod course;
mod deposit;
mod develop;
mod diffuse_bounce;
mod direct;
mod direct_light;
mod draws;
mod emission;
mod evenness;
mod eye_trees;
mod facets;
mod features;
mod flights;
mod flux_ledger;
mod foreign_state;
mod gather;
mod gather_by_pixel;
mod gather_glossy;
mod gather_task;
mod glints;
mod glossy_point;
mod guiding;
mod hit_point;
mod hit_points;
mod independent;
mod keeper;
mod lane_flux;
mod lane_parts;
mod ledger;
mod mixture;
mod onward;
mod pasts;
mod photon_media;
mod photon_packet;
pub mod photon_pass;
mod photons;
mod pilot;
mod pixel_light;
mod pixel_lists;
mod queries;
mod radius;
mod radius_floor;
mod radius_policy;
mod received;
mod render_state;
mod set_up;
mod settings;
mod stage;
mod statistic;
mod statistics;
mod strata;
mod trial;
mod trial_points;
mod wavefront;

pub use accuracy::{Accuracy, Forecast, Layers, Outlook, PictureError, PixelError};
pub use camera_pass::EyePass;
pub use direct::DirectPass;
pub use facets::Facets;
pub use features::Features;
pub use flux_ledger::FluxLedger;
pub use foreign_state::ForeignState;
pub use gather_task::Found;
pub use glossy_point::GlossyPoint;
pub use guiding::GuidePlan;
pub use hit_point::{GatherState, HitPoint, PassSum};
pub use hit_points::HitPoints;
pub use independent::{DependentPasses, IndependentPasses};
pub use ledger::Ledger;
pub use mixture::{Mixture, PhotonBudget};
pub use photon_pass::PhotonPass;
pub use photons::{Deposits, Photon, PhotonBatch, PhotonChunk, Photons};
pub use pilot::AimPlan;
pub use radius::automatic_radius;
pub use radius_floor::least_radius;
pub use radius_policy::RadiusPolicy;
pub use received::received;
pub use render_state::RenderState;
pub use settings::{Aiming, ErrorEstimates, Guiding, Kinds, Planning, Settings};
pub use stage::Stage;
pub use statistic::Precision;
pub use statistics::{CollectorStatistics, PassStatistics, PhaseSeconds, RadiusRange, SetupStatistics};

use std::sync::OnceLock;

use crate::effects::{EyePaths, Plan};
use crate::light::{Guide, Lights};
use crate::scene::Scene;
use accuracy::BatchMeans;
use collector::{Collector, View};
use direct_light::{DirectLight, Sight};
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
    /// Those that left the lights naturally in all passes: flux is normalised by them.
    emitted_photons: u64,
    passes: u32,
    /// Where the settings ask for estimates of the error.
    batches: Option<BatchMeans>,
    setup: SetupStatistics,
}

impl<'s> Render<'s> {
    /// What comes before the passes: the plan, the eye paths, a tree over what they hit, the light that takes no photons, and where
    /// photons start.
    pub fn new(scene: &'s Scene, settings: Settings) -> Render<'s> {
        let mut watch = Stopwatch::start();
        let mut render = Render::planned(scene, settings);
        render.setup.plan_seconds = watch.lap();
        let eye = render.trace_eye_paths();
        render.setup.eye_seconds = watch.lap();
        let sight = render.start_collecting(eye);
        render.setup.tree_seconds = watch.lap();
        render.find_direct_light(sight);
        render.setup.direct_seconds = watch.lap();
        render.decide_where_photons_start();
        render.setup.aim_seconds = watch.lap();
        render
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
        let ledgers = self.trace_photons(&settings);
        phases.trace = watch.lap();
        let (classes, glints) = self.gather(&settings);
        phases.gather = watch.lap();
        phases.errors = self.estimate_errors(&classes);
        let shadow_rays = self.direct.rays() - shadow_rays_before;
        self.statistics(phases, ledgers, classes, glints, eye_rays + shadow_rays)
    }

    fn trace_eye_paths(&self) -> EyePass {
        camera_pass::trace(self.stage(), &self.settings, self.passes)
    }

    /// Sees what a further pass sees: the same points in other light, or other points. How many eye rays that took.
    fn look_again(&mut self, watch: &mut Stopwatch, phases: &mut PhaseSeconds) -> u64 {
        let (mut sight, mut rays) = (Sight::default(), 0);
        if self.plan.eye_paths == EyePaths::Retraced {
            let eye = self.trace_eye_paths();
            rays = eye.rays;
            sight = self.collect_elsewhere(eye);
            phases.eye = watch.lap();
        }
        self.sample_direct_light(&sight);
        rays
    }

    /// Photons from the lights, kept where they arrive; none where nobody collects them. What became of the natural and of the
    /// aimed ones.
    fn trace_photons(&mut self, settings: &Settings) -> [Ledger; 2] {
        let stage = Stage::new(self.scene, &self.lights, &self.plan);
        let (mixture, guide) = (self.mixture.as_ref(), self.guide.as_ref());
        let batch = match self.collectors.is_empty() && self.glints.is_none() {
            true => self.photon_pass.skip(),
            false => self.photon_pass.trace_guided(stage, settings, self.passes, mixture, guide),
        };
        self.emitted_photons += batch.ledger.emitted;
        self.passes += 1;
        [batch.ledger, batch.aimed]
    }

    /// Adds the photons to the points within whose radius they lie; radii shrink, trees follow. What every collector found, and
    /// those on rough surfaces.
    fn gather(&mut self, settings: &Settings) -> (Vec<CollectorStatistics>, Option<CollectorStatistics>) {
        let Render { collectors, glints, photon_pass, facets, hit_points, direct, .. } = self;
        let (batch, pass) = (photon_pass.batch(), self.passes);
        let view = View { hit_points, receivers: Receivers::Diffuse(facets), lists: direct.view() };
        let gather = |c: &mut Collector| c.gather(view, &batch.of_any(c.classes), settings, pass);
        let found = collectors.iter_mut().map(gather).collect();
        (found, glints.as_mut().map(|glints| glints.gather(batch, settings, pass)))
    }

    /// Ends the batch of passes that the estimates of the error count by, if it is long enough. How many seconds that took.
    ///
    /// The radii of the last class stand for all: indirect light, if there is any, reaches everywhere, and where caustics
    /// are, their discs shrink alike.
    fn estimate_errors(&mut self, classes: &[CollectorStatistics]) -> f64 {
        let Some(mut batches) = self.batches.take() else { return 0.0 };
        // The picture needs them as well: they are no cost of the estimates.
        self.pixel_lists();
        let mut watch = Stopwatch::start();
        let mean_radius = classes.last().map_or(self.setup.radius, |class| class.radius.mean);
        batches.shrink((mean_radius / self.setup.radius).powi(2));
        if batches.is_due(self.passes) {
            let lists = self.pixel_lists();
            batches.close(self.passes, |place| develop::noisy_radiance(self, lists.pixel(place)));
        }
        self.batches = Some(batches);
        watch.lap()
    }
}
