//! Caustica: progressive photon mapping on Embree 4.
//!
//! Data flows one way:
//!
//! ```text
//! files ─> SceneDesc ─> Scene (immutable)
//!   camera_pass ─> [HitPoint] + [GatherState]
//!   spheres ─> SphereBvh
//!   per pass: photon_pass ─> [Photon] ─> gather ─> [PassSum] ─> GatherState::after_pass ─> SphereBvh::refit
//!   develop ─> Image ─> EXR, PNG
//! ```
//!
//! Inside a path: [`light::EmissionSample`] or a ray of the [`camera`] ─> [`scene::SurfaceHit`] ─>
//! [`bsdf::Scattering`] ─> [`math::Ray`].

pub mod bsdf;
pub mod bvh;
pub mod camera;
pub mod compare;
pub mod embree;
pub mod film;
pub mod light;
pub mod math;
pub mod output;
pub mod reference;
pub mod scene;
