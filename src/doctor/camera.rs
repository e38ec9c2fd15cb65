//! Where the camera is, and what it sees.

use super::bodies::Enclosures;
use super::duplicates::has_an_inside;
use super::places::first_of;
use super::subject::Subject;
use super::{Check, Finding, Severity};
use crate::math::{Ray, Vec2, Vec3};

pub(super) fn check(subject: &Subject) -> Vec<Finding> {
    vec![place(subject), view(subject), depth(subject)]
}

/// First hits of rays through the middles of a grid of cells that covers the picture.
struct Glance {
    rays: usize,
    misses: usize,
    /// Whether a surface is nearer than the error of its points.
    touches: bool,
}

fn glance(subject: &Subject) -> Glance {
    const CELLS: u16 = 32;
    let film = subject.scene.film();
    let size = Vec2::new(film.width as f32, film.height as f32) / f32::from(CELLS);
    let mut glance = Glance { rays: 0, misses: 0, touches: false };
    for cell in 0..CELLS * CELLS {
        let corner = Vec2::new(f32::from(cell % CELLS), f32::from(cell / CELLS));
        let ray = subject.scene.camera().ray((corner + 0.5) * size);
        glance.rays += 1;
        match subject.scene.intersect(&ray) {
            None => glance.misses += 1,
            Some(hit) => glance.touches |= (hit.p - ray.origin).dot(hit.ng).abs() <= hit.p_error,
        }
    }
    glance
}

fn place(subject: &Subject) -> Finding {
    let position = subject.scene.camera().position();
    if glance(subject).touches {
        let therefore = "sees that surface or what is behind it, pixel by pixel as rounding will have it; move the camera off";
        return Finding::new(Check::Camera, Severity::Warning, "the pinhole lies on a surface", therefore);
    }
    if lens_is_cut(subject) {
        let therefore = "sees with a part of its lens what is behind that surface; make lens_radius smaller or move the camera off";
        return Finding::new(
            Check::Camera,
            Severity::Warning,
            "the lens reaches through a surface",
            therefore,
        );
    }
    match glass_around(subject, position).as_slice() {
        [] => Finding::fine(Check::Camera, format!("at {position}, on no surface and in no glass")),
        glass => {
            let found = format!("the camera is inside {}", first_of(glass.iter().cloned()));
            Finding::new(
                Check::Camera,
                Severity::Note,
                found,
                "sees the world through its surface, from within",
            )
        }
    }
}

/// Whether a surface stands between the middle of the lens and its rim.
fn lens_is_cut(subject: &Subject) -> bool {
    const RIM: u16 = 64;
    let camera = subject.scene.camera();
    let origin = camera.position();
    let cut = |k| {
        let along_edge = f32::from(k % (RIM / 2)) / f32::from(RIM / 2);
        let u = if k < RIM / 2 { Vec2::new(along_edge, 0.0) } else { Vec2::new(0.0, along_edge) };
        // The square's edges are the rim; opposite points look along both ways.
        [u, Vec2::ONE - u].into_iter().any(|u| {
            let dir = camera.point_of_lens(u) - origin;
            subject.scene.occluded(&Ray { origin, dir, t_max: 1.0 })
        })
    };
    camera.has_lens() && (0..RIM).any(cut)
}

fn glass_around(subject: &Subject, p: Vec3) -> Vec<String> {
    let materials = Enclosures::of(subject.desc, &subject.bodies, p).materials(subject.desc, &subject.bodies);
    let of_number = |m: u32| &subject.desc.materials[m as usize];
    let glass = materials.into_iter().map(of_number).filter(|material| has_an_inside(&material.bsdf));
    glass.map(|material| format!("`{}`", material.name)).collect()
}

fn view(subject: &Subject) -> Finding {
    let Glance { rays, misses, .. } = glance(subject);
    let trial = &subject.trial;
    let percent = 100.0 * misses as f64 / rays as f64;
    if misses == rays && trial.hit_points.is_empty() && !trial.has_direct_light {
        let found = format!("all of {rays} eye rays miss every surface");
        return Finding::new(Check::View, Severity::Fault, found, "makes a black picture");
    }
    if trial.hit_points.is_empty() && !trial.has_direct_light {
        let found = "no diffuse surface and no lamp is seen, in mirrors and through glass neither";
        return Finding::new(Check::View, Severity::Fault, found, "has no hit point: the picture is black");
    }
    if !subject.scene.lights().is_empty() && !trial.has_direct_light && trial.pass.gathered == 0 {
        let found = format!(
            "no direct light and none of {} photons reached what is seen",
            trial.pass.photons.emitted
        );
        return Finding::new(
            Check::View,
            Severity::Warning,
            found,
            "makes a picture that is black, or nearly so",
        );
    }
    match (misses, subject.scene.lights().environment()) {
        (0, _) => Finding::fine(Check::View, "surfaces fill the picture, and light reaches them"),
        (_, Some(_)) => Finding::fine(Check::View, format!("{percent:.1} % of the picture shows the sky")),
        (_, None) => {
            let found = format!("{percent:.1} % of the picture shows no surface");
            Finding::new(Check::View, Severity::Note, found, "leaves it black there: there is no sky")
        }
    }
}

