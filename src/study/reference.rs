//! The picture that all others are held against: the mean of renders from many seeds.
//!
//! Each has eye samples of its own, so their noise falls in the mean as that of the photons does.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::StudyError;
use super::fingerprint::{described, fingerprint};
use super::watch::Watch;
use crate::bench::timing::timed;
use crate::compare::{CompareError, Metrics};
use crate::film::Image;
use crate::math::DVec3;
use crate::output::{Metadata, read_exr, write_bytes, write_exr};
use crate::ppm::{Render, Settings};
use crate::report::quoted;
use crate::scene::{Scene, SceneDesc, TraversalError};

/// How a reference is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recipe {
    /// Of each render, but its seed.
    pub settings: Settings,
    /// Passes of each render.
    pub passes: u32,
    /// Most renders that are averaged; at least 2.
    pub renders: u32,
    /// After so many seconds no further render begins, once there are two.
    pub seconds: f64,
    /// The seed of the first render; the others count on.
    pub first_seed: u64,
}

impl Recipe {
    /// For a study of a scene that is rendered with `baseline`: twice the eye samples, half the radius (which is in all
    /// renders alike, so no average mends what it blurs) and far seeds.
    pub fn new(baseline: Settings, passes: u32, renders: u32, seconds: f64) -> Recipe {
        let settings = Settings {
            samples: 2 * baseline.samples,
            radius: baseline.radius.map(|radius| 0.5 * radius),
            ..baseline
        };
        Recipe { settings, passes, renders, seconds, first_seed: baseline.seed.wrapping_add(1 << 32) }
    }

    fn key(&self, desc: &SceneDesc) -> String {
        // However long it may take: what it became of is in the manifest.
        let recipe = Recipe { seconds: 0.0, ..*self };
        format!("{:016x}", fingerprint(&(described(desc), recipe)))
    }

    /// The command that makes render `index`.
    fn command(&self, desc: &SceneDesc, index: u32) -> String {
        let s = &self.settings;
        let scene = quoted(&desc.path.to_string_lossy());
        let radius = s.radius.map(|radius| format!(" --radius {radius}")).unwrap_or_default();
        format!(
            "caustica render {scene} --size {}x{} --passes {} --photons {} --alpha {}{radius} --samples {} --depth {} --seed {}",
            desc.film.width,
            desc.film.height,
            self.passes,
            s.photons,
            s.alpha,
            s.samples,
            s.depth,
            self.first_seed.wrapping_add(index.into())
        )
    }
}

/// What a reference is, and how good.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Tells scene, size and settings apart.
    pub key: String,
    /// Renders that were averaged.
    pub renders: u32,
    /// Passes of each.
    pub passes: u32,
    /// Relative root-mean-square difference between the means of two halves of the renders, in percent.
    pub halves_differ_percent: f64,
    /// What that leaves for the mean of all, in percent: half of it. What all renders blur alike is not in it.
    pub error_percent: f64,
    /// Seconds that the renders took.
    pub seconds: f64,
    /// The command that makes the first render; the others differ in their seed, which counts on.
    pub command: String,
}

/// A reference and what is known of it.
#[derive(Clone, Debug)]
pub struct Reference {
    /// The picture.
    pub image: Image,
    /// Where it lies.
    pub path: PathBuf,
    /// The standard error of each of its pixels; `None` where it is not known.
    pub standard_error: Option<Image>,
    /// How it was made; `None` for a picture that the user gave.
    pub manifest: Option<Manifest>,
    /// Whether it was there already.
    pub cached: bool,
}

impl Reference {
    /// A picture that the user gave.
    pub fn given(image: Image, path: &Path) -> Reference {
        Reference { image, path: path.into(), standard_error: None, manifest: None, cached: true }
    }

    /// With the standard error of its pixels.
    ///
    /// # Errors
    /// When the two differ in size.
    pub fn with_standard_error(self, standard_error: Image) -> Result<Reference, CompareError> {
        Metrics::between(&standard_error, &self.image)?;
        Ok(Reference { standard_error: Some(standard_error), ..self })
    }

    /// The list comes last: without it, the pictures are no reference.
    fn write(&self, folder: &Path) -> Result<(), StudyError> {
        write_exr(&self.path, &self.image, &Metadata::new())?;
        if let Some(standard_error) = &self.standard_error {
            write_exr(&folder.join(STANDARD_ERROR), standard_error, &Metadata::new())?;
        }
        Ok(write_bytes(&folder.join(MANIFEST), format!("{:#}\n", serde_json::json!(self.manifest)))?)
    }

