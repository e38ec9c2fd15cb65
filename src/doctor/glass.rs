//! Which side of glass is its inside: by the normals of its surface, whatever is behind.

use super::bodies::{Body, Enclosures, Kind};
use super::places::{self, Place, counted, first_of};
use super::subject::Subject;
use super::{Check, Finding, Severity};
use crate::math::Vec3;
use crate::scene::{SceneDesc, SphereDesc};

/// Bodies of glass whose surroundings are looked at, at most.
const LOOKED_AT: usize = 64;

pub(super) fn check(subject: &Subject) -> Vec<Finding> {
    let glass: Vec<(usize, &Body)> =
        subject.bodies.iter().enumerate().filter(|(_, body)| matches!(body.kind, Kind::Glass(_))).collect();
    let spheres: Vec<usize> = glass_spheres(subject.desc);
    if glass.is_empty() && spheres.is_empty() {
        return vec![Finding::fine(Check::OpenGlass, "there is no glass")];
    }
    let mut findings = vec![open(subject.desc, &glass)];
    findings.extend(winding(subject, &glass));
    findings.push(nested(subject, &glass, &spheres));
    findings
}

fn glass_spheres(desc: &SceneDesc) -> Vec<usize> {
    let is_glass = |&k: &usize| {
        super::duplicates::has_an_inside(&desc.materials[desc.spheres[k].material as usize].bsdf)
    };
    (0..desc.spheres.len()).filter(is_glass).collect()
}

fn firsts(bodies: &[&Body]) -> Vec<Place> {
    bodies.iter().map(|body| body.triangles[0]).collect()
}

fn open(desc: &SceneDesc, glass: &[(usize, &Body)]) -> Finding {
    let open: Vec<&Body> = glass.iter().map(|(_, body)| *body).filter(|body| body.borders > 0).collect();
    if open.is_empty() {
        return Finding::fine(Check::OpenGlass, "all glass is closed");
    }
    let borders = open.iter().map(|body| body.borders).sum();
    let found = format!(
        "{} with {}: {}",
        counted(open.len(), "open sheet"),
        counted(borders, "free edge"),
        places::first(desc, &firsts(&open))
    );
    let therefore = "takes it for one interface, whose inside is all behind its normals: right for water in a basin, wrong for \
        a pane or a bottle with a hole";
    Finding::new(Check::OpenGlass, Severity::Note, found, therefore)
}

fn winding(subject: &Subject, glass: &[(usize, &Body)]) -> Vec<Finding> {
    let flipped: Vec<&Body> = glass.iter().map(|(_, body)| *body).filter(|body| body.flips > 0).collect();
    let inverted: Vec<&Body> = glass
        .iter()
        .filter(|(_, body)| body.is_closed() && body.volume < 0.0)
        .take(LOOKED_AT)
        .filter(|(number, body)| !is_cavity(subject, *number, body))
        .map(|(_, body)| *body)
        .collect();
    let warning = |bodies: &[&Body], what: &str, therefore: &str| {
        let found = format!(
            "{} {what}: {}",
            counted(bodies.len(), "surface"),
            places::first(subject.desc, &firsts(bodies))
        );
        (!bodies.is_empty()).then(|| Finding::new(Check::Winding, Severity::Warning, found, therefore))
    };
    let told: Vec<Finding> = [
        warning(
            &flipped,
            "of glass whose triangles face either way",
            "takes inside for outside where a triangle is turned: it refracts the wrong way there",
        ),
        warning(
            &inverted,
            "of glass wound inward",
            "takes inside for outside: glass of ior n refracts as a bubble of ior 1/n; reverse the faces",
        ),
    ]
    .into_iter()
    .flatten()
    .collect();
    if told.is_empty() {
        vec![Finding::fine(Check::Winding, "the inside of all glass is inside")]
    } else {
        told
    }
}

/// Whether an inward surface is the wall of a hole in glass, as it should be.
fn is_cavity(subject: &Subject, number: usize, body: &Body) -> bool {
    around(subject, number, body.triangles[0].corners(subject.desc)[0]) != Enclosures::default()
}

