//! What the tests of this module share.

use std::cell::Cell;

use super::{Axis, Plan, Subject, Watch, configurations};
use crate::ppm::Settings;
use crate::scene::{self, FilmDesc, SceneDesc};

const SCENE: &str = "\
[camera]
position = [0, 1, 4]
look_at = [0, 0.5, 0]
fov = 40
[render]
photons = 500
samples = 1
radius = 0.5
[material.a]
diffuse = { albedo = [0.5, 0.6, 0.7] }
[[point_light]]
position = [0, 3, 0]
intensity = [9, 9, 9]
[[quad]]
corners = [[-2, 0, -2], [-2, 0, 2], [2, 0, 2], [2, 0, -2]]
material = \"a\"
[[quad]]
corners = [[-2, 0, -2], [2, 0, -2], [2, 4, -2], [-2, 4, -2]]
material = \"a\"
";

/// A floor and a wall under a lamp, in 8 x 8 pixels.
pub fn desc() -> SceneDesc {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.toml");
    std::fs::write(&path, SCENE).unwrap();
    SceneDesc { film: FilmDesc::new(8, 8), ..scene::load(&path).unwrap() }
}

/// The baseline, path tracing and light tracing, twice and shortly.
pub fn plan() -> Plan {
    let desc = desc();
    let configurations = configurations(Settings::of_scene(&desc.render), &[Axis::Method]);
    Plan { desc, configurations, repetitions: 2, seconds_per_run: 0.01, seed: 0, surroundings: String::new() }
}

/// Stops after so many runs.
pub struct Bounded {
    left: Cell<u32>,
}

impl Bounded {
    pub fn to(runs: u32) -> Bounded {
        Bounded { left: Cell::new(runs) }
    }
}

impl Watch for Bounded {
    fn is_over(&self) -> bool {
        self.left.get() == 0
    }

    fn begins(&self, _configuration: &str, _repetition: u32) {}

    fn is_done(&self) {
        self.left.set(self.left.get().saturating_sub(1));
    }
}

/// What commands of the plan name.
pub fn subject() -> Subject {
    Subject { scene: "s.toml".into(), size: (8, 8), settings: Settings::of_scene(&desc().render) }
}
