use super::Coat;
use crate::math::{Rgb, Rng, Vec3, warp};

/// Whether surfaces can mirror and refract at all: in every program but that which measures what this ability costs scenes
/// that have no use for it. There such surfaces are black.
pub const SPECULAR: bool = !cfg!(feature = "lambertian-only");

/// What a path carries, which decides how it changes at a refracting interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transport {
    /// Radiance along a path from the camera before its first diffuse bounce. The course's fixed weights apply as they stand.
    Camera,
    /// Radiance along any later part of a path from the camera: refraction scales it by `1 / eta²`.
    Radiance,
    /// Photon power, which an interface passes on unscaled.
    Power,
}

/// How diffuse bounces choose their direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DiffuseSampling {
    /// Density cos θ / π: the cosine cancels and every photon keeps its power.
    Cosine,
    /// Density 1 / 2π by rejection: power is scaled by 2 cos θ.
    Uniform,
}

/// A kind of scattering.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// Lambertian reflection.
    Diffuse,
    /// Mirror reflection, total internal reflection included.
    Reflection,
    /// Refraction into the other side, or straight through a pane.
    Transmission,
    /// Reflection by a facet of a rough surface.
    GlossyReflection,
    /// Refraction by a facet of a rough surface.
    GlossyTransmission,
}

impl Event {
    /// Whether the path goes on along the one direction that there is: what no light can be sampled for.
    pub fn is_specular(self) -> bool {
        matches!(self, Event::Reflection | Event::Transmission)
    }

    /// Whether the path goes on behind the surface.
    pub fn crosses(self) -> bool {
        matches!(self, Event::Transmission | Event::GlossyTransmission)
    }
}

/// A continuation of a path along one direction: perfectly specular, or by the facet of a rough surface that was drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpecularLobe {
    /// Reflection or transmission, and whether by a facet.
    pub event: Event,
    /// Where the path goes on, unit, local.
    pub wi: Vec3,
    /// The share of the incident power that goes this way; roulette takes it as the probability.
    pub share: Rgb,
    /// What multiplies the share for the quantity that the path carries; 1 but for refracted radiance.
    pub scale: f32,
    /// The density by which facets give `wi` (1/sr); infinite of a perfectly specular lobe.
    pub pdf_w: f32,
}

impl SpecularLobe {
    /// The factor on a path that follows this lobe for certain.
    pub fn weight(&self) -> Rgb {
        self.share * self.scale
    }
}

/// All that a surface does with light that comes along one direction: one diffuse and at most two specular lobes, or those of
/// the facet of a rough surface that was drawn.
///
/// The shares of all lobes sum to at most 1 per channel; the rest is absorbed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scattering {
    /// `π f / T(wi)` of the diffuse lobe, where `T` is what passes the coat: its share of the incident power, where there is none.
    pub albedo: Rgb,
    /// What lies on the diffuse base.
    pub coat: Coat,
    /// The mean of `T(wi)` over cosine-weighted directions.
    enters: f32,
    lobes: [Option<SpecularLobe>; 2],
}

/// The lobe that roulette chose, and the factor on the path: its weight over its probability.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Choice {
    /// A diffuse bounce; the factor still lacks that of [`sample_diffuse`], and what of the light passes the coat.
    Diffuse {
        /// `albedo / p`.
        factor: Rgb,
    },
    /// A specular bounce, or one by a facet.
    Specular {
        /// Reflection or transmission, and whether by a facet.
        event: Event,
        /// Where the path goes on, unit, local.
        wi: Vec3,
        /// `weight / p`.
        factor: Rgb,
        /// See [`SpecularLobe::pdf_w`].
        pdf_w: f32,
    },
}

impl Scattering {
    /// Of a surface without specular lobes.
    pub fn diffuse(albedo: Rgb) -> Scattering {
        Scattering { albedo, coat: Coat::NONE, enters: 1.0, lobes: [None, None] }
    }

    /// Lobes without any share are left out: they contribute nothing.
    pub fn new(albedo: Rgb, lobes: [Option<SpecularLobe>; 2]) -> Scattering {
        Scattering { lobes: lobes.map(with_share), ..Scattering::diffuse(albedo) }
    }

    /// The same with a coat on the diffuse base that lets the share `enters` of diffuse light pass.
    pub(super) fn under(self, coat: Coat, enters: f32) -> Scattering {
        Scattering { coat, enters, ..self }
    }

    /// The diffuse lobe's share of the incident power.
    pub fn diffuse_share(&self) -> Rgb {
        self.albedo * self.enters
    }

    /// The specular lobes, or those of the facet that was drawn.
    pub fn specular(&self) -> impl Iterator<Item = &SpecularLobe> {
        self.lobes.iter().take(if SPECULAR { 2 } else { 0 }).flatten()
    }

    /// Russian roulette among the lobes and absorption (`None`), with `u` uniform in `[0, 1)`.
    ///
    /// A lobe is chosen with probability `p` = the largest channel of its share (linear RGB), and compensated by
    /// `1 / p` exactly once, here.
    pub fn choose(&self, u: f32) -> Option<Choice> {
        let mut below = 0.0;
        for lobe in self.specular() {
            let p = lobe.share.max_element();
            below += p;
            if u < below {
                let SpecularLobe { event, wi, pdf_w, .. } = *lobe;
                return Some(Choice::Specular { event, wi, factor: lobe.weight() / p, pdf_w });
            }
        }
        let p = self.enters * self.albedo.max_element();
        (u < below + p).then(|| Choice::Diffuse { factor: self.albedo / p })
    }

    /// Chooses a lobe for certain, in the same proportions as [`Scattering::choose`]: what would be absorbed
    /// lowers the factor instead. `None` only of a surface without lobes.
    pub fn choose_any(&self, u: f32) -> Option<Choice> {
        let lobes = self.specular().map(|lobe| lobe.share.max_element()).sum::<f32>();
        let survival = lobes + self.enters * self.albedo.max_element();
        self.choose(u * survival).map(|choice| choice.scaled(survival))
    }
}

impl Choice {
    fn scaled(self, by: f32) -> Choice {
        match self {
            Choice::Diffuse { factor } => Choice::Diffuse { factor: by * factor },
            Choice::Specular { event, wi, factor, pdf_w } => {
                Choice::Specular { event, wi, factor: by * factor, pdf_w }
            }
        }
    }
}

fn with_share(lobe: Option<SpecularLobe>) -> Option<SpecularLobe> {
    lobe.filter(|lobe| lobe.share.max_element() > 0.0)
}

/// A direction of a diffuse bounce on the side of `wo`, and its factor `cos θ / (π pdf_w)`, all local.
pub fn sample_diffuse(sampling: DiffuseSampling, wo: Vec3, rng: &mut Rng) -> (Vec3, f32) {
    let (wi, factor) = match sampling {
        DiffuseSampling::Cosine => (warp::square_to_cosine_hemisphere(rng.next_vec2()), 1.0),
        DiffuseSampling::Uniform => {
            let wi = warp::uniform_hemisphere_by_rejection(rng);
            (wi, 2.0 * wi.z)
        }
    };
    (if wo.z < 0.0 { wi.with_z(-wi.z) } else { wi }, factor)
}
