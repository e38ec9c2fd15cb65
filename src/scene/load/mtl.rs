//! MTL files: materials for meshes to which the scene file gives none.

use std::path::Path;

use super::statements::{keyword, statements, words};
use crate::bsdf::Bsdf;
use crate::math::Rgb;

/// The albedo of surfaces whose material is missing.
const GREY: Rgb = Rgb::splat(0.5);
/// What stands in for a missing index of refraction: window glass.
const USUAL_IOR: f32 = 1.5;

/// The surface of triangles without a known material.
pub(super) fn grey() -> (Bsdf, Rgb) {
    (Bsdf::Diffuse { albedo: GREY }, Rgb::ZERO)
}

/// More unreadable lines of a file are counted instead of told.
const MOST_TOLD: usize = 10;

/// The materials of an MTL file; those of its lines that cannot be read are left out, with warnings.
pub(super) fn parse(path: &Path, text: &str, warnings: &mut Vec<String>) -> Vec<tobj::Material> {
    let mut plain = String::new();
    let mut unreadable = 0;
    for (line, statement) in statements(text) {
        match checked(&statement) {
            Ok(Some(statement)) => plain.extend([&statement, "\n"]),
            Ok(None) => {}
            Err(reason) => {
                unreadable += 1;
                if unreadable <= MOST_TOLD {
                    warnings.push(format!("{}:{line}: {reason}; ignored", path.display()));
                }
            }
        }
    }
    if unreadable > MOST_TOLD {
        warnings.push(format!("{}: {} more such lines ignored", path.display(), unreadable - MOST_TOLD));
    }
    match tobj::load_mtl_buf(&mut plain.as_bytes()) {
        Ok((materials, _)) => materials,
        Err(e) => {
            warnings
                .push(format!("{}: cannot be parsed: {e}; its materials become grey 0.5", path.display()));
            Vec::new()
        }
    }
}

/// A statement in the form that `tobj` reads without fail, if it is of use; it panics on colours of one number.
fn checked(statement: &str) -> Result<Option<String>, String> {
    let (word, rest) = keyword(statement);
    let values = words(rest);
    let plain = match word {
        "newmtl" if rest.is_empty() => String::from("(unnamed)"),
        "newmtl" => rest.to_owned(),
        "map_Kd" if !rest.is_empty() => rest.to_owned(),
        "Kd" | "Ks" | "Ke" => color(&values).ok_or_else(|| unreadable(statement, "three numbers"))?,
        "Ni" => number::<f32>(&values).ok_or_else(|| unreadable(statement, "a number"))?,
        "illum" => number::<u8>(&values).ok_or_else(|| unreadable(statement, "0 to 255"))?,
        _ => return Ok(None),
    };
    Ok(Some(format!("{word} {plain}")))
}

fn unreadable(statement: &str, allowed: &str) -> String {
    const LONGEST: usize = 60;
    let shown: String = statement.trim().chars().take(LONGEST).collect();
    format!("`{shown}`; allowed: {allowed}")
}

/// Three numbers; a single one stands for all three.
fn color(values: &[&str]) -> Option<String> {
    let three = match values {
        [grey] => [*grey; 3],
        [r, g, b, ..] => [*r, *g, *b],
        _ => return None,
    };
    three.iter().all(|v| v.parse::<f32>().is_ok()).then(|| three.join(" "))
}

fn number<T: std::str::FromStr>(values: &[&str]) -> Option<String> {
    values.first().filter(|v| v.parse::<T>().is_ok()).map(|v| String::from(*v))
}

/// The scattering and emission of an MTL material by the table in the documentation of [`crate::scene`].
///
/// `label` names the material in warnings.
pub(super) fn surface(m: &tobj::Material, label: &str, warnings: &mut Vec<String>) -> (Bsdf, Rgb) {
    let mut clamped = |name: &str, color: Option<[f32; 3]>, most: f32| {
        let color = Rgb::from(color?);
        let inside = color.map(|c| if c.is_nan() { 0.0 } else { c.clamp(0.0, most) });
        if inside != color {
            warnings.push(format!("{label}: {name} is {color}; clamped to {inside}"));
        }
        Some(inside)
    };
    let kd = clamped("Kd", m.diffuse, 1.0);
    let ks = clamped("Ks", m.specular, 1.0).unwrap_or(Rgb::ZERO);
    let emission = clamped("Ke", m.emissive, f32::MAX).unwrap_or(Rgb::ZERO);
    if m.diffuse_texture.is_some() {
        warnings.push(format!("{label}: map_Kd is not read; the colour Kd counts"));
    }
    (scattering(m, kd, ks, label, warnings), emission)
}

fn scattering(m: &tobj::Material, kd: Option<Rgb>, ks: Rgb, label: &str, warnings: &mut Vec<String>) -> Bsdf {
    let is_pure_specular = kd.is_none_or(|kd| kd == Rgb::ZERO) && ks != Rgb::ZERO;
    match m.illumination_model {
        Some(4 | 6 | 7 | 9) => Bsdf::Dielectric { ior: ior(m, label, warnings) },
        Some(3) => Bsdf::Mirror { reflectance: ks },
        Some(5) if is_pure_specular => Bsdf::Mirror { reflectance: ks },
        _ => Bsdf::Diffuse {
            albedo: kd.unwrap_or_else(|| {
                warnings.push(format!("{label}: no Kd; diffuse grey 0.5"));
                GREY
            }),
        },
    }
}

