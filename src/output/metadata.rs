use serde::{Deserialize, Serialize};

/// What an attribute of a picture file holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Value {
    /// UTF-8 text.
    Text(String),
    /// A whole number: EXR type `int`, or text in decimal where 32 bits do not hold it.
    Integer(i64),
    /// EXR type `float`.
    Float(f32),
    /// EXR type `double`.
    Double(f64),
}

/// Named facts about a picture, such as its scene and its number of passes, kept in the order of their arrival.
///
/// ```
/// use caustica::output::{Metadata, Value};
/// let metadata = Metadata::new().with("caustica:passes", Value::Integer(1));
/// let metadata = metadata.with("caustica:passes", Value::Integer(2));
/// assert_eq!(metadata.entries(), [("caustica:passes".to_string(), Value::Integer(2))]);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Metadata {
    entries: Vec<(String, Value)>,
    world_to_camera: Option<[f32; 16]>,
}

impl Metadata {
    /// No facts.
    pub fn new() -> Metadata {
        Metadata::default()
    }

    /// These facts and one more; a name that is there already keeps its place and takes the new value.
    pub fn with(mut self, name: impl Into<String>, value: Value) -> Metadata {
        let name = name.into();
        match self.entries.iter_mut().find(|entry| entry.0 == name) {
            Some(entry) => entry.1 = value,
            None => self.entries.push((name, value)),
        }
        self
    }

    /// These facts and where the camera stands: a row-major matrix that takes row vectors `(x, y, z, 1)` of the world to the
    /// camera, which looks along -z with y upwards. EXR keeps it as `worldToCamera`.
    pub fn with_world_to_camera(self, matrix: [f32; 16]) -> Metadata {
        Metadata { world_to_camera: Some(matrix), ..self }
    }

    /// See [`Metadata::with_world_to_camera`].
    pub fn world_to_camera(&self) -> Option<[f32; 16]> {
        self.world_to_camera
    }

    /// The value of a name.
    pub fn value(&self, name: &str) -> Option<&Value> {
        self.entries.iter().find(|entry| entry.0 == name).map(|entry| &entry.1)
    }

    /// Names and values in order; no name comes twice.
    pub fn entries(&self) -> &[(String, Value)] {
        &self.entries
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_keep_their_order_and_come_once() {
        let metadata = Metadata::new()
            .with("z", Value::Float(1.0))
            .with("a", Value::Integer(2))
            .with("z", Value::Text("new".into()));
        let names: Vec<_> = metadata.entries().iter().map(|entry| entry.0.as_str()).collect();
        assert_eq!(names, ["z", "a"]);
        assert_eq!(metadata.entries()[0].1, Value::Text("new".into()));
    }
}
