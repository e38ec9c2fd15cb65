//! What shines, whether it can shine where it is, and how many photons it gets.

use super::bodies::Enclosures;
use super::duplicates::has_an_inside;
use super::places::{self, Place, counted, first_of, position_error, shown};
use super::subject::Subject;
use super::{Check, Finding, Severity};
use crate::light::Light;
use crate::math::{Aabb, Ray, Rgb, Rng, Stream, Vec3, mean, warp};
use crate::scene::{Material, PointLightDesc, SceneDesc};

/// Point lights and lamps that are looked at one by one, at most.
const LOOKED_AT: usize = 256;

pub(super) fn check(subject: &Subject) -> Vec<Finding> {
    let power = power(subject);
    if power.severity == Severity::Fault {
        return vec![power];
    }
    let dark = dark(subject.desc);
    let mut findings = vec![power];
    findings.extend(dark);
    findings.extend(light_places(subject));
    findings.push(lamp_places(subject));
    findings.push(shares(subject));
    findings
}

fn power(subject: &Subject) -> Finding {
    let lights = subject.scene.lights();
    let (flux, points) = (lights.flux(), lights.iter().filter(|light| light.is_delta()).count());
    if lights.is_empty() {
        return Finding::new(Check::Lights, Severity::Fault, "nothing shines", "makes a black picture");
    }
    let found = format!(
        "{} and {}, {} W in all",
        counted(points, "light") + " without extent",
        counted(lights.len() - points, "light") + " with one",
        shown(mean(flux))
    );
    if !flux.is_finite() {
        let therefore = "cannot share its photons: their power is not finite, and they are dropped";
        return Finding::new(Check::Lights, Severity::Fault, found, therefore);
    }
    Finding::fine(Check::Lights, found)
}

/// Lights that are none: [`crate::light::Lights`] leaves them out.
fn dark(desc: &SceneDesc) -> Option<Finding> {
    let points = desc.point_lights.iter().zip(1..).filter(|(light, _)| mean(light.intensity) == 0.0);
    let names: Vec<String> = points.map(|(_, number)| format!("point_light {number}")).collect();
    (!names.is_empty()).then(|| {
        let found =
            format!("{} without power: {}", counted(names.len(), "light"), first_of(names.into_iter()));
        Finding::new(Check::Lights, Severity::Note, found, "leaves them out")
    })
}

fn light_places(subject: &Subject) -> Vec<Finding> {
    let lit = subject.desc.point_lights.iter().zip(1..).filter(|(light, _)| mean(light.intensity) > 0.0);
    let mut findings: Vec<Finding> =
        lit.take(LOOKED_AT).filter_map(|(light, number)| light_place(subject, light, number)).collect();
    if findings.is_empty() {
        findings.push(Finding::fine(Check::LightPlaces, "no point light is inside or on a surface"));
    }
    findings
}

fn light_place(subject: &Subject, light: &PointLightDesc, number: usize) -> Option<Finding> {
    let name = format!("point_light {number}");
    let finding = |severity, found: String, therefore: &str| {
        Some(Finding::new(Check::LightPlaces, severity, found, therefore))
    };
    if let Some(material) = touched(subject, light.position) {
        let material = &subject.desc.materials[material as usize].name;
        let found = format!("{name} lies on a surface of `{material}`");
        return finding(
            Severity::Warning,
            found,
            "sends its photons to one side or the other by rounding; move it off",
        );
    }
    if reaches(subject, light) {
        return None;
    }
    let around = |p: Vec3| Enclosures::of(subject.desc, &subject.bodies, p);
    let here = around(light.position);
    if let Some(glass) = materials(subject, &here, true) {
        let found = format!("{name} is inside {glass}");
        let therefore =
            "takes it for opaque in shadow rays: all of its light comes as photons, direct light too";
        return finding(Severity::Note, found, therefore);
    }
    // The camera may be in the same room.
    let apart = here.without(&around(subject.desc.camera.position));
    if let Some(opaque) = materials(subject, &apart, false) {
        let found = format!("{name} is inside {opaque}, and nothing that is seen sees it");
        return finding(
            Severity::Warning,
            found,
            "shows none of its light outside, but spends photons on it",
        );
    }
    let found = format!("{name} is seen from no hit point of the trial");
    finding(Severity::Note, found, "shows its light only as photons that bounced or were refracted")
}

/// The names of the materials around that are glass or masks, or that are not; `None` where there are none.
fn materials(subject: &Subject, around: &Enclosures, glass: bool) -> Option<String> {
    let materials = around.materials(subject.desc, &subject.bodies).into_iter();
    let names: Vec<String> = materials
        .map(|number| &subject.desc.materials[number as usize])
        .filter(|material| lets_photons_on(material) == glass)
        .map(|material| format!("`{}`", material.name))
        .collect();
    (!names.is_empty()).then(|| first_of(names.into_iter()))
}

