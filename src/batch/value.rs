//! Values of job lists, whichever format they stand in.

use serde_json::Value as Json;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// What stands behind a key. Numbers stay the text that they were.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    Flag(bool),
    Text(String),
    List(Vec<Value>),
    Table(Vec<Entry>),
}

/// A key, its value, and the line it stands in.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Entry {
    pub key: String,
    pub line: usize,
    pub value: Value,
}

impl Value {
    /// `None` for a list or a table.
    pub fn as_text(&self) -> Option<String> {
        match self {
            Value::Flag(flag) => Some(flag.to_string()),
            Value::Text(text) => Some(text.clone()),
            Value::List(_) | Value::Table(_) => None,
        }
    }

    /// The items of a list, or one value for itself; `None` where one is a list or a table.
    pub fn as_texts(&self) -> Option<Vec<String>> {
        match self {
            Value::List(items) => items.iter().map(Value::as_text).collect(),
            single => single.as_text().map(|text| vec![text]),
        }
    }

    /// Of a value of TOML; `line` says where a byte of the file stands. Dates are text.
    pub fn of_toml(value: &DeValue, line: &dyn Fn(usize) -> usize) -> Value {
        match value {
            DeValue::Boolean(flag) => Value::Flag(*flag),
            DeValue::String(text) => Value::Text(text.to_string()),
            DeValue::Float(number) => Value::Text(number.as_str().to_owned()),
            DeValue::Integer(number) if number.radix() == 10 => Value::Text(number.as_str().to_owned()),
            DeValue::Integer(number) => Value::Text(
                u64::from_str_radix(number.as_str(), number.radix())
                    .map_or_else(|_| number.as_str().to_owned(), |number| number.to_string()),
            ),
            DeValue::Datetime(date) => Value::Text(date.to_string()),
            DeValue::Array(items) => {
                Value::List(items.iter().map(|item| Value::of_toml(item.get_ref(), line)).collect())
            }
            DeValue::Table(table) => Value::Table(entries_of_toml(table, line)),
        }
    }

    /// Of a value of JSON, all in one line. `null` is an empty text.
    pub fn of_json(value: &Json, line: usize) -> Value {
        match value {
            Json::Null => Value::Text(String::new()),
            Json::Bool(flag) => Value::Flag(*flag),
            Json::Number(number) => Value::Text(number.to_string()),
            Json::String(text) => Value::Text(text.clone()),
            Json::Array(items) => Value::List(items.iter().map(|item| Value::of_json(item, line)).collect()),
            Json::Object(object) => Value::Table(
                object
                    .iter()
                    .map(|(key, value)| Entry { key: key.clone(), line, value: Value::of_json(value, line) })
                    .collect(),
            ),
        }
    }
}

/// The entries of a table in the order of the file.
pub(super) fn entries_of_toml(table: &DeTable, line: &dyn Fn(usize) -> usize) -> Vec<Entry> {
    let mut entries: Vec<(&Spanned<_>, &Spanned<DeValue>)> = table.iter().collect();
    entries.sort_by_key(|(key, _)| key.span().start);
    let entry = |(key, value): (&Spanned<std::borrow::Cow<str>>, &Spanned<DeValue>)| Entry {
        key: key.get_ref().to_string(),
        line: line(key.span().start),
        value: Value::of_toml(value.get_ref(), line),
    };
    entries.into_iter().map(entry).collect()
}
