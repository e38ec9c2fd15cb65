//! Caustica: progressive photon mapping on Embree 4, for the light that path tracers find hard.
//!
//! # Ten lines to a picture
//!
//! ```no_run
//! use caustica::output::{Metadata, write_exr};
//! use caustica::{Render, Scene, Settings, scene};
//!
//! let desc = scene::load("data/cornell_b.toml".as_ref())?;
//! let settings = Settings::of_scene(&desc.render);
//! let scene = Scene::new(desc)?;
//! let mut render = Render::new(&scene, settings);
//! for _ in 0..16 {
//!     render.pass();
//! }
//! write_exr("cornell_b.exr".as_ref(), &render.picture(), &Metadata::new())?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The picture is there after every pass, and nobody has to go on: [`Render::pass`] returns what the pass did
//! ([`PassStatistics`]), [`Render::hit_points`] and [`Render::states`] tell of every hit point where it lies and what it has
//! gathered, and [`Render::accuracy`] how wrong the picture still is. The folder `examples/` has three programs: these lines, a
//! render that is watched and stopped by its own caller, and a scene that no file describes.
//!
//! # From a file to light in a pixel
//!
//! Data flows one way:
//!
//! ```text
//! files ─> SceneDesc ─> Scene (immutable)
//!   effects::Plan: what the scene calls for
//!   eye pass ─> [HitPoint] ─> spheres ─> SphereBvh
//!   every pass: photon pass ─> [Photon] ─> gather: flux is summed, radii shrink ─> boxes follow
//!   develop ─> Image ─> EXR, PNG
//! ```
//!
//! 1. [`scene::load`] reads a file into plain data, a [`SceneDesc`]; [`Scene::new`] makes it traceable. From here on nothing
//!    changes it.
//! 2. [`effects::Plan`] says which kinds of paths the scene calls for, and proves of the others that they bring nothing.
//! 3. [`Render::new`] makes the eye pass: a [`ray of the camera`](camera::Camera) meets a surface ([`scene::SurfaceHit`]), whose
//!    lobes ([`bsdf::Scattering`]) send it on or end it at a [`HitPoint`], with the weight that its light has in the pixel.
//! 4. [`Render::pass`] makes a photon pass: [`light::Lights`] emit photons, which surfaces scatter; those that fall within the
//!    radius of a hit point add their flux to its [`GatherState`], whose radius shrinks
//!    by `R'² = R² (N + α M) / (N + M)`.
//! 5. [`Render::picture`] develops what is there into an [`Image`]; [`output`] writes it, and [`compare`] holds it against others.
//!
//! The recipe is [`ppm`], line by line; what checks it are [`mod@reference`], a path tracer and a light tracer that share nothing with
//! it but surfaces and lights, and [`compare`].
//!
//! # What stays
//!
//! What this page names and what its modules `scene`, `ppm`, `film`, `math`, `bsdf`, `light`, `camera`, `texture`, `effects`,
//! `reference`, `output` and `compare` hold changes by the rules of semantic versions. `checkpoint`, `shard`, `study`, `bench`,
//! `bvh`, `simd`, `embree`, `live_view`, `report` and `cli` are public so that the program, its tests and its benchmarks reach them, and may change
//! at any time. Vectors are those of `glam`, as [`math`] hands them on: no other crate shows in what stays.

mod batch;
pub mod bench;
pub mod bsdf;
pub mod bvh;
pub mod camera;
pub mod checkpoint;
pub mod cli;
pub mod compare;
#[cfg(feature = "oidn")]
pub mod denoise;
mod doctor;
pub mod effects;
pub mod embree;
mod farm;
pub mod film;
mod input;
pub mod light;
pub mod live_view;
pub mod math;
pub mod output;
pub mod ppm;
mod price;
pub mod reference;
mod regression;
pub mod report;
pub mod scene;
mod sealed;
pub mod shard;
pub mod simd;
pub mod study;
pub mod texture;

pub use film::Image;
pub use ppm::{GatherState, HitPoint, PassStatistics, Render, Settings};
pub use scene::{Scene, SceneDesc, SceneError};
