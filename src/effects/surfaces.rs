//! What a scene is made of, as far as its effects go: pieces of surface, and sources of light.

use super::faces::{Face, Parts, Triangles, Vertices};
use super::{Effect, EffectSet, declare};
use crate::light::Light;
use crate::math::Rgb;
use crate::scene::{Item, Mesh, Scene, SphereDesc};

/// All surfaces of a scene by what hangs together.
pub(super) struct Surfaces<'s> {
    pub scene: &'s Scene,
    pub triangles: Triangles<'s>,
    /// Faces that do not refract; where nothing is to be gained from barriers, all faces by their meshes.
    pub opaque: Parts,
    /// Faces that refract.
    pub clear: Parts,
    /// Whether barriers may take anything off a plan.
    pub may_part: bool,
}

/// A piece of surface.
#[derive(Clone, Debug)]
pub(super) struct Object {
    pub shape: Shape,
    pub effects: EffectSet,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    /// Of [`Surfaces::opaque`].
    Opaque(usize),
    /// Of [`Surfaces::clear`].
    Clear(usize),
    /// Of the scene's spheres.
    Sphere(usize),
}

impl<'s> Surfaces<'s> {
    /// Finds out what hangs together where that may take anything off a plan: where something is specular, or where there
    /// is more than one light. In any other scene a barrier could only tell that its one light is not seen at all.
    pub fn of(scene: &'s Scene) -> Surfaces<'s> {
        let triangles = Triangles::of(scene);
        if !may_part(scene, &triangles) {
            let opaque = triangles.by_mesh();
            return Surfaces { scene, triangles, opaque, clear: Parts::default(), may_part: false };
        }
        let vertices = Vertices::weld(&triangles);
        let (clear, opaque): (Vec<Face>, Vec<Face>) =
            triangles.faces().partition(|face| declare::is_clear(triangles.material(*face)));
        let opaque = triangles.by_edges(opaque, &vertices);
        let clear = triangles.by_edges(clear, &vertices);
        Surfaces { scene, triangles, opaque, clear, may_part: true }
    }

    /// The faces of an object; none of a sphere.
    pub fn faces(&self, shape: Shape) -> &[Face] {
        match shape {
            Shape::Opaque(part) => &self.opaque.faces[self.opaque.parts[part].faces.clone()],
            Shape::Clear(part) => &self.clear.faces[self.clear.parts[part].faces.clone()],
            Shape::Sphere(_) => &[],
        }
    }

    fn sphere_effects(&self, sphere: &SphereDesc) -> EffectSet {
        declare::of_material(&self.scene.materials()[sphere.material as usize])
    }

    /// Whether light goes on behind the surface of a sphere.
    pub fn is_clear(&self, sphere: &SphereDesc) -> bool {
        declare::is_clear(&self.scene.materials()[sphere.material as usize])
    }

    /// All pieces: triangles, then spheres.
    pub fn objects(&self) -> Vec<Object> {
        let shapes = (0..self.opaque.parts.len()).map(Shape::Opaque);
        let shapes = shapes.chain((0..self.clear.parts.len()).map(Shape::Clear));
        let pieces = shapes.map(|shape| {
            let faces = self.faces(shape);
            let effects = faces.iter().map(|face| self.face_effects(*face));
            let effects = effects.fold(EffectSet::NONE, EffectSet::union);
            Object { shape, effects }
        });
        let spheres = self.scene.spheres().iter().enumerate().map(|(number, sphere)| Object {
            shape: Shape::Sphere(number),
            effects: self.sphere_effects(sphere),
        });
        pieces.chain(spheres).collect()
    }

    fn face_effects(&self, face: Face) -> EffectSet {
        declare::of_material(self.triangles.material(face))
    }

    /// The first face of an object that has an effect, or the object itself, and its material.
    pub fn describe(&self, object: &Object, effect: Effect) -> String {
        let of_face = |face: &Face| (Item::Mesh(face.mesh), self.triangles.material_number(*face));
        let (item, material) = match object.shape {
            Shape::Sphere(number) => (Item::Sphere(number as u32), self.scene.spheres()[number].material),
            shape => {
                let faces = self.faces(shape);
                let has_it = |face: &&Face| self.face_effects(**face).contains(effect);
                of_face(faces.iter().find(has_it).unwrap_or(&faces[0]))
            }
        };
        let material = &self.scene.materials()[material as usize].name;
        format!("{} of `{material}`", self.scene.describe(item))
    }

    /// The lights that belong to no surface, in the order of [`Scene::lights`].
    pub fn free_lights(&self) -> FreeLights {
        let (shining, dark): (Vec<_>, Vec<_>) = self
            .scene
            .free_lights()
            .into_iter()
            .partition(|(_, light)| declare::of_light(light) != EffectSet::NONE);
        let (delta, around) = shining.into_iter().partition(|(_, light)| light.is_delta());
        FreeLights { delta, around, dark: dark.into_iter().map(|(item, _)| item).collect() }
    }

    /// The spheres that are lights, by number, in the order of [`Scene::lights`].
    pub fn shining_spheres(&self) -> Vec<u32> {
        let spheres = self.scene.spheres().iter().zip(0..);
        let shines = |sphere: &SphereDesc| {
            let radiance = self.scene.materials()[sphere.material as usize].emission;
            let light = Light::Sphere { center: sphere.center, radius: sphere.radius, radiance };
            declare::of_light(&light) != EffectSet::NONE
        };
        spheres.filter(|(sphere, _)| shines(sphere)).map(|(_, number)| number).collect()
    }

    /// The triangles that are lights, in the order of [`Scene::lights`], by number of their mesh and triangle.
    pub fn lamps(&self) -> Vec<Face> {
        let of_mesh = |(mesh, number): (&Mesh, u32)| {
            let shines = |triangle: &u32| {
                let face = Face { mesh: number, triangle: *triangle };
                let radiance = self.triangles.material(face).emission;
                let light = || Light::Triangle { corners: self.triangles.corners(face), radiance };
                radiance != Rgb::ZERO && declare::of_light(&light()) != EffectSet::NONE
            };
            let triangles = (0..mesh.triangles.len() as u32).filter(shines);
            triangles.map(|triangle| Face { mesh: number, triangle }).collect::<Vec<Face>>()
        };
        self.scene.meshes().zip(0..).flat_map(of_mesh).collect()
    }
}

/// Lights that belong to no surface.
pub(super) struct FreeLights {
    /// Those without extent that have power.
    pub delta: Vec<(Item, Light)>,
    /// Those from all around that have power.
    pub around: Vec<(Item, Light)>,
    /// Those without power.
    pub dark: Vec<Item>,
}

/// Whether something is specular, or more than one thing shines: a mesh counts as one.
fn may_part(scene: &Scene, triangles: &Triangles) -> bool {
    let mut in_use = vec![false; scene.materials().len()];
    scene.meshes().flat_map(|mesh| &mesh.materials).for_each(|&material| in_use[material as usize] = true);
    scene.spheres().iter().for_each(|sphere| in_use[sphere.material as usize] = true);
    let used = || scene.materials().iter().zip(&in_use).filter(|(_, used)| **used);
    let is_specular = used().any(|(material, _)| declare::is_caster(declare::of_material(material)));
    let shines = |mesh: &&Mesh| {
        mesh.materials.iter().any(|&material| triangles.materials()[material as usize].emission != Rgb::ZERO)
    };
    let balls =
        scene.spheres().iter().filter(|s| scene.materials()[s.material as usize].emission != Rgb::ZERO);
    let lights = scene.free_lights().len() + scene.meshes().filter(shines).count() + balls.count();
    is_specular || lights > 1
}
