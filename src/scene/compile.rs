use super::desc::{Material, SceneDesc, SphereDesc};
use super::surface::Surface;
use super::{Mesh, Scene};
use crate::camera::Camera;
use crate::embree::{Device, EmbreeError, SceneBuilder, Sphere};
use crate::light::{Light, Lights};
use crate::math::{Aabb, Rgb};

impl Scene {
    /// Makes a description traceable.
    ///
    /// # Errors
    /// Whatever the ray tracer refuses: no memory, a library of the wrong version, more than 2³² primitives.
    pub fn new(desc: SceneDesc) -> Result<Scene, EmbreeError> {
        let device = Device::new()?;
        let camera = camera(&desc);
        let lights = lights(&desc);
        let (materials, render, film) = (desc.materials, desc.render, desc.film);
        let surfaces = surfaces(desc.meshes, desc.spheres);
        let mut builder = SceneBuilder::new(&device)?;
        for surface in &surfaces {
            add(&mut builder, surface)?;
        }
        let bounds = surfaces.iter().map(Surface::bounds).fold(Aabb::EMPTY, Aabb::union);
        let rays = builder.commit()?;
        Ok(Scene { rays, surfaces, materials, lights, camera, film, render, bounds })
    }
}

fn camera(desc: &SceneDesc) -> Camera {
    let c = &desc.camera;
    Camera::new(c.position, c.look_at, c.up, c.fov_degrees, (desc.film.width, desc.film.height))
}

/// The order of the surfaces is that of the ray tracer's geometry numbers.
fn surfaces(meshes: Vec<Mesh>, spheres: Vec<SphereDesc>) -> Vec<Surface> {
    let spheres = (!spheres.is_empty()).then_some(Surface::Spheres(spheres));
    meshes.into_iter().map(Surface::Mesh).chain(spheres).collect()
}

fn add(builder: &mut SceneBuilder, surface: &Surface) -> Result<(), EmbreeError> {
    match surface {
        Surface::Mesh(mesh) => builder.add_triangles(&mesh.vertices, &mesh.triangles)?,
        Surface::Spheres(spheres) => {
            let spheres: Vec<Sphere> =
                spheres.iter().map(|s| Sphere { center: s.center, radius: s.radius }).collect();
            builder.add_spheres(&spheres)?
        }
    };
    Ok(())
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
