//! The tables `[material.NAME]`.

use std::sync::Arc;

use super::super::{Material, SceneError, Textures};
use super::access::Reader;
use super::fields::{Allowed, FRACTION, Field, Fields, NON_NEGATIVE, POSITIVE};
use crate::bsdf::{Bsdf, Ggx, Interface, METALS, Metal, Plastic, RoughSurface};
use crate::math::Rgb;
use crate::texture::{Encoding, Texture};

const KINDS: [&str; 9] = [
    "diffuse",
    "mirror",
    "dielectric",
    "fixed_weight",
    "thin_dielectric",
    "conductor",
    "rough_conductor",
    "rough_dielectric",
    "plastic",
];

/// The roughness `α` of GGX: less is a smooth surface's business, since f32 hardly tells them apart.
pub(super) const ROUGHNESS: Allowed =
    Allowed { text: "a number from 0.001 to 1", holds: |x| (0.001..=1.0).contains(&x) };

/// The index of a coat.
pub(super) const COAT: Allowed =
    Allowed { text: "a number from 1 to 10", holds: |x| (1.0..=10.0).contains(&x) };

/// The materials in the order of the file.
pub(super) fn materials(
    root: &Fields,
    reader: &Reader,
    warnings: &mut Vec<String>,
) -> Result<Vec<Material>, SceneError> {
    let Some(field) = root.optional("material") else { return Ok(Vec::new()) };
    let table = field.open_table(String::from("scene"))?;
    table.all().map(|(name, field)| material(name, &field, reader, warnings)).collect()
}

fn material(
    name: &str,
    field: &Field,
    reader: &Reader,
    warnings: &mut Vec<String>,
) -> Result<Material, SceneError> {
    let known = [&KINDS[..], &["emission", "opacity", "absorption"]].concat();
    let table = field.table(format!("material `{name}`"), &known)?;
    let given: Vec<(&str, Field)> = table.all().filter(|(key, _)| KINDS.contains(key)).collect();
    let [(kind, values)] = &given[..] else { return Err(not_one_kind(&table, given.len())) };
    let emission = table.optional("emission").map(|field| field.vec3(&NON_NEGATIVE)).transpose()?;
    if emission == Some(Rgb::ZERO) {
        warnings.push(format!("{}: material `{name}`: emission is zero", table.whereabouts()));
    }
    let mut pictured = Pictured { reader, textures: Textures::NONE };
    let bsdf = bsdf(&table.place, kind, values, &mut pictured)?;
    let (opacity, absorption) = (pictured.opacity(&table)?, absorption(&table, &bsdf)?);
    let (name, emission) = (name.to_owned(), emission.unwrap_or(Rgb::ZERO));
    Ok(Material { name, bsdf, emission, opacity, absorption, textures: pictured.textures })
}

fn absorption(table: &Fields, bsdf: &Bsdf) -> Result<Rgb, SceneError> {
    let Some(field) = table.optional("absorption") else { return Ok(Rgb::ZERO) };
    let absorption = field.vec3(&NON_NEGATIVE)?;
    match bsdf.ior() {
        Some(_) => Ok(absorption),
        None => Err(field.error(NO_INSIDE.into())),
    }
}

const NO_INSIDE: &str = ": the material has no inside; allowed: of `dielectric`, `rough_dielectric`, and `fixed_weight` that is transparent";

fn not_one_kind(table: &Fields, n: usize) -> SceneError {
    table.error(format!("has {n} of `{}`; allowed: exactly one of them", KINDS.join("`, `")))
}

fn bsdf(place: &str, kind: &str, values: &Field, pictured: &mut Pictured) -> Result<Bsdf, SceneError> {
    let table = |known: &[&str]| values.table(format!("{place}, {kind}"), known);
    match kind {
        "diffuse" => Ok(Bsdf::Diffuse { albedo: pictured.color(&table(&["albedo"])?, "albedo")? }),
        "mirror" => {
            Ok(Bsdf::Mirror { reflectance: pictured.color(&table(&["reflectance"])?, "reflectance")? })
        }
        "dielectric" => Ok(Bsdf::Dielectric { ior: float(&table(&["ior"])?, "ior", &POSITIVE)? }),
        "thin_dielectric" => Ok(Bsdf::ThinDielectric { ior: float(&table(&["ior"])?, "ior", &POSITIVE)? }),
        "conductor" => {
            let (eta, k, reflectance) = metal(&table(&["metal", "eta", "k", "reflectance"])?, pictured)?;
            Ok(Bsdf::Conductor { eta, k, reflectance })
        }
        "rough_conductor" => {
            let table = table(&["roughness", "metal", "eta", "k", "reflectance"])?;
            let (eta, k, reflectance) = metal(&table, pictured)?;
            rough(&table, pictured, Interface::Conductor { eta, k, reflectance })
        }
        "rough_dielectric" => {
            let table = table(&["roughness", "ior"])?;
            rough(&table, pictured, Interface::Dielectric { ior: float(&table, "ior", &POSITIVE)? })
        }
        "plastic" => plastic(&table(&["base", "ior", "nonlinear"])?, pictured),
        _ => fixed_weight(&table(&["color", "reflectivity", "transparency", "ior"])?, pictured),
    }
}