fn depth(subject: &Subject) -> Finding {
    const MUCH: f64 = 0.001;
    let (cut, depth) = (subject.trial.setup.cut_weight, subject.settings.depth);
    let found = format!("depth {depth} cuts {:.3} % of the picture's weight", 100.0 * cut);
    if cut > MUCH {
        let therefore =
            "leaves dark what is seen through longer chains of mirrors and glass; raise the depth";
        return Finding::new(Check::Depth, Severity::Note, found, therefore);
    }
    Finding::fine(Check::Depth, found)
}

#[cfg(test)]
mod tests {
    use super::super::testing::{GLASS, ceiling, cube, of, room, severity, subject};
    use super::*;
    use crate::bsdf::Bsdf;
    use crate::math::Rgb;
    use crate::scene::{LightDesc, SceneDesc};

    fn findings(edit: impl FnOnce(&mut SceneDesc)) -> Vec<Finding> {
        let mut desc = room();
        edit(&mut desc);
        check(&subject(&desc))
    }

    #[test]
    fn a_camera_in_a_room_is_fine() {
        let findings = findings(|_| ());
        assert!(findings.iter().all(|f| f.severity == Severity::Fine), "{findings:?}");
    }

    #[test]
    fn a_pinhole_on_a_surface_is_told() {
        let at = |z: f32| {
            let sheet = ceiling("sheet", Vec3::new(-0.5, 0.0, -0.5), 1.0, 0);
            let upright = |p: Vec3| Vec3::new(p.x, p.z, z);
            let findings = findings(|desc| {
                let mut sheet = sheet;
                sheet.vertices.iter_mut().for_each(|p| *p = upright(*p));
                desc.meshes.push(sheet);
            });
            severity(&findings, Check::Camera)
        };
        assert_eq!((at(0.9 - 1e-6), at(0.9 - 1e-4)), (Severity::Warning, Severity::Fine));
    }

    #[test]
    fn a_lens_that_reaches_through_a_wall_is_told() {
        let of_radius = |radius: f32| {
            let findings = findings(|desc| {
                desc.camera.lens_radius = radius;
            });
            (severity(&findings, Check::Camera), of(&findings, Check::Camera).found.contains("lens"))
        };
        assert_eq!(
            [0.0, 0.2, 1.5].map(of_radius),
            [(Severity::Fine, false), (Severity::Fine, false), (Severity::Warning, true)]
        );
    }

    #[test]
    fn a_camera_in_glass_is_told() {
        let in_ball = findings(|desc| {
            desc.spheres[0].center = desc.camera.position;
            desc.spheres[0].radius = 0.05;
        });
        let in_box = findings(|desc| desc.meshes.push(cube("box", desc.camera.position, 0.05, GLASS)));
        for findings in [in_ball, in_box] {
            assert!(of(&findings, Check::Camera).found.contains("inside `glass`"), "{findings:?}");
        }
    }

    #[test]
    fn a_camera_that_sees_nothing_is_a_fault() {
        let away = findings(|desc| {
            desc.camera.position = Vec3::new(0.0, 0.0, 5.0);
            desc.camera.look_at = Vec3::new(0.0, 0.0, 9.0);
        });
        assert_eq!(severity(&away, Check::View), Severity::Fault);
        assert!(of(&away, Check::View).found.contains("miss every surface"));
        let mirrors = findings(|desc| desc.materials[0].bsdf = Bsdf::Mirror { reflectance: Rgb::ONE });
        assert!(of(&mirrors, Check::View).found.contains("no diffuse surface"), "{mirrors:?}");
    }

    #[test]
    fn a_light_that_cannot_reach_the_view_is_told() {
        let findings = findings(|desc| {
            let around = cube("cover", desc.point_lights[0].position, 0.1, 0);
            desc.meshes.push(around);
        });
        assert_eq!(severity(&findings, Check::View), Severity::Warning);
    }

    #[test]
    fn a_part_of_the_picture_may_be_empty() {
        let findings = findings(|desc| {
            desc.camera.position = Vec3::new(0.0, 0.0, 5.0);
            desc.camera.fov_degrees = 60.0;
            desc.point_lights[0].position = Vec3::new(0.0, 0.0, 4.0);
        });
        assert_eq!(severity(&findings, Check::View), Severity::Note);
    }

    #[test]
    fn a_sky_is_not_black() {
        let findings = findings(|desc| {
            desc.camera.position = Vec3::new(0.0, 0.0, 5.0);
            desc.camera.fov_degrees = 60.0;
            desc.further_lights.push(LightDesc::Sky(Rgb::ONE));
        });
        assert_eq!(severity(&findings, Check::View), Severity::Fine);
        assert!(of(&findings, Check::View).found.contains("sky"), "{findings:?}");
    }

    #[test]
    fn a_depth_that_cuts_is_told() {
        let findings = findings(|desc| {
            desc.render.depth = 0;
            desc.spheres[0].center.z = 0.2;
        });
        assert_eq!(severity(&findings, Check::Depth), Severity::Note, "{findings:?}");
    }
}
