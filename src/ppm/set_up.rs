//! The steps of the set-up, and of a further pass that looks elsewhere: from what eye paths hit to trees, statistics and direct light.

use std::sync::OnceLock;

use super::accuracy::BatchMeans;
use super::collector::Collector;
use super::direct_light::{DirectLight, Sight};
use super::glints::Glints;
use super::keeper::Keeper;
use super::pixel_lists::PixelLists;
use super::{
    EyePass, Facets, HitPoint, HitPoints, Kinds, PhotonPass, Planning, Render, Settings, SetupStatistics,
    Stage, automatic_radius, pilot,
};
use crate::bvh::SphereBvh;
use crate::effects::{EyePaths, PathClass, PathClasses, Plan};
use crate::scene::Scene;

impl<'s> Render<'s> {
    /// What is simulated, by which lights; nothing is seen yet.
    pub(super) fn planned(scene: &'s Scene, settings: Settings) -> Render<'s> {
        let plan = plan_of(scene, &settings);
        let lights = scene.lights().filtered(|number| plan.keeps_light(number));
        Render {
            scene,
            settings,
            hit_points: Vec::new(),
            collectors: Vec::new(),
            glints: None,
            pixel_lists: OnceLock::new(),
            facets: Facets::default(),
            plan,
            lights,
            direct: DirectLight::default(),
            photon_pass: PhotonPass::default(),
            mixture: None,
            guide: None,
            emitted_photons: 0,
            passes: 0,
            batches: None,
            setup: SetupStatistics::default(),
        }
    }

    /// Builds the tree over the hit points of the first eye pass, and statistics for what photons will bring there.
    pub(super) fn start_collecting(&mut self, eye: EyePass) -> Sight {
        let (settings, pixels) = (self.settings, eye.emitted.len());
        let radius = settings.radius.unwrap_or_else(|| radius_of(&eye));
        let (tree, hit_points, keys) = eye.hit_points.tree(|_| radius as f32);
        self.facets = Facets::of(&hit_points);
        if settings.planning == Planning::Derived {
            let points = hit_points.len() + eye.glossy_points.len();
            self.plan = self.plan.clone().finish_if_blind(points as u64);
        }
        let keeper = Keeper::of(self.plan.eye_paths);
        let kept = (keeper, keeper.count(&hit_points, pixels));
        self.collectors = collectors(self.plan.classes, tree, &hit_points, kept, radius, &settings);
        let glints = || Glints::new(eye.glossy_points, pixels, radius, &settings);
        self.glints = self.plan.glints.then(glints);
        self.batches = BatchMeans::asked_for(settings.error_estimates, pixels);
        if self.plan.eye_paths == EyePaths::Retraced {
            self.pixel_lists = PixelLists::of_pixels(&hit_points, pixels).into();
        }
        self.setup = SetupStatistics {
            hit_points: hit_points.len() as u64,
            eye_rays: eye.rays,
            cut_weight: eye.cut_weight,
            radius,
            ..self.setup
        };
        self.hit_points = hit_points;
        Sight { keys, emitted: eye.emitted }
    }

    /// Builds the tree over other hit points, which go on with the radii of their pixels.
    pub(super) fn collect_elsewhere(&mut self, eye: EyePass) -> Sight {
        let radius_of = |hit_point: &HitPoint| {
            let radius = |collector: &Collector| collector.state(hit_point.pixel as usize).radius();
            self.collectors.first().map_or(self.setup.radius, radius) as f32
        };
        let (tree, hit_points, keys) = eye.hit_points.tree(radius_of);
        let trees = vec![tree; self.collectors.len()];
        for (collector, tree) in self.collectors.iter_mut().zip(trees) {
            collector.look_at(tree, &hit_points);
        }
        if let Some(glints) = &mut self.glints {
            glints.look_at(eye.glossy_points);
        }
        self.facets = Facets::of(&hit_points);
        self.hit_points = hit_points;
        Sight { keys, emitted: eye.emitted }
    }

    /// The light that takes no photons, as the first eye pass sees it.
    pub(super) fn find_direct_light(&mut self, sight: Sight) {
        let (stage, seed) = (self.stage().of_direct_light(&self.plan), self.settings.seed);
        self.direct = DirectLight::new(stage, self.plan.eye_paths, seed, &self.hit_points, sight);
        self.setup.shadow_rays = self.direct.rays();
    }

    /// The same once more: of the hit points as they are, or of those of another eye pass.
    pub(super) fn sample_direct_light(&mut self, sight: &Sight) {
        let stage = Stage::new(self.scene, &self.lights, &self.plan).of_direct_light(&self.plan);
        self.direct.add_pass(stage, (self.settings.seed, self.passes), &self.hit_points, sight);
    }

    /// Aims and guides photons, where trials find that this helps.
    pub(super) fn decide_where_photons_start(&mut self) {
        let decided = pilot::decide(self);
        (self.mixture, self.setup.aim) = (decided.mixture, decided.aim);
        (self.guide, self.setup.guide) = (decided.guide, decided.guiding);
        if let Some(guide) = decided.guiding {
            self.plan.tell_of_guiding(guide.share > 0.0, guide.to_string());
        }
    }

    pub(super) fn stage(&self) -> Stage<'_> {
        Stage::new(self.scene, &self.lights, &self.plan)
    }
}

fn plan_of(scene: &Scene, settings: &Settings) -> Plan {
    let plan = match settings.planning {
        Planning::Derived => Plan::of(scene, settings.transport),
        Planning::Everything => Plan::everything(scene, settings.transport),
    };
    plan.with_eye_paths(settings.eye_paths)
}

/// That which the eye pass suggests: by its hit points, or by rough surfaces where there is nothing else.
fn radius_of(eye: &EyePass) -> f64 {
    let glossy = || HitPoints::new(vec![eye.glossy_points.iter().map(|point| point.hit_point).collect()]);
    if eye.hit_points.is_empty() { automatic_radius(&glossy()) } else { automatic_radius(&eye.hit_points) }
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
