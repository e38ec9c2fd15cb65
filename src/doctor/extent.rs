//! How large the scene is, where it lies, and what single precision makes of that.

use super::places::{self, Place, counted, first_of, position_error, shown};
use super::subject::Subject;
use super::triangles::longest_edge;
use super::{Check, Finding, Severity};
use crate::math::{RELATIVE_POSITION_ERROR, Vec3};
use crate::scene::{SceneDesc, keeps_clear_of_edges, least_altitude};

pub(super) fn check(subject: &Subject) -> Vec<Finding> {
    if subject.scene.primitives() == 0 {
        let finding = Finding::new(
            Check::Extent,
            Severity::Fault,
            "there is no surface at all",
            "makes a black picture",
        );
        return vec![finding];
    }
    vec![extent(subject), small_parts(subject.desc)]
}

fn extent(subject: &Subject) -> Finding {
    /// So many errors of a point fit into a scene that is large for its distance from the origin.
    const FEW: f32 = 4096.0;
    let bounds = subject.scene.bounds();
    let longest = bounds.extent().max_element();
    let largest = bounds.min.abs().max(bounds.max.abs()).max_element();
    let error = RELATIVE_POSITION_ERROR * largest;
    let found = format!(
        "longest side {}, largest coordinate {}: coordinates in steps of {}, points uncertain by {}",
        shown(longest),
        shown(largest),
        shown(largest.next_up() - largest),
        shown(error)
    );
    let coarse = |detail: String| {
        let therefore = format!(
            "sees no shadow of what is nearer to a surface than {}{detail}; move the scene to the origin",
            shown(error)
        );
        Finding::new(Check::Extent, Severity::Warning, found.clone(), therefore)
    };
    match subject.footprint() {
        Some(width) if width < f64::from(error) => coarse(format!(", and a pixel is {} wide", shown(width))),
        _ if longest < FEW * error => coarse(String::new()),
        _ => Finding::fine(Check::Extent, found),
    }
}

fn small_parts(desc: &SceneDesc) -> Finding {
    let small: Vec<Place> = places::all(desc).filter(|p| is_small(p.corners(desc))).collect();
    let balls: Vec<String> = desc
        .spheres
        .iter()
        .zip(1..)
        .filter(|(s, _)| ball_is_small(s.center, s.radius))
        .map(|(_, number)| format!("sphere {number}"))
        .collect();
    if small.is_empty() && balls.is_empty() {
        return Finding::fine(Check::SmallParts, "none is lost in the errors of points");
    }
    let triangles = (!small.is_empty())
        .then(|| format!("{}: {}", counted(small.len(), "triangle"), places::first(desc, &small)));
    let spheres = (!balls.is_empty())
        .then(|| format!("{}: {}", counted(balls.len(), "sphere"), first_of(balls.iter().cloned())));
    let parts = [triangles, spheres].into_iter().flatten().collect::<Vec<_>>().join("; ");
    let found = format!("smaller than 32 errors of a point: {parts}");
    let therefore =
        "starts rays from them off their surface by more than a 32nd of their size: their shading is crude";
    Finding::new(Check::SmallParts, Severity::Note, found, therefore)
}

/// Needles are told elsewhere.
fn is_small(corners: [Vec3; 3]) -> bool {
    let altitude = least_altitude(corners);
    let is_thin = longest_edge(corners) > 4.0 * altitude;
    altitude > 0.0 && !is_thin && !keeps_clear_of_edges(corners)
}

fn ball_is_small(center: Vec3, radius: f32) -> bool {
    const ERRORS: f32 = 32.0;
    radius < ERRORS * position_error([center.abs() + radius; 3])
}

#[cfg(test)]
mod tests {
    use super::super::testing::{moved, of, room, severity, subject, triangle};
    use super::*;

    #[test]
    fn distance_from_the_origin_matters_and_size_does_not() {
        let of_room = |scale: f32, shift: Vec3| {
            let desc = moved(room(), scale, shift);
            severity(&check(&subject(&desc)), Check::Extent)
        };
        assert_eq!(of_room(1.0, Vec3::ZERO), Severity::Fine);
        assert_eq!(of_room(1e-6, Vec3::ZERO), Severity::Fine);
        assert_eq!(of_room(1e6, Vec3::splat(1e6)), Severity::Fine);
        assert_eq!(of_room(1.0, Vec3::new(1e4, 0.0, 0.0)), Severity::Warning);
    }

    #[test]
    fn a_scene_of_nothing_is_a_fault() {
        let mut desc = room();
        (desc.meshes, desc.spheres) = (vec![], vec![]);
        assert_eq!(severity(&check(&subject(&desc)), Check::Extent), Severity::Fault);
    }

    #[test]
    fn small_parts_are_counted() {
        let of_size = |size: f32| {
            let mut desc = room();
            let corners = [Vec3::ZERO, Vec3::X, Vec3::Y].map(|p| 0.9 * Vec3::X + size * p);
            desc.meshes.push(triangle("tiny", corners));
            desc.spheres[0].radius = size;
            desc.spheres[0].center = 0.5 * Vec3::ONE;
            of(&[small_parts(&desc)], Check::SmallParts).clone()
        };
        assert_eq!(of_size(1e-2).severity, Severity::Fine);
        let finding = of_size(1e-5);
        assert_eq!(finding.severity, Severity::Note);
        assert!(finding.found.contains("1 triangle: tiny triangle 1"), "{finding:?}");
        assert!(finding.found.contains("1 sphere: sphere 1"), "{finding:?}");
    }
}
