use std::sync::LazyLock;

use crate::effects::{PathClass, Plan};
use crate::light::Lights;
use crate::scene::{Scene, SurfaceHit};

/// What of a scene is simulated.
#[derive(Clone, Copy, Debug)]
pub struct Stage<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Those of its lights that matter.
    pub lights: &'a Lights,
    /// Whether paths may meet surfaces that mirror or refract.
    pub casters: bool,
    /// Whether caustics are collected on rough surfaces.
    pub glints: bool,
}

impl<'a> Stage<'a> {
    pub(super) fn new(scene: &'a Scene, lights: &'a Lights, plan: &Plan) -> Stage<'a> {
        Stage { scene, lights, casters: plan.casters, glints: plan.glints }
    }

    /// Whether caustics are collected where a path met a surface.
    #[inline]
    pub(super) fn collects_glints_at(&self, hit: &SurfaceHit) -> bool {
        self.glints && self.scene.is_rough(hit)
    }

    /// For direct light: without lights where that is not simulated.
    pub(super) fn of_direct_light(self, plan: &Plan) -> Stage<'a> {
        static NONE: LazyLock<Lights> = LazyLock::new(Lights::default);
        match plan.classes.contains(PathClass::Direct) {
            true => self,
            false => Stage { lights: &NONE, ..self },
        }
    }
}

/// All of a scene.
impl<'a> From<&'a Scene> for Stage<'a> {
    fn from(scene: &'a Scene) -> Stage<'a> {
        Stage { scene, lights: scene.lights(), casters: scene.any_specular(), glints: scene.any_glossy() }
    }
}
