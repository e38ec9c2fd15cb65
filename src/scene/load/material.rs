//! The tables `[material.NAME]`.

use super::super::{Material, SceneError};
use super::fields::{Allowed, FRACTION, Field, Fields, NON_NEGATIVE, POSITIVE};
use crate::bsdf::Bsdf;
use crate::math::Rgb;

const KINDS: [&str; 4] = ["diffuse", "mirror", "dielectric", "fixed_weight"];

/// The materials in the order of the file.
pub(super) fn materials(root: &Fields, warnings: &mut Vec<String>) -> Result<Vec<Material>, SceneError> {
    let Some(field) = root.optional("material") else { return Ok(Vec::new()) };
    let table = field.open_table(String::from("scene"))?;
    table.all().map(|(name, field)| material(name, &field, warnings)).collect()
}

fn material(name: &str, field: &Field, warnings: &mut Vec<String>) -> Result<Material, SceneError> {
    let known = [&KINDS[..], &["emission"]].concat();
    let table = field.table(format!("material `{name}`"), &known)?;
    let given: Vec<(&str, Field)> = table.all().filter(|(key, _)| KINDS.contains(key)).collect();
    let [(kind, values)] = &given[..] else { return Err(not_one_kind(&table, given.len())) };
    let emission = table.optional("emission").map(|field| field.vec3(&NON_NEGATIVE)).transpose()?;
    if emission == Some(Rgb::ZERO) {
        warnings.push(format!("{}: material `{name}`: emission is zero", table.whereabouts()));
    }
    let bsdf = bsdf(&table.place, kind, values)?;
    Ok(Material { name: name.to_owned(), bsdf, emission: emission.unwrap_or(Rgb::ZERO) })
}

fn not_one_kind(table: &Fields, n: usize) -> SceneError {
    table.error(format!("has {n} of `{}`; allowed: exactly one of them", KINDS.join("`, `")))
}

fn bsdf(place: &str, kind: &str, values: &Field) -> Result<Bsdf, SceneError> {
    let table = |known: &[&str]| values.table(format!("{place}, {kind}"), known);
    match kind {
        "diffuse" => Ok(Bsdf::Diffuse { albedo: color(&table(&["albedo"])?, "albedo")? }),
        "mirror" => Ok(Bsdf::Mirror { reflectance: color(&table(&["reflectance"])?, "reflectance")? }),
        "dielectric" => Ok(Bsdf::Dielectric { ior: float(&table(&["ior"])?, "ior", &POSITIVE)? }),
        _ => fixed_weight(&table(&["color", "reflectivity", "transparency", "ior"])?),
    }
}

fn fixed_weight(table: &Fields) -> Result<Bsdf, SceneError> {
    let share = |name| table.required(name, FRACTION.text)?.f64(&FRACTION);
    let (reflectivity, transparency) = (share("reflectivity")?, share("transparency")?);
    let sum = reflectivity + transparency;
    if sum > 1.0 + f64::EPSILON {
        return Err(table.error(format!("reflectivity + transparency is {sum}; allowed: 1 at most")));
    }
    let reflectivity = reflectivity as f32;
    Ok(Bsdf::FixedWeight {
        color: color(table, "color")?,
        reflectivity,
        // Rounding must not leave a negative share to the Lambertian part.
        transparency: (transparency as f32).min(1.0 - reflectivity),
        ior: float(table, "ior", &POSITIVE)?,
    })
}

fn color(table: &Fields, name: &str) -> Result<Rgb, SceneError> {
    table.required(name, "three numbers from 0 to 1")?.vec3(&FRACTION)
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
                "material `b`: has 0 of `diffuse`, `mirror`, `dielectric`, `fixed_weight`; allowed: exactly one",
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
        ] {
            added_fails_with(tables, line, words);
        }
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
