//! Tables and values of a scene file, read field by field, with errors that say what is allowed.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::super::SceneError;
use super::source::Source;
use crate::math::{DVec3, Vec3};

/// A range of numbers and the words for it.
pub(super) struct Allowed {
    pub text: &'static str,
    pub holds: fn(f64) -> bool,
}

/// The largest coordinate that Embree traces; it drops what lies beyond without a word.
pub(super) const MAX_COORDINATE: f64 = 1.8e18_f32 as f64;

pub(super) const COORDINATE: Allowed =
    Allowed { text: "a number from -1.8e18 to 1.8e18", holds: |x| x.abs() <= MAX_COORDINATE };
pub(super) const FRACTION: Allowed =
    Allowed { text: "a number from 0 to 1", holds: |x| (0.0..=1.0).contains(&x) };
pub(super) const POSITIVE: Allowed =
    Allowed { text: "a finite number above 0", holds: |x| x > 0.0 && x.is_finite() };
pub(super) const NON_NEGATIVE: Allowed =
    Allowed { text: "a finite number, 0 or above", holds: |x| x >= 0.0 && x.is_finite() };
pub(super) const FIELD_OF_VIEW: Allowed =
    Allowed { text: "degrees above 0 and below 180", holds: |x| x > 0.0 && x < 180.0 };
/// From the axis of a spot light.
pub(super) const CONE_ANGLE: Allowed =
    Allowed { text: "degrees above 0 and up to 180", holds: |x| x > 0.0 && x <= 180.0 };
pub(super) const FINITE: Allowed = Allowed { text: "a finite number", holds: f64::is_finite };

/// A table of a scene file whose every key is known.
pub(super) struct Fields<'a> {
    source: &'a Source<'a>,
    table: &'a DeTable<'a>,
    span: Range<usize>,
    /// What the table describes, for messages.
    pub place: String,
}

/// A value of a scene file and the words for where it stands.
pub(super) struct Field<'a> {
    source: &'a Source<'a>,
    place: String,
    name: String,
    value: &'a Spanned<DeValue<'a>>,
}

impl<'a> Fields<'a> {
    /// The whole file, which may hold the tables `known`.
    pub fn root(
        source: &'a Source<'a>,
        table: &'a Spanned<DeTable<'a>>,
        known: &[&str],
    ) -> Result<Fields<'a>, SceneError> {
        let place = String::from("scene");
        Fields { source, table: table.get_ref(), span: table.span(), place }.only(known)
    }

    fn only(self, known: &[&str]) -> Result<Self, SceneError> {
        for (key, _) in self.in_file_order() {
            if !known.contains(&key.get_ref().as_ref()) {
                let reason = format!("{}: unknown field {}", self.place, unknown_name(key.get_ref(), known));
                return Err(self.source.error(&key.span(), reason));
            }
        }
        Ok(self)
    }

    fn in_file_order(&self) -> Vec<(&'a Spanned<Cow<'a, str>>, &'a Spanned<DeValue<'a>>)> {
        let mut entries: Vec<_> = self.table.iter().collect();
        entries.sort_by_key(|(key, _)| key.span().start);
        entries
    }

    fn field(&self, name: String, value: &'a Spanned<DeValue<'a>>) -> Field<'a> {
        Field { source: self.source, place: self.place.clone(), name, value }
    }

    /// All fields by name, as they follow in the file.
    pub fn all(&self) -> impl Iterator<Item = (&'a str, Field<'a>)> {
        self.in_file_order()
            .into_iter()
            .map(|(key, value)| (key.get_ref().as_ref(), self.field(key.get_ref().to_string(), value)))
    }

    pub fn optional(&self, name: &str) -> Option<Field<'a>> {
        self.table.get(name).map(|value| self.field(name.to_owned(), value))
    }

    /// The field `name`, or an error that says what may stand there.
    pub fn required(&self, name: &str, allowed: &str) -> Result<Field<'a>, SceneError> {
        self.optional(name)
            .ok_or_else(|| self.error(format!("field `{name}` is missing; allowed: {allowed}")))
    }

    /// The elements of an array of tables; none where it is absent.
    pub fn tables(&self, name: &str) -> Result<Vec<Field<'a>>, SceneError> {
        let Some(field) = self.optional(name) else { return Ok(Vec::new()) };
        let allowed = format!("tables that are headed [[{name}]]");
        let DeValue::Array(array) = field.value.get_ref() else { return Err(field.wrong(&allowed)) };
        Ok(array.iter().map(|value| self.field(name.to_owned(), value)).collect())
    }

    /// An error about the table as a whole.
    pub fn error(&self, reason: String) -> SceneError {
        self.source.error(&self.span, format!("{}: {reason}", self.place))
    }

    /// The scene file's path and the line of the table's header, for warnings.
    pub fn whereabouts(&self) -> String {
        format!("{}:{}", self.source.path.display(), self.source.line(&self.span))
    }
}

