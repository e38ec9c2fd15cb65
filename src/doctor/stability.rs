//! Whether this build, on this machine, renders scenes of its own as it must.

use rayon::ThreadPoolBuilder;

use super::specimens::{Specimen, bare, specimens};
use super::{Check, Diagnosis, Finding, Severity};
use crate::film::Image;
use crate::math::{Ray, Rng, Stream, Vec3};
use crate::ppm::{Ledger, Render, Settings};
use crate::scene::{Mesh, Scene, SceneDesc, Traversal, TraversalError};

/// Both ways of tracing rays that promise to let none through between triangles.
const TRAVERSALS: [Traversal; 2] = [Traversal::Embree, Traversal::Custom];

/// Powers of two, by which nothing but exponents changes.
const SCALES: [i32; 2] = [-13, 20];

/// Why the program cannot be examined.
#[derive(Debug, thiserror::Error)]
pub enum StabilityError {
    /// The ray tracer refuses a scene.
    #[error(transparent)]
    Traversal(#[from] TraversalError),
    /// The system gives no threads.
    #[error("cannot start threads: {reason}")]
    Threads {
        /// What it says.
        reason: String,
    },
}

/// Renders the built-in scenes, each in several ways.
///
/// # Errors
/// If there are no threads to be had, or a ray tracer does not start.
pub fn stability() -> Result<Diagnosis, StabilityError> {
    let mut findings = vec![seal(&bare())?];
    for specimen in specimens() {
        findings.push(examine(&specimen)?);
    }
    Ok(Diagnosis { subject: "built-in scenes".into(), findings })
}

fn finding(name: &str, holds: &str, faults: &[String]) -> Finding {
    if faults.is_empty() {
        return Finding::fine(Check::Stability, format!("{name}: {holds}"));
    }
    let found = format!("{name}: {}", faults.join("; "));
    let therefore = "is not to be trusted on this machine, or with this build or Embree: please report it";
    Finding::new(Check::Stability, Severity::Fault, found, therefore)
}

/// A render of a built-in scene.
struct Rendered {
    picture: Image,
    ledger: Ledger,
}

fn rendered(desc: &SceneDesc, traversal: Traversal) -> Result<Rendered, TraversalError> {
    let scene = Scene::with_traversal(desc.clone(), traversal)?;
    let mut render = Render::new(&scene, Settings::of_scene(&desc.render));
    let mut ledger = Ledger::default();
    for _ in 0..desc.render.passes {
        ledger = ledger.plus(render.pass().photons);
    }
    Ok(Rendered { picture: render.picture(), ledger })
}

fn rendered_by(desc: &SceneDesc, traversal: Traversal, threads: usize) -> Result<Rendered, StabilityError> {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|error| StabilityError::Threads { reason: error.to_string() })?;
    Ok(pool.install(|| rendered(desc, traversal))?)
}

fn examine(specimen: &Specimen) -> Result<Finding, StabilityError> {
    let mut faults = Vec::new();
    let mut pictures = Vec::new();
    for traversal in TRAVERSALS {
        let one = rendered_by(&specimen.desc, traversal, 1)?;
        let told = |fault: String| format!("{fault} by {traversal}");
        faults.extend(faults_of(specimen, &one).into_iter().map(told));
        if rendered_by(&specimen.desc, traversal, 2)?.picture != one.picture {
            faults.push(format!("two threads make another picture than one by {traversal}"));
        }
        for exponent in SCALES {
            let mut scaled = specimen.desc.clone();
            scaled.place(2f32.powi(exponent), Vec3::ZERO);
            if rendered(&scaled, traversal)?.picture != one.picture {
                faults.push(format!("another picture at 2^{exponent} times its size by {traversal}"));
            }
        }
        pictures.push(one.picture);
    }
    let agree = if specimen.is_chaotic { agree_on_average } else { agree };
    if !pictures.windows(2).all(|pair| agree(&pair[0], &pair[1])) {
        faults.push(String::from("Embree and custom make different pictures"));
    }
    let holds = "finite, photons balanced, none escaped; the same by 1 and 2 threads, at 2^-13 and 2^20 times its size, by Embree \
        and custom";
    Ok(finding(specimen.name, holds, &faults))
}

fn faults_of(specimen: &Specimen, Rendered { picture, ledger }: &Rendered) -> Vec<String> {
    let odd = picture.pixels().iter().filter(|p| !p.is_finite() || p.min_element() < 0.0).count();
    let is_lit = picture.pixels().iter().any(|p| p.max_element() > 0.0);
    let escaped = if specimen.is_closed { ledger.escaped } else { 0 };
    let faults = [
        (odd > 0, format!("{odd} pixels are negative or not finite")),
        (!ledger.is_balanced(), format!("photons are not accounted for: {ledger:?}")),
        (escaped > 0, format!("{escaped} of {} photons escaped", ledger.emitted)),
        (is_lit && !specimen.is_lit, String::from("light out of nothing")),
        (!is_lit && specimen.is_lit, String::from("no light")),
    ];
    faults.into_iter().filter(|(is_fault, _)| *is_fault).map(|(_, fault)| fault).collect()
}

/// Of the brightness of the whole picture.
const TOLERANCE: f64 = 0.02;

