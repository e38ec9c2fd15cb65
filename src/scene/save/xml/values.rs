//! Values as the elements and attributes that Mitsuba reads.

use crate::math::{DVec3, Rgb, Vec3};

pub(super) fn to_world(step: &str) -> String {
    format!("<transform name=\"to_world\">{step}</transform>")
}

pub(super) fn exact(v: DVec3) -> String {
    v.to_array().map(|x| format!("{x:?}")).join(", ")
}

pub(super) fn rgb(name: &str, color: Rgb) -> String {
    format!("<rgb name=\"{name}\" value=\"{}\"/>", vector(color))
}

pub(super) fn float(name: &str, x: f32) -> String {
    format!("<float name=\"{name}\" value=\"{x:?}\"/>")
}

pub(super) fn string(name: &str, value: &str) -> String {
    format!("<string name=\"{name}\" value=\"{value}\"/>")
}

pub(super) fn vector(v: Vec3) -> String {
    v.to_array().map(|x| format!("{x:?}")).join(", ")
}

/// As the value of an attribute; what XML cannot hold becomes U+FFFD.
pub(super) fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\n' => escaped.push_str("&#10;"),
            '\t' => escaped.push_str("&#9;"),
            '\r' => escaped.push_str("&#13;"),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => escaped.push('\u{fffd}'),
            c => escaped.push(c),
        }
    }
    escaped
}