impl<'a> Field<'a> {
    /// The line in which the value begins; of a table, that of its header.
    pub fn line(&self) -> u32 {
        u32::try_from(self.source.line(&self.value.span())).unwrap_or(u32::MAX)
    }

    /// An error about this value.
    pub fn error(&self, reason: String) -> SceneError {
        self.source.error(&self.value.span(), format!("{}: field `{}`{reason}", self.place, self.name))
    }

    /// The error that this value is something else than what is `allowed`.
    pub fn wrong(&self, allowed: &str) -> SceneError {
        self.error(format!(" is {}; allowed: {allowed}", self.shown()))
    }

    /// The value as it is written, cut short.
    fn shown(&self) -> String {
        let written = self.source.text.get(self.value.span()).unwrap_or_default();
        let line = written.lines().next().unwrap_or_default();
        let short: String = line.chars().take(LONGEST_SHOWN).collect();
        if short.len() < written.len() { format!("{short}...") } else { short }
    }

    fn number(&self) -> Option<f64> {
        match self.value.get_ref() {
            DeValue::Float(float) => float.as_str().parse().ok(),
            DeValue::Integer(integer) => {
                i64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|i| i as f64)
            }
            _ => None,
        }
    }

    /// A number that is `allowed`.
    pub fn f64(&self, allowed: &Allowed) -> Result<f64, SceneError> {
        self.number().filter(|&x| (allowed.holds)(x)).ok_or_else(|| self.wrong(allowed.text))
    }

    /// A number that is `allowed` after rounding to single precision.
    pub fn f32(&self, allowed: &Allowed) -> Result<f32, SceneError> {
        let rounded = self.number().map(|x| x as f32);
        rounded.filter(|&x| (allowed.holds)(f64::from(x))).ok_or_else(|| self.wrong(allowed.text))
    }

    /// A whole number from `low` to `high`.
    pub fn integer(&self, (low, high): (u64, u64)) -> Result<u64, SceneError> {
        let written = self.value.get_ref().as_integer();
        written
            .and_then(|integer| u64::from_str_radix(integer.as_str(), integer.radix()).ok())
            .filter(|n| (low..=high).contains(n))
            .ok_or_else(|| self.wrong(&format!("a whole number from {low} to {high}")))
    }

    pub fn string(&self) -> Result<&'a str, SceneError> {
        self.value.get_ref().as_str().ok_or_else(|| self.wrong("a text in quotes"))
    }

    /// True or false.
    pub fn bool(&self) -> Result<bool, SceneError> {
        self.value.get_ref().as_bool().ok_or_else(|| self.wrong("true or false"))
    }

    /// The `N` elements of an array; `what` names them.
    pub fn elements<const N: usize>(&self, what: &str) -> Result<[Field<'a>; N], SceneError> {
        let allowed = || self.wrong(&format!("an array of {N} {what}"));
        let array = self.value.get_ref().as_array().filter(|array| array.len() == N).ok_or_else(allowed)?;
        let element = |(i, value): (usize, _)| Field {
            source: self.source,
            place: self.place.clone(),
            name: format!("{}[{i}]", self.name),
            value,
        };
        let elements: Vec<Field> = array.iter().enumerate().map(element).collect();
        elements.try_into().map_err(|_| allowed())
    }

    /// Three numbers that are each `allowed` after rounding to single precision.
    pub fn vec3(&self, allowed: &Allowed) -> Result<Vec3, SceneError> {
        let [x, y, z] = self.elements("numbers")?;
        Ok(Vec3::new(x.f32(allowed)?, y.f32(allowed)?, z.f32(allowed)?))
    }

    /// Three numbers that are each `allowed`.
    pub fn dvec3(&self, allowed: &Allowed) -> Result<DVec3, SceneError> {
        let [x, y, z] = self.elements("numbers")?;
        Ok(DVec3::new(x.f64(allowed)?, y.f64(allowed)?, z.f64(allowed)?))
    }

    pub fn is_array(&self) -> bool {
        self.value.get_ref().is_array()
    }

    /// A table that holds only `known` keys and describes `place`.
    pub fn table(&self, place: String, known: &[&str]) -> Result<Fields<'a>, SceneError> {
        self.open_table(place)?.only(known)
    }

    /// A table whose keys are names of the user's choice.
    pub fn open_table(&self, place: String) -> Result<Fields<'a>, SceneError> {
        let table = self.value.get_ref().as_table().ok_or_else(|| self.wrong("a table"))?;
        Ok(Fields { source: self.source, table, span: self.value.span(), place })
    }

    /// The position of this name among `known` ones.
    pub fn choice(&self, known: &Names) -> Result<usize, SceneError> {
        let name = self.string()?;
        let unknown = || self.error(format!(": unknown name {}", unknown_name(name, &known.in_order)));
        known.positions.get(name).copied().ok_or_else(unknown)
    }
}

