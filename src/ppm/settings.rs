use crate::bsdf::DiffuseSampling;
use crate::scene::RenderDesc;

/// What governs a render, beside the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Eye samples a pixel.
    pub samples: u32,
    /// Longest chain of specular events on an eye path.
    pub depth: u32,
    /// Photons emitted in a pass.
    pub photons: u64,
    /// `α` in `(0, 1]`: the share of each pass's photons that is kept as the radius shrinks.
    pub alpha: f64,
    /// Initial radius in scene units; `None` lets the eye pass find one.
    pub radius: Option<f64>,
    /// How photons bounce off diffuse surfaces.
    pub sampling: DiffuseSampling,
    /// Key of all random numbers.
    pub seed: u64,
}

impl Settings {
    /// The settings that a scene asks for, with cosine-weighted bounces and seed 0.
    pub fn of_scene(render: &RenderDesc) -> Settings {
        Settings {
            samples: render.samples,
            depth: render.depth,
            photons: render.photons,
            alpha: render.alpha,
            radius: render.radius,
            sampling: DiffuseSampling::Cosine,
            seed: 0,
        }
    }
}
