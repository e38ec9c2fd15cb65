//! What a render has gathered: what scene and settings do not give again.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use super::accuracy::BatchMeans;
use super::collector::Collector;
use super::direct_light::DirectState;
use super::glints::Glints;
use super::keeper::Keeper;
use super::statistic::Statistics;
use super::{ForeignState, Render};
use crate::effects::PathClasses;

/// The progress of a [`Render`], to be kept and given to another one of the same scene and settings.
///
/// Eye paths, the tree's shape and the light of point lights at fixed hit points are no part of it: they come out the same
/// again.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RenderState<'a> {
    passes: u32,
    emitted_photons: u64,
    collectors: Vec<CollectorState<'a>>,
    /// Of caustics on rough surfaces.
    glints: Option<Cow<'a, Statistics>>,
    direct: DirectState<'a>,
    batches: Option<Cow<'a, BatchMeans>>,
}

/// What kinds of paths brought that are kept together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct CollectorState<'a> {
    kinds: PathClasses,
    statistics: Cow<'a, Statistics>,
    /// As the tree has them: f64 radii rounded, except where no photon came yet. None where every pass builds a tree.
    radii: Cow<'a, [f32]>,
}

impl<'a> CollectorState<'a> {
    fn of(collector: &'a Collector) -> CollectorState<'a> {
        CollectorState {
            kinds: collector.classes,
            statistics: Cow::Borrowed(&collector.states),
            radii: Cow::Borrowed(kept_radii(collector)),
        }
    }

    fn fits(&self, collector: &Collector) -> bool {
        let radii = self.radii.iter().all(|radius| (0.0..f32::INFINITY).contains(radius));
        self.kinds == collector.classes
            && collector.states.is_like(&self.statistics)
            && self.radii.len() == kept_radii(collector).len()
            && radii
    }
}

fn kept_radii(collector: &Collector) -> &[f32] {
    match collector.keeper {
        Keeper::HitPoints => collector.tree.radii(),
        Keeper::Pixels => &[],
    }
}

impl RenderState<'_> {
    /// Photon passes done.
    pub fn passes(&self) -> u32 {
        self.passes
    }
}

