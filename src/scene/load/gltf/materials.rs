//! The metals and the rest of glTF, as the nearest of the core's surfaces.

use std::collections::BTreeMap;

use glam::DAffine2;
use gltf::material::AlphaMode;
use gltf::texture::Info;

use super::super::super::{Material, Textures};
use super::super::pictures::UPRIGHT;
use super::textures::{self, Picture, Pictures};
use crate::bsdf::{Bsdf, Ggx, Interface, Plastic, RoughSurface};
use crate::math::Rgb;
use crate::texture::{Encoding, Texture};

/// Glass and coats that do not say otherwise.
const USUAL_IOR: f32 = 1.5;
/// Rougher coats hardly mirror: they are left out.
const ROUGHEST_COAT: f32 = 0.2;
/// Pictures whose values differ by less are the same everywhere.
const EVEN: f32 = 0.01;

/// Those that were asked for, in that order.
#[derive(Default)]
pub(super) struct Materials {
    pub list: Vec<Material>,
    /// Of each of them: from texture coordinates to those by which its pictures are looked up.
    to_uv: Vec<DAffine2>,
    known: BTreeMap<Option<usize>, u32>,
}

impl Materials {
    /// The number of a material of the file.
    pub fn number(
        &mut self,
        material: &gltf::Material,
        pictures: Pictures,
        warnings: &mut Vec<String>,
    ) -> u32 {
        if let Some(&known) = self.known.get(&material.index()) {
            return known;
        }
        let number = self.list.len() as u32;
        let name = match (material.index(), material.name()) {
            (None, _) => String::from("(default)"),
            (Some(index), None) => format!("material {index}"),
            (_, Some(name)) => name.to_owned(),
        };
        let label = format!("{}: material `{name}`", pictures.path.display());
        tell_of_the_rest(material, &label, warnings);
        let mut look = Look { pictures, label, warnings, textures: Textures::NONE, to_uv: None };
        let bsdf = look.bsdf(material);
        let emission = look.emission(material);
        let (opacity, absorption) = (opacity(material), absorption(material, &bsdf));
        let (textures, to_uv) = (look.textures, look.to_uv.unwrap_or(DAffine2::IDENTITY));
        self.list.push(Material { opacity, absorption, textures, ..Material::plain(name, bsdf, emission) });
        self.to_uv.push(to_uv);
        self.known.insert(material.index(), number);
        number
    }

    /// From the texture coordinates of meshes to those that a material's pictures are looked up by; none where it has no pictures.
    pub fn to_uv(&self, number: u32) -> Option<DAffine2> {
        let number = number as usize;
        (self.list[number].textures != Textures::NONE).then(|| UPRIGHT * self.to_uv[number])
    }
}

/// What a material is put together from.
struct Look<'a> {
    pictures: Pictures<'a>,
    label: String,
    warnings: &'a mut Vec<String>,
    textures: Textures,
    /// That of the first picture.
    to_uv: Option<DAffine2>,
}

