//! Caustica: progressive photon mapping on Embree 4.
//!
//! Data flows one way:
//!
//! ```text
//! files ─> SceneDesc ─> Scene (immutable)
//!   camera_pass ─> [HitPoint] + [GatherState]
//!   spheres ─> SphereBvh
//!   per pass: photon_pass ─> [Photon] ─> gather: sums ─> GatherState::after_pass ─> boxes follow
//!   develop ─> Image ─> EXR, PNG
//! ```
//!
//! Inside a path: [`light::EmissionSample`] or a ray of the [`camera`] ─> [`scene::SurfaceHit`] ─>
//! [`bsdf::Scattering`] ─> [`math::Ray`].
//!
//! Start at [`scene::load`] and [`ppm::Render`]:
//!
//! ```no_run
//! use caustica::{ppm::{Render, Settings}, scene::{self, Scene}};
//!
//! let desc = scene::load("data/course_diffuse.toml".as_ref())?;
//! let settings = Settings::of_scene(&desc.render);
//! let scene = Scene::new(desc)?;
//! let mut render = Render::new(&scene, settings);
//! for _ in 0..10 {
//!     render.pass();
//! }
//! let picture = render.picture();
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod batch;
pub mod bench;
pub mod bsdf;
pub mod bvh;
pub mod camera;
pub mod checkpoint;
pub mod cli;
pub mod compare;
#[cfg(feature = "oidn")]
pub mod denoise;
pub mod doctor;
pub mod effects;
pub mod embree;
pub mod farm;
pub mod film;
pub mod input;
pub mod light;
pub mod live_view;
pub mod math;
pub mod output;
pub mod ppm;
pub mod price;
pub mod reference;
pub mod regression;
pub mod report;
pub mod scene;
pub mod sealed;
pub mod shard;
pub mod simd;
pub mod study;
pub mod texture;
