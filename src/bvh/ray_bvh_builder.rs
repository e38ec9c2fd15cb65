//! How the tree of triangles and spheres is made: what is taken into it, and what is refused.

use super::build::build;
use super::primitive::{Primitive, PrimitiveId, Shape, has_area};
use super::ray_bvh::RayBvh;
use super::ray_bvh_error::RayBvhError;
use super::sphere::Sphere;
use super::wide::{WIDTH, WideTree};
use crate::math::{Aabb, Vec3};

/// Beyond this, products of three differences of coordinates could overflow f32.
const MAX_COORDINATE: f32 = 1.8e18;

/// Most primitives of a tree: the builder's limit.
const MAX_PRIMITIVES: usize = 1 << 30;

/// Collects geometries until the tree is built. Their numbers count up from 0 in the order of adding.
///
/// ```
/// use caustica::{bvh::{RayBvhBuilder, Sphere}, math::{Ray, Vec3}};
/// # fn main() -> Result<(), caustica::bvh::RayBvhError> {
/// let mut builder = RayBvhBuilder::new();
/// let ball = builder.add_spheres(&[Sphere { center: Vec3::ZERO, radius: 1.0 }])?;
/// let floor = builder.add_triangles(&[Vec3::ZERO, 9.0 * Vec3::Z, 9.0 * Vec3::X], &[[0, 1, 2]])?;
/// let bvh = builder.build();
/// let down = |x| bvh.intersect(&Ray::new(Vec3::new(x, 3.0, x), Vec3::NEG_Y));
/// assert_eq!(down(0.0).map(|hit| (hit.geometry, hit.t)), Some((ball, 2.0)));
/// assert_eq!(down(2.0).map(|hit| (hit.geometry, hit.t)), Some((floor, 3.0)));
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug, Default)]
pub struct RayBvhBuilder {
    primitives: Vec<Primitive>,
    geometries: u32,
}

impl RayBvhBuilder {
    /// Nothing to hit.
    pub fn new() -> RayBvhBuilder {
        RayBvhBuilder::default()
    }

    /// Adds a triangle mesh, and returns its number; each triangle is three indices into `vertices`.
    ///
    /// A triangle without area is allowed, and never hit.
    ///
    /// # Errors
    /// If a triangle names a vertex beyond the last, or if a vertex (used or not) is not finite or has a coordinate
    /// beyond ±1.8e18, or if the tree would have more than 2³⁰ primitives.
    pub fn add_triangles(&mut self, vertices: &[Vec3], triangles: &[[u32; 3]]) -> Result<u32, RayBvhError> {
        self.check_room(triangles.len())?;
        check_vertices(vertices)?;
        check_indices(vertices.len(), triangles)?;
        let corners = triangles.iter().map(|triangle| triangle.map(|corner| vertices[corner as usize]));
        let shapes = corners.map(|corners| has_area(corners).then_some(Shape::Triangle(corners)));
        Ok(self.add(shapes))
    }

    /// Adds spheres, hit from outside and inside, and returns the number of their geometry.
    ///
    /// # Errors
    /// If a radius is not positive, or if a sphere is not finite or reaches beyond ±1.8e18, or if the tree would have
    /// more than 2³⁰ primitives.
    pub fn add_spheres(&mut self, spheres: &[Sphere]) -> Result<u32, RayBvhError> {
        self.check_room(spheres.len())?;
        check_spheres(spheres)?;
        Ok(self.add(spheres.iter().map(|&sphere| Some(Shape::Sphere(sphere)))))
    }

    /// Builds the tree, on all cores; the same geometries always give the same tree.
    pub fn build(self) -> RayBvh {
        let boxes: Vec<Aabb> = self.primitives.iter().map(Primitive::bounds).collect();
        let (tree, order) = build(&boxes, WIDTH);
        let primitives: Vec<Primitive> = order.iter().map(|&index| self.primitives[index as usize]).collect();
        let bounds = tree.bounds();
        let extent = if tree.is_empty() { 0.0 } else { bounds.min.abs().max(bounds.max.abs()).max_element() };
        RayBvh::new(WideTree::new(&tree, &primitives), extent)
    }

    fn add(&mut self, shapes: impl Iterator<Item = Option<Shape>>) -> u32 {
        let geometry = self.geometries;
        let numbered = (0..).zip(shapes).filter_map(|(primitive, shape)| {
            Some(Primitive { shape: shape?, id: PrimitiveId { geometry, primitive } })
        });
        self.primitives.extend(numbered);
        self.geometries += 1;
        geometry
    }

    fn check_room(&self, more: usize) -> Result<(), RayBvhError> {
        let count = self.primitives.len() + more;
        if count > MAX_PRIMITIVES { Err(RayBvhError::TooMany { count }) } else { Ok(()) }
    }
}

fn check_vertices(vertices: &[Vec3]) -> Result<(), RayBvhError> {
    match vertices.iter().position(|&vertex| !is_within_limits(vertex)) {
        Some(vertex) => Err(RayBvhError::Vertex { vertex, position: vertices[vertex] }),
        None => Ok(()),
    }
}

/// False for NaN and infinities too.
fn is_within_limits(point: Vec3) -> bool {
    point.abs().cmple(Vec3::splat(MAX_COORDINATE)).all()
}

fn check_indices(vertices: usize, triangles: &[[u32; 3]]) -> Result<(), RayBvhError> {
    let wrong = |corner: &&u32| **corner as usize >= vertices;
    for (triangle, corners) in triangles.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(wrong) {
            return Err(RayBvhError::Index { triangle, vertex, vertices });
        }
    }
    Ok(())
}

fn check_spheres(spheres: &[Sphere]) -> Result<(), RayBvhError> {
    let fits = |s: &Sphere| s.radius > 0.0 && is_within_limits(s.center.abs() + s.radius);
    match spheres.iter().position(|sphere| !fits(sphere)) {
        Some(sphere) => {
            let Sphere { center, radius } = spheres[sphere];
            Err(RayBvhError::Sphere { sphere, center, radius })
        }
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [Vec3; 3] = [Vec3::ZERO, Vec3::new(2.0, 0.0, 0.0), Vec3::new(0.0, 2.0, 0.0)];

    #[test]
    fn what_cannot_be_traced_is_named() {
        let error = |vertices: &[Vec3], triangles: &[[u32; 3]]| {
            RayBvhBuilder::new().add_triangles(vertices, triangles).unwrap_err().to_string()
        };
        let text = error(&CORNERS, &[[0, 1, 2], [2, 1, 3]]);
        assert_eq!(text, "triangle 1 names vertex 3, but there are 3 vertices, numbered from 0");
        let text = error(&[Vec3::ZERO, Vec3::new(0.0, f32::NAN, 0.0), Vec3::Y], &[[0, 1, 2]]);
        assert_eq!(text, "vertex 1 is at [0, NaN, 0]: its coordinates must be finite and within ±1.8e18");
        for (x, radius) in [(0.0, -2.0), (0.0, 0.0), (f32::NAN, 1.0), (0.0, f32::INFINITY), (1.8e18, 1e18)] {
            let sphere = Sphere { center: Vec3::X * x, radius };
            let text = RayBvhBuilder::new().add_spheres(&[sphere]).unwrap_err().to_string();
            assert!(text.starts_with("sphere 0 has its center at"), "{text}");
        }
        let full = RayBvhBuilder::new().check_room(MAX_PRIMITIVES + 1).unwrap_err().to_string();
        assert!(full.starts_with("1073741825 triangles and spheres are too many"), "{full}");
    }
}
