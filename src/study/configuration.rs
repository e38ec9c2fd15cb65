//! What is measured against what: the table of configurations.

use std::fmt;

use crate::bsdf::{Bsdf, DiffuseSampling};
use crate::effects::EyePaths;
use crate::ppm::{Precision, RadiusPolicy, Settings};
use crate::reference;
use crate::report::quoted;
use crate::scene::{SceneDesc, Traversal};

/// What a configuration changes about the baseline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// Nothing: the scene's own settings.
    Baseline,
    /// `α`.
    Alpha,
    /// The initial radius.
    Radius,
    /// Photons a pass.
    Photons,
    /// Eye samples a pixel.
    Samples,
    /// How photons bounce off diffuse surfaces.
    Sampling,
    /// What shrinks the radii.
    Policy,
    /// `α` of a shared schedule, in discs so large that their bias can be told from noise.
    Convergence,
    /// How precisely hit points keep their statistics.
    Precision,
    /// Photon mapping, path tracing or light tracing.
    Method,
    /// Who answers the rays.
    Traversal,
    /// An effect is switched off.
    Effects,
    /// Several of these at a time.
    Pairs,
}

impl Axis {
    /// Every axis, in the order of the table; the baseline is measured beside any of them.
    pub const ALL: [Axis; 13] = [
        Axis::Baseline,
        Axis::Alpha,
        Axis::Radius,
        Axis::Photons,
        Axis::Samples,
        Axis::Sampling,
        Axis::Policy,
        Axis::Convergence,
        Axis::Precision,
        Axis::Method,
        Axis::Traversal,
        Axis::Effects,
        Axis::Pairs,
    ];

    /// The axis of this name.
    pub fn named(name: &str) -> Option<Axis> {
        Axis::ALL.into_iter().find(|axis| axis.name() == name)
    }

    /// What a command line calls it.
    pub fn name(self) -> &'static str {
        self.words().0
    }

    /// What it asks, as a heading.
    pub fn question(self) -> &'static str {
        self.words().1
    }

    fn words(self) -> (&'static str, &'static str) {
        match self {
            Axis::Baseline => ("baseline", "The baseline"),
            Axis::Alpha => ("alpha", "How fast radii shrink"),
            Axis::Radius => ("radius", "Where radii begin"),
            Axis::Photons => ("photons", "Photons a pass"),
            Axis::Samples => ("samples", "Eye samples a pixel"),
            Axis::Sampling => ("sampling", "Uniform or cosine-weighted bounces"),
            Axis::Policy => ("policy", "What shrinks the radii"),
            Axis::Convergence => ("convergence", "Large discs by a shared schedule"),
            Axis::Precision => ("precision", "Statistics in f64 or f32"),
            Axis::Method => ("method", "Photon mapping, path tracing or light tracing"),
            Axis::Traversal => ("traversal", "Who answers the rays"),
            Axis::Effects => ("effects", "An effect left out"),
            Axis::Pairs => ("pairs", "Several changes at a time"),
        }
    }
}

impl fmt::Display for Axis {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.pad(self.name())
    }
}

/// What makes the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// [`crate::ppm::Render`]; a step is a pass.
    PhotonMapping,
    /// One of the estimators of [`crate::reference`]; a step is a sample a pixel.
    Reference(reference::Method),
}

/// One way to render the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Configuration {
    /// What is told apart by, in tables and file names.
    pub name: &'static str,
    /// What it changes.
    pub axis: Axis,
    /// All that photon mapping goes by, its radius included.
    pub settings: Settings,
    /// What makes the picture.
    pub method: Method,
    /// Who answers the rays.
    pub traversal: Traversal,
}

/// Of a configuration that was the baseline.
type Change = fn(&mut Configuration);

