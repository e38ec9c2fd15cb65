//! Triangles that rays cannot rely on.

use super::places::{self, Place, counted};
use super::{Check, Finding, Severity};
use crate::math::Vec3;
use crate::scene::{SceneDesc, keeps_clear_of_edges, least_altitude};

pub(super) fn check(desc: &SceneDesc) -> [Finding; 2] {
    [areas(desc), needles(desc)]
}

/// The loader drops triangles without area, so only scenes made in code can hold any.
fn areas(desc: &SceneDesc) -> Finding {
    let flat: Vec<Place> = places::all(desc).filter(|p| least_altitude(p.corners(desc)) == 0.0).collect();
    if flat.is_empty() {
        return Finding::fine(Check::Areas, "every triangle has one");
    }
    let found = format!("{} without area: {}", counted(flat.len(), "triangle"), places::first(desc, &flat));
    Finding::new(Check::Areas, Severity::Note, found, "never sees them, as if they were not there")
}

fn needles(desc: &SceneDesc) -> Finding {
    let thin: Vec<Place> = places::all(desc).filter(|p| is_needle(p.corners(desc))).collect();
    if thin.is_empty() {
        return Finding::fine(Check::Needles, "no triangle is too thin for its position");
    }
    let found = format!(
        "{} too thin for the errors of points there: {}",
        counted(thin.len(), "triangle"),
        places::first(desc, &thin)
    );
    let therefore = "cannot keep all of their points clear of their edges: a ray that goes on from there may start \
        behind a wall that meets it";
    Finding::new(Check::Needles, Severity::Note, found, therefore)
}

/// Thinner than a quarter of its length; others are small altogether, which [`super::extent`] tells.
fn is_needle(corners: [Vec3; 3]) -> bool {
    const LONG: f32 = 4.0;
    let altitude = least_altitude(corners);
    altitude > 0.0 && longest_edge(corners) > LONG * altitude && !keeps_clear_of_edges(corners)
}

pub(super) fn longest_edge([a, b, c]: [Vec3; 3]) -> f32 {
    a.distance(b).max(b.distance(c)).max(c.distance(a))
}

#[cfg(test)]
mod tests {
    use super::super::testing::{of, room, severity, triangle};
    use super::*;

    #[test]
    fn triangles_without_area_are_counted() {
        let mut desc = room();
        assert_eq!(severity(&check(&desc), Check::Areas), Severity::Fine);
        desc.meshes.push(triangle("flat", [Vec3::ZERO, Vec3::ONE, Vec3::splat(0.5)]));
        desc.meshes.push(triangle("point", [Vec3::ONE; 3]));
        let findings = check(&desc);
        assert_eq!(severity(&findings, Check::Areas), Severity::Note);
        let found = &of(&findings, Check::Areas).found;
        assert!(found.contains("2 triangles without area: flat triangle 1 (`wall`)"), "{found}");
        assert_eq!(severity(&findings, Check::Needles), Severity::Fine, "they are no needles");
    }

    /// Points of a triangle at 1 have an error of 2⁻¹⁹, so one of altitude 2⁻¹⁵ is too thin.
    #[test]
    fn needles_are_those_that_cannot_keep_clear() {
        let thin = |altitude: f32| {
            let mut desc = room();
            desc.meshes.push(triangle("thin", [Vec3::ZERO, Vec3::X, Vec3::new(0.5, altitude, 0.0)]));
            severity(&check(&desc), Check::Needles)
        };
        assert_eq!((thin(1e-3), thin(1e-5)), (Severity::Fine, Severity::Note));
    }
}
