//! The statements of an MTL file, each checked on its own.

use std::collections::BTreeSet;
use std::path::Path;
use std::str::FromStr;

use super::super::statements::{keyword, statements, words};
use crate::math::Rgb;

/// A material as its statements have it; what is absent was not said.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in super::super) struct Mtl {
    pub name: String,
    pub kd: Option<Rgb>,
    pub ks: Option<Rgb>,
    pub ke: Option<Rgb>,
    pub tf: Option<Rgb>,
    pub ns: Option<f32>,
    pub ni: Option<f32>,
    /// Opacity.
    pub d: Option<f32>,
    /// Transparency.
    pub tr: Option<f32>,
    pub pr: Option<f32>,
    pub pm: Option<f32>,
    pub illum: Option<u8>,
    pub map_kd: Option<String>,
    pub map_d: Option<String>,
}

/// More unreadable lines of a file are counted instead of told.
const MOST_TOLD: usize = 10;

/// Statements without a meaning for light that obeys physics: an ambient colour, the sharpness of reflections.
const OF_NO_USE: [&str; 3] = ["Ka", "sharpness", "map_Ka"];

/// The materials of an MTL file; those of its lines that cannot be read are left out, with warnings.
pub(in super::super) fn parse(path: &Path, text: &str, warnings: &mut Vec<String>) -> Vec<Mtl> {
    let mut materials = Vec::new();
    let (mut unreadable, mut unused) = (0, BTreeSet::new());
    for (line, statement) in statements(text) {
        let (word, rest) = keyword(&statement);
        if OF_NO_USE.contains(&word) {
            unused.insert(word.to_owned());
        } else if let Err(reason) = read(word, rest, &mut materials) {
            unreadable += 1;
            if unreadable <= MOST_TOLD {
                let shown: String = statement.trim().chars().take(LONGEST_SHOWN).collect();
                warnings.push(format!("{}:{line}: `{shown}`{reason}; ignored", path.display()));
            }
        }
    }
    if unreadable > MOST_TOLD {
        warnings.push(format!("{}: {} more such lines ignored", path.display(), unreadable - MOST_TOLD));
    }
    if !unused.is_empty() {
        let listed = Vec::from_iter(unused).join(", ");
        warnings.push(format!("{}: read, but of no use here: {listed}", path.display()));
    }
    materials
}

const LONGEST_SHOWN: usize = 60;

/// Takes in a statement about the last of the materials.
fn read(word: &str, rest: &str, materials: &mut Vec<Mtl>) -> Result<(), &'static str> {
    if word == "newmtl" {
        let name = if rest.is_empty() { String::from("(unnamed)") } else { rest.to_owned() };
        materials.push(Mtl { name, ..Mtl::default() });
        return Ok(());
    }
    let values = words(rest);
    if word.is_empty() || word.starts_with('#') {
        return Ok(());
    }
    let Some(material) = materials.last_mut() else { return Err(" stands before any newmtl") };
    match word {
        "Kd" => material.kd = Some(color(&values)?),
        "Ks" => material.ks = Some(color(&values)?),
        "Ke" => material.ke = Some(color(&values)?),
        "Tf" => material.tf = Some(color(&values)?),
        "Ns" => material.ns = Some(number(&values)?),
        "Ni" => material.ni = Some(number(&values)?),
        "d" => material.d = Some(number(&values)?),
        "Tr" => material.tr = Some(number(&values)?),
        "Pr" => material.pr = Some(number(&values)?),
        "Pm" => material.pm = Some(number(&values)?),
        "illum" => material.illum = Some(parsed(&values).ok_or("; allowed: 0 to 255")?),
        "map_Kd" if !rest.is_empty() => material.map_kd = Some(rest.to_owned()),
        "map_d" if !rest.is_empty() => material.map_d = Some(rest.to_owned()),
        _ => {
            return Err(
                " is not supported; allowed: newmtl, Kd, Ks, Ke, Tf, Ns, Ni, d, Tr, Pr, Pm, illum, map_Kd, map_d",
            );
        }
    }
    Ok(())
}

/// Three numbers; a single one stands for all three.
fn color(values: &[&str]) -> Result<Rgb, &'static str> {
    let numbers = values.iter().take(3).map(|value| value.parse().ok()).collect::<Option<Vec<f32>>>();
    match numbers.as_deref() {
        Some(&[grey]) => Ok(Rgb::splat(grey)),
        Some(&[r, g, b]) => Ok(Rgb::new(r, g, b)),
        _ => Err("; allowed: three numbers"),
    }
}

fn number(values: &[&str]) -> Result<f32, &'static str> {
    parsed(values).ok_or("; allowed: a number")
}

fn parsed<T: FromStr>(values: &[&str]) -> Option<T> {
    values.first()?.parse().ok()
}
