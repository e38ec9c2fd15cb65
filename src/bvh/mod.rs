//! Bounding volume hierarchies by the surface area heuristic: a builder over boxes, and the tree of spheres that
//! answers which spheres contain a point.

mod build;
mod gather;
mod items;
mod sphere;
mod sphere_bvh;
mod split;
#[cfg(test)]
mod test_sets;
mod tree;

pub use build::build;
pub use sphere::Sphere;
pub use sphere_bvh::SphereBvh;
pub use tree::{Node, Tree};
