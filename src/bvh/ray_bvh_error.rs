use crate::math::Vec3;

/// Why a geometry was not taken into a [`super::RayBvh`].
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum RayBvhError {
    /// More primitives than the tree can number.
    #[error("{count} triangles and spheres are too many for one tree: at most 1073741824 are allowed")]
    TooMany {
        /// How many there would be.
        count: usize,
    },
    /// A triangle with a corner that does not exist.
    #[error("triangle {triangle} names vertex {vertex}, but there are {vertices} vertices, numbered from 0")]
    Index {
        /// The number of the triangle.
        triangle: usize,
        /// The vertex that it names.
        vertex: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// A vertex that cannot be traced.
    #[error("vertex {vertex} is at {position}: its coordinates must be finite and within ±1.8e18")]
    Vertex {
        /// The number of the vertex.
        vertex: usize,
        /// Where it is.
        position: Vec3,
    },
    /// A sphere that cannot be traced.
    #[error(
        "sphere {sphere} has its center at {center} and radius {radius}: the radius must be positive, and all of \
         the sphere within ±1.8e18"
    )]
    Sphere {
        /// The number of the sphere.
        sphere: usize,
        /// Its center.
        center: Vec3,
        /// Its radius.
        radius: f32,
    },
}
