//! Light that takes no photons: lights that are seen, and what shadow rays bring.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use super::direct::{Sampled, sample_once};
use super::pixel_light::PixelLight;
use super::pixel_lists::PixelLists;
use super::{DirectPass, ForeignState, HitPoint, Stage};
use crate::effects::EyePaths;
use crate::math::{DVec3, Rgb};

/// Direct light, by whether eye paths stay.
#[derive(Clone, Debug)]
pub(super) enum DirectLight {
    /// At every hit point, and seen lights by pixel.
    Fixed { pass: DirectPass, emitted: Vec<Rgb> },
    /// By pixel, and where the hit points of each are in the pass under way.
    Retraced { light: PixelLight, view: PixelLists },
}

/// What passes bring.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum DirectState<'a> {
    Fixed(Cow<'a, Sampled>),
    Retraced(Cow<'a, PixelLight>),
}

/// What an eye pass leaves to direct light.
#[derive(Default)]
pub(super) struct Sight {
    /// Whose random numbers each hit point draws, in the order of the tree.
    pub keys: Vec<u32>,
    /// The radiance of lights that are seen, by pixel.
    pub emitted: Vec<Rgb>,
}

impl Default for DirectLight {
    /// Of no hit point and no pixel.
    fn default() -> DirectLight {
        DirectLight::Fixed { pass: DirectPass::default(), emitted: Vec::new() }
    }
}

impl DirectLight {
    /// Of the first pass.
    pub fn new(
        stage: Stage,
        eye_paths: EyePaths,
        seed: u64,
        hit_points: &[HitPoint],
        sight: Sight,
    ) -> DirectLight {
        match eye_paths {
            EyePaths::Fixed => {
                let pass = DirectPass::new(stage, hit_points, sight.keys, seed);
                DirectLight::Fixed { pass, emitted: sight.emitted }
            }
            EyePaths::Retraced => {
                let light = PixelLight::new(sight.emitted.len());
                let mut direct = DirectLight::Retraced { light, view: PixelLists::default() };
                direct.add_pass(stage, (seed, 0), hit_points, &sight);
                direct
            }
        }
    }

    /// Adds what a pass sees, drawn by seed and number of the pass: other samples of the lights at the hit points of the first, which
    /// nothing of `sight` is needed for, or all light at others.
    pub fn add_pass(
        &mut self,
        stage: Stage,
        (seed, number): (u64, u32),
        hit_points: &[HitPoint],
        sight: &Sight,
    ) {
        match self {
            DirectLight::Fixed { pass, .. } => pass.add_pass(stage, hit_points, seed, number),
            DirectLight::Retraced { light, view } => {
                *view = PixelLists::new(hit_points, sight.emitted.len(), |h| h.reflectance);
                let irradiance = sample_once(stage, hit_points, &sight.keys, seed, number);
                light.add_pass(view, &sight.emitted, irradiance);
            }
        }
    }

    /// Empties the sums over passes.
    pub fn forget(&mut self) {
        match self {
            DirectLight::Fixed { pass, .. } => pass.forget(),
            DirectLight::Retraced { light, .. } => light.forget(),
        }
    }

    /// Whether any of it changes from pass to pass.
    pub fn is_sampled(&self) -> bool {
        match self {
            DirectLight::Fixed { pass, .. } => pass.is_sampled(),
            DirectLight::Retraced { .. } => true,
        }
    }

    /// The hit points of each pixel in the pass under way, where pixels keep the statistics.
    pub fn view(&self) -> Option<&PixelLists> {
        match self {
            DirectLight::Fixed { .. } => None,
            DirectLight::Retraced { view, .. } => Some(view),
        }
    }

    /// The radiance of a pixel.
    pub fn radiance(&self, lists: &PixelLists, pixel: usize) -> DVec3 {
        match self {
            DirectLight::Fixed { pass, emitted } => {
                emitted[pixel].as_dvec3() + lists.reflected(pixel, |position| pass.irradiance(position))
            }
            DirectLight::Retraced { light, .. } => light.radiance(pixel),
        }
    }

    /// Whether a pixel saw no hit point in any pass.
    pub fn sees_nothing(&self, lists: &PixelLists, pixel: usize) -> bool {
        match self {
            DirectLight::Fixed { .. } => lists.of(pixel).is_empty(),
            DirectLight::Retraced { light, .. } => !light.sees(pixel),
        }
    }

    /// Shadow rays so far.
    pub fn rays(&self) -> u64 {
        match self {
            DirectLight::Fixed { pass, .. } => pass.rays(),
            DirectLight::Retraced { light, .. } => light.rays(),
        }
    }

    pub fn state(&self) -> DirectState<'_> {
        match self {
            DirectLight::Fixed { pass, .. } => DirectState::Fixed(Cow::Borrowed(pass.sampled())),
            DirectLight::Retraced { light, .. } => DirectState::Retraced(Cow::Borrowed(light)),
        }
    }

    /// Goes on from `state`, which [`DirectLight::check`] finds fit.
    pub fn restore(&mut self, state: DirectState) {
        match (self, state) {
            (DirectLight::Fixed { pass, .. }, DirectState::Fixed(theirs)) => {
                pass.set_sampled(theirs.into_owned())
            }
            (DirectLight::Retraced { light, .. }, DirectState::Retraced(theirs)) => {
                *light = theirs.into_owned()
            }
            _ => (),
        }
    }

    /// Whether `state` is that of a render like this one after so many passes.
    pub fn check(&self, state: &DirectState, passes: u32) -> Result<(), ForeignState> {
        let (part, is_like, theirs) = match (self, state) {
            (DirectLight::Fixed { pass, .. }, DirectState::Fixed(theirs)) => {
                ("samples of area lights", pass.sampled().is_like(theirs), theirs.passes)
            }
            (DirectLight::Retraced { light, .. }, DirectState::Retraced(theirs)) => {
                ("pixels", light.is_like(theirs), theirs.passes)
            }
            _ => ("eye paths", false, passes),
        };
        match is_like {
            false => Err(ForeignState::in_its(part)),
            true if theirs != passes.max(1) => Err(ForeignState::in_its("passes")),
            true => Ok(()),
        }
    }

    pub fn memory_bytes(&self) -> usize {
        match self {
            DirectLight::Fixed { pass, emitted } => pass.memory_bytes() + size_of_val(&**emitted),
            DirectLight::Retraced { light, view } => light.memory_bytes() + view.memory_bytes(),
        }
    }
}
