use crate::checkpoint::Facts;
use crate::output::{Metadata, Value};

/// Whose picture a shard is part of.
#[derive(Clone, Debug, PartialEq)]
pub struct Identity {
    /// Program, settings and scene, by name.
    pub facts: Facts,
    /// What the header of the picture tells; the same in all shards.
    pub header: Metadata,
}

impl Identity {
    /// What the two differ in, a sentence for each, by names for the two.
    ///
    /// Facts first: what the header tells follows from them, except for the scene's name and for what the set-up found, which another
    /// kind of processor may round otherwise.
    pub fn differences(&self, other: &Identity, [self_name, other_name]: [&str; 2]) -> Vec<String> {
        let facts = self.facts.differences_between(&other.facts, [self_name, other_name]);
        if !facts.is_empty() {
            return facts;
        }
        let entries = self.header.entries().iter().chain(other.header.entries());
        let mut names: Vec<&str> = entries.map(|(name, _)| name.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        let values = |name| [&self.header, &other.header].map(|header| header.value(name));
        let different = names.into_iter().map(|name| (name, values(name))).filter(|(_, [a, b])| a != b);
        let told = |(name, [a, b]): (&str, [Option<&Value>; 2])| {
            format!("{name}: {self_name} has {}, {other_name} {}", told(a), told(b))
        };
        let camera = self.header.world_to_camera() != other.header.world_to_camera();
        different.map(told).chain(camera.then(|| "where the camera stands".into())).collect()
    }
}

fn told(value: Option<&Value>) -> String {
    match value {
        None => "none".into(),
        Some(Value::Text(text)) => text.clone(),
        Some(Value::Integer(number)) => number.to_string(),
        Some(Value::Float(number)) => number.to_string(),
        Some(Value::Double(number)) => number.to_string(),
    }
}