fn rough(table: &Fields, pictured: &mut Pictured, interface: Interface) -> Result<Bsdf, SceneError> {
    let alpha = pictured.roughness(table)?;
    Ok(Bsdf::Rough(RoughSurface { facets: Ggx { alpha }, interface }))
}

fn plastic(table: &Fields, pictured: &mut Pictured) -> Result<Bsdf, SceneError> {
    let nonlinear = table.optional("nonlinear").map(|field| field.bool()).transpose()?.unwrap_or(false);
    Ok(Bsdf::Plastic(Plastic::new(pictured.color(table, "base")?, float(table, "ior", &COAT)?, nonlinear)))
}

/// `eta`, `k` and the factor of a metal: by its name, or by its index.
fn metal(table: &Fields, pictured: &mut Pictured) -> Result<(Rgb, Rgb, Rgb), SceneError> {
    let given = table.optional("reflectance").map(|_| pictured.color(table, "reflectance")).transpose()?;
    let reflectance = given.unwrap_or(Rgb::ONE);
    let Some(name) = table.optional("metal") else {
        let index =
            |name: &str| table.required(name, "three finite numbers, 0 or above")?.vec3(&NON_NEGATIVE);
        return Ok((index("eta")?, index("k")?, reflectance));
    };
    if table.optional("eta").is_some() || table.optional("k").is_some() {
        return Err(table.error("has `metal` beside `eta` or `k`; allowed: either of the two".into()));
    }
    let Metal { eta, k, .. } = METALS[name.choice(&METALS.iter().map(|metal| metal.name).collect())?];
    Ok((eta, k, reflectance))
}

fn fixed_weight(table: &Fields, pictured: &mut Pictured) -> Result<Bsdf, SceneError> {
    let share = |name| table.required(name, FRACTION.text)?.f64(&FRACTION);
    let (reflectivity, transparency) = (share("reflectivity")?, share("transparency")?);
    let sum = reflectivity + transparency;
    if sum > 1.0 + f64::EPSILON {
        return Err(table.error(format!("reflectivity + transparency is {sum}; allowed: 1 at most")));
    }
    let reflectivity = reflectivity as f32;
    Ok(Bsdf::FixedWeight {
        color: pictured.color(table, "color")?,
        reflectivity,
        // Rounding must not leave a negative share to the Lambertian part.
        transparency: (transparency as f32).min(1.0 - reflectivity),
        ior: float(table, "ior", &POSITIVE)?,
    })
}

/// Reads values that may be pictures; the constant in place of one is the largest value that it has.
struct Pictured<'a> {
    reader: &'a Reader<'a>,
    textures: Textures,
}

