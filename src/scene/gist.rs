use super::Material;
use crate::bsdf::Bsdf;
use crate::math::Rgb;

/// What of a material is known without looking at it closely.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Gist {
    /// Lambertian, the same everywhere, of this albedo, and no mask.
    Lambertian(Rgb),
    /// A mask, or of other lobes, too, none of them rough, under no coat; the diffuse share is the same wherever and from wherever it
    /// is seen.
    Uniform(Rgb),
    /// Nothing but facets.
    Rough,
    /// It depends on where, or whence, it is seen.
    Varying,
}

impl Gist {
    pub fn of(material: &Material) -> Gist {
        match material.bsdf {
            Bsdf::Rough(_) => Gist::Rough,
            Bsdf::Plastic(_) => Gist::Varying,
            Bsdf::Diffuse { .. } | Bsdf::FixedWeight { .. } if !material.textures.are_plain() => {
                Gist::Varying
            }
            Bsdf::Diffuse { albedo } if !material.is_mask() => Gist::Lambertian(albedo),
            Bsdf::Diffuse { .. }
            | Bsdf::FixedWeight { .. }
            | Bsdf::Mirror { .. }
            | Bsdf::Dielectric { .. }
            | Bsdf::ThinDielectric { .. }
            | Bsdf::Conductor { .. } => Gist::Uniform(material.bsdf.albedo(1.0)),
        }
    }
}
