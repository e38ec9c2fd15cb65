//! Materials that are hardly meant as they are.

use super::places::{counted, first_of};
use super::{Check, Finding, Severity};
use crate::scene::{Material, SceneDesc};

pub(super) fn check(desc: &SceneDesc) -> Vec<Finding> {
    let mut findings: Vec<Finding> = unused(desc).into_iter().collect();
    findings.extend(told(
        desc,
        |material| ior(material) == Some(1.0),
        "that bend nothing, of ior 1",
        "lets eye rays and photons through, but takes them for opaque in shadow rays",
    ));
    findings.extend(told(
        desc,
        |material| ior(material).is_some_and(|ior| !(0.3..=4.0).contains(&ior)),
        "of an ior below 0.3 or above 4, as no glass has",
        "follows it: hardly any light gets in, or out again",
    ));
    if findings.is_empty() {
        findings.push(Finding::fine(
            Check::Materials,
            format!("{}, all in use", counted(desc.materials.len(), "material")),
        ));
    }
    findings
}

/// The ior of a surface that light passes.
fn ior(material: &Material) -> Option<f32> {
    material.bsdf.ior()
}

fn told(
    desc: &SceneDesc,
    is_odd: impl Fn(&Material) -> bool,
    what: &str,
    therefore: &str,
) -> Option<Finding> {
    let names: Vec<String> =
        desc.materials.iter().filter(|m| is_odd(m)).map(|m| format!("`{}`", m.name)).collect();
    (!names.is_empty()).then(|| {
        let found = format!("{} {what}: {}", counted(names.len(), "material"), first_of(names.into_iter()));
        Finding::new(Check::Materials, Severity::Note, found, therefore)
    })
}

fn unused(desc: &SceneDesc) -> Option<Finding> {
    let mut used = vec![false; desc.materials.len()];
    let of_meshes = desc.meshes.iter().flat_map(|mesh| &mesh.materials);
    for &material in of_meshes.chain(desc.spheres.iter().map(|sphere| &sphere.material)) {
        used[material as usize] = true;
    }
    let unused = desc.materials.iter().zip(used).filter(|(_, used)| !used);
    let names: Vec<String> = unused.map(|(material, _)| format!("`{}`", material.name)).collect();
    (!names.is_empty()).then(|| {
        let found =
            format!("{} in no use: {}", counted(names.len(), "material"), first_of(names.into_iter()));
        Finding::new(Check::Materials, Severity::Note, found, "does without")
    })
}

#[cfg(test)]
mod tests {
    use super::super::testing::{GLASS, room};
    use super::*;
    use crate::bsdf::Bsdf;

    fn found(edit: impl Fn(&mut SceneDesc)) -> String {
        let mut desc = room();
        desc.materials.truncate(2);
        edit(&mut desc);
        check(&desc).into_iter().map(|f| format!("{}: {}\n", f.severity, f.found)).collect()
    }

    #[test]
    fn materials_in_use_are_fine() {
        assert_eq!(found(|_| ()), "fine: 2 materials, all in use\n");
    }

    #[test]
    fn odd_ones_are_named() {
        assert_eq!(found(|desc| desc.spheres.clear()), "note: 1 material in no use: `glass`\n");
        let of_ior = |ior| found(move |desc| desc.materials[GLASS as usize].bsdf = Bsdf::Dielectric { ior });
        assert!(of_ior(1.0).contains("note: 1 material that bend nothing, of ior 1: `glass`"));
        for ior in [0.2, 5.0] {
            assert!(of_ior(ior).contains("note: 1 material of an ior below 0.3 or above 4"), "{ior}");
        }
        assert!(of_ior(0.75).starts_with("fine"));
    }

    #[test]
    fn what_lets_no_light_through_has_no_ior() {
        let bsdf = |transparency| Bsdf::FixedWeight {
            color: crate::math::Rgb::ONE,
            reflectivity: 0.5,
            transparency,
            ior: 1.0,
        };
        let of_share = |transparency| found(|desc| desc.materials[GLASS as usize].bsdf = bsdf(transparency));
        assert!(of_share(0.0).starts_with("fine") && of_share(0.5).starts_with("note"));
    }
}