/// The whole list: a new axis is a new name above and a few rows here.
const CHANGES: &[(Axis, &str, Change)] = &[
    (Axis::Baseline, "baseline", |_| ()),
    (Axis::Alpha, "alpha 1/2", |c| c.settings.alpha = 0.5),
    (Axis::Alpha, "alpha 2/3", |c| c.settings.alpha = 2.0 / 3.0),
    (Axis::Alpha, "alpha 0.8", |c| c.settings.alpha = 0.8),
    (Axis::Alpha, "alpha 1", |c| c.settings.alpha = 1.0),
    (Axis::Radius, "radius x0.5", |c| scale_radius(c, 0.5)),
    (Axis::Radius, "radius x2", |c| scale_radius(c, 2.0)),
    (Axis::Radius, "radius x4", |c| scale_radius(c, 4.0)),
    (Axis::Photons, "photons /4", |c| c.settings.photons = (c.settings.photons / 4).max(1)),
    (Axis::Photons, "photons x4", |c| c.settings.photons *= 4),
    (Axis::Samples, "samples /4", |c| c.settings.samples = (c.settings.samples / 4).max(1)),
    (Axis::Samples, "samples x4", |c| c.settings.samples *= 4),
    (Axis::Sampling, "uniform bounces", |c| c.settings.sampling = DiffuseSampling::Uniform),
    (Axis::Policy, "shared schedule", |c| c.settings.policy = RadiusPolicy::Shared),
    (Axis::Policy, "tested discs", |c| c.settings.policy = RadiusPolicy::Tested),
    (Axis::Policy, "fixed radius", |c| c.settings.policy = RadiusPolicy::Fixed),
    (Axis::Convergence, "shared, alpha 1/2", |c| converge(c, 0.5)),
    (Axis::Convergence, "shared, alpha 2/3", |c| converge(c, 2.0 / 3.0)),
    (Axis::Convergence, "shared, alpha 0.8", |c| converge(c, 0.8)),
    (Axis::Precision, "f32 statistics", |c| c.settings.precision = Precision::Single),
    (Axis::Method, "path tracing", |c| c.method = Method::Reference(reference::Method::Path)),
    (Axis::Method, "light tracing", |c| c.method = Method::Reference(reference::Method::Light)),
    (Axis::Traversal, "Embree, fast", |c| c.traversal = Traversal::EmbreeFast),
    (Axis::Traversal, "own tree", |c| c.traversal = Traversal::Custom),
    (Axis::Effects, "no specular chains", |c| c.settings.depth = 0),
    (Axis::Pairs, "alpha 1/2, radius x4", |c| {
        c.settings.alpha = 0.5;
        scale_radius(c, 4.0);
    }),
    (Axis::Pairs, "alpha 1, radius x0.5", |c| {
        c.settings.alpha = 1.0;
        scale_radius(c, 0.5);
    }),
    (Axis::Pairs, "photons x4, samples x4", |c| {
        c.settings.photons *= 4;
        c.settings.samples *= 4;
    }),
];

fn scale_radius(configuration: &mut Configuration, factor: f64) {
    configuration.settings.radius = configuration.settings.radius.map(|radius| factor * radius);
}

/// What Knaus and Zwicker analyse: one schedule for all radii and eye paths of its own for each pass, so that nothing but photons,
/// discs and eye samples that become ever more is in the error. The noise of eye samples falls as `1 / N`, faster than that of photons,
/// and in large discs many photons would leave it the larger one, so there are few.
fn converge(configuration: &mut Configuration, alpha: f64) {
    let Settings { radius, photons, .. } = configuration.settings;
    configuration.settings = Settings {
        alpha,
        photons: (photons / 16).max(1),
        radius: radius.map(|radius| 32.0 * radius),
        policy: RadiusPolicy::Shared,
        eye_paths: Some(EyePaths::Retraced),
        ..configuration.settings
    };
}

/// The baseline and every change along `axes` that changes something about it.
///
/// `baseline` names its radius, so that multiples of it mean something.
pub fn configurations(baseline: Settings, axes: &[Axis]) -> Vec<Configuration> {
    let start = Configuration {
        name: "baseline",
        axis: Axis::Baseline,
        settings: baseline,
        method: Method::PhotonMapping,
        traversal: Traversal::Embree,
    };
    let changed = |&(axis, name, change): &(Axis, &'static str, Change)| {
        let mut configuration = start.clone();
        change(&mut configuration);
        let is_new = axis == Axis::Baseline || configuration != start;
        is_new.then_some(Configuration { name, axis, ..configuration })
    };
    let wanted = |(axis, ..): &&(Axis, &str, Change)| *axis == Axis::Baseline || axes.contains(axis);
    CHANGES.iter().filter(wanted).filter_map(changed).collect()
}

/// The scene and the picture that command lines name.
#[derive(Clone, Debug, PartialEq)]
pub struct Subject {
    /// The scene file, as it was asked for.
    pub scene: String,
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// What the scene file asks for.
    pub settings: Settings,
}

impl Configuration {
    /// The command that renders so many steps of this configuration from `seed`.
    pub fn command(&self, subject: &Subject, steps: u32, seed: u64) -> String {
        let (width, height) = subject.size;
        let (command, count) = match self.method {
            Method::PhotonMapping => ("render", "passes"),
            Method::Reference(_) => ("reference", "spp"),
        };
        let scene = quoted(&subject.scene);
        let mut line =
            format!("caustica {command} {scene} --size {width}x{height} --{count} {steps} --seed {seed}");
        match self.method {
            Method::PhotonMapping => line += &self.options(&subject.settings),
            Method::Reference(reference::Method::Path) => (),
            Method::Reference(reference::Method::Light) => line += " --method light",
        }
        if self.traversal != Traversal::Embree {
            line += &format!(" --traversal {}", self.traversal);
        }
        line
    }