/// What glass is around a corner of a body, itself left out.
fn around(subject: &Subject, number: usize, corner: Vec3) -> Enclosures {
    let mut enclosures = Enclosures::of(subject.desc, &subject.bodies, corner);
    enclosures.bodies.retain(|&k| k != number && matches!(subject.bodies[k].kind, Kind::Glass(_)));
    let glass = glass_spheres(subject.desc);
    enclosures.spheres.retain(|k| glass.binary_search(k).is_ok());
    enclosures
}

fn nested(subject: &Subject, glass: &[(usize, &Body)], spheres: &[usize]) -> Finding {
    let desc = subject.desc;
    let pairs = sphere_pairs(desc, spheres);
    let crossing: Vec<String> = names(&pairs, Meeting::Crossing);
    if !crossing.is_empty() {
        let found = format!("glass spheres that cut each other: {}", first_of(crossing.into_iter()));
        let therefore = "refracts at each surface as if air were outside, in the common part too; make them one mesh, or keep them \
            apart";
        return Finding::new(Check::NestedGlass, Severity::Warning, found, therefore);
    }
    let in_glass = glass
        .iter()
        .filter(|(_, body)| body.is_closed())
        .take(LOOKED_AT)
        .map(|(number, body)| {
            (body.triangles[0], around(subject, *number, body.triangles[0].corners(desc)[0]))
        })
        .filter(|(_, around)| *around != Enclosures::default())
        .map(|(place, _)| desc.meshes[place.mesh as usize].name.clone());
    let held_by_bodies = spheres
        .iter()
        .take(LOOKED_AT)
        .filter(|&&k| !around(subject, usize::MAX, desc.spheres[k].center).bodies.is_empty())
        .map(|k| format!("sphere {}", k + 1));
    let inner: Vec<String> =
        names(&pairs, Meeting::Nested).into_iter().chain(in_glass).chain(held_by_bodies).collect();
    if inner.is_empty() {
        return Finding::fine(Check::NestedGlass, "no glass lies in other glass");
    }
    let found = format!("glass in glass: {}", first_of(inner.into_iter()));
    let therefore = "refracts at each surface by its own ior alone: inside over outside, so 1.5 / 1.33 for glass in water";
    Finding::new(Check::NestedGlass, Severity::Note, found, therefore)
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Meeting {
    Crossing,
    Nested,
}

fn names(pairs: &[(usize, usize, Meeting)], meeting: Meeting) -> Vec<String> {
    let of_kind = pairs.iter().filter(|(_, _, m)| *m == meeting);
    of_kind.map(|(a, b, _)| format!("sphere {} and {}", a + 1, b + 1)).collect()
}

/// The spheres of glass that cut or hold each other, in the order of the file.
fn sphere_pairs(desc: &SceneDesc, spheres: &[usize]) -> Vec<(usize, usize, Meeting)> {
    let left = |k: usize| desc.spheres[k].center.x - desc.spheres[k].radius;
    let right = |k: usize| desc.spheres[k].center.x + desc.spheres[k].radius;
    let mut sorted = spheres.to_vec();
    sorted.sort_by(|&a, &b| left(a).total_cmp(&left(b)));
    let mut pairs = Vec::new();
    for (index, &a) in sorted.iter().enumerate() {
        for &b in sorted[index + 1..].iter().take_while(|&&b| left(b) <= right(a)) {
            if let Some(meeting) = meeting(&desc.spheres[a], &desc.spheres[b]) {
                pairs.push((a.min(b), a.max(b), meeting));
            }
        }
    }
    pairs.sort_unstable_by_key(|&(a, b, _)| (a, b));
    pairs
}

fn meeting(a: &SphereDesc, b: &SphereDesc) -> Option<Meeting> {
    let distance = a.center.distance(b.center);
    if distance >= a.radius + b.radius {
        return None;
    }
    Some(if distance <= (a.radius - b.radius).abs() { Meeting::Nested } else { Meeting::Crossing })
}

#[cfg(test)]
mod tests {
    use super::super::testing::{GLASS, ceiling, cube, of, room, severity, subject};
    use super::*;
    use crate::scene::Mesh;

    fn with_meshes(meshes: Vec<Mesh>) -> Vec<Finding> {
        let mut desc = room();
        desc.meshes.extend(meshes);
        check(&subject(&desc))
    }

    const MIDDLE: Vec3 = Vec3::new(0.4, -0.5, -0.4);

    #[test]
    fn closed_glass_is_fine() {
        let findings = with_meshes(vec![cube("box", MIDDLE, 0.2, GLASS)]);
        assert!(findings.len() == 3 && findings.iter().all(|f| f.severity == Severity::Fine), "{findings:?}");
    }

    #[test]
    fn scenes_without_glass_have_nothing_to_tell() {
        let mut desc = room();
        desc.spheres.clear();
        assert_eq!(check(&subject(&desc)).len(), 1);
    }

    #[test]
    fn an_open_sheet_is_noted_with_its_edges() {
        let findings = with_meshes(vec![ceiling("water", -0.5 * Vec3::ONE, 1.0, GLASS)]);
        let finding = of(&findings, Check::OpenGlass);
        assert_eq!(finding.severity, Severity::Note);
        assert!(finding.found.contains("1 open sheet with 4 free edges: water triangle 1"), "{finding:?}");
    }

    #[test]
    fn inward_glass_is_a_warning_unless_it_is_a_cavity() {
        let inward = |half: f32| {
            let mut mesh = cube("inward", MIDDLE, half, GLASS);
            mesh.triangles.iter_mut().for_each(|corners| corners.reverse());
            mesh
        };
        let findings = with_meshes(vec![inward(0.2)]);
        assert_eq!(severity(&findings, Check::Winding), Severity::Warning, "{findings:?}");
        let hollow = with_meshes(vec![cube("outer", MIDDLE, 0.3, GLASS), inward(0.2)]);
        assert_eq!(severity(&hollow, Check::Winding), Severity::Fine, "{hollow:?}");
    }

    #[test]
    fn a_turned_triangle_is_a_warning() {
        let mut mesh = cube("box", MIDDLE, 0.2, GLASS);
        mesh.triangles[5].reverse();
        let findings = with_meshes(vec![mesh]);
        assert!(
            of(&findings, Check::Winding)
                .found
                .contains("1 surface of glass whose triangles face either way")
        );
        assert_eq!(severity(&findings, Check::OpenGlass), Severity::Fine);
    }

    #[test]
    fn spheres_that_meet_are_told() {
        let second = |distance: f32, radius: f32| {
            let mut desc = room();
            let first = desc.spheres[0];
            let center = first.center + distance * Vec3::X;
            desc.spheres.push(SphereDesc { center, radius, ..first });
            of(&check(&subject(&desc)), Check::NestedGlass).clone()
        };
        assert_eq!(second(0.7, 0.3).severity, Severity::Fine);
        assert_eq!(second(0.5, 0.3).severity, Severity::Warning);
        let nested = second(0.1, 0.1);
        assert_eq!(nested.severity, Severity::Note);
        assert!(nested.found.contains("sphere 1 and 2"), "{nested:?}");
    }

    #[test]
    fn glass_within_meshes_of_glass_is_told() {
        let boxes = with_meshes(vec![cube("outer", MIDDLE, 0.3, GLASS), cube("inner", MIDDLE, 0.1, GLASS)]);
        let found = &of(&boxes, Check::NestedGlass).found;
        assert!(found.contains("glass in glass: inner"), "{found}");
        let around = with_meshes(vec![cube("outer", room().spheres[0].center, 0.35, GLASS)]);
        let found = &of(&around, Check::NestedGlass).found;
        assert!(found.contains("sphere 1"), "{found}");
    }
}
