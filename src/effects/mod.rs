//! Which effects a scene calls for, and so what a render simulates.

pub mod declare;
mod effect;
mod path_class;

pub use effect::{Effect, EffectSet};
pub use path_class::{PathClass, PathClasses};
