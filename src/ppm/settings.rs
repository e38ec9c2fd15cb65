use std::fmt;

use super::{Precision, RadiusPolicy};
use crate::bsdf::DiffuseSampling;
use crate::effects::{EyePaths, PathClasses};
use crate::scene::RenderDesc;

/// What a render keeps statistics of, for [`Render::accuracy`](super::Render::accuracy).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ErrorEstimates {
    /// Nothing.
    #[default]
    None,
    /// Some thousand pixels: enough for the error of the picture.
    Picture,
    /// Every pixel, 96 bytes each.
    Pixels,
}

/// Who decides what is simulated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Planning {
    /// The scene: what provably brings no light is left out.
    #[default]
    Derived,
    /// Nobody: all that was asked for is simulated, to hold the plan against.
    Everything,
}

/// Who decides how many photons of a pass are aimed at casters of caustics.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Aiming {
    /// A trial with a few thousand photons: as many as make variance times rays the least.
    #[default]
    Auto,
    /// The user: so many, though one photon at least is not aimed. None where there is nothing to aim at.
    Photons(u64),
}

impl fmt::Display for Aiming {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Aiming::Auto => f.write_str("auto"),
            Aiming::Photons(photons) => photons.fmt(f),
        }
    }
}

/// Who decides whether photons are guided to what is seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Guiding {
    /// A trial with some thousand photons: they are where that lowers variance times rays.
    #[default]
    Auto,
    /// Nobody: they start in proportion to the emitted flux.
    Off,
    /// The user: they are, as well as the trial can, whether it finds a gain or not.
    On,
}

impl fmt::Display for Guiding {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Guiding::Auto => "auto",
            Guiding::Off => "off",
            Guiding::On => "on",
        })
    }
}

/// Whether caustics and indirect light have statistics of their own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kinds {
    /// They share hit points' radii and sums: one walk gathers both.
    #[default]
    Together,
    /// Each has its own, so that each can be looked at: a second walk, and 60 bytes more a hit point.
    Apart,
}

/// What governs a render, beside the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Eye samples a pixel.
    pub samples: u32,
    /// Longest chain of specular events on an eye path.
    pub depth: u32,
    /// Photons emitted in a pass, aimed ones included.
    pub photons: u64,
    /// How many of them are aimed at casters of caustics.
    pub caustic_photons: Aiming,
    /// Whether the others are guided to what is seen.
    pub guiding: Guiding,
    /// `α` in `(0, 1]`: the share of each pass's photons that is kept as the radius shrinks.
    pub alpha: f64,
    /// Initial radius in scene units; `None` lets the eye pass find one.
    pub radius: Option<f64>,
    /// How radii shrink.
    pub policy: RadiusPolicy,
    /// How precisely hit points keep their statistics.
    pub precision: Precision,
    /// How photons bounce off diffuse surfaces.
    pub sampling: DiffuseSampling,
    /// Key of all random numbers.
    pub seed: u64,
    /// Key of the eye paths, if another than `seed`: renders with equal ones have the same hit points.
    pub eye_seed: Option<u64>,
    /// Whether eye paths stay; `None` is what the scene calls for.
    pub eye_paths: Option<EyePaths>,
    /// What is to be known of the error.
    pub error_estimates: ErrorEstimates,
    /// The kinds of paths that are asked for.
    pub transport: PathClasses,
    /// Whether those that come by photons are kept apart.
    pub kinds: Kinds,
    /// Who decides which of them are simulated.
    pub planning: Planning,
}

impl Settings {
    /// The key of the eye paths.
    pub fn key_of_eye_paths(&self) -> u64 {
        self.eye_seed.unwrap_or(self.seed)
    }

    /// The settings that a scene asks for, with radii shrunk by hit point, statistics in f64, cosine-weighted bounces, seed 0 and no estimates of the
    /// error.
    pub fn of_scene(render: &RenderDesc) -> Settings {
        Settings {
            samples: render.samples,
            depth: render.depth,
            photons: render.photons,
            caustic_photons: Aiming::Auto,
            guiding: Guiding::Auto,
            alpha: render.alpha,
            radius: render.radius,
            policy: RadiusPolicy::HitPoint,
            precision: Precision::Double,
            sampling: DiffuseSampling::Cosine,
            seed: 0,
            eye_seed: None,
            eye_paths: None,
            error_estimates: ErrorEstimates::None,
            transport: PathClasses::ALL,
            kinds: Kinds::Together,
            planning: Planning::Derived,
        }
    }
}
