//! Which effects a scene calls for, and so what a render simulates.

mod path_class;

pub use path_class::{PathClass, PathClasses};
