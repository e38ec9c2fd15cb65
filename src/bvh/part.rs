use super::gatherer::Radii;
use super::sphere::Sphere;
use super::tree::Node;
use crate::math::{Aabb, Vec3};

/// A subtree with its spheres' radii and states, which nobody else touches meanwhile.
pub(super) struct Part<'a, S> {
    /// The first is the root.
    pub(super) nodes: &'a mut [Node],
    pub(super) radii: &'a mut [f32],
    pub(super) states: &'a mut [S],
}

impl<S> Part<'_, S> {
    /// The two halves below an inner node.
    pub(super) fn children(&mut self) -> (Part<'_, S>, Part<'_, S>) {
        let first = self.nodes[0].first;
        let size = self.nodes[1].size as usize;
        let (left, right) = self.nodes[1..].split_at_mut(size);
        let n_left = (right[0].first - first) as usize;
        let (left_radii, right_radii) = self.radii.split_at_mut(n_left);
        let (left_states, right_states) = self.states.split_at_mut(n_left);
        (
            Part { nodes: left, radii: left_radii, states: left_states },
            Part { nodes: right, radii: right_radii, states: right_states },
        )
    }

    /// Tightens the root's box after those of its children.
    pub(super) fn follow_children(&mut self, radii: [Radii; 2]) -> Radii {
        if radii == [Radii::Kept; 2] {
            return Radii::Kept;
        }
        let right = 1 + self.nodes[1].size as usize;
        self.nodes[0].bounds = self.nodes[1].bounds.union(self.nodes[right].bounds);
        Radii::Changed
    }

    /// Tightens the box of a leaf.
    pub(super) fn follow_spheres(&mut self, centers: [&[f32]; 3], radii: Radii) -> Radii {
        if radii == Radii::Changed {
            let first = self.nodes[0].first as usize;
            let [x, y, z] = centers.map(|column| &column[first..first + self.radii.len()]);
            let spheres = self
                .radii
                .iter()
                .zip(x)
                .zip(y)
                .zip(z)
                .map(|(((&radius, &x), &y), &z)| Sphere { center: Vec3::new(x, y, z), radius });
            self.nodes[0].bounds = spheres.map(|s| s.bounds()).fold(Aabb::EMPTY, Aabb::union);
        }
        radii
    }
}
