//! Triangles by number, and their names in messages.

use crate::math::{RELATIVE_POSITION_ERROR, Vec3};
use crate::report::Cell;
use crate::scene::{Material, SceneDesc};

/// A triangle of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Place {
    pub mesh: u32,
    pub triangle: u32,
}

impl Place {
    pub fn corners(self, desc: &SceneDesc) -> [Vec3; 3] {
        desc.meshes[self.mesh as usize].corners(self.triangle as usize)
    }

    pub fn material_number(self, desc: &SceneDesc) -> u32 {
        desc.meshes[self.mesh as usize].materials[self.triangle as usize]
    }

    pub fn material(self, desc: &SceneDesc) -> &Material {
        &desc.materials[self.material_number(desc) as usize]
    }

    /// Triangles count from 1.
    fn name(self, desc: &SceneDesc) -> String {
        let mesh = &desc.meshes[self.mesh as usize].name;
        format!("{mesh} triangle {} (`{}`)", self.triangle + 1, self.material(desc).name)
    }
}

/// All triangles, mesh by mesh.
pub(super) fn all(desc: &SceneDesc) -> impl Iterator<Item = Place> {
    desc.meshes.iter().zip(0..).flat_map(|(mesh, number)| {
        (0..mesh.triangles.len() as u32).map(move |triangle| Place { mesh: number, triangle })
    })
}

/// The names of the first of `places`, and how many there are beside them.
pub(super) fn first(desc: &SceneDesc, places: &[Place]) -> String {
    first_of(places.iter().map(|place| place.name(desc)))
}

/// The first of `names`, and how many there are beside them.
pub(super) fn first_of(names: impl ExactSizeIterator<Item = String>) -> String {
    const SHOWN: usize = 2;
    let more = names.len().saturating_sub(SHOWN);
    let shown = names.take(SHOWN).collect::<Vec<_>>().join(", ");
    if more > 0 { format!("{shown}, and {more} more") } else { shown }
}

/// The error of points on a triangle: that of [`crate::scene::SurfaceHit::p_error`].
pub(super) fn position_error(corners: [Vec3; 3]) -> f32 {
    RELATIVE_POSITION_ERROR * corners.iter().fold(0.0, |m: f32, c| m.max(c.abs().max_element()))
}

/// Four digits, by powers of ten where there are many zeros.
pub(super) fn shown(x: impl Into<f64>) -> String {
    let x = x.into();
    if x == 0.0 || (1e-3..1e6).contains(&x.abs()) { Cell::Number(x).to_string() } else { format!("{x:.3e}") }
}

/// `1 triangle` or `7 triangles`.
pub(super) fn counted(n: usize, what: &str) -> String {
    if n == 1 { format!("1 {what}") } else { format!("{n} {what}s") }
}
