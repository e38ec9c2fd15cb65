//! Passes that know nothing of each other: each is a picture of its own, and their mean is that of a render.

use super::{ErrorEstimates, PassStatistics, RadiusPolicy, Render, Settings};
use crate::effects::EyePaths;
use crate::film::Image;
use crate::scene::Scene;

/// A render whose passes may be made in any order, on any machine.
///
/// Pass `k` (from 0) gathers with `R_k² = R_0² Π_{i=1..k} (i + α) / (i + 1)` and random numbers of its own, so its picture `X_k` depends on
/// scene, settings and `k` alone. The mean of `X_0 .. X_{n-1}` is what a [`Render`] with [`RadiusPolicy::Shared`] shows after `n`
/// passes, up to rounding; where eye paths are retraced, also up to floors of radii that it keeps from passes before.
///
/// # Source
/// Knaus and Zwicker, "Progressive Photon Mapping: A Probabilistic Approach", ACM Transactions on Graphics 30(3), 2011.
pub struct IndependentPasses<'s> {
    render: Render<'s>,
}

/// Why passes would depend on each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "by the radius policy `{policy}` the discs of a pass depend on what passes before it found, so none stands alone; \
     `shared` (or `fixed`) is right"
)]
pub struct DependentPasses {
    /// How radii were to shrink.
    pub policy: RadiusPolicy,
}

impl<'s> IndependentPasses<'s> {
    /// Sets up the render, once for all its passes; errors are not estimated.
    ///
    /// # Errors
    /// Where radii depend on what was found before.
    ///
    /// ```no_run
    /// use caustica::{ppm::{IndependentPasses, RadiusPolicy, Settings}, scene::{self, Scene}};
    /// let desc = scene::load("data/course_diffuse.toml".as_ref())?;
    /// let settings = Settings { policy: RadiusPolicy::Shared, ..Settings::of_scene(&desc.render) };
    /// let scene = Scene::new(desc)?;
    /// let mut passes = IndependentPasses::new(&scene, settings)?;
    /// let (seventh, _) = passes.pass(7);
    /// passes.pass(3);
    /// assert_eq!(passes.pass(7).0, seventh);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(scene: &'s Scene, settings: Settings) -> Result<IndependentPasses<'s>, DependentPasses> {
        IndependentPasses::check(&settings)?;
        let settings = Settings { error_estimates: ErrorEstimates::None, ..settings };
        Ok(IndependentPasses { render: Render::new(scene, settings) })
    }

    /// Whether passes by these settings are independent.
    ///
    /// # Errors
    /// As for [`IndependentPasses::new`].
    pub fn check(settings: &Settings) -> Result<(), DependentPasses> {
        let Settings { policy, alpha, .. } = *settings;
        policy.radius_of_pass(1.0, alpha, 0).map(drop).ok_or(DependentPasses { policy })
    }

    /// The picture of pass `k`, from 0, and what it did.
    pub fn pass(&mut self, k: u32) -> (Image, PassStatistics) {
        let settings = self.render.settings;
        self.render.forget(k);
        // The radius is that of the pass already, and nobody asks for that of the next.
        let statistics = self.render.pass_by(Settings { policy: RadiusPolicy::Fixed, ..settings }, true);
        (self.render.picture(), statistics)
    }

    /// The render as the last pass left it.
    pub fn render(&self) -> &Render<'s> {
        &self.render
    }
}

