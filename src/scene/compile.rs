use std::sync::Arc;

use super::desc::{Material, PointLightDesc, SceneDesc, SphereDesc};
use super::gist::Gist;
use super::media::Absorbers;
use super::surface::Surface;
use super::tracer::Tracer;
use super::{Mesh, Scene, Traversal, TraversalError, ball};
use crate::camera::Camera;
use crate::embree::EmbreeError;
use crate::light::{Light, Lights};
use crate::math::{Aabb, Rgb};

impl Scene {
    /// Makes a description traceable by Embree.
    ///
    /// # Errors
    /// Whatever the ray tracer refuses: no memory, a library of the wrong version, more than 2³² primitives.
    pub fn new(desc: SceneDesc) -> Result<Scene, EmbreeError> {
        compile(desc, Traversal::Embree, |surfaces| Tracer::embree(surfaces).map(Arc::new))
    }

    /// Makes a description traceable by the means of choice.
    ///
    /// # Errors
    /// Whatever those refuse: see [`Scene::new`]; the project's own tree has room for 2³⁰ primitives.
    pub fn with_traversal(desc: SceneDesc, traversal: Traversal) -> Result<Scene, TraversalError> {
        compile(desc, traversal, |surfaces| Tracer::new(surfaces, traversal).map(Arc::new))
    }

    /// Makes another description traceable by the same means, with the tree of this scene where its surfaces lie as they do here,
    /// whatever their materials, the lights and the camera are.
    ///
    /// # Errors
    /// Those of [`Scene::with_traversal`].
    pub fn successor(&self, desc: SceneDesc) -> Result<Scene, TraversalError> {
        compile(desc, self.traversal, |surfaces| match same_places(surfaces, &self.surfaces) {
            true => Ok(Arc::clone(&self.rays)),
            false => Tracer::new(surfaces, self.traversal).map(Arc::new),
        })
    }

    /// Whether a tree is shared with `other`.
    pub fn shares_tree(&self, other: &Scene) -> bool {
        Arc::ptr_eq(&self.rays, &other.rays)
    }
}

fn compile<E>(
    desc: SceneDesc,
    traversal: Traversal,
    trace: impl FnOnce(&[Surface]) -> Result<Arc<Tracer>, E>,
) -> Result<Scene, E> {
    let camera = camera(&desc);
    let emitters: Vec<Light> = emitters(&desc).collect();
    let SceneDesc { materials, render, film, point_lights, further_lights, camera: view, places, .. } = desc;
    let meshes = desc.meshes.into_iter().map(|mesh| without_idle_coordinates(mesh, &materials)).collect();
    let surfaces = surfaces(meshes, desc.spheres);
    let gists = materials.iter().map(Gist::of).collect();
    let absorbers = Absorbers::of(&materials);
    let has_masks = materials.iter().any(Material::is_mask);
    let bounds = surfaces.iter().map(Surface::bounds).fold(Aabb::EMPTY, Aabb::union);
    let free = point_lights.iter().map(PointLightDesc::light);
    let (delta, around): (Vec<Light>, Vec<Light>) =
        free.chain(further_lights.iter().map(|light| light.light(ball(bounds)))).partition(Light::is_delta);
    let lights = Lights::new(delta.into_iter().chain(emitters).chain(around));
    let rays = trace(&surfaces)?;
    let mut scene = Scene {
        rays,
        traversal,
        surfaces,
        materials,
        gists,
        has_masks,
        absorbers,
        lights,
        camera,
        point_lights,
        further_lights,
        view,
        film,
        render,
        bounds,
        places,
    };
    scene.find_media();
    Ok(scene)
}

/// Whether rays cannot tell the surfaces apart.
fn same_places(these: &[Surface], those: &[Surface]) -> bool {
    these.len() == those.len() && these.iter().zip(those).all(|(a, b)| a.lies_as(b))
}

fn camera(desc: &SceneDesc) -> Camera {
    let c = &desc.camera;
    let pinhole =
        Camera::new(c.position, c.look_at, c.up, c.fov_degrees, (desc.film.width, desc.film.height));
    pinhole.with_lens(c.lens_radius, c.focus_distance)
}

/// Without texture coordinates that no picture asks for, which would be looked up at every hit.
fn without_idle_coordinates(mesh: Mesh, materials: &[Material]) -> Mesh {
    let pictured = |&material: &u32| !materials[material as usize].textures.is_none();
    let uvs = if mesh.materials.iter().any(pictured) { mesh.uvs } else { None };
    Mesh { uvs, ..mesh }
}

/// The order of the surfaces is that of the ray tracer's geometry numbers.
fn surfaces(meshes: Vec<Mesh>, spheres: Vec<SphereDesc>) -> Vec<Surface> {
    let spheres = (!spheres.is_empty()).then_some(Surface::Spheres(spheres));
    meshes.into_iter().map(Surface::of_mesh).chain(spheres).collect()
}

/// The surfaces that shine: triangles, then spheres.
fn emitters(desc: &SceneDesc) -> impl Iterator<Item = Light> {
    let spheres = desc.spheres.iter().filter_map(|&SphereDesc { center, radius, material }| {
        let radiance = desc.materials[material as usize].emission;
        (radiance != Rgb::ZERO).then_some(Light::Sphere { center, radius, radiance })
    });
    desc.meshes.iter().flat_map(|mesh| shining(mesh, &desc.materials)).chain(spheres)
}

fn shining(mesh: &Mesh, materials: &[Material]) -> impl Iterator<Item = Light> {
    mesh.materials.iter().enumerate().filter_map(|(triangle, &material)| {
        let radiance = materials[material as usize].emission;
        (radiance != Rgb::ZERO).then(|| Light::Triangle { corners: mesh.corners(triangle), radiance })
    })
}
