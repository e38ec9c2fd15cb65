use std::fmt;

use super::SphereDesc;
use super::surface::Surface;
use crate::bvh::{self, RayBvh, RayBvhBuilder, RayBvhError};
use crate::embree::{
    self, Coherence, Device, EmbreeError, HitPacket, PACKET, PacketWidth, RayPacket, SceneBuilder,
    SceneOptions,
};
use crate::math::Ray;

/// Where a ray first meets a surface, whoever found it.
pub(super) use crate::embree::Hit;

/// Who answers what a ray hits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Traversal {
    /// Embree 4.
    #[default]
    Embree,
    /// Embree 4 without the promise that no ray slips through between adjacent triangles.
    EmbreeFast,
    /// The project's own tree, [`bvh::RayBvh`].
    Custom,
}

impl fmt::Display for Traversal {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Traversal::Embree => "embree",
            Traversal::EmbreeFast => "embree-fast",
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

/// Where rays point alike, packets of 16 save a third over those of 8; where they do not, they cost a fifth more.
fn width(coherence: Coherence) -> PacketWidth {
    match coherence {
        Coherence::Coherent => PacketWidth::Sixteen,
        Coherence::Incoherent => PacketWidth::Eight,
    }
}

impl Tracer {
    pub fn new(surfaces: &[Surface], traversal: Traversal) -> Result<Tracer, TraversalError> {
        Ok(match traversal {
            Traversal::Embree => Tracer::embree(surfaces)?,
            Traversal::EmbreeFast => {
                Tracer::embree_with(surfaces, SceneOptions { robust: false, ..SceneOptions::default() })?
            }
            Traversal::Custom => Tracer::custom(surfaces)?,
        })
    }

    pub fn embree(surfaces: &[Surface]) -> Result<Tracer, EmbreeError> {
        Tracer::embree_with(surfaces, SceneOptions::default())
    }

    fn embree_with(surfaces: &[Surface], options: SceneOptions) -> Result<Tracer, EmbreeError> {
        let mut builder = SceneBuilder::with_options(&Device::new()?, options)?;
        for surface in surfaces {
            match surface {
                Surface::Mesh(mesh, _) => builder.add_triangles(&mesh.vertices, &mesh.triangles)?,
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
                Surface::Mesh(mesh, _) => builder.add_triangles(&mesh.vertices, &mesh.triangles)?,
                Surface::Spheres(spheres) => {
                    let ball = |s: &SphereDesc| bvh::Sphere { center: s.center, radius: s.radius };
                    builder.add_spheres(&spheres.iter().map(ball).collect::<Vec<_>>())?
                }
            };
        }
        Ok(Tracer::Custom(builder.build()))
    }

    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        match self {
            Tracer::Embree(scene) => scene.intersect(ray),
            Tracer::Custom(tree) => tree.intersect(ray).map(Hit::from),
        }
    }

    /// [`Tracer::intersect`] for every ray, up to ties and rounding.
    ///
    /// Which rays share a packet can change the last bit of a hit, so whoever wants the same bytes twice asks for
    /// the same packets.
    pub fn intersect_packet(&self, rays: &RayPacket, hits: &mut HitPacket, coherence: Coherence) {
        match self {
            Tracer::Embree(scene) => scene.intersect_packet(rays, hits, width(coherence), coherence),
            Tracer::Custom(tree) => {
                for lane in 0..PACKET {
                    let ray = (lane < rays.len).then(|| rays.ray(lane));
                    hits.set(lane, ray.and_then(|ray| tree.intersect(&ray)).map(Hit::from));
                }
            }
        }
    }

    pub fn occluded(&self, ray: &Ray) -> bool {
        match self {
            Tracer::Embree(scene) => scene.occluded(ray),
            Tracer::Custom(tree) => tree.occluded(ray),
        }
    }
}

impl From<bvh::RayHit> for Hit {
    fn from(hit: bvh::RayHit) -> Hit {
        let bvh::RayHit { t, u, v, ng, geometry, primitive } = hit;
        Hit { t, u, v, ng, geometry, primitive }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Rng, Stream, Vec3, warp};

    fn point_in_cube(rng: &mut Rng) -> Vec3 {
        2.0 * Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32()) - 1.0
    }

    fn balls() -> Vec<Surface> {
        let mut rng = Rng::new(1, Stream::Test, 0, 0);
        let ball = |_| SphereDesc { center: point_in_cube(&mut rng), radius: 0.3, material: 0 };
        vec![Surface::Spheres((0..20).map(ball).collect())]
    }

    fn random_rays(count: u64) -> Vec<Ray> {
        let ray = |index| {
            let mut rng = Rng::new(2, Stream::Test, 0, index);
            Ray::new(2.0 * point_in_cube(&mut rng), warp::square_to_uniform_sphere(rng.next_vec2()))
        };
        (0..count).map(ray).collect()
    }

    /// Every length of a packet.
    #[test]
    fn many_rays_hit_what_single_ones_hit() {
        let same = |a: &Hit, b: &Hit| {
            (a.geometry, a.primitive) == (b.geometry, b.primitive) && (a.t - b.t).abs() < 1e-5
        };
        let agree = |a: &Option<Hit>, b: &Option<Hit>| match (a, b) {
            (Some(a), Some(b)) => same(a, b),
            (a, b) => a.is_none() && b.is_none(),
        };
        for traversal in [Traversal::Embree, Traversal::EmbreeFast, Traversal::Custom] {
            let tracer = Tracer::new(&balls(), traversal).unwrap();
            for count in (0..=PACKET as u64).chain([1000]) {
                let rays = random_rays(count);
                let single: Vec<Option<Hit>> = rays.iter().map(|ray| tracer.intersect(ray)).collect();
                for coherence in [Coherence::Coherent, Coherence::Incoherent] {
                    let hits: Vec<Option<Hit>> = rays
                        .chunks(PACKET)
                        .flat_map(|rays| {
                            // What it held before must not show.
                            let mut hits = HitPacket::none();
                            tracer.intersect_packet(&RayPacket::of(&random_rays(16)), &mut hits, coherence);
                            tracer.intersect_packet(&RayPacket::of(rays), &mut hits, coherence);
                            (0..rays.len()).map(move |lane| hits.hit(lane))
                        })
                        .collect();
                    assert!(hits.iter().zip(&single).all(|(a, b)| agree(a, b)), "{traversal}, {count} rays");
                }
                assert!(count < 1000 || (100..900).contains(&single.iter().flatten().count()));
            }
        }
    }
}