impl Render<'_> {
    /// What passes brought so far; nothing is copied.
    ///
    /// ```no_run
    /// use caustica::{ppm::{Render, Settings}, scene::{self, Scene}};
    /// let desc = scene::load("data/course_diffuse.toml".as_ref())?;
    /// let settings = Settings::of_scene(&desc.render);
    /// let scene = Scene::new(desc)?;
    /// let (mut first, mut second) = (Render::new(&scene, settings), Render::new(&scene, settings));
    /// first.pass();
    /// second.restore(first.state())?;
    /// assert_eq!(second.picture(), first.picture());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn state(&self) -> RenderState<'_> {
        RenderState {
            passes: self.passes,
            emitted_photons: self.emitted_photons,
            collectors: self.collectors.iter().map(CollectorState::of).collect(),
            glints: self.glints.as_ref().map(Glints::state),
            direct: self.direct.state(),
            batches: self.batches.as_ref().map(Cow::Borrowed),
        }
    }

    /// Goes on where the render that `state` comes from was: further passes bring the same bytes.
    ///
    /// # Errors
    /// Where the state is visibly that of another scene or other settings; nothing is changed then.
    pub fn restore(&mut self, state: RenderState) -> Result<(), ForeignState> {
        self.check(&state)?;
        self.passes = state.passes;
        self.emitted_photons = state.emitted_photons;
        for (collector, theirs) in self.collectors.iter_mut().zip(state.collectors) {
            collector.states = theirs.statistics.into_owned();
            if collector.keeper == Keeper::HitPoints {
                collector.tree.refit(|position| theirs.radii[position]);
            }
        }
        if let (Some(ours), Some(theirs)) = (&mut self.glints, state.glints) {
            ours.restore(theirs.into_owned());
        }
        self.direct.restore(state.direct);
        self.batches = state.batches.map(Cow::into_owned);
        Ok(())
    }

    fn check(&self, state: &RenderState) -> Result<(), ForeignState> {
        let batches = match (&self.batches, &state.batches) {
            (None, None) => true,
            (Some(ours), Some(theirs)) => ours.is_like(theirs) && theirs.passes() <= state.passes,
            _ => false,
        };
        let glints = match (&self.glints, &state.glints) {
            (None, None) => true,
            (Some(ours), Some(theirs)) => ours.state().is_like(theirs),
            _ => false,
        };
        let fits = |(ours, theirs): (&Collector, &CollectorState)| theirs.fits(ours);
        let parts = [
            ("kinds of light", self.collectors.len() == state.collectors.len()),
            ("hit points", self.collectors.iter().zip(&state.collectors).all(fits)),
            ("caustics on rough surfaces", glints),
            ("estimates of the error", batches),
        ];
        match parts.iter().find(|(_, fits)| !fits) {
            Some(&(part, _)) => Err(ForeignState::in_its(part)),
            None => self.direct.check(&state.direct, state.passes),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{ErrorEstimates, EyePaths, Precision, RadiusPolicy, Settings};
    use super::*;
    use crate::film::Image;
    use crate::scene::{self, Scene};
    use std::path::Path;

    /// With a light of an area, so that direct light is sampled.
    fn scene(name: &str) -> Scene {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name);
        let mut desc = scene::load(&path).unwrap();
        (desc.film.width, desc.film.height) = (24, 20);
        Scene::new(desc).unwrap()
    }

    fn settings(scene: &Scene) -> Settings {
        let error_estimates = ErrorEstimates::Pixels;
        Settings { samples: 1, photons: 3000, error_estimates, ..Settings::of_scene(scene.render()) }
    }

    fn layers(render: &Render) -> Vec<Image> {
        let layers = render.accuracy(0.9).unwrap().layers().unwrap();
        vec![render.picture(), render.direct_picture(), layers.stderr, layers.bias, layers.radius]
    }

    /// The bits of `a`, since unknown errors are NaN.
    fn bits(images: &[Image]) -> Vec<[u32; 3]> {
        images.iter().flat_map(Image::pixels).map(|p| p.to_array().map(f32::to_bits)).collect()
    }

    /// Whatever is kept of hit points; through bytes and back.
    #[test]
    fn a_render_goes_on_as_if_it_had_not_stopped() {
        let scene = scene("cornell_b.toml");
        for policy in
            [RadiusPolicy::HitPoint, RadiusPolicy::Shared, RadiusPolicy::Tested, RadiusPolicy::Fixed]
        {
            for (precision, eye_paths) in [
                (Precision::Double, EyePaths::Fixed),
                (Precision::Single, EyePaths::Fixed),
                (Precision::Double, EyePaths::Retraced),
            ] {
                let eye_paths = Some(eye_paths);
                let settings = Settings { policy, precision, eye_paths, ..settings(&scene) };
                let (mut whole, mut first) = (Render::new(&scene, settings), Render::new(&scene, settings));
                for _ in 0..3 {
                    first.pass();
                }
                let bytes = postcard::to_stdvec(&first.state()).unwrap();
                let mut second = Render::new(&scene, settings);
                second.restore(postcard::from_bytes(&bytes).unwrap()).unwrap();
                let both = second.collectors.iter().zip(&first.collectors);
                for (second, first) in both.filter(|_| eye_paths == Some(EyePaths::Fixed)) {
                    assert!(second.tree.nodes() == first.tree.nodes(), "{policy} {precision:?}");
                }
                for _ in 0..4 {
                    second.pass();
                }
                for _ in 0..7 {
                    whole.pass();
                }
                assert!(second.state() == whole.state(), "{policy} {precision:?}");
                assert!(bits(&layers(&second)) == bits(&layers(&whole)), "{policy} {precision:?}");
            }
        }
    }

    #[test]
    fn states_of_other_renders_are_refused() {
        let scene = scene("cornell_b.toml");
        let ours = settings(&scene);
        let mut render = Render::new(&scene, ours);
        let before = render.state().passes();
        for (part, theirs) in [
            ("hit points", Settings { samples: 2, ..ours }),
            ("hit points", Settings { precision: Precision::Single, ..ours }),
            ("estimates of the error", Settings { error_estimates: ErrorEstimates::None, ..ours }),
            ("hit points", Settings { eye_paths: Some(EyePaths::Retraced), ..ours }),
        ] {
            let mut other = Render::new(&scene, theirs);
            other.pass();
            let error = render.restore(other.state()).unwrap_err();
            assert_eq!(error.to_string(), format!("its {part} do not belong to this render"));
            assert_eq!(render.passes(), before);
        }
        let other = Render::new(&scene, ours);
        let skipping = RenderState { passes: 5, ..other.state() };
        assert_eq!(render.restore(skipping).unwrap_err().part, "passes");
        let mut state = other.state();
        state.collectors[0].radii = Cow::Owned(vec![f32::NAN; other.hit_points.len()]);
        assert_eq!(render.restore(state).unwrap_err().part, "hit points");
    }
}
