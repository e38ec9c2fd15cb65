//! The tree that rays walk: four children to a node, so that one test is of four boxes at once.

use std::ops::Range;

use super::prepared_ray::Slabs;
use super::primitive::{Primitive, Shape};
use super::sphere_block::SphereBlock;
use super::tree::Tree;
use super::triangle_block::TriangleBlock;
use crate::math::{Aabb, Vec4};

/// Children of a node, and triangles in a block: the lanes of a vector.
pub(super) const WIDTH: usize = 4;

/// A child of a node: its kind in two bits, and its number among its kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Child(u32);

/// What a [`Child`] is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Node(usize),
    Triangles(usize),
    Spheres(usize),
}

impl Child {
    const KIND_SHIFT: u32 = 30;
    const NUMBER: u32 = (1 << Child::KIND_SHIFT) - 1;

    fn new(kind: Kind) -> Child {
        let (kind, number) = match kind {
            Kind::Node(number) => (0, number),
            Kind::Triangles(number) => (1, number),
            Kind::Spheres(number) => (2, number),
        };
        Child(kind << Child::KIND_SHIFT | number as u32)
    }

    pub fn kind(self) -> Kind {
        let number = (self.0 & Child::NUMBER) as usize;
        match self.0 >> Child::KIND_SHIFT {
            0 => Kind::Node(number),
            1 => Kind::Triangles(number),
            _ => Kind::Spheres(number),
        }
    }

    pub fn to_bits(self) -> u32 {
        self.0
    }

    pub fn from_bits(bits: u32) -> Child {
        Child(bits)
    }
}

/// Four boxes, one a lane. A lane without a child holds the empty box.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct WideNode {
    /// By side (lower, upper) and axis.
    planes: [[Vec4; 3]; 2],
    children: [Child; WIDTH],
}

impl WideNode {
    const EMPTY: WideNode =
        WideNode { planes: [[Vec4::INFINITY; 3], [Vec4::NEG_INFINITY; 3]], children: [Child(0); WIDTH] };

    fn set(&mut self, lane: usize, bounds: &Aabb, child: Child) {
        for axis in 0..3 {
            self.planes[0][axis][lane] = bounds.min[axis];
            self.planes[1][axis][lane] = bounds.max[axis];
        }
        self.children[lane] = child;
    }

    pub fn child(&self, lane: usize) -> Child {
        self.children[lane]
    }

    /// Where the ray enters each box (along its dominant axis), and bits of the boxes that it meets before `reach`.
    #[inline(always)]
    pub fn enter(&self, slabs: &Slabs, reach: f32) -> (Vec4, u32) {
        let at = |side: usize, axis: usize, origin: &[Vec4; 3]| {
            (self.planes[side & 1][axis] - origin[axis]) * slabs.inverse[axis]
        };
        let near = |axis: usize| at(slabs.entry[axis], axis, &slabs.near_origin);
        let far = |axis: usize| at(1 - slabs.entry[axis], axis, &slabs.far_origin);
        let entry = near(0).max(near(1)).max(near(2).max(Vec4::ZERO));
        let exit = far(0).min(far(1)).min(far(2).min(Vec4::splat(reach)));
        (entry, entry.cmple(exit).bitmask())
    }
}

/// Nodes and leaves; `root` is none where there is nothing to hit.
#[derive(Clone, Debug)]
pub(super) struct WideTree {
    pub root: Option<Child>,
    pub nodes: Vec<WideNode>,
    pub triangles: Vec<TriangleBlock>,
    pub spheres: Vec<SphereBlock>,
    /// Nodes on the longest way down.
    pub levels: usize,
}

impl WideTree {
    /// Four levels become two: each node takes in those of its descendants that rays meet most often.
    ///
    /// The leaves of `tree` hold at most [`WIDTH`] positions; `primitives` are in the order of the positions.
    pub fn new(tree: &Tree, primitives: &[Primitive]) -> WideTree {
        let wide = WideTree { root: None, nodes: vec![], triangles: vec![], spheres: vec![], levels: 0 };
        let mut collapse = Collapse { tree, primitives, wide };
        collapse.wide.root = (!tree.is_empty()).then(|| collapse.child(0, 0));
        collapse.wide.shrink();
        collapse.wide
    }

