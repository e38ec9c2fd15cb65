//! What is odd about a scene, and what a render of it will therefore do.
//!
//! [`examine`] looks at a scene that has loaded: first at its numbers, then at its surfaces, lights and glass, and at
//! last at a small trial render, so that whatever it predicts comes from the code that it predicts. [`stability`] renders
//! scenes of its own and holds the pictures against each other: it examines the program and the machine. Both give a
//! [`Diagnosis`], one [`Finding`] a check.
#![doc = include_str!("../../docs/doctor.md")]

mod bodies;
mod camera;
mod duplicates;
mod extent;
mod finding;
mod glass;
mod lights;
mod materials;
mod numbers;
mod photons;
mod places;
mod radius;
mod specimens;
mod stability;
mod subject;
#[cfg(test)]
mod testing;
mod triangles;

pub use finding::{Check, Diagnosis, Finding, Severity};
pub use stability::{StabilityError, stability};

use crate::ppm::Settings;
use crate::scene::{SceneDesc, SceneError, Traversal, TraversalError};
use subject::Subject;

/// Examines a scene that would be rendered by `settings` and `traversal`.
///
/// # Errors
/// Whatever the ray tracer refuses: see [`crate::scene::Scene::with_traversal`].
pub fn examine(
    desc: &SceneDesc,
    settings: Settings,
    traversal: Traversal,
) -> Result<Diagnosis, TraversalError> {
    let mut findings = numbers::check(desc);
    if findings.iter().any(|finding| finding.severity == Severity::Fault) {
        return Ok(Diagnosis { subject: desc.path.display().to_string(), findings });
    }
    findings.extend(triangles::check(desc));
    findings.extend(duplicates::check(desc));
    let subject = Subject::new(desc, settings, traversal)?;
    findings.extend(extent::check(&subject));
    findings.extend(lights::check(&subject));
    findings.extend(glass::check(&subject));
    findings.extend(materials::check(desc));
    findings.extend(camera::check(&subject));
    findings.extend(photons::check(&subject));
    findings.extend(radius::check(&subject));
    Ok(Diagnosis { subject: desc.path.display().to_string(), findings })
}

/// What there is to say of a scene that does not load.
pub fn not_loaded(path: &std::path::Path, error: &SceneError) -> Diagnosis {
    let finding = Finding::new(
        Check::Loading,
        Severity::Fault,
        error.to_string(),
        "does not start: exit code 2, nothing is written",
    );
    Diagnosis { subject: path.display().to_string(), findings: vec![finding] }
}
