//! Materials as the bsdfs of Mitsuba.

use std::collections::BTreeSet;

use super::super::super::{Material, SceneDesc, Textures};
use super::super::SaveError;
use super::super::normal_form::unique;
use super::Writer;
use super::values::{escaped, float, rgb, string};
use crate::bsdf::{Bsdf, Interface, Plastic, RoughSurface};
use crate::math::Rgb;
use crate::texture::{Encoding, Texture};

impl Writer {
    pub fn materials(&mut self, desc: &SceneDesc) -> Result<(), SaveError> {
        let mut taken = BTreeSet::new();
        let in_meshes = desc.meshes.iter().flat_map(|mesh| &mesh.materials).copied();
        let used: BTreeSet<u32> =
            in_meshes.chain(desc.spheres.iter().map(|sphere| sphere.material)).collect();
        for (material, number) in desc.materials.iter().zip(0..) {
            let id = unique(&plain_id(&material.name), &mut taken);
            self.material(material, number, &id)?;
            self.ids.push(id);
            if !used.contains(&number) {
                self.tell_lost(material);
            }
        }
        Ok(())
    }

    /// Emission and absorption stand in the shapes.
    fn tell_lost(&mut self, material: &Material) {
        for (what, value) in [("emission", material.emission), ("absorption", material.absorption)] {
            if value != Rgb::ZERO {
                let lost = format!("no shape has it, so its {what} is not written");
                self.warnings.push(format!("material `{}`: {lost}", material.name));
            }
        }
    }

    fn material(&mut self, material: &Material, number: u32, id: &str) -> Result<(), SaveError> {
        let (kind, properties) = self.bsdf(material, number)?;
        let note = if id == material.name {
            String::new()
        } else {
            format!("<?caustica name=\"{}\"?>", escaped(&material.name))
        };
        let id = escaped(id);
        let inner = format!("<bsdf type=\"{kind}\">{properties}</bsdf>");
        if material.is_mask() {
            let both_sides = format!("<bsdf type=\"twosided\">{inner}</bsdf>");
            let inner = if material.bsdf.transmits() { inner } else { both_sides };
            let opacity = self.opacity(material, number)?;
            self.line(format_args!("<bsdf type=\"mask\" id=\"{id}\">{note}{opacity}"));
            self.line(format_args!("    {inner}"));
            self.line("</bsdf>");
        } else if material.bsdf.transmits() {
            self.line(format_args!("<bsdf type=\"{kind}\" id=\"{id}\">{note}{properties}</bsdf>"));
        } else {
            self.line(format_args!("<bsdf type=\"twosided\" id=\"{id}\">{note}"));
            self.line(format_args!("    {inner}"));
            self.line("</bsdf>");
        }
        Ok(())
    }

    /// Its type and its properties.
    fn bsdf(&mut self, material: &Material, number: u32) -> Result<(&'static str, String), SaveError> {
        let turned = self.round.contains(&number);
        let mut color = |name: &str, constant: Rgb| self.color(name, constant, &material.textures, turned);
        Ok(match material.bsdf {
            Bsdf::Diffuse { albedo } => ("diffuse", color("reflectance", albedo)?),
            Bsdf::Mirror { reflectance } => {
                ("conductor", string("material", "none") + &color("specular_reflectance", reflectance)?)
            }
            Bsdf::Dielectric { ior } => ("dielectric", indices(ior)),
            Bsdf::ThinDielectric { ior } => ("thindielectric", indices(ior)),
            Bsdf::Conductor { eta, k, reflectance } => {
                ("conductor", metal(eta, k) + &color("specular_reflectance", reflectance)?)
            }
            Bsdf::Rough(RoughSurface { facets, interface }) => {
                let facets =
                    string("distribution", "ggx") + &self.roughness(material, facets.alpha, turned)?;
                match interface {
                    Interface::Conductor { eta, k, reflectance } => {
                        let name = "specular_reflectance";
                        let reflectance = self.color(name, reflectance, &material.textures, turned)?;
                        ("roughconductor", facets + &metal(eta, k) + &reflectance)
                    }
                    Interface::Dielectric { ior } => ("roughdielectric", facets + &indices(ior)),
                }
            }
            Bsdf::Plastic(Plastic { base, ior, nonlinear, .. }) => {
                let nonlinear = format!("<boolean name=\"nonlinear\" value=\"{nonlinear}\"/>");
                ("plastic", color("diffuse_reflectance", base)? + &indices(ior) + &nonlinear)
            }
            Bsdf::FixedWeight { .. } => ("diffuse", rgb("reflectance", self.diffuse_share(material)?)),
        })
    }

