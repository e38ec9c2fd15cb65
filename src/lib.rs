//! Progressive photon mapping on Embree 4.

pub mod bsdf;
pub mod camera;
pub mod compare;
pub mod embree;
pub mod film;
pub mod light;
pub mod math;
pub mod output;
pub mod scene;