/// The material of a surface so near to `p` that rounding decides on which side of it `p` is.
fn touched(subject: &Subject, p: Vec3) -> Option<u32> {
    const DIRECTIONS: u64 = 64;
    const ERRORS: f32 = 1.0;
    let Aabb { min, max } = subject.scene.bounds();
    let error = position_error([p; 3]);
    let most = position_error([p, min, max]);
    let ball =
        subject.desc.spheres.iter().find(|s| {
            (s.center.distance(p) - s.radius).abs() <= position_error([s.center.abs() + s.radius; 3])
        });
    if let Some(ball) = ball {
        return Some(ball.material);
    }
    (0..DIRECTIONS).find_map(|index| {
        let mut rng = Rng::new(0, Stream::Probe, 0, index);
        let dir = warp::square_to_uniform_sphere(rng.next_vec2());
        // From a little behind, so that a surface on which `p` lies is met.
        let back = 4.0 * most * dir;
        let hit = subject.scene.intersect(&Ray::new(p - back, dir))?;
        ((hit.p - p).dot(hit.ng).abs() <= ERRORS * error.max(hit.p_error)).then_some(hit.material)
    })
}

/// Whether any point that the trial's camera sees gets light straight from it.
fn reaches(subject: &Subject, light: &PointLightDesc) -> bool {
    let light = Light::Point { position: light.position, intensity: light.intensity };
    subject.trial.hit_points.iter().any(|hit_point| {
        light.illuminate(hit_point.receiver.p, Default::default()).is_some_and(|sample| {
            subject.scene.arriving(&hit_point.receiver, &sample).irradiance != Rgb::ZERO
        })
    })
}

fn lamp_places(subject: &Subject) -> Finding {
    let shines = |place: &Place| place.material(subject.desc).emission != Rgb::ZERO;
    let hidden: Vec<Place> = places::all(subject.desc)
        .filter(shines)
        .take(LOOKED_AT)
        .filter(|&place| is_hidden(subject, place))
        .collect();
    if hidden.is_empty() {
        return Finding::fine(Check::LampPlaces, "no lamp shines straight into a surface");
    }
    let found = format!(
        "{} with a surface right before them: {}",
        counted(hidden.len(), "lamp triangle"),
        places::first(subject.desc, &hidden)
    );
    let therefore = "lights that surface alone by them; turn them round or move them off";
    Finding::new(Check::LampPlaces, Severity::Warning, found, therefore)
}

/// Whether a surface stands before the middle of a lamp, nearer than a hundredth of the lamp's size, or just where it is.
fn is_hidden(subject: &Subject, place: Place) -> bool {
    const NEAR: f32 = 0.01;
    let corners = place.corners(subject.desc);
    let [a, b, c] = corners;
    let cross = (b - a).as_dvec3().cross((c - a).as_dvec3());
    let Some(ng) = cross.try_normalize().map(|n| n.as_vec3()) else { return false };
    let size = (0.5 * cross.length()).sqrt() as f32;
    let error = position_error(corners);
    let middle = (a + b + c) / 3.0;
    let gap = (NEAR * size).max(4.0 * error);
    let before = Ray { t_max: gap, ..Ray::new(middle + 2.0 * error * ng, ng) };
    let back = Ray { t_max: 2.0 * gap, ..Ray::new(middle + gap * ng, -ng) };
    let own = place.material_number(subject.desc);
    [before, back].iter().any(|ray| {
        let hit = subject.scene.intersect(ray).filter(|hit| hit.material != own);
        hit.is_some_and(|hit| !lets_photons_on(&subject.desc.materials[hit.material as usize]))
    })
}

/// Whether photons go on through it: glass, or a mask.
fn lets_photons_on(material: &Material) -> bool {
    material.is_mask() || has_an_inside(&material.bsdf)
}

/// Photons go to lights in proportion to their flux.
fn shares(subject: &Subject) -> Finding {
    let lights = subject.scene.lights();
    let all = f64::from(mean(lights.flux()));
    let photons = subject.settings.photons as f64;
    let weakest = lights
        .iter()
        .filter(|light| light.is_delta())
        .map(|light| f64::from(mean(light.flux())) / all)
        .fold(f64::INFINITY, f64::min);
    let share = weakest * photons;
    if share < 1.0 {
        let found =
            format!("the weakest point light gets {} of the {photons} photons of a pass", shown(share));
        let therefore = "shows of its indirect light rare bright spots alone, unless photons are many more";
        return Finding::new(Check::LightShares, Severity::Note, found, therefore);
    }
    Finding::fine(Check::LightShares, "every point light gets photons in each pass")
}

