//! What the loader said, and whether the numbers are fit for use: the loader refuses others, but scenes made in code
//! have not passed it.

use super::places::{counted, first_of};
use super::{Check, Finding, Severity};
use crate::math::Vec3;
use crate::scene::{Mesh, SceneDesc};

pub(super) fn check(desc: &SceneDesc) -> Vec<Finding> {
    let mut findings = vec![contents(desc)];
    findings.extend(repairs(desc));
    findings.push(finite(desc));
    findings
}

fn contents(desc: &SceneDesc) -> Finding {
    let triangles = desc.meshes.iter().map(|mesh| mesh.triangles.len()).sum();
    let (meshes, spheres) = (
        counted(desc.meshes.len(), "mesh").replace("meshs", "meshes"),
        counted(desc.spheres.len(), "sphere"),
    );
    Finding::fine(Check::Loading, format!("{} in {meshes}, {spheres}", counted(triangles, "triangle")))
}

fn repairs(desc: &SceneDesc) -> Vec<Finding> {
    let told = |warning: &String| {
        Finding::new(Check::Repairs, Severity::Warning, warning, "goes on with what is left")
    };
    match desc.warnings.as_slice() {
        [] => vec![Finding::fine(Check::Repairs, "the loader had nothing to repair")],
        warnings => warnings.iter().map(told).collect(),
    }
}

fn finite(desc: &SceneDesc) -> Finding {
    let meshes = desc.meshes.iter().filter(|mesh| !mesh_is_finite(mesh)).map(|mesh| mesh.name.clone());
    let spheres =
        desc.spheres.iter().zip(1..).filter(|(s, _)| !(s.center.is_finite() && s.radius.is_finite()));
    let lights = desc
        .point_lights
        .iter()
        .zip(1..)
        .filter(|(l, _)| !(l.position.is_finite() && l.intensity.is_finite()));
    let camera = &desc.camera;
    let eye = [camera.position, camera.look_at, camera.up].iter().all(|v| v.is_finite());
    let names: Vec<String> = meshes
        .chain(spheres.map(|(_, n)| format!("sphere {n}")))
        .chain(lights.map(|(_, n)| format!("point_light {n}")))
        .chain((!eye).then(|| String::from("camera")))
        .collect();
    if names.is_empty() {
        return Finding::fine(Check::Numbers, "all are finite");
    }
    let found = format!("not finite: {}", first_of(names.into_iter()));
    Finding::new(Check::Numbers, Severity::Fault, found, "is undefined; nothing else was examined")
}

fn mesh_is_finite(mesh: &Mesh) -> bool {
    let finite = |vectors: &[Vec3]| vectors.iter().all(|v| v.is_finite());
    finite(&mesh.vertices) && mesh.normals.as_deref().is_none_or(finite)
}

#[cfg(test)]
mod tests {
    use super::super::testing::{of, room, severity};
    use super::*;

    #[test]
    fn what_the_loader_said_is_passed_on() {
        let mut desc = room();
        assert_eq!(severity(&check(&desc), Check::Repairs), Severity::Fine);
        desc.warnings = vec!["m.obj: dropped triangles without area: 3".into(), "other".into()];
        let findings = check(&desc);
        assert_eq!(findings.iter().filter(|f| f.check == Check::Repairs).count(), 2);
        assert!(of(&findings, Check::Repairs).found.contains("without area: 3"));
    }

    #[test]
    fn numbers_that_are_not_finite_are_found_wherever_they_are() {
        assert_eq!(severity(&check(&room()), Check::Numbers), Severity::Fine);
        type Break = (&'static str, fn(&mut SceneDesc));
        let breaks: [Break; 5] = [
            ("room", |desc| desc.meshes[0].vertices[3].y = f32::NAN),
            ("room", |desc| desc.meshes[0].normals = Some(vec![Vec3::INFINITY; 8])),
            ("sphere 1", |desc| desc.spheres[0].radius = f32::INFINITY),
            ("point_light 1", |desc| desc.point_lights[0].intensity.x = f32::NAN),
            ("camera", |desc| desc.camera.position.z = f32::NEG_INFINITY),
        ];
        for (name, break_it) in breaks {
            let mut desc = room();
            break_it(&mut desc);
            let findings = check(&desc);
            assert_eq!(severity(&findings, Check::Numbers), Severity::Fault);
            assert!(of(&findings, Check::Numbers).found.contains(name), "{name}: {findings:?}");
        }
    }
}