/// Names that may be chosen from, each once.
pub(super) struct Names<'a> {
    in_order: Vec<&'a str>,
    positions: BTreeMap<&'a str, usize>,
}

impl<'a> FromIterator<&'a str> for Names<'a> {
    fn from_iter<I: IntoIterator<Item = &'a str>>(names: I) -> Names<'a> {
        let in_order: Vec<&str> = names.into_iter().collect();
        Names { positions: in_order.iter().copied().zip(0..).collect(), in_order }
    }
}

/// More of a value or a name is not shown.
const LONGEST_SHOWN: usize = 40;

/// Longer names than this are not compared: that takes the product of their lengths.
const LONGEST_COMPARED: usize = 64;

/// More names than these are not listed.
const MOST_LISTED: usize = 20;

/// "`nmae`; did you mean `name`? allowed: `name`, `other`".
pub(super) fn unknown_name(name: &str, known: &[&str]) -> String {
    let comparable = known.iter().filter(|k| k.len().max(name.len()) <= LONGEST_COMPARED);
    let closest = comparable.map(|k| (edit_distance(name, k), k)).min_by_key(|(distance, _)| *distance);
    let close_enough = closest.filter(|(distance, k)| *distance <= k.len().div_ceil(2));
    let hint = close_enough.map_or(String::new(), |(_, k)| format!(" did you mean `{k}`?"));
    let quoted: Vec<String> = known.iter().take(MOST_LISTED).map(|k| format!("`{}`", shortened(k))).collect();
    let list = match known.len() {
        0 => String::from("none, as there are none"),
        n if n > MOST_LISTED => format!("{} and {} more", quoted.join(", "), n - MOST_LISTED),
        _ => quoted.join(", "),
    };
    format!("`{}`;{hint} allowed: {list}", shortened(name))
}

/// A word of a file as far as it fits into a message.
pub(super) fn shortened(word: &str) -> Cow<'_, str> {
    match word.char_indices().nth(LONGEST_SHOWN) {
        Some((end, _)) => Cow::Owned(format!("{}...", &word[..end])),
        None => Cow::Borrowed(word),
    }
}

/// The number of characters to insert, delete or replace (Levenshtein's distance).
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = std::mem::replace(&mut row[0], i + 1);
        for (j, y) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(x != *y);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edit_distance_counts_changes() {
        for (a, b, distance) in [("", "", 0), ("abc", "", 3), ("kitten", "sitting", 3), ("wihte", "white", 2)]
        {
            assert_eq!(edit_distance(a, b), distance, "{a} {b}");
            assert_eq!(edit_distance(b, a), distance, "{b} {a}");
        }
    }

    #[test]
    fn only_a_close_name_is_suggested() {
        assert_eq!(
            unknown_name("wihte", &["red", "white"]),
            "`wihte`; did you mean `white`? allowed: `red`, `white`"
        );
        assert_eq!(unknown_name("xyz", &["red", "white"]), "`xyz`; allowed: `red`, `white`");
        assert_eq!(unknown_name("xyz", &[]), "`xyz`; allowed: none, as there are none");
    }

    #[test]
    fn long_values_are_shown_cut() {
        let text = format!("a = \"{}\"\nb = [\n1]", "x".repeat(90));
        let source = Source::new(std::path::Path::new("s"), &text);
        let table = DeTable::parse(&text).unwrap();
        let root = Fields::root(&source, &table, &["a", "b"]).unwrap();
        assert_eq!(root.optional("a").unwrap().shown(), format!("\"{}...", "x".repeat(39)));
        assert_eq!(root.optional("b").unwrap().shown(), "[...");
    }
}
