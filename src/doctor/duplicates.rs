//! Surfaces in the same place: which of them a ray meets is a matter of luck.

use rayon::prelude::*;

use super::places::{self, Place, counted, first_of};
use super::{Check, Finding, Severity};
use crate::bsdf::Bsdf;
use crate::math::{Rgb, Vec3};
use crate::scene::{SceneDesc, SphereDesc};

pub(super) fn check(desc: &SceneDesc) -> Vec<Finding> {
    let mut found: Vec<Finding> = triangles(desc).into_iter().chain(spheres(desc)).collect();
    if found.is_empty() {
        found.push(Finding::fine(Check::Duplicates, "no two surfaces lie in the same place"));
    }
    found
}

/// What comes of a triangle that lies where another does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Alike in all that shows.
    Alike,
    /// Alike, and both shine.
    Shining,
    /// Of other materials, or of glass that faces the other way.
    Different,
}

const KINDS: [(Kind, Severity, &str, &str); 3] = [
    (Kind::Alike, Severity::Note, "alike", "meets one of the two, as if it were alone"),
    (
        Kind::Shining,
        Severity::Warning,
        "that shine",
        "emits the light of both, but the camera sees that of one",
    ),
    (
        Kind::Different,
        Severity::Warning,
        "of other material or facing",
        "meets either of the two by rounding, another with --traversal custom than with Embree",
    ),
];

fn triangles(desc: &SceneDesc) -> Vec<Finding> {
    let pairs = duplicates(desc);
    let finding = |(kind, severity, what, therefore): (Kind, Severity, &str, &str)| {
        let places: Vec<Place> = pairs.iter().filter(|(k, _)| *k == kind).map(|(_, place)| *place).collect();
        (!places.is_empty()).then(|| {
            let found = format!(
                "{} where others are, {what}: {}",
                counted(places.len(), "triangle"),
                places::first(desc, &places)
            );
            Finding::new(Check::Duplicates, severity, found, therefore)
        })
    };
    KINDS.into_iter().filter_map(finding).collect()
}

/// The triangles that have the corners of an earlier one, in the order of the file.
fn duplicates(desc: &SceneDesc) -> Vec<(Kind, Place)> {
    let mut keyed: Vec<([[u32; 3]; 3], Place)> =
        places::all(desc).map(|place| (key(place.corners(desc)), place)).collect();
    keyed.par_sort_unstable();
    let groups = keyed.chunk_by(|(a, _), (b, _)| a == b);
    let mut pairs: Vec<(Kind, Place)> = groups
        .flat_map(|group| group[1..].iter().map(|&(_, place)| (kind(desc, group[0].1, place), place)))
        .collect();
    pairs.sort_unstable_by_key(|(_, place)| *place);
    pairs
}

/// The same for the same three corners in any order; -0 is 0.
fn key(corners: [Vec3; 3]) -> [[u32; 3]; 3] {
    let mut key = corners.map(|p| (p + 0.0).to_array().map(f32::to_bits));
    key.sort_unstable();
    key
}

fn kind(desc: &SceneDesc, a: Place, b: Place) -> Kind {
    let (first, second) = (a.material(desc), b.material(desc));
    let faces_alike = normal(a.corners(desc)).dot(normal(b.corners(desc))) > 0.0;
    let shines = first.emission != Rgb::ZERO;
    match () {
        () if (first.bsdf, first.emission) != (second.bsdf, second.emission) => Kind::Different,
        () if !faces_alike && (shines || has_an_inside(&first.bsdf)) => Kind::Different,
        () if shines => Kind::Shining,
        () => Kind::Alike,
    }
}

fn normal([a, b, c]: [Vec3; 3]) -> crate::math::DVec3 {
    (b - a).as_dvec3().cross((c - a).as_dvec3())
}

/// Whether light goes through, so that the two sides differ.
pub(super) fn has_an_inside(bsdf: &Bsdf) -> bool {
    bsdf.ior().is_some()
}

fn spheres(desc: &SceneDesc) -> Option<Finding> {
    let key = |s: &SphereDesc| (s.center + 0.0).extend(s.radius).to_array().map(f32::to_bits);
    let mut keyed: Vec<([u32; 4], usize)> = desc.spheres.iter().map(key).zip(1..).collect();
    keyed.sort_unstable();
    let groups = keyed.chunk_by(|(a, _), (b, _)| a == b);
    let names: Vec<String> =
        groups.flat_map(|group| group[1..].iter().map(|(_, number)| format!("sphere {number}"))).collect();
    (!names.is_empty()).then(|| {
        let found =
            format!("{} where others are: {}", counted(names.len(), "sphere"), first_of(names.into_iter()));
        Finding::new(
            Check::Duplicates,
            Severity::Warning,
            found,
            "meets one of them, whichever it comes upon first",
        )
    })
}

#[cfg(test)]
mod tests {
    use super::super::testing::{GLASS, LAMP, WALL, WHITE, of, room, triangle, with_material};
    use super::*;

    const CORNERS: [Vec3; 3] = [Vec3::ZERO, Vec3::X, Vec3::Y];
    const TURNED: [Vec3; 3] = [Vec3::X, Vec3::Y, Vec3::ZERO];
    const FLIPPED: [Vec3; 3] = [Vec3::Y, Vec3::X, Vec3::new(-0.0, 0.0, 0.0)];

    fn severity_of(first: u32, second: u32, corners: [Vec3; 3]) -> Severity {
        let mut desc = room();
        desc.meshes.push(with_material(triangle("one", CORNERS), first));
        desc.meshes.push(with_material(triangle("two", corners), second));
        let findings = check(&desc);
        let finding = of(&findings, Check::Duplicates);
        assert!(finding.found.contains("1 triangle where others are"), "{finding:?}");
        assert!(finding.found.contains("two triangle 1"), "{finding:?}");
        finding.severity
    }

    #[test]
    fn rooms_without_duplicates_are_fine() {
        assert_eq!(of(&check(&room()), Check::Duplicates).severity, Severity::Fine);
    }

    #[test]
    fn what_two_triangles_do_together_decides() {
        for corners in [CORNERS, TURNED, FLIPPED] {
            assert_eq!(severity_of(WALL, WALL, corners), Severity::Note, "{corners:?}");
            assert_eq!(severity_of(WALL, WHITE, corners), Severity::Warning, "{corners:?}");
            assert_eq!(severity_of(LAMP, LAMP, corners), Severity::Warning, "{corners:?}");
        }
        assert_eq!(severity_of(GLASS, GLASS, TURNED), Severity::Note);
        assert_eq!(severity_of(GLASS, GLASS, FLIPPED), Severity::Warning);
    }

    #[test]
    fn within_a_mesh_and_more_than_two() {
        let mut desc = room();
        let mut mesh = triangle("thrice", CORNERS);
        mesh.triangles = vec![[0, 1, 2], [1, 2, 0], [2, 1, 0]];
        mesh.materials = vec![WALL; 3];
        desc.meshes.push(mesh);
        let findings = check(&desc);
        let found = &of(&findings, Check::Duplicates).found;
        assert!(found.contains("2 triangles where") && found.contains("thrice triangle 2"), "{found}");
    }

    #[test]
    fn spheres_are_compared_too() {
        let mut desc = room();
        desc.spheres.push(desc.spheres[0]);
        let findings = check(&desc);
        assert!(of(&findings, Check::Duplicates).found.contains("1 sphere where others are: sphere 2"));
    }
}