    fn color(
        &mut self,
        name: &str,
        constant: Rgb,
        textures: &Textures,
        turned: bool,
    ) -> Result<String, SaveError> {
        textures
            .color
            .as_ref()
            .map_or_else(|| Ok(rgb(name, constant)), |texture| self.bitmap(name, texture, turned))
    }

    fn roughness(&mut self, material: &Material, alpha: f32, turned: bool) -> Result<String, SaveError> {
        let Some(texture) = &material.textures.roughness else { return Ok(float("alpha", alpha)) };
        if texture.image().pixels().iter().any(|pixel| *pixel != Rgb::splat(pixel.x)) {
            let what = format!("a roughness by a picture of colours, as in material `{}`,", material.name);
            self.lacks(
                what,
                "grey pictures; or --lenient",
                "Mitsuba takes the luminance for the first channel",
            )?;
        }
        self.bitmap("alpha", texture, turned)
    }

    /// Its picture as plain numbers, since alpha is nothing that Mitsuba looks at.
    fn opacity(&mut self, material: &Material, number: u32) -> Result<String, SaveError> {
        let Some(texture) = &material.textures.opacity else {
            return Ok(float("opacity", material.opacity));
        };
        self.bitmap("opacity", &texture.without_file(), self.round.contains(&number))
    }

    /// A picture whose first row is at `v = 1`; for Mitsuba it is at 0.
    fn bitmap(&mut self, name: &str, texture: &Texture, turned: bool) -> Result<String, SaveError> {
        let encoding = texture.file.as_ref().map_or(Encoding::Plain, |file| file.encoding);
        let file = string("filename", &escaped(&self.pictures.texture(texture, encoding)?));
        let raw = format!("<boolean name=\"raw\" value=\"{}\"/>", encoding == Encoding::Plain);
        let x = if turned { -1 } else { 1 };
        let to_uv =
            format!("<transform name=\"to_uv\"><scale x=\"{x}\" y=\"-1\"/><translate y=\"1\"/></transform>");
        Ok(format!("<texture name=\"{name}\" type=\"bitmap\">{file}{raw}{to_uv}</texture>"))
    }

    /// Refuses what is not written, or says what stands in its place.
    fn lacks(&mut self, what: String, allowed: &str, instead: &str) -> Result<(), SaveError> {
        if !self.lenient {
            return Err(SaveError::NoCounterpart { what, allowed: allowed.to_owned() });
        }
        self.warnings.push(format!("{what}: not written; {instead}"));
        Ok(())
    }

    /// What Mitsuba can show of fixed weights.
    fn diffuse_share(&mut self, material: &Material) -> Result<Rgb, SaveError> {
        let what = format!("material `{}` of fixed weights", material.name);
        let allowed =
            "diffuse, mirror, dielectric and the like; or --lenient, which keeps its diffuse share alone";
        self.lacks(what, allowed, "the file has its diffuse share alone, without mirror and glass")?;
        Ok(material.bsdf.albedo(1.0))
    }
}

fn indices(ior: f32) -> String {
    float("int_ior", ior) + &float("ext_ior", 1.0)
}

fn metal(eta: Rgb, k: Rgb) -> String {
    rgb("eta", eta) + &rgb("k", k)
}

/// An id that Mitsuba accepts: letters, digits and some signs, not an underscore in front.
fn plain_id(name: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || "-_ ()".contains(c) { c } else { '_' };
    let id: String = name.chars().map(plain).collect();
    if id.is_empty() || id.starts_with('_') { format!("m{id}") } else { id }
}