    /// A number that tells its pixels and their errors from others.
    pub fn fingerprint(&self) -> u64 {
        fingerprint(&(self.image.pixels(), self.standard_error.as_ref().map(Image::pixels)))
    }
}

/// The reference at `folder/reference.exr`, its standard error beside it: the one that is there if scene, size and settings match, or
/// else a new one.
///
/// Every render is kept in `folder/reference` until all are there, so that an interrupted reference goes on. `None`
/// where `watch` stopped it.
///
/// # Errors
/// When the scene cannot be traced or a file cannot be written.
pub fn make(
    desc: &SceneDesc,
    recipe: &Recipe,
    folder: &Path,
    watch: &impl Watch,
) -> Result<Option<Reference>, StudyError> {
    let key = recipe.key(desc);
    if let Some(reference) = cached(folder, &key) {
        return Ok(Some(reference));
    }
    let parts = folder.join("reference").join(&key);
    let scene = Scene::new(desc.clone()).map_err(TraversalError::from)?;
    let mut halves = [Half::new(&scene), Half::new(&scene)];
    let (mut seconds, mut renders) = (0.0, 0);
    while renders < recipe.renders.max(2) && (renders < 2 || seconds < recipe.seconds) {
        watch.begins("reference", renders);
        let (part, time) = timed(|| part(&scene, recipe, &parts, renders, watch));
        let Some(part) = part? else { return Ok(None) };
        halves[renders as usize % 2].add(&part);
        (seconds, renders) = (seconds + time, renders + 1);
        watch.is_done();
    }
    let [even, odd] = [&halves[0], &halves[1]].map(Half::mean);
    let halves_differ_percent = 100.0 * Metrics::between(&even, &odd)?.rel_mse.sqrt();
    let manifest = Manifest {
        key,
        renders,
        passes: recipe.passes,
        halves_differ_percent,
        error_percent: 0.5 * halves_differ_percent,
        seconds,
        command: recipe.command(desc, 0),
    };
    let standard_error = Some(half_the_difference(&even, &odd));
    let [even, odd] = halves;
    let image = even.plus(odd).mean();
    let path = folder.join(PICTURE);
    let reference = Reference { image, path, standard_error, manifest: Some(manifest), cached: false };
    reference.write(folder)?;
    // What is left over costs disk space alone.
    let _ = std::fs::remove_dir_all(folder.join("reference"));
    Ok(Some(reference))
}

const PICTURE: &str = "reference.exr";
const STANDARD_ERROR: &str = "reference_stderr.exr";
const MANIFEST: &str = "reference.json";

fn cached(folder: &Path, key: &str) -> Option<Reference> {
    let manifest: Manifest = serde_json::from_slice(&std::fs::read(folder.join(MANIFEST)).ok()?).ok()?;
    if manifest.key != key {
        return None;
    }
    let path = folder.join(PICTURE);
    let (image, standard_error) = (read_exr(&path).ok()?, read_exr(&folder.join(STANDARD_ERROR)).ok()?);
    let reference = Reference { manifest: Some(manifest), ..Reference::given(image, &path) };
    reference.with_standard_error(standard_error).ok()
}

/// Of the means of two halves: squared, the variance of the mean of both.
fn half_the_difference(a: &Image, b: &Image) -> Image {
    let mut image = Image::new(a.width(), a.height());
    let halves = a.pixels().iter().zip(b.pixels());
    image.pixels_mut().iter_mut().zip(halves).for_each(|(pixel, (a, b))| *pixel = 0.5 * (a - b).abs());
    image
}

/// Render `index`, from its file if it is there; `None` where `watch` stopped it.
fn part(
    scene: &Scene,
    recipe: &Recipe,
    folder: &Path,
    index: u32,
    watch: &impl Watch,
) -> Result<Option<Image>, StudyError> {
    let path = folder.join(format!("{index}.exr"));
    if let Ok(image) = read_exr(&path) {
        return Ok(Some(image));
    }
    let seed = recipe.first_seed.wrapping_add(index.into());
    let mut render = Render::new(scene, Settings { seed, ..recipe.settings });
    while render.passes() < recipe.passes {
        if watch.is_over() {
            return Ok(None);
        }
        render.pass();
    }
    let image = render.picture();
    write_exr(&path, &image, &Metadata::new())?;
    Ok(Some(image))
}

