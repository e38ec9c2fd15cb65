//! What was decided of an effect, and of a light.

use serde::Serialize;

/// Whether one thing is simulated, and because of what.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Decision {
    /// An effect, a kind of path, or a part of the render.
    pub what: String,
    /// Whether it is simulated.
    pub on: bool,
    /// The object that calls for it, with its file and line; or the rule by which it contributes nothing.
    pub because: String,
}

/// A light that photons and shadow rays need not start from or end at.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct DroppedLight {
    /// What it is, with its file and line.
    pub light: String,
    /// Numbers in the order of [`crate::light::Lights::iter`], increasing; none of a light without power, which is not
    /// among those.
    pub numbers: Vec<u32>,
    /// Why nothing of it could be seen.
    pub because: String,
}
