use crate::effects::Plan;
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
}

/// All of a scene.
impl<'a> From<&'a Scene> for Stage<'a> {
    fn from(scene: &'a Scene) -> Stage<'a> {
        Stage { scene, lights: scene.lights(), casters: scene.any_specular() }
    }
}