/// The sum of some renders.
struct Half {
    size: (usize, usize),
    sum: Vec<DVec3>,
    count: u32,
}

impl Half {
    fn new(scene: &Scene) -> Half {
        let size = (scene.film().width as usize, scene.film().height as usize);
        Half { size, sum: vec![DVec3::ZERO; size.0 * size.1], count: 0 }
    }

    fn add(&mut self, image: &Image) {
        self.sum.iter_mut().zip(image.pixels()).for_each(|(sum, pixel)| *sum += pixel.as_dvec3());
        self.count += 1;
    }

    fn plus(mut self, other: Half) -> Half {
        self.sum.iter_mut().zip(other.sum).for_each(|(sum, more)| *sum += more);
        Half { count: self.count + other.count, ..self }
    }

    fn mean(&self) -> Image {
        let mut image = Image::new(self.size.0, self.size.1);
        for (pixel, sum) in image.pixels_mut().iter_mut().zip(&self.sum) {
            *pixel = (*sum / f64::from(self.count.max(1))).as_vec3();
        }
        image
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Bounded, desc};
    use super::*;

    fn recipe(renders: u32) -> Recipe {
        let baseline = Settings::of_scene(&desc().render);
        Recipe::new(baseline, 2, renders, 1e9)
    }

    fn made(folder: &Path, recipe: &Recipe) -> Reference {
        make(&desc(), recipe, folder, &Bounded::to(u32::MAX)).unwrap().unwrap()
    }

    #[test]
    fn a_reference_is_made_once() {
        let folder = tempfile::tempdir().unwrap();
        let first = made(folder.path(), &recipe(4));
        let again = made(folder.path(), &recipe(4));
        assert!(!first.cached && again.cached && first.image == again.image);
        assert!(first.standard_error.is_some() && first.standard_error == again.standard_error);
        assert_eq!(again.manifest.unwrap().renders, 4);
        let other = made(folder.path(), &recipe(3));
        assert!(!other.cached && other.image != first.image);
        assert!(!folder.path().join("reference").exists(), "the parts are gone");
    }

    /// Two halves of n renders differ by twice what their mean is off; a mean of many tells.
    #[test]
    fn the_error_is_what_the_halves_say() {
        let folders = [(); 2].map(|()| tempfile::tempdir().unwrap());
        let few = made(folders[0].path(), &recipe(6));
        let many = Recipe { first_seed: 1, ..recipe(200) };
        let many = made(folders[1].path(), &many);
        let found = 100.0 * Metrics::between(&few.image, &many.image).unwrap().rel_mse.sqrt();
        let told = few.manifest.unwrap().error_percent;
        assert!((0.7..1.4).contains(&(found / told)), "{found} % found, {told} % told");
        let of_pixels = few.standard_error.unwrap();
        let sum = few.image.pixels().iter().zip(of_pixels.pixels()).map(|(&x, &s)| x + s).collect();
        let off = Image::from_pixels(8, 8, sum).unwrap();
        let squares = Metrics::between(&off, &few.image).unwrap().rel_mse;
        assert!((100.0 * squares.sqrt() / told - 1.0).abs() < 0.05, "{told} %, of pixels {squares}");
    }

    #[test]
    fn an_interrupted_reference_goes_on() {
        let (folder, other) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let stopped = make(&desc(), &recipe(4), folder.path(), &Bounded::to(0)).unwrap();
        assert!(stopped.is_none() && !folder.path().join("reference.exr").exists());
        let scene = Scene::new(desc()).unwrap();
        let parts = folder.path().join("reference").join(recipe(4).key(&desc()));
        let planted = part(&scene, &recipe(4), &parts, 0, &Bounded::to(1)).unwrap().unwrap();
        assert_eq!(read_exr(&parts.join("0.exr")).unwrap(), planted);
        let resumed = made(folder.path(), &recipe(4));
        assert_eq!(resumed.image, made(other.path(), &recipe(4)).image);
    }

    #[test]
    fn no_time_still_makes_two_halves() {
        let folder = tempfile::tempdir().unwrap();
        let reference = made(folder.path(), &Recipe { seconds: 0.0, ..recipe(9) });
        assert_eq!(reference.manifest.unwrap().renders, 2);
    }
}
