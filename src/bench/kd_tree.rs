//! The rival that libraries offer: a k-d tree over the centers of the spheres, that of the crate kiddo.

use kiddo::{ImmutableKdTree, SquaredEuclidean};

use super::BenchError;
use crate::bvh::Sphere;
use crate::math::Vec3;

/// A k-d tree that is asked for all centers within the largest radius; the spheres themselves decide which contain the point.
///
/// kiddo knows points, not spheres. Where all radii are equal that costs nothing. Where they differ every point finds the
/// centers that the largest sphere would reach, and nothing prunes by smaller ones. Radii may shrink without a new
/// tree, centers may not move.
#[derive(Debug)]
pub struct KdTree {
    tree: ImmutableKdTree<f32, 3>,
    spheres: Vec<Sphere>,
    /// A little more than the square of the largest radius, since kiddo may round otherwise than the spheres do.
    squared_reach: f32,
}

/// More than what some twenty roundings on the way to a leaf can come to.
const ROUNDING: f32 = 1e-5;

impl KdTree {
    /// Builds the tree; on all threads of the pool from 262,144 spheres on.
    ///
    /// # Errors
    /// If there are more than 2³² spheres.
    pub fn build(spheres: &[Sphere]) -> Result<KdTree, BenchError> {
        let centers: Vec<[f32; 3]> = spheres.iter().map(|sphere| sphere.center.to_array()).collect();
        let refused =
            |error: kiddo::kd_tree::ConstructionError| BenchError::Kiddo { reason: error.to_string() };
        let tree = ImmutableKdTree::new_from_slice(&centers).map_err(refused)?;
        let largest = spheres.iter().fold(0f32, |largest, sphere| largest.max(sphere.radius));
        let squared_reach = largest * largest * (1.0 + ROUNDING) + f32::MIN_POSITIVE;
        Ok(KdTree { tree, spheres: spheres.to_vec(), squared_reach })
    }

    /// Calls `visit(index)` once for every sphere that contains `p`, in no particular order.
    pub fn for_each_containing(&self, p: Vec3, mut visit: impl FnMut(usize)) {
        let point = p.to_array();
        let near = self.tree.query(&point).within::<SquaredEuclidean<f32>>(self.squared_reach);
        near.unsorted().visit(|found| {
            let index = found.item as usize;
            if self.spheres[index].contains(p) {
                visit(index);
            }
        });
    }

    /// The memory that tree and spheres hold, in bytes. kiddo does not tell: counted are a center and a number for every
    /// point, place and length of every leaf, and a plane for every node above them.
    pub fn memory_bytes(&self) -> usize {
        let points = self.tree.size() * (size_of::<[f32; 3]>() + size_of::<u32>());
        let leaves = self.tree.leaf_count() * size_of::<(usize, usize)>();
        let planes = self.tree.leaf_count().next_power_of_two() * size_of::<f32>();
        points + leaves + planes + size_of_val(&*self.spheres)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn found(tree: &KdTree, p: Vec3) -> Vec<usize> {
        let mut found = Vec::new();
        tree.for_each_containing(p, |index| found.push(index));
        found.sort_unstable();
        found
    }

    fn naive(spheres: &[Sphere], p: Vec3) -> Vec<usize> {
        (0..spheres.len()).filter(|&k| spheres[k].contains(p)).collect()
    }

    /// Half of them in one plane, as hit points on a wall are.
    fn point() -> impl Strategy<Value = Vec3> {
        let height = prop_oneof![Just(0f32), -2f32..2.0];
        (-2f32..2.0, height, -2f32..2.0).prop_map(Vec3::from)
    }

    fn check(spheres: &[Sphere], mut points: Vec<Vec3>) -> Result<(), TestCaseError> {
        points.extend(spheres.iter().map(|s| s.center - Vec3::Y * s.radius));
        points.extend([Vec3::NAN, Vec3::splat(1e30), Vec3::splat(-1e30)]);
        let tree = KdTree::build(spheres).unwrap();
        for p in points {
            prop_assert_eq!(found(&tree, p), naive(spheres, p), "{}", p);
        }
        Ok(())
    }

    proptest! {
        #[test]
        fn points_find_what_the_naive_search_finds(
            centers in prop::collection::vec(point(), 1..300),
            radii in prop::collection::vec(prop_oneof![1e-3f32..1.0, Just(0.0), Just(-1.0), Just(f32::NAN)], 300),
            points in prop::collection::vec(point(), 1..50),
        ) {
            let sphere = |(&center, &radius)| Sphere { center, radius };
            let spheres: Vec<Sphere> = centers.iter().zip(&radii).map(sphere).collect();
            check(&spheres, points)?;
        }

        #[test]
        fn equal_radii_need_no_filter_and_get_the_same_answers(
            centers in prop::collection::vec(point(), 1..300),
            radius in prop_oneof![1e-3f32..1.0, Just(1e-30)],
            points in prop::collection::vec(point(), 1..50),
        ) {
            let spheres: Vec<Sphere> = centers.iter().map(|&center| Sphere { center, radius }).collect();
            check(&spheres, points)?;
        }
    }

    #[test]
    fn spheres_around_one_point_are_all_found() {
        let spheres = vec![Sphere { center: Vec3::ONE, radius: 0.5 }; 1000];
        let tree = KdTree::build(&spheres).unwrap();
        assert_eq!(found(&tree, Vec3::ONE).len(), 1000);
        assert!(found(&tree, Vec3::ZERO).is_empty());
        assert!(tree.memory_bytes() > 32 * 1000);
    }

    #[test]
    fn no_sphere_is_found_in_no_tree() {
        assert!(found(&KdTree::build(&[]).unwrap(), Vec3::ZERO).is_empty());
    }
}
