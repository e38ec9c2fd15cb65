//! From corners, each with a position, a normal and texture coordinates of its own, to vertices that have one of each.

use std::collections::BTreeMap;

use crate::math::{Vec2, Vec3};

/// The corner of a face: numbers from 1 of what it has, 0 for what it has not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Corner {
    pub position: u32,
    pub normal: u32,
    /// Of texture coordinates; 0 for none.
    pub uv: u32,
}

/// What corners count.
pub(super) struct Values<'a> {
    pub positions: &'a [Vec3],
    pub normals: &'a [Vec3],
    pub uvs: &'a [Vec2],
}

/// Vertices in the order in which corners first use them.
pub(super) struct Joined {
    pub vertices: Vec<Vec3>,
    /// One per vertex, zero for corners without one; none if no corner has one.
    pub normals: Option<Vec<Vec3>>,
    /// As the normals.
    pub uvs: Option<Vec<Vec2>>,
    /// Of each corner, its vertex.
    pub indices: Vec<u32>,
}

impl Joined {
    /// Every number of a corner is that of a position or a normal that is there.
    pub fn of(corners: &[Corner], values: &Values) -> Joined {
        let has_uvs = corners.iter().any(|corner| corner.uv > 0);
        let has_normals = corners.iter().any(|corner| corner.normal > 0);
        let mut vertices = Vertices::new(values.positions.len());
        let indices = corners.iter().map(|corner| vertices.number(*corner)).collect();
        let used = vertices.used;
        let normal = |number: u32| number.checked_sub(1).map_or(Vec3::ZERO, |at| values.normals[at as usize]);
        let uv = |number: u32| number.checked_sub(1).map_or(Vec2::ZERO, |at| values.uvs[at as usize]);
        Joined {
            vertices: used.iter().map(|vertex| values.positions[vertex.position as usize - 1]).collect(),
            normals: has_normals.then(|| used.iter().map(|vertex| normal(vertex.normal)).collect()),
            uvs: has_uvs.then(|| used.iter().map(|vertex| uv(vertex.uv)).collect()),
            indices,
        }
    }
}

/// No vertex.
const NONE: u32 = u32::MAX;

/// More vertices of one position are looked up in a tree: walking past all of them would take time that grows with their square.
const LONGEST_CHAIN: usize = 16;

/// The vertices so far; those of one position are chained to each other.
struct Vertices {
    used: Vec<Corner>,
    /// Of each position, its first vertex.
    first: Vec<u32>,
    /// Of each vertex, the next one of its position.
    next: Vec<u32>,
    beyond_chains: BTreeMap<(u32, u32, u32), u32>,
}

impl Vertices {
    fn new(positions: usize) -> Vertices {
        Vertices {
            used: Vec::with_capacity(positions),
            first: vec![NONE; positions],
            next: Vec::with_capacity(positions),
            beyond_chains: BTreeMap::new(),
        }
    }

    /// The number of the vertex that a corner has.
    fn number(&mut self, corner: Corner) -> u32 {
        let mut last = NONE;
        let mut at = self.first[corner.position as usize - 1];
        for _ in 0..LONGEST_CHAIN {
            if at == NONE {
                return self.append(corner, last);
            }
            if self.used[at as usize] == corner {
                return at;
            }
            (last, at) = (at, self.next[at as usize]);
        }
        let key = (corner.position, corner.normal, corner.uv);
        if let Some(&known) = self.beyond_chains.get(&key) {
            return known;
        }
        let number = self.push(corner);
        self.beyond_chains.insert(key, number);
        number
    }

    /// A new vertex behind the `last` one of its position.
    fn append(&mut self, corner: Corner, last: u32) -> u32 {
        let number = self.push(corner);
        let link = match last {
            NONE => &mut self.first[corner.position as usize - 1],
            last => &mut self.next[last as usize],
        };
        *link = number;
        number
    }

    fn push(&mut self, corner: Corner) -> u32 {
        self.used.push(corner);
        self.next.push(NONE);
        self.used.len() as u32 - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_number_of_normals_of_one_position_is_joined() {
        const N: u32 = 100;
        let normals: Vec<Vec3> = (0..N).map(|k| Vec3::splat(k as f32)).collect();
        let around = (1..=N).map(|normal| Corner { position: 1, normal, uv: 0 });
        let corners: Vec<Corner> = around.clone().chain(around.rev()).collect();
        let joined = Joined::of(&corners, &Values { positions: &[Vec3::X], normals: &normals, uvs: &[] });
        assert_eq!(joined.vertices, vec![Vec3::X; N as usize]);
        assert_eq!(joined.normals.unwrap(), normals);
        assert_eq!(joined.indices, (0..N).chain((0..N).rev()).collect::<Vec<_>>());
    }
}
