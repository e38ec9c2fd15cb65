//! The gather radius: against the scene, the pixels, the photons and the grid of coordinates.

use super::places::shown;
use super::subject::Subject;
use super::{Check, Finding, Severity};
use crate::ppm::{RadiusPolicy, least_radius};

pub(super) fn check(subject: &Subject) -> Vec<Finding> {
    if subject.trial.hit_points.is_empty() {
        return Vec::new();
    }
    vec![first(subject), floor(subject)]
}

fn first(subject: &Subject) -> Finding {
    /// Shares of the scene, widths of pixels, photons in a disc.
    const LARGE: f64 = 0.1;
    const WIDE: f64 = 20.0;
    const FEW: f64 = 10.0;
    let radius = subject.trial.setup.radius;
    let pixels = radius / subject.footprint().unwrap_or(radius);
    let in_a_disc = photons_in_a_disc(subject);
    let origin = if subject.settings.radius.is_some() { "as asked for" } else { "found by the eye pass" };
    let found = format!(
        "{}, {origin}: {} pixels wide, {} photons in a disc and pass",
        shown(radius),
        shown(pixels),
        shown(in_a_disc)
    );
    let longest = f64::from(subject.scene.bounds().extent().max_element());
    let passes = f64::from(subject.desc.render.passes);
    if radius > LARGE * longest {
        let therefore =
            "blurs indirect light and caustics over more than a tenth of the scene, and gathers slowly";
        return Finding::new(Check::Radius, Severity::Warning, found, therefore);
    }
    if pixels > WIDE {
        let therefore = "blurs caustics over many pixels until radii have shrunk";
        return Finding::new(Check::Radius, Severity::Note, found, therefore);
    }
    if !subject.scene.lights().is_empty() && in_a_disc * passes < FEW {
        let therefore = format!(
            "finds about {} photons a disc in all {passes} passes: noise; take more photons or passes, or a larger radius",
            shown(in_a_disc * passes)
        );
        return Finding::new(Check::Radius, Severity::Note, found, therefore);
    }
    Finding::fine(Check::Radius, found)
}

/// In the first pass of the whole render, on average over what is seen.
fn photons_in_a_disc(subject: &Subject) -> f64 {
    let pass = &subject.trial.pass;
    let more = subject.settings.photons as f64 / pass.photons.emitted.max(1) as f64;
    more * pass.gathered as f64 / subject.trial.hit_points.len() as f64
}

fn floor(subject: &Subject) -> Finding {
    let floors = subject.trial.hit_points.iter().map(least_radius);
    let asked = subject.settings.radius.unwrap_or(subject.trial.setup.radius);
    let raised = floors.clone().filter(|&floor| floor >= asked).count();
    let largest = floors.fold(0.0, f64::max);
    if raised > 0 {
        let percent = 100.0 * raised as f64 / subject.trial.hit_points.len() as f64;
        let found = format!(
            "coordinates are too coarse for the radius at {percent:.0} % of what is seen: {} is the least",
            shown(largest)
        );
        let therefore = "raises those radii to the least, where they stay: fixed discs keep their blur";
        return Finding::new(Check::RadiusFloor, Severity::Warning, found, therefore);
    }
    let passes = passes_to(largest / asked, subject);
    let found = match passes {
        Some(passes) => {
            format!("the least radius is {}: reached after some {passes:.0e} passes", shown(largest))
        }
        None => format!("the least radius is {}, and radii do not shrink", shown(largest)),
    };
    match passes {
        Some(passes) if passes <= f64::from(subject.desc.render.passes) => {
            let therefore = "stops shrinking discs there: what blur is left stays";
            Finding::new(Check::RadiusFloor, Severity::Note, found, therefore)
        }
        _ => Finding::fine(Check::RadiusFloor, found),
    }
}

/// Passes after which a radius has shrunk to `share` of the first where photons fall in each: `R ~ passes^((α - 1) / 2)`.
fn passes_to(share: f64, subject: &Subject) -> Option<f64> {
    let alpha = subject.settings.alpha;
    let shrinks = alpha < 1.0 && subject.settings.policy != RadiusPolicy::Fixed;
    shrinks.then(|| share.powf(2.0 / (alpha - 1.0)))
}

#[cfg(test)]
mod tests {
    use super::super::subject::Subject;
    use super::super::testing::{moved, of, room, subject};
    use super::*;
    use crate::math::Vec3;
    use crate::ppm::Settings;
    use crate::scene::{SceneDesc, Traversal};

    fn findings(edit: impl FnOnce(&mut SceneDesc)) -> Vec<Finding> {
        let mut desc = room();
        edit(&mut desc);
        check(&subject(&desc))
    }

    fn radius(radius: Option<f64>) -> Finding {
        of(&findings(|desc| desc.render.radius = radius), Check::Radius).clone()
    }

    #[test]
    fn radii_are_held_against_scene_pixels_and_photons() {
        assert_eq!(radius(Some(0.05)).severity, Severity::Fine);
        let found = findings(|desc| {
            (desc.film.width, desc.film.height) = (96, 96);
            desc.render.radius = None;
        });
        let found = of(&found, Check::Radius);
        assert!(found.severity == Severity::Fine && found.found.contains(": 2.000 pixels wide"), "{found:?}");
        assert!(radius(Some(0.3)).therefore.contains("a tenth of the scene"));
        assert!(radius(Some(0.001)).therefore.contains("noise"), "{:?}", radius(Some(0.001)));
        let fine_pixels = findings(|desc| (desc.film.width, desc.film.height) = (2000, 2000));
        assert_eq!(of(&fine_pixels, Check::Radius).severity, Severity::Note);
    }

    /// The trial is smaller than the picture, and has fewer photons.
    #[test]
    fn the_trial_stands_for_the_picture() {
        let all = |width: u32, photons: u64| {
            let mut desc = room();
            (desc.film.width, desc.film.height, desc.render.photons) = (width, width, photons);
            let subject = subject(&desc);
            (subject.footprint().unwrap(), photons_in_a_disc(&subject))
        };
        let ((width, disc), (finer, more)) = (all(96, 20_000), all(960, 200_000));
        assert!((width / finer / 10.0 - 1.0).abs() < 0.02, "{width} against {finer}");
        assert!((more / disc / 10.0 - 1.0).abs() < 0.02, "{disc} against {more}");
    }

    #[test]
    fn radii_are_held_against_the_grid() {
        let floor = |radius: f64, passes: u32, shift: f32| {
            let mut desc = room();
            (desc.render.radius, desc.render.passes) = (Some(radius), passes);
            let desc = moved(desc, 1.0, Vec3::splat(shift));
            of(&check(&subject(&desc)), Check::RadiusFloor).severity
        };
        assert_eq!(floor(0.05, 4, 0.0), Severity::Fine);
        assert_eq!(floor(0.001, 4, 1e4), Severity::Warning);
        assert_eq!(floor(0.01, 4, 1e4), Severity::Fine);
        assert_eq!(floor(0.01, 4000, 1e4), Severity::Note);
    }

    #[test]
    fn discs_of_fixed_size_never_reach_it() {
        let desc = room();
        let settings = Settings { policy: RadiusPolicy::Fixed, ..Settings::of_scene(&desc.render) };
        let subject = Subject::new(&desc, settings, Traversal::Custom).unwrap();
        assert!(of(&check(&subject), Check::RadiusFloor).found.contains("do not shrink"));
    }
}