    fn shrink(&mut self) {
        self.nodes.shrink_to_fit();
        self.triangles.shrink_to_fit();
        self.spheres.shrink_to_fit();
    }

    /// The memory that nodes and leaves hold, in bytes.
    pub fn memory_bytes(&self) -> usize {
        size_of::<WideNode>() * self.nodes.capacity()
            + size_of::<TriangleBlock>() * self.triangles.capacity()
            + size_of::<SphereBlock>() * self.spheres.capacity()
    }
}

struct Collapse<'a> {
    tree: &'a Tree,
    primitives: &'a [Primitive],
    wide: WideTree,
}

impl Collapse<'_> {
    fn child(&mut self, node: usize, level: usize) -> Child {
        if self.tree.nodes[node].is_leaf() {
            return self.leaf(self.tree.positions(node), level);
        }
        let number = self.reserve(level);
        for (lane, descendant) in self.descendants(node).into_iter().enumerate() {
            let child = self.child(descendant, level + 1);
            self.wide.nodes[number].set(lane, &self.tree.nodes[descendant].bounds, child);
        }
        Child::new(Kind::Node(number))
    }

    fn reserve(&mut self, level: usize) -> usize {
        self.wide.levels = self.wide.levels.max(level + 1);
        self.wide.nodes.push(WideNode::EMPTY);
        self.wide.nodes.len() - 1
    }

    /// At most [`WIDTH`] nodes below the inner node `node`, which together hold all its positions.
    fn descendants(&self, node: usize) -> Vec<usize> {
        let (left, right) = self.tree.children(node);
        let mut found = vec![left, right];
        let area = |k: &usize| self.tree.nodes[*k].bounds.surface_area();
        while found.len() < WIDTH {
            let inner = (0..found.len()).filter(|&k| !self.tree.nodes[found[k]].is_leaf());
            let Some(largest) = inner.max_by(|&a, &b| area(&found[a]).total_cmp(&area(&found[b]))) else {
                break;
            };
            let (left, right) = self.tree.children(found[largest]);
            found.splice(largest..=largest, [left, right]);
        }
        found
    }

    fn leaf(&mut self, positions: Range<usize>, level: usize) -> Child {
        let is_triangle = |p: &&Primitive| matches!(p.shape, Shape::Triangle(_));
        let (triangles, spheres): (Vec<&Primitive>, Vec<&Primitive>) =
            self.primitives[positions].iter().partition(is_triangle);
        if spheres.is_empty() {
            return self.triangles(&triangles);
        }
        if triangles.is_empty() {
            return self.spheres(&spheres);
        }
        let number = self.reserve(level);
        let children = [self.triangles(&triangles), self.spheres(&spheres)];
        for (lane, (child, group)) in children.into_iter().zip([triangles, spheres]).enumerate() {
            let bounds = group.iter().fold(Aabb::EMPTY, |bounds, p| bounds.union(p.bounds()));
            self.wide.nodes[number].set(lane, &bounds, child);
        }
        Child::new(Kind::Node(number))
    }

    fn triangles(&mut self, group: &[&Primitive]) -> Child {
        let mut block = TriangleBlock::EMPTY;
        for (lane, primitive) in group.iter().enumerate() {
            if let Shape::Triangle(corners) = primitive.shape {
                block.set(lane, corners, primitive.id);
            }
        }
        self.wide.triangles.push(block);
        Child::new(Kind::Triangles(self.wide.triangles.len() - 1))
    }

    fn spheres(&mut self, group: &[&Primitive]) -> Child {
        let mut block = SphereBlock::EMPTY;
        for (lane, primitive) in group.iter().enumerate() {
            if let Shape::Sphere(sphere) = primitive.shape {
                block.set(lane, sphere, primitive.id);
            }
        }
        self.wide.spheres.push(block);
        Child::new(Kind::Spheres(self.wide.spheres.len() - 1))
    }
}