impl Pictured<'_> {
    fn color(&mut self, table: &Fields, name: &str) -> Result<Rgb, SceneError> {
        let field = table.required(name, "three numbers from 0 to 1")?;
        if field.string().is_err() {
            return field.vec3(&FRACTION);
        }
        let texture = self.texture(&field, Encoding::Colour)?;
        let largest = texture.max();
        if largest.max_element() > 1.0 || texture.min().min_element() < 0.0 {
            return Err(field.error(format!(" reaches {largest}; allowed: values from 0 to 1")));
        }
        self.textures.color = Some(texture);
        Ok(largest)
    }

    fn roughness(&mut self, table: &Fields) -> Result<f32, SceneError> {
        let field = table.required("roughness", ROUGHNESS.text)?;
        if field.string().is_err() {
            return field.f32(&ROUGHNESS);
        }
        let texture = self.texture(&field, Encoding::Plain)?;
        let largest = texture.max().x.clamp(Ggx::LEAST_ALPHA, 1.0);
        self.textures.roughness = Some(texture);
        Ok(largest)
    }

    fn opacity(&mut self, table: &Fields) -> Result<f32, SceneError> {
        let Some(field) = table.optional("opacity") else { return Ok(1.0) };
        if field.string().is_err() {
            return field.f32(&FRACTION);
        }
        let texture = self.texture(&field, Encoding::Opacity)?;
        let (least, largest) = (texture.min().x, texture.max().x);
        if least < 0.0 || largest > 1.0 {
            let range = format!(" reaches from {least} to {largest}; allowed: values from 0 to 1");
            return Err(field.error(range));
        }
        self.textures.opacity = Some(texture);
        Ok(largest)
    }

    fn texture(&self, field: &Field, encoding: Encoding) -> Result<Arc<Texture>, SceneError> {
        let (path, image) = self.reader.picture(field, encoding)?;
        let texture = Texture::new(path.display().to_string(), image).map(|new| new.of_file(path, encoding));
        let empty = || field.error(": holds what is no number; allowed: finite values".into());
        texture.map(Arc::new).ok_or_else(empty)
    }
}

fn float(table: &Fields, name: &str, allowed: &Allowed) -> Result<f32, SceneError> {
    table.required(name, allowed.text)?.f32(allowed)
}

#[cfg(test)]
mod tests {
    use super::super::testing::{BASE, added_fails_with, changed_fails_with, fails_with, good};
    use super::*;

    #[test]
    fn every_kind_arrives_in_the_order_of_the_file() {
        let kinds = "[material.w]\nfixed_weight = { color = [0.6, 0.6, 0.7], reflectivity = 0.3, transparency = 0.7, ior = 1.33 }\n\
            [material.m]\nmirror = { reflectance = [1, 0, 1] }\nemission = [1, 2, 3]\n[material.g]\ndielectric = { ior = 0.5 }\n";
        let materials = good(&format!("{kinds}{BASE}"), &[]).materials;
        let color = Rgb::new(0.6, 0.6, 0.7);
        let expected = [
            ("w", Bsdf::FixedWeight { color, reflectivity: 0.3, transparency: 0.7, ior: 1.33 }, Rgb::ZERO),
            ("m", Bsdf::Mirror { reflectance: Rgb::new(1.0, 0.0, 1.0) }, Rgb::new(1.0, 2.0, 3.0)),
            ("g", Bsdf::Dielectric { ior: 0.5 }, Rgb::ZERO),
            ("a", Bsdf::Diffuse { albedo: Rgb::splat(0.5) }, Rgb::ZERO),
        ];
        let read: Vec<_> = materials.iter().map(|m| (m.name.as_str(), m.bsdf, m.emission)).collect();
        assert_eq!(read, expected);
    }

    #[test]
    fn mistakes_in_a_material_are_told() {
        for (old, new, place, words) in [
            (
                "diffuse",
                "difuse",
                "s.toml:6:1: material `a`: unknown field `difuse`",
                "did you mean `diffuse`?",
            ),
            (
                "0.5, 0.5, 0.5",
                "0.5, 1.5, 0.5",
                "s.toml:6:28: material `a`, diffuse",
                "`albedo[1]` is 1.5; allowed: a number from 0 to 1",
            ),
            ("0.5, 0.5, 0.5", "0.5, -0.1, 0.5", "s.toml:6:28", "is -0.1; allowed: a number from 0 to 1"),
            (
                "albedo = [0.5, 0.5, 0.5]",
                "",
                "s.toml:6:11",
                "field `albedo` is missing; allowed: three numbers from 0 to 1",
            ),
            (
                "{ albedo = [0.5, 0.5, 0.5] }",
                "0.5",
                "s.toml:6:11",
                "field `diffuse` is 0.5; allowed: a table",
            ),
        ] {
            changed_fails_with(old, new, place, words);
        }
    }

