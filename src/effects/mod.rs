//! Which effects a scene calls for, and so what a render simulates.

mod barriers;
mod contacts;
mod decision;
pub mod declare;
mod effect;
mod faces;
mod facts;
mod path_class;
mod plan;
mod reach;
mod region;
mod rules;
mod sphere_sides;
mod surfaces;
#[cfg(test)]
mod testing;
mod unseen;

pub use decision::{Decision, DroppedLight};
pub use effect::{Effect, EffectSet};
pub use path_class::{PathClass, PathClasses, UnknownPathClass};
pub use plan::{EyePaths, Plan};
pub use unseen::Unseen;
