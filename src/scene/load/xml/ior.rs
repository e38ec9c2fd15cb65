//! Indices of refraction by name.

use super::super::super::SceneError;
use super::super::fields::{POSITIVE, unknown_name};
use super::object::Object;

/// At the wavelength of sodium's light, 589 nm, near room temperature.
///
/// # Source
/// The table of Mitsuba 3's documentation of `dielectric`.
const NAMED: [(&str, f64); 23] = [
    ("vacuum", 1.0),
    ("helium", 1.000036),
    ("hydrogen", 1.000132),
    ("air", 1.000277),
    ("carbon dioxide", 1.00045),
    ("water", 1.333),
    ("acetone", 1.36),
    ("ethanol", 1.361),
    ("carbon tetrachloride", 1.461),
    ("glycerol", 1.4729),
    ("benzene", 1.501),
    ("silicone oil", 1.52045),
    ("bromine", 1.661),
    ("water ice", 1.31),
    ("fused quartz", 1.458),
    ("pyrex", 1.47),
    ("acrylic glass", 1.49),
    ("polypropylene", 1.49),
    ("bk7", 1.5046),
    ("sodium chloride", 1.544),
    ("amber", 1.55),
    ("pet", 1.575),
    ("diamond", 2.419),
];

/// The index inside over that outside, by `int_ior` and `ext_ior`: numbers or names.
pub(super) fn ratio(object: &Object, inside: &str) -> Result<f32, SceneError> {
    Ok((index(object, "int_ior", inside)? / index(object, "ext_ior", "air")?) as f32)
}

fn index(object: &Object, name: &str, default: &str) -> Result<f64, SceneError> {
    let is_word =
        object.element.children.iter().any(|c| c.attribute("name") == Some(name) && c.tag == "string");
    let word = if is_word { object.string(name)?.unwrap_or(default) } else { default };
    match object.element.children.iter().any(|c| c.attribute("name") == Some(name)) && !is_word {
        true => object.f64(name, 1.0, &POSITIVE),
        false => named(object, name, word),
    }
}

fn named(object: &Object, name: &str, word: &str) -> Result<f64, SceneError> {
    let lower = word.to_lowercase();
    let known = NAMED.iter().find(|(material, _)| *material == lower);
    known.map(|(_, index)| *index).ok_or_else(|| {
        let names: Vec<&str> = NAMED.iter().map(|(material, _)| *material).collect();
        object.error(format!("`{name}`: unknown name {}", unknown_name(word, &names)))
    })
}