    #[test]
    fn mistakes_in_an_added_material_are_told() {
        for (tables, line, words) in [
            (
                "[material.b]",
                10,
                "material `b`: has 0 of `diffuse`, `mirror`, `dielectric`, `fixed_weight`, `thin_dielectric`, `conductor`",
            ),
            (
                "[material.b]\ndielectric = { ior = 1.5 }\nmirror = { reflectance = [1, 1, 1] }",
                10,
                "has 2 of",
            ),
            (
                "[material.b]\ndielectric = { ior = 0 }",
                11,
                "material `b`, dielectric: field `ior` is 0; allowed: a finite number above 0",
            ),
            ("[material.b]\ndielectric = { ior = 1e-60 }", 11, "is 1e-60; allowed"),
            ("[material.b]\nmirror = { }", 11, "field `reflectance` is missing"),
            (
                "[material.b]\ndielectric = { ior = 1 }\nemission = [nan, 0, 0]",
                12,
                "field `emission[0]` is nan",
            ),
            ("[material.a]\n", 10, "duplicate key `a`"),
            (
                "[material.b]\nmirror = { reflectance = [1, 1, 1] }\nopacity = 1.5",
                12,
                "material `b`: field `opacity` is 1.5; allowed: a number from 0 to 1",
            ),
            (
                "[material.b]\nmirror = { reflectance = [1, 1, 1] }\nopacity = \"no.png\"",
                12,
                "field `opacity`: no.png: cannot be read",
            ),
            (
                "[material.b]\nthin_dielectric = { ior = 1.5 }\nabsorption = [1, 1, 1]",
                12,
                "material `b`: field `absorption`: the material has no inside; allowed: of `dielectric`",
            ),
            (
                "[material.b]\ndielectric = { ior = 1.5 }\nabsorption = [1, -1, 1]",
                12,
                "field `absorption[1]` is -1; allowed: a finite number, 0 or above",
            ),
        ] {
            added_fails_with(tables, line, words);
        }
    }

    #[test]
    fn opacity_and_absorption_stand_beside_the_kind() {
        let text = "[material.b]\ndielectric = { ior = 1.5 }\nopacity = 0.25\nabsorption = [1, 0, 2]\n";
        let materials = good(&format!("{BASE}{text}"), &[]).materials;
        let values = |m: &Material| (m.opacity, m.absorption);
        assert_eq!(values(&materials[0]), (1.0, Rgb::ZERO));
        assert_eq!(values(&materials[1]), (0.25, Rgb::new(1.0, 0.0, 2.0)));
    }

    /// Alpha where there is any, else luminance; either without sRGB's curve.
    #[test]
    fn opacity_may_be_a_picture() {
        let folder = tempfile::tempdir().unwrap();
        let read = |color, bytes: &[u8]| {
            let file = folder.path().join("p.png");
            let mut encoder = png::Encoder::new(std::fs::File::create(&file).unwrap(), 2, 1);
            encoder.set_color(color);
            encoder.write_header().unwrap().write_image_data(bytes).unwrap();
            let picture = format!(
                "[material.b]\nmirror = {{ reflectance = [1, 1, 1] }}\nopacity = \"{}\"\n",
                file.display()
            );
            let material = good(&format!("{BASE}{picture}"), &[]).materials[1].clone();
            let texture = material.textures.opacity.unwrap();
            (texture.image().pixels().to_vec(), material.opacity)
        };
        let (pixels, largest) = read(png::ColorType::Rgba, &[255, 255, 255, 0, 0, 0, 0, 51]);
        assert_eq!((pixels, largest), (vec![Rgb::ZERO, Rgb::splat(0.2)], 0.2));
        let (pixels, largest) = read(png::ColorType::Grayscale, &[51, 102]);
        assert_eq!((pixels, largest), (vec![Rgb::splat(0.2), Rgb::splat(0.4)], 0.4));
        assert!((read(png::ColorType::Rgb, &[0, 0, 0, 255, 0, 0]).1 - 0.2126).abs() < 1e-6);
    }

    #[test]
    fn shares_above_one_are_refused() {
        let weights = |r: &str, t: &str| {
            format!(
                "{BASE}[material.b]\nfixed_weight = {{ color = [1, 1, 1], reflectivity = {r}, transparency = {t}, ior = 1 }}\n"
            )
        };
        fails_with(
            &weights("0.2", "1.7"),
            "s.toml:11:",
            "field `transparency` is 1.7; allowed: a number from 0 to 1",
        );
        fails_with(
            &weights("0.6", "0.5"),
            "s.toml:11:16",
            "reflectivity + transparency is 1.1; allowed: 1 at most",
        );
        for tenths in 0..=10 {
            let scene = good(
                &weights(
                    &format!("0.{tenths}").replace("0.10", "1"),
                    &format!("{}", 1.0 - 0.1 * f64::from(tenths)),
                ),
                &[],
            );
            let Bsdf::FixedWeight { reflectivity, transparency, .. } = scene.materials[1].bsdf else {
                panic!()
            };
            assert!(1.0 - reflectivity - transparency >= 0.0);
        }
    }
}