fn ior(m: &tobj::Material, label: &str, warnings: &mut Vec<String>) -> f32 {
    m.optical_density.filter(|ior| *ior > 0.0 && ior.is_finite()).unwrap_or_else(|| {
        warnings.push(format!("{label}: no Ni above 0; {USUAL_IOR} instead"));
        USUAL_IOR
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The surfaces of an MTL text, and the warnings about them.
    fn surfaces(text: &str) -> (Vec<(Bsdf, Rgb)>, Vec<String>) {
        let mut warnings = Vec::new();
        let materials = parse(Path::new("m.mtl"), text, &mut warnings);
        let surfaces = materials.iter().map(|m| surface(m, &m.name, &mut warnings)).collect();
        (surfaces, warnings)
    }

    fn one(statements: &str) -> (Bsdf, Rgb, Vec<String>) {
        let (surfaces, warnings) = surfaces(&format!("newmtl a\n{statements}"));
        let [(bsdf, emission)] = surfaces[..] else { panic!("{surfaces:?}") };
        (bsdf, emission, warnings)
    }

    #[test]
    fn each_row_of_the_table_holds() {
        let half = Rgb::splat(0.5);
        let diffuse = |albedo| Bsdf::Diffuse { albedo };
        let mirror = Bsdf::Mirror { reflectance: half };
        for (text, expected) in [
            ("Kd 0.1 0.2 0.3", diffuse(Rgb::new(0.1, 0.2, 0.3))),
            ("Kd 0.25 # grey", diffuse(Rgb::splat(0.25))),
            ("Kd 0 0 0\nKs .5 .5 .5\nillum 2", diffuse(Rgb::ZERO)),
            ("Kd .1 .1 .1\nKs .5 .5 .5\nillum 3", mirror),
            ("Kd 0 0 0\nKs .5 .5 .5\nillum 5", mirror),
            ("Ks .5 .5 .5\nillum 5", mirror),
            ("Kd .5 .5 .5\nKs .5 .5 .5\nillum 5", diffuse(half)),
            ("Ni 1.25\nillum 4", Bsdf::Dielectric { ior: 1.25 }),
            ("Ni 1.25\nillum 6", Bsdf::Dielectric { ior: 1.25 }),
            ("\tillum 7\r\n\tNi 1.25\r\n", Bsdf::Dielectric { ior: 1.25 }),
            ("Ni 1.25\nillum 9", Bsdf::Dielectric { ior: 1.25 }),
        ] {
            assert_eq!(one(text), (expected, Rgb::ZERO, Vec::new()), "{text}");
        }
        assert_eq!(one("Kd 0 0 0\nKe 5 6 7").1, Rgb::new(5.0, 6.0, 7.0));
    }

    #[test]
    fn repairs_leave_a_warning() {
        let grey = Bsdf::Diffuse { albedo: GREY };
        let albedo = |r, g, b| Bsdf::Diffuse { albedo: Rgb::new(r, g, b) };
        for (text, expected, words) in [
            ("", grey, "a: no Kd"),
            ("Ka 1 1 1", grey, "a: no Kd"),
            ("illum 7", Bsdf::Dielectric { ior: 1.5 }, "a: no Ni"),
            ("illum 7\nNi 0", Bsdf::Dielectric { ior: 1.5 }, "a: no Ni"),
            ("illum 7\nNi inf", Bsdf::Dielectric { ior: 1.5 }, "a: no Ni"),
            ("Kd 1.5 -1 nan", albedo(1.0, 0.0, 0.0), "a: Kd is [1.5, -1, NaN]; clamped"),
            ("Kd .1 .1 .1\nKd 1 1", albedo(0.1, 0.1, 0.1), "m.mtl:3: `Kd 1 1`; allowed: three numbers"),
            ("Kd spectral x.rfl", grey, "m.mtl:2: `Kd spectral"),
            ("Kd 0 0 0\nillum x", albedo(0.0, 0.0, 0.0), "m.mtl:3: `illum x`; allowed: 0 to 255"),
            ("Kd 0 0 0\nillum", albedo(0.0, 0.0, 0.0), "m.mtl:3: `illum`"),
            ("Kd 0 0 0\nNi", albedo(0.0, 0.0, 0.0), "m.mtl:3: `Ni`; allowed: a number"),
            ("Kd 0 0 0\nmap_Kd wood.png", albedo(0.0, 0.0, 0.0), "a: map_Kd is not read"),
        ] {
            let (bsdf, _, warnings) = one(text);
            assert_eq!(bsdf, expected, "{text}");
            assert!(warnings[0].contains(words), "{text}: {warnings:?}");
        }
        assert_eq!(one("Kd 0 0 0\nKe -5 6 inf").1, Rgb::new(0.0, 6.0, f32::MAX));
    }

    #[test]
    fn an_unnamed_material_does_not_change_the_one_before() {
        let (surfaces, _) = surfaces("newmtl a\nKd 0 0 0\nnewmtl\nKd 1 1 1\nmap_Kd\n");
        assert_eq!(surfaces[0].0, Bsdf::Diffuse { albedo: Rgb::ZERO });
        assert_eq!(surfaces.len(), 2);
    }
}
