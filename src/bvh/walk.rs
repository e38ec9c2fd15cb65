//! The walk of a ray through the tree, near children first, and the two questions that it answers.

use super::prepared_ray::PreparedRay;
use super::primitive::PrimitiveId;
use super::ray_hit::RayHit;
use super::sphere_block::SphereBlock;
use super::triangle_block::{Meeting, TriangleBlock};
use super::wide::{Child, Kind, WIDTH, WideNode, WideTree};

/// What a walk looks for.
pub(super) trait Query {
    /// Boxes that begin beyond this (along the dominant axis) do not matter.
    fn reach(&self) -> f32;

    fn is_answered(&self) -> bool;

    /// The ray's line meets the primitive `id` at `t`, behind the origin or beyond the end maybe.
    fn meet(&mut self, ray: &PreparedRay, t: f32, id: PrimitiveId, hit: impl FnOnce() -> RayHit);
}

/// The hit with the least `t`, and the least id among those.
pub(super) struct Nearest {
    pub hit: Option<RayHit>,
    t: f32,
    id: PrimitiveId,
    reach: f32,
}

impl Nearest {
    pub fn new(ray: &PreparedRay) -> Nearest {
        let t = ray.ray.t_max;
        Nearest { hit: None, t, id: PrimitiveId::FIRST, reach: t * ray.dominant }
    }
}

impl Query for Nearest {
    fn reach(&self) -> f32 {
        self.reach
    }

    fn is_answered(&self) -> bool {
        false
    }

    #[inline(always)]
    fn meet(&mut self, ray: &PreparedRay, t: f32, id: PrimitiveId, hit: impl FnOnce() -> RayHit) {
        let is_nearer = t < self.t || (t == self.t && id < self.id);
        if t > 0.0 && is_nearer {
            *self = Nearest { hit: Some(hit()), t, id, reach: t * ray.dominant };
        }
    }
}

/// Whether there is a hit.
pub(super) struct Any {
    pub found: bool,
    reach: f32,
}

impl Any {
    pub fn new(ray: &PreparedRay) -> Any {
        Any { found: false, reach: ray.ray.t_max * ray.dominant }
    }
}

impl Query for Any {
    fn reach(&self) -> f32 {
        self.reach
    }

    fn is_answered(&self) -> bool {
        self.found
    }

    #[inline(always)]
    fn meet(&mut self, ray: &PreparedRay, t: f32, _: PrimitiveId, _: impl FnOnce() -> RayHit) {
        self.found |= t > 0.0 && t < ray.ray.t_max;
    }
}

/// A child and where the ray enters its box, as one number that sorts by the latter: bits of positive floats do.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Entry(u64);

impl Entry {
    fn new(near: f32, child: Child) -> Entry {
        Entry(u64::from(near.to_bits()) << 32 | u64::from(child.to_bits()))
    }

    fn near(self) -> f32 {
        f32::from_bits((self.0 >> 32) as u32)
    }

    fn child(self) -> Child {
        Child::from_bits(self.0 as u32)
    }
}

/// Entries that a walk of so many levels keeps at most: of each level all children but the one that it is in.
pub(super) const fn stack_size(levels: usize) -> usize {
    levels * (WIDTH - 1) + 1
}

/// The farthest entry is at the bottom.
struct Stack<const SIZE: usize> {
    entries: [Entry; SIZE],
    len: usize,
}

impl<const SIZE: usize> Stack<SIZE> {
    fn new() -> Stack<SIZE> {
        Stack { entries: [Entry(0); SIZE], len: 0 }
    }

    /// The topmost entry whose box begins before `reach`.
    #[inline(always)]
    fn pop(&mut self, reach: f32) -> Option<Entry> {
        while self.len > 0 {
            self.len -= 1;
            let entry = self.entries[self.len];
            if entry.near() <= reach {
                return Some(entry);
            }
        }
        None
    }

    /// Returns the nearest of the children in `lanes` of `node`, and pushes the others.
    #[inline(always)]
    fn push(&mut self, node: &WideNode, near: &[f32; WIDTH], mut lanes: u32) -> Option<Entry> {
        let bottom = self.len;
        let mut nearest = None;
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize % WIDTH;
            lanes &= lanes - 1;
            let entry = Entry::new(near[lane], node.child(lane));
            nearest = Some(match nearest {
                Some(other) => {
                    self.insert(bottom, entry.max(other));
                    entry.min(other)
                }
                None => entry,
            });
        }
        nearest
    }

    /// Pushes an entry below the nearer ones among those from `bottom` on.
    #[inline(always)]
    fn insert(&mut self, bottom: usize, entry: Entry) {
        let mut at = self.len;
        while at > bottom && self.entries[at - 1] < entry {
            self.entries[at] = self.entries[at - 1];
            at -= 1;
        }
        self.entries[at] = entry;
        self.len += 1;
    }
}

/// Walks the tree with a stack of `SIZE` entries, at least [`stack_size`] of its levels.
pub(super) fn walk<const SIZE: usize, Q: Query>(tree: &WideTree, ray: &PreparedRay, query: &mut Q) {
    let mut stack = Stack::<SIZE>::new();
    let mut next = tree.root.map(|root| Entry::new(0.0, root));
    while let Some(entry) = next {
        next = None;
        match entry.child().kind() {
            Kind::Node(number) => {
                let node = &tree.nodes[number];
                let (near, lanes) = node.enter(&ray.slabs, query.reach());
                next = stack.push(node, &near.to_array(), lanes);
            }
            Kind::Triangles(number) => meet_triangles(&tree.triangles[number], ray, query),
            Kind::Spheres(number) => meet_spheres(&tree.spheres[number], ray, query),
        }
        if query.is_answered() {
            return;
        }
        next = next.or_else(|| stack.pop(query.reach()));
    }
}

#[inline(always)]
fn meet_triangles(block: &TriangleBlock, ray: &PreparedRay, query: &mut impl Query) {
    block.for_each_meeting(ray, |Meeting { t, u, v, lane }| {
        let id = block.id(lane);
        query.meet(ray, t, id, || RayHit::new(t, [u, v], block.normal(lane), id));
    });
}

fn meet_spheres(block: &SphereBlock, ray: &PreparedRay, query: &mut impl Query) {
    block.for_each_meeting(&ray.ray, |t, normal, id| {
        query.meet(ray, t, id, || RayHit::new(t, [0.0, 0.0], normal, id));
    });
}