impl Render<'_> {
    /// Leaves nothing of other passes: what comes next is pass `k`, with its radius.
    fn forget(&mut self, k: u32) {
        let Settings { policy, alpha, .. } = self.settings;
        let radius = policy.radius_of_pass(self.setup.radius, alpha, k).unwrap_or(self.setup.radius);
        (self.passes, self.emitted_photons) = (k, 0);
        self.direct.forget();
        self.collectors.iter_mut().for_each(|collector| collector.forget(radius, &self.settings));
        self.glints.iter_mut().for_each(|glints| glints.forget(radius, &self.settings));
        // Retraced eye paths bring other trees, with floors of their own.
        if self.plan.eye_paths == EyePaths::Fixed {
            self.collectors.iter_mut().for_each(|collector| collector.follow(&self.hit_points));
            self.glints.iter_mut().for_each(|glints| glints.follow());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Guiding, Kinds, Precision};
    use super::*;
    use crate::math::DVec3;
    use crate::scene;
    use std::path::Path;

    fn scene(name: &str) -> Scene {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name).with_extension("toml");
        let mut desc = scene::load(&path).unwrap();
        (desc.film.width, desc.film.height) = (24, 20);
        Scene::new(desc).unwrap()
    }

    fn settings(scene: &Scene) -> Settings {
        let policy = RadiusPolicy::Shared;
        Settings { samples: 1, photons: 3000, policy, ..Settings::of_scene(scene.render()) }
    }

    /// The mean in f64.
    fn mean(pictures: &[Image]) -> Vec<DVec3> {
        let sum =
            |pixel: usize| pictures.iter().map(|picture| picture.pixels()[pixel].as_dvec3()).sum::<DVec3>();
        (0..pictures[0].pixels().len()).map(|pixel| sum(pixel) / pictures.len() as f64).collect()
    }

    /// The largest error of a channel beside the brightest pass of its pixel, which it is rounded by.
    fn worst(mean: &[DVec3], picture: &Image, passes: &[Image]) -> f64 {
        let error = |pixel: usize| {
            let brightest =
                passes.iter().map(|image| image.pixels()[pixel].max_element()).fold(1e-30, f32::max);
            (mean[pixel] - picture.pixels()[pixel].as_dvec3()).abs().max_element() / f64::from(brightest)
        };
        (0..mean.len()).map(error).fold(0.0, f64::max)
    }

    /// Direct light from points and from areas, photons in one sum and in two, of both precisions.
    #[test]
    fn their_mean_is_the_picture_of_a_render() {
        const PASSES: u32 = 6;
        for (name, kinds, precision, policy, bound) in [
            ("cornell_b", Kinds::Together, Precision::Double, RadiusPolicy::Shared, 3e-7),
            ("course_balls", Kinds::Apart, Precision::Double, RadiusPolicy::Shared, 3e-7),
            ("glass_bead", Kinds::Apart, Precision::Double, RadiusPolicy::Shared, 3e-7),
            ("cornell_b", Kinds::Together, Precision::Single, RadiusPolicy::Shared, 3e-6),
            ("cornell_b", Kinds::Together, Precision::Double, RadiusPolicy::Fixed, 3e-7),
        ] {
            let scene = scene(name);
            let settings = Settings { kinds, precision, policy, ..settings(&scene) };
            let mut render = Render::new(&scene, settings);
            (0..PASSES).for_each(|_| drop(render.pass()));
            let mut passes = IndependentPasses::new(&scene, settings).unwrap();
            let pictures: Vec<Image> = (0..PASSES).map(|k| passes.pass(k).0).collect();
            let worst = worst(&mean(&pictures), &render.picture(), &pictures);
            eprintln!("{name} {kinds:?} {precision:?} {policy}: {worst:e}");
            assert!(worst < bound, "{name} {kinds:?} {precision:?} {policy}: {worst}");
            assert!(pictures[0] != pictures[5], "{name}");
        }
    }

    /// Whatever was made before, by whomever.
    #[test]
    fn a_pass_depends_on_its_number_alone() {
        let fixed = [("cornell_b", None), ("glass_bead", None), ("keyhole", Some(Guiding::On))];
        let retraced = [("depth_of_field", None), ("ground_glass", None)];
        for (name, guiding) in fixed.into_iter().chain(retraced) {
            let scene = scene(name);
            for kinds in [Kinds::Together, Kinds::Apart] {
                let guiding = guiding.unwrap_or_default();
                let settings = Settings { kinds, guiding, ..settings(&scene) };
                let mut passes = IndependentPasses::new(&scene, settings).unwrap();
                let [fifth, zeroth, again] = [5, 0, 5].map(|k| passes.pass(k));
                let mut others = IndependentPasses::new(&scene, settings).unwrap();
                assert!(again.0 == fifth.0 && others.pass(5).0 == fifth.0, "{name} {kinds:?}");
                assert!(others.pass(0).0 == zeroth.0 && zeroth.0 != fifth.0, "{name} {kinds:?}");
                assert_eq!((fifth.1.pass, again.1.emitted_in_all), (6, fifth.1.photons.emitted));
                assert_eq!(passes.render().glints.is_some(), name == "ground_glass");
            }
        }
    }

    /// The radius is that of the schedule, and not of how many passes were made.
    #[test]
    fn radii_follow_the_schedule() {
        let scene = scene("cornell_b");
        let settings = settings(&scene);
        let mut passes = IndependentPasses::new(&scene, settings).unwrap();
        for k in [40, 2, 0] {
            let radius = RadiusPolicy::Shared.radius_of_pass(passes.render().setup.radius, settings.alpha, k);
            let found = passes.pass(k).1.radius.mean;
            assert!((found / radius.unwrap() - 1.0).abs() < 1e-6, "pass {k}: {found}, not {radius:?}");
        }
    }

    #[test]
    fn policies_that_look_back_are_refused() {
        let scene = scene("cornell_b");
        for policy in [RadiusPolicy::HitPoint, RadiusPolicy::Tested] {
            let settings = Settings { policy, ..settings(&scene) };
            let error = IndependentPasses::new(&scene, settings).err().unwrap();
            assert!(error.to_string().contains(&format!("`{policy}`")), "{error}");
        }
    }
}
