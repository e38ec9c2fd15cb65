use super::error::CliError;
use crate::input;
use crate::ppm::Settings;
use crate::scene::FilmDesc;
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
/// Bytes of a hit point and its place in the tree, about; every eye sample leaves one where it sees no mirrors.
const OF_EYE_SAMPLE: u64 = 160;
/// Bytes of the records that a photon leaves in a pass, about.
const OF_PHOTON: u64 = 100;

/// Refuses a render by photon mapping that this machine has not the memory for, before any is taken.
pub fn check_render(film: &FilmDesc, settings: &Settings) -> Result<(), CliError> {
    check(of_render(film, settings), &told(film, settings), LESS)
}

const LESS: &str = "fewer pixels (--size), samples or photons";

fn of_render(film: &FilmDesc, settings: &Settings) -> u64 {
    let pixels = u64::from(film.width) * u64::from(film.height);
    let of_eye = pixels.saturating_mul(OF_PIXEL + OF_EYE_SAMPLE * u64::from(settings.samples));
    of_eye.saturating_add(settings.photons.saturating_mul(OF_PHOTON))
}

fn told(film: &FilmDesc, settings: &Settings) -> String {
    format!(
        "{} x {} pixels of {} samples with {} photons a pass",
        film.width, film.height, settings.samples, settings.photons
    )
}

/// The same for some passes of it.
pub fn check_partial(film: &FilmDesc, settings: &Settings) -> Result<(), CliError> {
    let pixels = u64::from(film.width) * u64::from(film.height);
    let bytes = of_render(film, settings).saturating_add(pixels * Sums::BYTES_A_PIXEL as u64);
    check(bytes, &told(film, settings), LESS)
}

/// The same for a picture of the reference.
pub fn check_reference(film: &FilmDesc) -> Result<(), CliError> {
    let bytes = u64::from(film.width) * u64::from(film.height) * OF_PIXEL;
    check(bytes, &format!("{} x {} pixels", film.width, film.height), "fewer pixels (--size)")
}

fn check(bytes: u64, what: &str, remedy: &'static str) -> Result<(), CliError> {
    input::check_memory(bytes).map_err(|source| CliError::Memory { what: what.to_owned(), source, remedy })
}
