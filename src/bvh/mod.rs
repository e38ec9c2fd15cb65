//! Bounding volume hierarchies by the surface area heuristic: a builder over boxes; the tree of spheres that answers
//! which spheres contain a point; and the tree of triangles and spheres that answers what a ray hits.

mod build;
mod gather;
mod gatherer;
mod items;
mod list_pool;
mod part;
mod point_lists;
mod prepared_ray;
mod primitive;
mod ray_bvh;
mod ray_bvh_builder;
mod ray_bvh_error;
mod ray_hit;
mod sphere;
mod sphere_block;
mod sphere_bvh;
mod split;
#[cfg(test)]
mod test_sets;
mod tree;
mod triangle_block;
mod walk;
mod wide;

pub use build::build;
pub use gatherer::{Balls, EachMeeting, Gatherer, Leaf, Radii};
pub use point_lists::Points;
pub use ray_bvh::RayBvh;
pub use ray_bvh_builder::RayBvhBuilder;
pub use ray_bvh_error::RayBvhError;
pub use ray_hit::RayHit;
pub use sphere::Sphere;
pub use sphere_bvh::SphereBvh;
pub use split::Weight;
pub use tree::{Node, Tree};
