//! What becomes of the photons of one pass.

use super::subject::Subject;
use super::{Check, Finding, Severity};

pub(super) fn check(subject: &Subject) -> Option<Finding> {
    /// Shares of all photons.
    const CUT: f64 = 0.001;
    const LOST: f64 = 0.5;
    let ledger = subject.trial.pass.photons;
    if ledger.emitted == 0 {
        return None;
    }
    let share = |n: u64| n as f64 / ledger.emitted as f64;
    let percent = |n: u64| 100.0 * share(n);
    let finding = |severity, found: String, therefore: &str| {
        Some(Finding::new(Check::Photons, severity, found, therefore))
    };
    if ledger.dropped > 0 {
        let found = format!("{} of {} photons lost their power to overflow", ledger.dropped, ledger.emitted);
        return finding(Severity::Warning, found, "drops them: the picture is too dark");
    }
    if share(ledger.terminated) > CUT {
        let found =
            format!("{:.1} % of photons are under way after 1000 bounces", percent(ledger.terminated));
        let therefore = "cuts them there: in a closed scene that absorbs nothing the picture is too dark, and passes are slow; use \
            albedos below 1";
        return finding(Severity::Warning, found, therefore);
    }
    if ledger.deposited == 0 {
        let found = format!(
            "none of {} photons comes to a diffuse surface a second time, or after glass or mirror",
            ledger.emitted
        );
        return finding(Severity::Warning, found, "shows direct light alone, whatever its passes");
    }
    let found = format!(
        "{:.1} % leave the scene; {:.2} places a photon",
        percent(ledger.escaped),
        ledger.deposited as f64 / ledger.emitted as f64
    );
    if share(ledger.escaped) > LOST {
        return finding(Severity::Note, found, "spends most of its photons on light that nothing stops");
    }
    Some(Finding::fine(Check::Photons, found))
}

#[cfg(test)]
mod tests {
    use super::super::testing::{WALL, room, subject};
    use super::*;
    use crate::bsdf::Bsdf;
    use crate::math::{Rgb, Vec3};
    use crate::scene::SceneDesc;

    fn finding(edit: impl FnOnce(&mut SceneDesc)) -> Option<Finding> {
        let mut desc = room();
        edit(&mut desc);
        check(&subject(&desc))
    }

    #[test]
    fn a_room_absorbs_its_photons() {
        assert_eq!(finding(|_| ()).unwrap().severity, Severity::Fine);
        assert_eq!(finding(|desc| desc.point_lights.clear()), None);
    }

    #[test]
    fn a_room_that_absorbs_nothing_is_told() {
        let white = finding(|desc| {
            desc.materials[WALL as usize].bsdf = Bsdf::Diffuse { albedo: Rgb::ONE };
            desc.render.photons = 50;
        });
        assert!(white.unwrap().found.contains("100.0 % of photons are under way"));
    }

    #[test]
    fn photons_that_fall_nowhere_are_told() {
        let mirrors = finding(|desc| {
            desc.materials[WALL as usize].bsdf = Bsdf::Mirror { reflectance: Rgb::splat(0.5) }
        });
        assert_eq!(mirrors.unwrap().severity, Severity::Warning);
        let outside = finding(|desc| desc.point_lights[0].position = Vec3::new(0.0, 3.0, 0.0));
        assert!(outside.unwrap().found.starts_with("none of 20000 photons"), "nothing bounces back to a box");
    }

    #[test]
    fn photons_that_leave_are_told() {
        let open = finding(|desc| {
            desc.meshes[0].triangles.truncate(4);
            desc.meshes[0].materials.truncate(4);
        });
        assert_eq!(open.as_ref().unwrap().severity, Severity::Note, "{open:?}");
    }

    #[test]
    fn power_that_overflows_is_told() {
        let bright = finding(|desc| desc.point_lights[0].intensity = Rgb::splat(1e38));
        assert!(bright.unwrap().found.contains("lost their power"));
    }
}