fn brightness<'a>(pixels: impl IntoIterator<Item = &'a Vec3>) -> f64 {
    pixels.into_iter().map(|pixel| f64::from(pixel.element_sum())).sum()
}

/// Whether nearly all paths are the same: a few may graze an edge and part.
fn agree(a: &Image, b: &Image) -> bool {
    let differences: Vec<Vec3> = a.pixels().iter().zip(b.pixels()).map(|(a, b)| (*a - *b).abs()).collect();
    brightness(&differences) <= TOLERANCE * brightness(a.pixels())
}

/// Whether as much light is seen.
fn agree_on_average(a: &Image, b: &Image) -> bool {
    let (a, b) = (brightness(a.pixels()), brightness(b.pixels()));
    (a - b).abs() <= TOLERANCE * a
}

/// Rays from within the cube from -1 to 1 that `desc` holds, to points on its edges and to its corners, where they are most
/// likely to slip out.
fn seal(desc: &SceneDesc) -> Result<Finding, StabilityError> {
    const RAYS: u64 = 20_000;
    let name = "a sealed cube";
    let Mesh { vertices: corners, triangles: faces, .. } = Mesh::inward_cube(name, 0);
    let mut faults = Vec::new();
    for traversal in TRAVERSALS {
        let scene = Scene::with_traversal(desc.clone(), traversal)?;
        let escapes = |&index: &u64| {
            let mut rng = Rng::new(0, Stream::Probe, 0, index);
            let [a, b, _] = faces[index as usize % faces.len()].map(|corner| corners[corner as usize]);
            let along = if index % 2 == 0 { 0.0 } else { rng.next_f32() };
            let origin = 1.6 * Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32()) - 0.8;
            scene.distance(&Ray::new(origin, a.lerp(b, along) - origin)).is_none()
        };
        let leaks = (0..RAYS).filter(escapes).count();
        if leaks > 0 {
            faults.push(format!("{leaks} of {RAYS} rays slip out between triangles by {traversal}"));
        }
    }
    Ok(finding(name, "no ray slips out at its edges and corners, by Embree and custom", &faults))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Rgb;

    #[test]
    fn this_build_is_sound() {
        let diagnosis = stability().unwrap();
        assert_eq!(diagnosis.severity(), Severity::Fine, "{}", diagnosis.table().to_text());
        assert_eq!(diagnosis.findings.len(), 1 + specimens().len());
    }

    #[test]
    fn what_must_hold_is_seen_where_it_does_not() {
        let specimen = specimens().swap_remove(0);
        let sound = || rendered(&specimen.desc, Traversal::Custom).unwrap();
        assert!(faults_of(&specimen, &sound()).is_empty());
        let faults = |edit: &dyn Fn(&mut Rendered)| {
            let mut broken = sound();
            edit(&mut broken);
            faults_of(&specimen, &broken).join("; ")
        };
        assert_eq!(
            faults(&|r| r.picture.pixels_mut()[3].y = f32::NAN),
            "1 pixels are negative or not finite"
        );
        assert_eq!(faults(&|r| r.picture.pixels_mut()[3].y = -1.0), "1 pixels are negative or not finite");
        assert_eq!(faults(&|r| r.picture.pixels_mut().fill(Rgb::ZERO)), "no light");
        assert!(faults(&|r| r.ledger.emitted += 1).starts_with("photons are not accounted for"));
        let one_escaped =
            |r: &mut Rendered| (r.ledger.escaped, r.ledger.absorbed) = (1, r.ledger.absorbed - 1);
        assert_eq!(faults(&one_escaped), "1 of 20000 photons escaped");
        let dark = Specimen { is_lit: false, ..specimens().swap_remove(0) };
        assert_eq!(faults_of(&dark, &sound()), ["light out of nothing"]);
    }

    #[test]
    fn an_open_box_is_not_taken_for_sealed() {
        let mut specimen = specimens().swap_remove(0);
        specimen.desc.meshes[0].triangles.remove(0);
        specimen.desc.meshes[0].materials.remove(0);
        let finding = examine(&specimen).unwrap();
        assert_eq!(finding.severity, Severity::Fault);
        assert!(finding.found.contains("photons escaped by embree"), "{finding:?}");
        let leaks = seal(&specimen.desc).unwrap();
        assert!(leaks.found.contains("slip out between triangles by custom"), "{leaks:?}");
    }

    #[test]
    fn pictures_agree_up_to_a_few_paths() {
        let image = |brightness: f32| Image::from_pixels(10, 10, vec![Rgb::splat(brightness); 100]).unwrap();
        let mut near = image(1.0);
        near.pixels_mut()[7] = Rgb::splat(2.0);
        assert!(agree(&image(1.0), &near) && agree(&image(0.0), &image(0.0)));
        assert!(!agree(&image(1.0), &image(1.03)) && !agree_on_average(&image(1.0), &image(1.03)));
        let mut elsewhere = image(1.0);
        elsewhere.pixels_mut()[..50].fill(Rgb::splat(1.5));
        elsewhere.pixels_mut()[50..].fill(Rgb::splat(0.5));
        assert!(!agree(&image(1.0), &elsewhere) && agree_on_average(&image(1.0), &elsewhere));
    }
}
