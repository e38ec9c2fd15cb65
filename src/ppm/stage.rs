use crate::effects::{PathClass, Plan};
use crate::light::Lights;
use crate::scene::Scene;

/// What of a scene is simulated.
#[derive(Clone, Copy, Debug)]
pub struct Stage<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Those of its lights that matter.
    pub lights: &'a Lights,
    /// Whether paths may meet surfaces that mirror or refract.
    pub casters: bool,
}

impl<'a> Stage<'a> {
    pub(super) fn new(scene: &'a Scene, lights: &'a Lights, plan: &Plan) -> Stage<'a> {
        Stage { scene, lights, casters: plan.casters }
    }

    /// For direct light: without lights, `none`, where that is not simulated.
    pub(super) fn of_direct_light(self, plan: &Plan, none: &'a Lights) -> Stage<'a> {
        match plan.classes.contains(PathClass::Direct) {
            true => self,
            false => Stage { lights: none, ..self },
        }
    }
}

/// All of a scene.
impl<'a> From<&'a Scene> for Stage<'a> {
    fn from(scene: &'a Scene) -> Stage<'a> {
        Stage { scene, lights: scene.lights(), casters: scene.any_specular() }
    }
}