    /// What differs from the scene's own settings.
    fn options(&self, scene: &Settings) -> String {
        let s = &self.settings;
        let radius = s.radius.map(|radius| radius.to_string()).unwrap_or_default();
        let sampling = format!("{:?}", s.sampling).to_lowercase();
        let precision = format!("{:?}", s.precision).to_lowercase();
        let eye_paths = s.eye_paths.map(|eye_paths| eye_paths.to_string()).unwrap_or_default();
        let all = [
            (s.photons != scene.photons, "photons", s.photons.to_string()),
            (s.alpha != scene.alpha, "alpha", s.alpha.to_string()),
            (s.radius != scene.radius, "radius", radius),
            (s.samples != scene.samples, "samples", s.samples.to_string()),
            (s.depth != scene.depth, "depth", s.depth.to_string()),
            (s.sampling != scene.sampling, "sampling", sampling),
            (s.policy != scene.policy, "radius-policy", s.policy.to_string()),
            (s.eye_paths != scene.eye_paths, "eye-paths", eye_paths),
            (s.precision != scene.precision, "precision", precision),
        ];
        all.iter()
            .filter(|(differs, ..)| *differs)
            .map(|(_, name, value)| format!(" --{name} {value}"))
            .collect()
    }

    /// Whether its picture may never become the reference's, however long it takes: no path from the eye finds a point
    /// light through glass, and none from a light what mirrors show. Where all is opaque and diffuse, both find all.
    pub fn may_lack_light(&self, scene: &SceneDesc) -> bool {
        let is_plain = scene
            .materials
            .iter()
            .all(|material| matches!(material.bsdf, Bsdf::Diffuse { .. }) && !material.is_mask());
        self.axis == Axis::Effects || matches!(self.method, Method::Reference(_)) && !is_plain
    }

    /// The name as part of a file's.
    pub fn file_stem(&self) -> String {
        let plain = |c: char| if c.is_ascii_alphanumeric() || c == '.' { c } else { '_' };
        self.name.replace(", ", "_").replace('/', "_over_").chars().map(plain).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::RenderDesc;

    fn settings() -> Settings {
        let render =
            RenderDesc { passes: 9, photons: 1000, samples: 4, alpha: 0.7, radius: Some(0.5), depth: 12 };
        Settings::of_scene(&render)
    }

    #[test]
    fn every_axis_has_configurations_of_its_own() {
        let all = configurations(settings(), &Axis::ALL);
        assert_eq!(all.len(), CHANGES.len());
        for axis in Axis::ALL {
            assert!(all.iter().any(|c| c.axis == axis), "{axis}");
            assert_eq!(Axis::named(axis.name()), Some(axis));
        }
        for (k, a) in all.iter().enumerate() {
            for b in &all[k + 1..] {
                assert!(a.name != b.name && a.file_stem() != b.file_stem(), "{} twice", a.name);
                let same = (a.settings, a.method, a.traversal) == (b.settings, b.method, b.traversal);
                assert!(!same, "{} is {}", a.name, b.name);
            }
        }
    }

    #[test]
    fn axes_choose_and_the_baseline_always_stands() {
        let names = |axes: &[Axis]| -> Vec<&str> {
            configurations(settings(), axes).iter().map(|c| c.name).collect()
        };
        assert_eq!(names(&[]), ["baseline"]);
        assert_eq!(names(&[Axis::Radius]), ["baseline", "radius x0.5", "radius x2", "radius x4"]);
        assert_eq!(
            names(&[Axis::Method, Axis::Effects]),
            ["baseline", "path tracing", "light tracing", "no specular chains"]
        );
    }

    #[test]
    fn what_changes_nothing_is_left_out() {
        let settings = Settings { samples: 1, alpha: 0.8, depth: 0, ..settings() };
        let all = configurations(settings, &Axis::ALL);
        let missing = ["samples /4", "alpha 0.8", "no specular chains"];
        assert!(all.iter().all(|c| !missing.contains(&c.name)));
        assert_eq!(all.len(), CHANGES.len() - missing.len());
    }

    #[test]
    fn commands_name_what_differs() {
        let all = configurations(settings(), &Axis::ALL);
        let subject = Subject { scene: "a b.toml".into(), size: (64, 48), settings: settings() };
        let command = |name: &str| all.iter().find(|c| c.name == name).unwrap().command(&subject, 7, 3);
        let start = "'a b.toml' --size 64x48";
        assert_eq!(command("baseline"), format!("caustica render {start} --passes 7 --seed 3"));
        assert_eq!(command("path tracing"), format!("caustica reference {start} --spp 7 --seed 3"));
        assert!(command("alpha 1/2, radius x4").ends_with("--seed 3 --alpha 0.5 --radius 2"));
        assert!(command("light tracing").ends_with("--seed 3 --method light"));
        assert!(command("shared schedule").ends_with(" --radius-policy shared"));
        assert!(command("shared, alpha 2/3").ends_with(
            " --photons 62 --alpha 0.6666666666666666 --radius 16 --radius-policy shared --eye-paths retraced"
        ));
        assert!(command("f32 statistics").ends_with(" --precision single"));
        assert!(command("own tree").ends_with(" --traversal custom"));
        assert!(command("Embree, fast").ends_with(" --traversal embree-fast"));
        assert!(command("uniform bounces").ends_with(" --sampling uniform"));
        assert!(command("photons x4").ends_with(" --photons 4000"));
    }
}