impl Look<'_> {
    fn tell(&mut self, what: &str) {
        self.warnings.push(format!("{}: {what}", self.label));
    }

    fn picture(&mut self, info: Option<&Info>, name: &str, encoding: Encoding) -> Option<Picture> {
        let (label, warnings) = (&self.label, &mut *self.warnings);
        self.pictures.read(info?, encoding, &mut |what| warnings.push(format!("{label}: {name} {what}")))
    }

    /// The picture, as part of the surface; none where another one lies there by other coordinates.
    fn on_surface(&mut self, picture: Picture, name: &str) -> Option<Texture> {
        if *self.to_uv.get_or_insert(picture.to_uv) != picture.to_uv {
            self.tell(&format!(
                "{name} is moved otherwise than another picture, which is not supported; its mean counts"
            ));
            return None;
        }
        Some(picture.texture)
    }

    fn bsdf(&mut self, material: &gltf::Material) -> Bsdf {
        let glass = material.transmission().is_some_and(|glass| glass.transmission_factor() > 0.5);
        let (roughness, is_metal) = self.grain(material, glass);
        let base = self.base(material, glass);
        let ior = material.ior().filter(|ior| *ior >= 1.0 && ior.is_finite()).unwrap_or(USUAL_IOR);
        // What modellers call roughness is the root of the facets'.
        let constant = roughness * roughness;
        let pictured = self.textures.roughness.as_ref().map(|texture| texture.max().x);
        let alpha = pictured.or((constant >= Ggx::LEAST_ALPHA).then_some(constant));
        let facets = alpha.map(|alpha| Ggx { alpha });
        let rough = |facets, interface| Bsdf::Rough(RoughSurface { facets, interface });
        let is_solid = || material.volume().is_some_and(|volume| volume.thickness_factor() > 0.0);
        let metal = Interface::Conductor { eta: Rgb::ZERO, k: Rgb::ONE, reflectance: base };
        match facets {
            Some(facets) if glass => rough(facets, Interface::Dielectric { ior }),
            None if glass && is_solid() => Bsdf::Dielectric { ior },
            None if glass => Bsdf::ThinDielectric { ior },
            Some(facets) if is_metal => rough(facets, metal),
            None if is_metal => Bsdf::Mirror { reflectance: base },
            _ if roughness > ROUGHEST_COAT => Bsdf::Diffuse { albedo: base },
            _ => Bsdf::Plastic(Plastic::new(base, ior.clamp(1.001, 10.0), false)),
        }
    }

    /// The mean roughness, and whether it is most of all metal. Notes the roughness of facets where a picture has it: green is the
    /// roughness, blue how much of it is metal.
    fn grain(&mut self, material: &gltf::Material, is_glass: bool) -> (f32, bool) {
        const NAME: &str = "metallicRoughnessTexture";
        let pbr = material.pbr_metallic_roughness();
        let (factor, metallic) = (pbr.roughness_factor().clamp(0.0, 1.0), pbr.metallic_factor());
        let Some(picture) = self.picture(pbr.metallic_roughness_texture().as_ref(), NAME, Encoding::Plain)
        else {
            return (factor, !is_glass && metallic > 0.5);
        };
        let (low, high) = (picture.texture.min(), picture.texture.max());
        let mean = textures::mean(&picture.texture);
        let is_metal = !is_glass && metallic * mean.z > 0.5;
        if metallic > 0.0 && high.z - low.z > EVEN {
            self.tell("metal by a picture is not supported; wholly what it is most of");
        }
        if high.y - low.y > EVEN && !is_metal && !is_glass {
            self.tell(
                "a roughness by a picture, of what is no metal or glass, is not supported; its mean counts",
            );
        } else if high.y - low.y > EVEN
            && let Some(texture) = self.on_surface(picture, NAME)
        {
            let alpha = |pixel: Rgb| Rgb::splat((factor * pixel.y).powi(2).clamp(Ggx::LEAST_ALPHA, 1.0));
            self.textures.roughness = textures::changed(&texture, alpha);
        }
        (factor * mean.y, is_metal)
    }

    /// The largest colour of what is no glass; notes the picture that has it.
    fn base(&mut self, material: &gltf::Material, is_glass: bool) -> Rgb {
        const NAME: &str = "baseColorTexture";
        let pbr = material.pbr_metallic_roughness();
        let [r, g, b, _] = pbr.base_color_factor();
        let factor = Rgb::new(r, g, b).map(|x| if x.is_nan() { 0.0 } else { x.clamp(0.0, 1.0) });
        if is_glass && pbr.base_color_texture().is_some() {
            self.tell("the colour of glass by a picture is not supported; the glass is clear");
            return factor;
        }
        let Some(picture) = self.picture(pbr.base_color_texture().as_ref(), NAME, Encoding::Colour) else {
            return factor;
        };
        let mean = textures::mean(&picture.texture);
        let Some(texture) = self.on_surface(picture, NAME) else { return factor * mean };
        self.textures.color = textures::scaled(texture, factor);
        self.textures.color.as_ref().map_or(factor, |texture| texture.max())
    }

    /// The radiance: of a picture its mean.
    fn emission(&mut self, material: &gltf::Material) -> Rgb {
        let factor = material.emissive_strength().unwrap_or(1.0) * Rgb::from(material.emissive_factor());
        let factor = factor.map(|x| if x.is_nan() { 0.0 } else { x.clamp(0.0, f32::MAX) });
        let Some(texture) = material.emissive_texture().filter(|_| factor != Rgb::ZERO) else {
            return factor;
        };
        self.tell("emissiveTexture is not supported; its mean is emitted all over");
        let picture = self.picture(Some(&texture), "emissiveTexture", Encoding::Colour);
        picture.map_or(factor, |picture| factor * textures::mean(&picture.texture))
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
    let (glass, volume) = (material.transmission(), material.volume());
    let textures = [
        ("normalTexture", material.normal_texture().is_some()),
        ("occlusionTexture", material.occlusion_texture().is_some()),
        ("transmissionTexture", glass.as_ref().is_some_and(|glass| glass.transmission_texture().is_some())),
        ("thicknessTexture", volume.as_ref().is_some_and(|volume| volume.thickness_texture().is_some())),
    ];
    let named: Vec<&str> = textures.iter().filter(|(_, given)| *given).map(|(name, _)| *name).collect();
    if !named.is_empty() {
        warnings.push(format!(
            "{label}: not supported: {}; the picture lacks what they change",
            named.join(", ")
        ));
    }
    if material.alpha_mode() != AlphaMode::Opaque
        && material.pbr_metallic_roughness().base_color_texture().is_some()
    {
        warnings.push(format!("{label}: alpha of baseColorTexture is not read; that of the factor counts"));
    }
    let mixed = |x: f32| x > 0.0 && x < 1.0;
    let transmission = glass.map_or(0.0, |transmission| transmission.transmission_factor());
    if mixed(material.pbr_metallic_roughness().metallic_factor()) || mixed(transmission) {
        warnings.push(format!("{label}: part metal or part glass; wholly what it is most of"));
    }
    let tinted = |volume: &gltf::material::Volume| volume.attenuation_color() != [1.0; 3];
    if material.volume().filter(tinted).is_some_and(|volume| volume.thickness_factor() <= 0.0) {
        warnings.push(format!("{label}: attenuation without a thickness; the glass is clear"));
    }
}
