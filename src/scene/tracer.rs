use std::fmt;

use super::SphereDesc;
use super::surface::Surface;
use crate::bvh::{self, RayBvh, RayBvhBuilder, RayBvhError};
use crate::embree::{self, Device, EmbreeError, SceneBuilder};
use crate::math::{Ray, Vec3};

/// Who answers what a ray hits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Traversal {
    /// Embree 4.
    #[default]
    Embree,
    /// The project's own tree, [`bvh::RayBvh`].
    Custom,
}

impl fmt::Display for Traversal {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Traversal::Embree => "embree",
            Traversal::Custom => "custom",
        })
    }
}

/// Why the surfaces of a scene cannot be traced.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TraversalError {
    /// Embree refuses.
    #[error(transparent)]
    Embree(#[from] EmbreeError),
    /// The project's own tree refuses.
    #[error(transparent)]
    Custom(#[from] RayBvhError),
}

/// Surfaces as rays see them. Their order is that of the geometry numbers.
#[derive(Debug)]
pub(super) enum Tracer {
    Embree(embree::Scene),
    Custom(RayBvh),
}

/// Where a ray first meets a surface, whoever found it; see [`embree::Hit`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Hit {
    pub t: f32,
    pub u: f32,
    pub v: f32,
    pub ng: Vec3,
    pub geometry: u32,
    pub primitive: u32,
}

impl Tracer {
    pub fn new(surfaces: &[Surface], traversal: Traversal) -> Result<Tracer, TraversalError> {
        Ok(match traversal {
            Traversal::Embree => Tracer::embree(surfaces)?,
            Traversal::Custom => Tracer::custom(surfaces)?,
        })
    }

    pub fn embree(surfaces: &[Surface]) -> Result<Tracer, EmbreeError> {
        let mut builder = SceneBuilder::new(&Device::new()?)?;
        for surface in surfaces {
            match surface {
                Surface::Mesh(mesh) => builder.add_triangles(&mesh.vertices, &mesh.triangles)?,
                Surface::Spheres(spheres) => {
                    let ball = |s: &SphereDesc| embree::Sphere { center: s.center, radius: s.radius };
                    builder.add_spheres(&spheres.iter().map(ball).collect::<Vec<_>>())?
                }
            };
        }
        Ok(Tracer::Embree(builder.commit()?))
    }

    fn custom(surfaces: &[Surface]) -> Result<Tracer, RayBvhError> {
        let mut builder = RayBvhBuilder::new();
        for surface in surfaces {
            match surface {
                Surface::Mesh(mesh) => builder.add_triangles(&mesh.vertices, &mesh.triangles)?,
                Surface::Spheres(spheres) => {
                    let ball = |s: &SphereDesc| bvh::Sphere { center: s.center, radius: s.radius };
                    builder.add_spheres(&spheres.iter().map(ball).collect::<Vec<_>>())?
                }
            };
        }
        Ok(Tracer::Custom(builder.build()))
    }

    pub fn traversal(&self) -> Traversal {
        match self {
            Tracer::Embree(_) => Traversal::Embree,
            Tracer::Custom(_) => Traversal::Custom,
        }
    }

    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        match self {
            Tracer::Embree(scene) => scene.intersect(ray).map(Hit::from),
            Tracer::Custom(tree) => tree.intersect(ray).map(Hit::from),
        }
    }

    pub fn occluded(&self, ray: &Ray) -> bool {
        match self {
            Tracer::Embree(scene) => scene.occluded(ray),
            Tracer::Custom(tree) => tree.occluded(ray),
        }
    }
}

impl From<embree::Hit> for Hit {
    fn from(hit: embree::Hit) -> Hit {
        let embree::Hit { t, u, v, ng, geometry, primitive } = hit;
        Hit { t, u, v, ng, geometry, primitive }
    }
}

impl From<bvh::RayHit> for Hit {
    fn from(hit: bvh::RayHit) -> Hit {
        let bvh::RayHit { t, u, v, ng, geometry, primitive } = hit;
        Hit { t, u, v, ng, geometry, primitive }
    }
}
