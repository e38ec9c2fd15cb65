//! The fence around Embree 4: the only place that calls C, behind an interface that cannot be misused.
//!
//! A one-way street leads from a [`Device`] through a [`SceneBuilder`] to a committed [`Scene`]. What Embree would
//! answer with undefined behaviour or in silence (an index beyond the vertices, a coordinate that is not a number)
//! is an [`EmbreeError`] here; a committed scene has only `&self` queries and shares nothing mutable.
//!
//! ```
//! use caustica::embree::{Device, SceneBuilder, Sphere};
//! use caustica::math::{Ray, Vec3};
//! # fn main() -> Result<(), caustica::embree::EmbreeError> {
//! let mut builder = SceneBuilder::new(&Device::new()?)?;
//! let ball = builder.add_spheres(&[Sphere { center: Vec3::ZERO, radius: 1.0 }])?;
//! let scene = builder.commit()?;
//! let hit = scene.intersect(&Ray::new(Vec3::new(0.0, 0.0, 3.0), Vec3::NEG_Z)).ok_or("miss");
//! assert_eq!(hit.map(|hit| (hit.geometry, hit.t)), Ok((ball, 2.0)));
//! # Ok(())
//! # }
//! ```

#![allow(unsafe_code)]
#![warn(clippy::undocumented_unsafe_blocks)]

mod builder;
mod device;
mod error;
mod geometry;
mod memory;
mod options;
mod packet;
mod point_query;
mod scene;
mod scene_handle;
mod sys;
mod version;

pub use builder::{SceneBuilder, Sphere};
pub use device::Device;
pub use error::EmbreeError;
pub use options::{BuildQuality, SceneOptions};
pub use packet::{Coherence, HitPacket, PACKET, PacketWidth, RayPacket, Row};
pub use point_query::SphereQuery;
pub use scene::{Hit, Scene};
pub use version::Version;

/// The number of a geometry in its scene: they count up from 0 in the order of adding.
pub type GeometryId = u32;
