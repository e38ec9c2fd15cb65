use super::error::CliError;
use crate::effects::{Effect, EyePaths, declare};
use crate::input;
use crate::ppm::Settings;
use crate::scene::{FilmDesc, SceneDesc};
use crate::shard::Sums;

/// The most memory that the process ever held, in bytes; `None` where the system does not tell.
pub fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}

/// Bytes of a pixel in pictures and their statistics, about.
const OF_PIXEL: u64 = 50;
/// Bytes of a hit point and its place in the tree while both are made, about; every eye sample leaves one where it sees no mirrors.
const OF_EYE_SAMPLE: u64 = 230;
/// What eye paths that are retraced take beyond those of a pixel, which keeps statistics and lists of its own.
const OF_RETRACED_PIXEL: u64 = 100;
/// And beyond those of an eye sample, while the points of two passes are there.
const OF_RETRACED_SAMPLE: u64 = 60;
/// Bytes of the records that a photon leaves in a pass, about.
const OF_PHOTON: u64 = 100;

/// Refuses a render by photon mapping that this machine has not the memory for, before any is taken.
pub fn check_render(desc: &SceneDesc, settings: &Settings) -> Result<(), CliError> {
    check(of_render(desc, settings), &told(&desc.film, settings), LESS)
}

const LESS: &str = "fewer pixels (--size), samples or photons";

fn of_render(desc: &SceneDesc, settings: &Settings) -> u64 {
    let (of_pixel, of_sample) = match retraces(desc, settings) {
        true => (OF_PIXEL + OF_RETRACED_PIXEL, OF_EYE_SAMPLE + OF_RETRACED_SAMPLE),
        false => (OF_PIXEL, OF_EYE_SAMPLE),
    };
    let of_eye = pixels(&desc.film).saturating_mul(of_pixel + of_sample * u64::from(settings.samples));
    of_eye.saturating_add(settings.photons.saturating_mul(OF_PHOTON))
}

/// Whether every pass is to trace other eye paths: as the plan finds it when the scene is built, but for rough materials that nothing
/// is made of.
fn retraces(desc: &SceneDesc, settings: &Settings) -> bool {
    let is_called_for = || {
        declare::of_camera(&desc.camera).contains(Effect::Lens)
            || declare::of_film(&desc.film).contains(Effect::AreaFilter)
            || desc.materials.iter().any(|material| declare::of_material(material).contains(Effect::Glossy))
    };
    settings.eye_paths.map_or_else(is_called_for, |asked| asked == EyePaths::Retraced)
}

fn pixels(film: &FilmDesc) -> u64 {
    u64::from(film.width) * u64::from(film.height)
}

fn told(film: &FilmDesc, settings: &Settings) -> String {
    format!(
        "{} x {} pixels of {} samples with {} photons a pass",
        film.width, film.height, settings.samples, settings.photons
    )
}

/// The same for some passes of it.
pub fn check_partial(desc: &SceneDesc, settings: &Settings) -> Result<(), CliError> {
    let of_sums = pixels(&desc.film) * Sums::BYTES_A_PIXEL as u64;
    check(of_render(desc, settings).saturating_add(of_sums), &told(&desc.film, settings), LESS)
}

/// The same for a picture of the reference.
pub fn check_reference(film: &FilmDesc) -> Result<(), CliError> {
    check(
        pixels(film) * OF_PIXEL,
        &format!("{} x {} pixels", film.width, film.height),
        "fewer pixels (--size)",
    )
}

fn check(bytes: u64, what: &str, remedy: &'static str) -> Result<(), CliError> {
    input::check_memory(bytes).map_err(|source| CliError::Memory { what: what.to_owned(), source, remedy })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::{Bsdf, Ggx, Interface, RoughSurface};
    use crate::camera::PixelFilter;
    use crate::ppm::Render;
    use crate::scene::{self, Scene};
    use std::path::Path;

    fn desc() -> SceneDesc {
        let mut desc =
            scene::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("data/course_diffuse.toml")).unwrap();
        (desc.film.width, desc.film.height) = (64, 48);
        desc
    }

    #[test]
    fn a_render_holds_less_than_it_is_checked_for_and_not_far_less() {
        let scene = Scene::new(desc()).unwrap();
        let ours = Settings { photons: 100, samples: 2, ..Settings::of_scene(scene.render()) };
        let bytes = [EyePaths::Fixed, EyePaths::Retraced].map(|eye_paths| {
            let settings = Settings { eye_paths: Some(eye_paths), ..ours };
            let mut render = Render::new(&scene, settings);
            (0..2).for_each(|_| drop(render.pass()));
            let (held, checked) = (render.memory_bytes() as u64, of_render(&desc(), &settings));
            assert!((held..4 * held).contains(&checked), "{eye_paths}: {held} bytes, checked for {checked}");
            checked
        });
        assert!(bytes[1] > bytes[0]);
    }

    #[test]
    fn eye_paths_are_foreseen_as_the_plan_finds_them() {
        let rough = Bsdf::Rough(RoughSurface {
            facets: Ggx { alpha: 0.3 },
            interface: Interface::Dielectric { ior: 1.5 },
        });
        let edits: [&dyn Fn(&mut SceneDesc); 4] = [
            &|_| (),
            &|desc| desc.materials[0].bsdf = rough,
            &|desc| desc.camera.lens_radius = 0.1,
            &|desc| desc.film.filter = PixelFilter::Box,
        ];
        for edit in edits {
            let mut desc = desc();
            edit(&mut desc);
            let settings = Settings { photons: 1, samples: 1, ..Settings::of_scene(&desc.render) };
            let foreseen = retraces(&desc, &settings);
            let scene = Scene::new(desc).unwrap();
            assert_eq!(foreseen, Render::new(&scene, settings).eye_paths() == EyePaths::Retraced);
        }
    }
}