#[cfg(test)]
mod tests {
    use super::super::testing::{
        GLASS, LAMP, WALL, ceiling, cube, of, room, severity, subject, with_material,
    };
    use super::*;
    use crate::scene::SphereDesc;

    fn findings(desc: &SceneDesc) -> Vec<Finding> {
        check(&subject(desc))
    }

    #[test]
    fn a_light_in_a_room_is_fine() {
        let findings = findings(&room());
        assert!(findings.iter().all(|f| f.severity == Severity::Fine), "{findings:?}");
    }

    #[test]
    fn darkness_is_a_fault_and_a_dark_light_a_note() {
        let mut desc = room();
        desc.point_lights.push(PointLightDesc { position: Vec3::ZERO, intensity: Rgb::ZERO });
        assert!(findings(&desc)[1].found.contains("1 light without power: point_light 2"));
        desc.point_lights.remove(0);
        assert_eq!(severity(&findings(&desc), Check::Lights), Severity::Fault);
    }

    #[test]
    fn power_that_overflows_is_a_fault() {
        let mut desc = room();
        desc.point_lights[0].intensity = Rgb::splat(1e38);
        let findings = findings(&desc);
        assert_eq!(severity(&findings, Check::Lights), Severity::Fault);
        assert!(subject(&desc).trial.pass.photons.dropped > 0, "photons are dropped indeed");
    }

    /// The same in a ball and in a box of triangles.
    #[test]
    fn lights_inside_of_things_are_told_by_what_is_around() {
        let place = |material: u32, severity, words: &str| {
            let mut in_ball = room();
            let center = in_ball.point_lights[0].position;
            in_ball.spheres.push(SphereDesc { center, radius: 0.2, material });
            let mut in_box = room();
            in_box.meshes.push(cube("box", center, 0.2, material));
            for desc in [in_ball, in_box] {
                let findings = findings(&desc);
                let finding = of(&findings, Check::LightPlaces);
                assert_eq!(finding.severity, severity, "{finding:?}");
                assert!(finding.found.contains(words), "{finding:?}");
            }
        };
        place(GLASS, Severity::Note, "point_light 1 is inside `glass`");
        place(WALL, Severity::Warning, "point_light 1 is inside `wall`, and nothing");
    }

    #[test]
    fn lights_on_surfaces_are_told() {
        let at = |position: Vec3| {
            let mut desc = room();
            desc.point_lights[0].position = position;
            of(&findings(&desc), Check::LightPlaces).clone()
        };
        let on_wall = at(Vec3::new(0.2, 1.0, 0.1));
        assert_eq!(on_wall.severity, Severity::Warning, "{on_wall:?}");
        assert!(on_wall.found.contains("on a surface of `wall`"), "{on_wall:?}");
        assert_eq!(at(Vec3::new(0.2, 0.999, 0.1)).severity, Severity::Fine);
        let on_ball = at(Vec3::new(-0.4, -0.3, -0.3));
        assert!(on_ball.found.contains("on a surface of `glass`"), "{on_ball:?}");
    }

    #[test]
    fn lamps_that_shine_into_walls_are_told() {
        let lamp = |y: f32, turned: bool| {
            let mut desc = room();
            let mut mesh = ceiling("lamp", Vec3::new(-0.2, y, -0.2), 0.4, LAMP);
            if turned {
                mesh.triangles.iter_mut().for_each(|corners| corners.reverse());
            }
            desc.meshes.push(mesh);
            severity(&findings(&desc), Check::LampPlaces)
        };
        assert_eq!((lamp(0.9, false), lamp(0.9, true)), (Severity::Fine, Severity::Fine));
        assert_eq!((lamp(0.999, false), lamp(0.999, true)), (Severity::Fine, Severity::Warning));
        let mut desc = room();
        desc.meshes.push(with_material(cube("cover", Vec3::new(0.0, 0.9, 0.0), 0.3, WALL), WALL));
        desc.meshes.push(ceiling("lamp", Vec3::new(-0.2, 0.601, -0.2), 0.4, LAMP));
        assert_eq!(severity(&findings(&desc), Check::LampPlaces), Severity::Warning, "inside of a cover");
        desc.meshes[1].materials.fill(GLASS);
        assert_eq!(severity(&findings(&desc), Check::LampPlaces), Severity::Fine, "under glass");
    }

    #[test]
    fn a_light_that_gets_no_photon_is_told() {
        let mut desc = room();
        desc.point_lights
            .push(PointLightDesc { position: Vec3::new(0.5, 0.5, 0.5), intensity: Rgb::splat(1e-7) });
        let findings = findings(&desc);
        assert_eq!(severity(&findings, Check::LightShares), Severity::Note, "{findings:?}");
    }
}
