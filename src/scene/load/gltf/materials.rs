//! The metals and the rest of glTF, as the nearest of the core's surfaces.

use std::collections::BTreeMap;
use std::path::Path;

use gltf::material::AlphaMode;

use super::super::super::Material;
use crate::bsdf::{Bsdf, Ggx, Interface, Plastic, RoughSurface};
use crate::math::Rgb;

/// Glass and coats that do not say otherwise.
const USUAL_IOR: f32 = 1.5;
/// Rougher coats hardly mirror: they are left out.
const ROUGHEST_COAT: f32 = 0.2;
const LEAST_ALPHA: f32 = 1e-3;

/// Those that were asked for, in that order.
#[derive(Default)]
pub(super) struct Materials {
    pub list: Vec<Material>,
    known: BTreeMap<Option<usize>, u32>,
}

impl Materials {
    /// The number of a material of the file.
    pub fn number(&mut self, material: &gltf::Material, path: &Path, warnings: &mut Vec<String>) -> u32 {
        if let Some(&known) = self.known.get(&material.index()) {
            return known;
        }
        let number = self.list.len() as u32;
        let name = match (material.index(), material.name()) {
            (None, _) => String::from("(default)"),
            (Some(index), None) => format!("material {index}"),
            (_, Some(name)) => name.to_owned(),
        };
        tell_of_the_rest(material, &format!("{}: material `{name}`", path.display()), warnings);
        let emission = material.emissive_strength().unwrap_or(1.0) * Rgb::from(material.emissive_factor());
        let emission = emission.map(|x| if x.is_nan() { 0.0 } else { x.clamp(0.0, f32::MAX) });
        let bsdf = bsdf(material);
        let (opacity, absorption) = (opacity(material), absorption(material, &bsdf));
        self.list.push(Material { opacity, absorption, ..Material::plain(name, bsdf, emission) });
        self.known.insert(material.index(), number);
        number
    }
}

fn bsdf(material: &gltf::Material) -> Bsdf {
    let pbr = material.pbr_metallic_roughness();
    let [r, g, b, _] = pbr.base_color_factor();
    let base = Rgb::new(r, g, b).map(|x| if x.is_nan() { 0.0 } else { x.clamp(0.0, 1.0) });
    let roughness = pbr.roughness_factor().clamp(0.0, 1.0);
    let ior = material.ior().filter(|ior| *ior >= 1.0 && ior.is_finite()).unwrap_or(USUAL_IOR);
    // What modellers call roughness is the root of the facets'.
    let facets = (roughness * roughness >= LEAST_ALPHA).then_some(Ggx { alpha: roughness * roughness });
    let rough = |facets, interface| Bsdf::Rough(RoughSurface { facets, interface });
    if material.transmission().is_some_and(|transmission| transmission.transmission_factor() > 0.5) {
        let is_solid = material.volume().is_some_and(|volume| volume.thickness_factor() > 0.0);
        return match facets {
            Some(facets) => rough(facets, Interface::Dielectric { ior }),
            None if is_solid => Bsdf::Dielectric { ior },
            None => Bsdf::ThinDielectric { ior },
        };
    }
    match facets {
        _ if pbr.metallic_factor() <= 0.5 && roughness > ROUGHEST_COAT => Bsdf::Diffuse { albedo: base },
        _ if pbr.metallic_factor() <= 0.5 => Bsdf::Plastic(Plastic::new(base, ior.clamp(1.001, 10.0), false)),
        Some(facets) => {
            rough(facets, Interface::Conductor { eta: Rgb::ZERO, k: Rgb::ONE, reflectance: base })
        }
        None => Bsdf::Mirror { reflectance: base },
    }
}

/// What leaves the share `attenuationColor` after `attenuationDistance`; black as the least number above 0.
fn absorption(material: &gltf::Material, bsdf: &Bsdf) -> Rgb {
    let volume = material.volume().filter(|volume| bsdf.ior().is_some() && volume.thickness_factor() > 0.0);
    let Some(volume) = volume else { return Rgb::ZERO };
    let color = Rgb::from(volume.attenuation_color());
    let absorption = color.map(|c| -c.clamp(f32::MIN_POSITIVE, 1.0).ln() / volume.attenuation_distance());
    absorption.map(|sigma| if sigma.is_finite() { sigma.max(0.0) } else { 0.0 })
}

/// By the constant alpha: all or nothing where the material is cut out.
fn opacity(material: &gltf::Material) -> f32 {
    let [_, _, _, alpha] = material.pbr_metallic_roughness().base_color_factor();
    match material.alpha_mode() {
        AlphaMode::Opaque => 1.0,
        AlphaMode::Mask => f32::from(alpha >= material.alpha_cutoff().unwrap_or(0.5)),
        AlphaMode::Blend if alpha.is_nan() => 1.0,
        AlphaMode::Blend => alpha.clamp(0.0, 1.0),
    }
}

fn tell_of_the_rest(material: &gltf::Material, label: &str, warnings: &mut Vec<String>) {
    let pbr = material.pbr_metallic_roughness();
    let textures = [
        ("baseColorTexture", pbr.base_color_texture().is_some()),
        ("metallicRoughnessTexture", pbr.metallic_roughness_texture().is_some()),
        ("normalTexture", material.normal_texture().is_some()),
        ("occlusionTexture", material.occlusion_texture().is_some()),
        ("emissiveTexture", material.emissive_texture().is_some()),
    ];
    let named: Vec<&str> = textures.iter().filter(|(_, given)| *given).map(|(name, _)| *name).collect();
    if !named.is_empty() {
        warnings.push(format!("{label}: {} are not read; the factors count", named.join(", ")));
    }
    if material.alpha_mode() != AlphaMode::Opaque && pbr.base_color_texture().is_some() {
        warnings.push(format!("{label}: alpha of baseColorTexture is not read; that of the factor counts"));
    }
    let mixed = |x: f32| x > 0.0 && x < 1.0;
    let transmission = material.transmission().map_or(0.0, |transmission| transmission.transmission_factor());
    if mixed(pbr.metallic_factor()) || mixed(transmission) {
        warnings.push(format!("{label}: part metal or part glass; wholly what it is most of"));
    }
    let tinted = |volume: &gltf::material::Volume| volume.attenuation_color() != [1.0; 3];
    if material.volume().filter(tinted).is_some_and(|volume| volume.thickness_factor() <= 0.0) {
        warnings.push(format!("{label}: attenuation without a thickness; the glass is clear"));
    }
}
