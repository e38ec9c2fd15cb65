//! The tree: nodes in depth-first order, each over a contiguous range of positions.

use std::ops::Range;

use crate::math::{Aabb, Vec3};

/// A box over the positions from `first` up to the `first` of the node that follows its subtree.
///
/// The left child of node `i` is `i + 1`; the right child follows the left child's subtree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// Encloses everything at the node's positions.
    pub bounds: Aabb,
    /// The first position.
    pub first: u32,
    /// The number of nodes in the subtree, this one included; 1 for a leaf.
    pub size: u32,
}

impl Node {
    /// Whether the node has no children.
    pub fn is_leaf(&self) -> bool {
        self.size == 1
    }
}

/// A binary tree of boxes over the positions `0..len`.
#[derive(Clone, Debug, PartialEq)]
pub struct Tree {
    pub(super) nodes: Vec<Node>,
    pub(super) len: usize,
}

impl Tree {
    /// All nodes, parents before children, left before right; empty if there are no positions.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// The number of positions.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there is no position.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The box of the root; empty without a root.
    pub fn bounds(&self) -> Aabb {
        self.nodes.first().map_or(Aabb::EMPTY, |root| root.bounds)
    }

    /// The two children of the inner node `node`.
    pub fn children(&self, node: usize) -> (usize, usize) {
        let left = node + 1;
        (left, left + self.nodes[left].size as usize)
    }

    /// The positions below `node`.
    pub fn positions(&self, node: usize) -> Range<usize> {
        let next = node + self.nodes[node].size as usize;
        let end = self.nodes.get(next).map_or(self.len, |n| n.first as usize);
        self.nodes[node].first as usize..end
    }

    /// Calls `visit(positions)` for each leaf whose box contains `p`, in increasing order.
    pub(super) fn for_each_leaf_around(&self, p: Vec3, mut visit: impl FnMut(Range<usize>)) {
        let mut at = 0;
        while let Some(node) = self.nodes.get(at) {
            let inside = node.bounds.contains(p);
            if inside && node.is_leaf() {
                visit(self.positions(at));
            }
            at += if inside { 1 } else { node.size as usize };
        }
    }

    /// Whether ranges partition `0..len`, sizes add up and every box contains its children and, at the leaves,
    /// the boxes that `bounds_of` gives for its positions.
    ///
    /// # Errors
    /// Names the first node that breaks a rule, and the rule.
    pub fn check_invariants(&self, bounds_of: impl Fn(usize) -> Aabb) -> Result<(), String> {
        if self.nodes.is_empty() {
            return if self.len == 0 { Ok(()) } else { Err(format!("no node over {} positions", self.len)) };
        }
        let root = &self.nodes[0];
        if root.first != 0 || root.size as usize != self.nodes.len() {
            return Err(format!("the root starts at {} and spans {} nodes", root.first, root.size));
        }
        (0..self.nodes.len()).try_for_each(|node| {
            if self.nodes[node].is_leaf() {
                self.check_leaf(node, &bounds_of)
            } else {
                self.check_inner(node)
            }
        })
    }

    fn check_leaf(&self, node: usize, bounds_of: impl Fn(usize) -> Aabb) -> Result<(), String> {
        let positions = self.positions(node);
        if positions.is_empty() || positions.end > self.len {
            return Err(format!("leaf {node} covers the positions {positions:?} of {}", self.len));
        }
        match positions.into_iter().find(|&k| !self.nodes[node].bounds.contains_box(&bounds_of(k))) {
            Some(position) => Err(format!("the box of leaf {node} does not enclose position {position}")),
            None => Ok(()),
        }
    }

    fn check_inner(&self, node: usize) -> Result<(), String> {
        let parent = &self.nodes[node];
        let (left, right) = (node + 1, node + 1 + self.nodes.get(node + 1).map_or(0, |n| n.size as usize));
        let Some(right_node) = self.nodes.get(right).filter(|_| left < right) else {
            return Err(format!("node {node} has no right child"));
        };
        let left_node = &self.nodes[left];
        if left_node.size + right_node.size + 1 != parent.size || left_node.first != parent.first {
            return Err(format!("the children of node {node} do not make up its subtree"));
        }
        match [left, right].into_iter().find(|&k| !parent.bounds.contains_box(&self.nodes[k].bounds)) {
            Some(child) => Err(format!("the box of node {node} does not enclose its child {child}")),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::build;

    fn tree_of_three() -> (Tree, Vec<Aabb>) {
        let boxes: Vec<Aabb> = (0..3).map(|k| Aabb::of_sphere(Vec3::splat(k as f32), 0.25)).collect();
        (build(&boxes, 1).0, boxes)
    }

    fn complaint(break_it: impl FnOnce(&mut Tree)) -> String {
        let (mut tree, boxes) = tree_of_three();
        tree.check_invariants(|k| boxes[k]).unwrap();
        break_it(&mut tree);
        tree.check_invariants(|k| boxes[k]).unwrap_err()
    }

    #[test]
    fn the_check_names_what_is_broken() {
        let root_size = complaint(|t| t.nodes[0].size = 4);
        assert_eq!(root_size, "the root starts at 0 and spans 4 nodes");
        assert_eq!(complaint(|t| t.nodes.clear()), "no node over 3 positions");
        let sizes = complaint(|t| t.nodes[1].size = 5);
        assert_eq!(sizes, "node 0 has no right child");
        let child = complaint(|t| t.nodes[0].bounds.max.y = 1.0);
        assert!(child.starts_with("the box of node 0 does not enclose its child"), "{child}");
        let leaf = complaint(|t| t.nodes[4].bounds.min.z += 0.1);
        assert_eq!(leaf, "the box of leaf 4 does not enclose position 2");
        let positions = complaint(|t| t.len = 2);
        assert_eq!(positions, "leaf 4 covers the positions 2..2 of 2");
        let first = complaint(|t| t.nodes[1].first = 1);
        assert_eq!(first, "the children of node 0 do not make up its subtree");
    }

    #[test]
    fn children_and_positions_follow_the_depth_first_order() {
        let (tree, _) = tree_of_three();
        let (left, right) = tree.children(0);
        assert_eq!(tree.positions(0), 0..3);
        assert_eq!(tree.positions(left).end, tree.positions(right).start);
        assert_eq!(tree.bounds(), tree.nodes()[left].bounds.union(tree.nodes()[right].bounds));
    }
}
