use super::desc::{Material, SceneDesc, SphereDesc};
use super::surface::Surface;
use super::tracer::Tracer;
use super::{Mesh, Scene, Traversal, TraversalError};
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
        compile(desc, Traversal::Embree, Tracer::embree)
    }

    /// Makes a description traceable by the means of choice.
    ///
    /// # Errors
    /// Whatever those refuse: see [`Scene::new`]; the project's own tree has room for 2³⁰ primitives.
    pub fn with_traversal(desc: SceneDesc, traversal: Traversal) -> Result<Scene, TraversalError> {
        compile(desc, traversal, |surfaces| Tracer::new(surfaces, traversal))
    }
}

fn compile<E>(
    desc: SceneDesc,
    traversal: Traversal,
    trace: impl FnOnce(&[Surface]) -> Result<Tracer, E>,
) -> Result<Scene, E> {
    let camera = camera(&desc);
    let lights = lights(&desc);
    let SceneDesc { materials, render, film, point_lights, camera: view, places, .. } = desc;
    let surfaces = surfaces(desc.meshes, desc.spheres);
    let bounds = surfaces.iter().map(Surface::bounds).fold(Aabb::EMPTY, Aabb::union);
    let rays = trace(&surfaces)?;
    Ok(Scene {
        rays,
        traversal,
        surfaces,
        materials,
        lights,
        camera,
        point_lights,
        view,
        film,
        render,
        bounds,
        places,
    })
}

fn camera(desc: &SceneDesc) -> Camera {
    let c = &desc.camera;
    let pinhole =
        Camera::new(c.position, c.look_at, c.up, c.fov_degrees, (desc.film.width, desc.film.height));
    pinhole.with_lens(c.lens_radius, c.focus_distance)
}

/// The order of the surfaces is that of the ray tracer's geometry numbers.
fn surfaces(meshes: Vec<Mesh>, spheres: Vec<SphereDesc>) -> Vec<Surface> {
    let spheres = (!spheres.is_empty()).then_some(Surface::Spheres(spheres));
    meshes.into_iter().map(Surface::of_mesh).chain(spheres).collect()
}

fn lights(desc: &SceneDesc) -> Lights {
    let points =
        desc.point_lights.iter().map(|l| Light::Point { position: l.position, intensity: l.intensity });
    let triangles = desc.meshes.iter().flat_map(|mesh| emitters(mesh, &desc.materials));
    Lights::new(points.chain(triangles))
}

fn emitters(mesh: &Mesh, materials: &[Material]) -> impl Iterator<Item = Light> {
    mesh.triangles.iter().zip(&mesh.materials).filter_map(|(triangle, &material)| {
        let radiance = materials[material as usize].emission;
        (radiance != Rgb::ZERO)
            .then(|| Light::Triangle { corners: triangle.map(|i| mesh.vertices[i as usize]), radiance })
    })
}
